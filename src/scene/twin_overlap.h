/// Whether two triangles share a piece of surface.
#ifndef RSV_TWIN_OVERLAP_H
#define RSV_TWIN_OVERLAP_H

#include "resolvent/scene.h"

/// Planes that meet at a larger angle share a line, not a piece (the cosine of 18 degrees: copies of the smallest
/// triangles are inexact by a part of their size).
#define RSV_TWIN_PARALLEL 0.95f

/// A triangle and its unit normal.
typedef struct rsv_twin_face {
    uint32_t triangle;
    rsv_vec3 normal;
} rsv_twin_face;

/// How two triangles lie that cover each other somewhere.
typedef struct rsv_twin_overlap {
    bool opposite; ///< they turn opposite ways
    double gap;    ///< metres between their planes, at the centre of the overlap
} rsv_twin_overlap;

/// Triangles that only share an edge or a corner, up to rounding, do not overlap.
/// @param a, b parallel by RSV_TWIN_PARALLEL
/// @param reach maximum distance between their planes, metres
bool rsv_twins_overlap(const rsv_scene_view *scene, rsv_twin_face a, rsv_twin_face b, float reach,
    rsv_twin_overlap *overlap);

#endif
