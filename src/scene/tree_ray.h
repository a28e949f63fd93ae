/// Rays through a tree of triangles, before the scene has a hierarchy for many of them.
#ifndef RSV_TREE_RAY_H
#define RSV_TREE_RAY_H

#include "twin_tree.h"

/// Which triangles a ray meets, and from where on.
typedef struct rsv_tree_ray {
    const rsv_scene_view *view;
    const rsv_twin_tree *tree;
    rsv_ray ray;
    float t_min;
    float slack;             ///< metres by which boxes are widened
    const uint32_t *kind_of; ///< [triangle_count] of the scene's triangles; NULL = all are met
    uint32_t kind;           ///< the only one that is met
} rsv_tree_ray;

/// The closest triangle, edges included, so that no ray slips through between triangles. Skips cut-out parts.
/// @param hit out: with triangle RSV_NONE if there is none
bool rsv_tree_ray_closest(const rsv_tree_ray *ray, rsv_hit *hit);

/// Where the line along a ray meets triangles, before and behind its origin, in no order. @param t [most] out @return
/// how many
uint32_t rsv_tree_ray_all(const rsv_tree_ray *ray, float *t, uint32_t most);

#endif
