/// Selection among many lights by what each may contribute at a point: a binary tree over bounds of place,
/// orientation and strength (Conty Estevez and Kulla 2018). Sampling and its probability take as many
/// steps as the tree is deep.
#ifndef RSV_LIGHT_TREE_H
#define RSV_LIGHT_TREE_H

#include "../core/sampling.h"

/// Where lights are, where they shine, and how strongly. Light leaves within `emission` of a direction that is
/// within `spread` of the axis.
typedef struct rsv_light_bounds {
    rsv_vec3 low, high;
    rsv_vec3 axis;                  ///< unit
    float cos_spread, cos_emission; ///< spread 0..pi, emission 0..pi/2
    float strength;                 ///< of the intensity along the axis, W/sr
} rsv_light_bounds;

typedef struct rsv_light_node {
    rsv_light_bounds bounds;
    uint32_t right;  ///< the left child follows its parent; 0 = leaf
    uint32_t parent; ///< RSV_NONE at the root
    uint32_t light;  ///< of a leaf
} rsv_light_node;

typedef struct rsv_light_tree {
    rsv_context *context;
    rsv_light_node *node; ///< [2 * light_count - 1], in depth-first order
    uint32_t *leaf;       ///< [light_count] node of each light
    size_t light_count;
} rsv_light_tree;

/// @param bounds [light_count], of strength above 0; light_count at least 1
rsv_status rsv_light_tree_create(rsv_context *context, const rsv_light_bounds *bounds,
    size_t light_count, rsv_light_tree **tree);
void rsv_light_tree_destroy(rsv_light_tree *tree);

/// Draws a light for a receiver. @param normal unit; zero = light from everywhere counts
/// @return its probability; 0 if no light can contribute
float rsv_light_tree_sample(
    const rsv_light_tree *tree, rsv_vec3 point, rsv_vec3 normal, float u, uint32_t *light);

/// Probability of rsv_light_tree_sample to draw `light`.
float rsv_light_tree_probability(
    const rsv_light_tree *tree, rsv_vec3 point, rsv_vec3 normal, uint32_t light);

#endif
