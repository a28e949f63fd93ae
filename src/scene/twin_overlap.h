/// Whether two triangles share a piece of surface.
#ifndef RSV_TWIN_OVERLAP_H
#define RSV_TWIN_OVERLAP_H

#include "resolvent/scene.h"

/// How two triangles lie that cover each other somewhere.
typedef struct rsv_twin_overlap {
    bool opposite; ///< they turn opposite ways
    double gap;    ///< metres between their planes, in the middle of what they share
} rsv_twin_overlap;

/// Triangles that merely share an edge or a corner, but for rounding, do not overlap.
/// @param reach metres that their planes may lie apart @param normal [triangle_count] unit
bool rsv_twins_overlap(const rsv_scene_view *scene, const rsv_vec3 *normal, uint32_t a, uint32_t b,
    float reach, rsv_twin_overlap *overlap);

#endif
