/// Whether two triangles share a piece of surface.
#ifndef RSV_TWIN_OVERLAP_H
#define RSV_TWIN_OVERLAP_H

#include "resolvent/scene.h"

/// Planes that meet at a larger angle share a line, not a piece (the cosine of 18 degrees: copies of the smallest triangles
/// are inexact by a part of their size).
#define RSV_TWIN_PARALLEL 0.95f

/// How two triangles lie that cover each other somewhere.
typedef struct rsv_twin_overlap {
    bool opposite; ///< they turn opposite ways
    double gap;    ///< metres between their planes, in the middle of what they share
} rsv_twin_overlap;

/// Triangles that merely share an edge or a corner, but for rounding, do not overlap.
/// @param normal_a, normal_b unit, of triangles that are parallel by RSV_TWIN_PARALLEL
/// @param reach metres that their planes may lie apart
bool rsv_twins_overlap(const rsv_scene_view *scene, uint32_t a, uint32_t b, rsv_vec3 normal_a,
    rsv_vec3 normal_b, float reach, rsv_twin_overlap *overlap);

#endif
