/// Selection among many lights by their possible contribution at a point: a binary tree over bounds of position,
/// orientation and strength (Conty Estevez and Kulla 2018). Sampling and its probability take as many steps as the
/// depth of the tree.
///
/// Inline functions are also for device code.
#ifndef RSV_LIGHT_TREE_H
#define RSV_LIGHT_TREE_H

#include "../core/sampling.h"
#include "resolvent/scene.h"

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

// ---- sampling -----------------------------------------------------------------------------------

RSV_INLINE float rsv_light_sine(float cosine) { return sqrtf(f_max(1 - cosine * cosine, 0)); }

/// cos(max(0, a - b))
RSV_INLINE float rsv_light_cos_difference(float cos_a, float cos_b)
{
    return cos_a > cos_b ? 1 : cos_a * cos_b + rsv_light_sine(cos_a) * rsv_light_sine(cos_b);
}

/// Rounding of the cosines must not hide a light that contributes.
#define RSV_LIGHT_SLACK 1e-4f

/// Cosine between the emission and the way to the receiver at best; 0 if none of it goes there.
RSV_INLINE float rsv_light_best_emission(
    const rsv_light_bounds *b, rsv_vec3 towards_light, float cos_width)
{
    float cos_axis = -v3_dot(b->axis, towards_light);
    // the angle from the axis, minus the spread and the apparent width of the bounds
    float cos_outside = rsv_light_cos_difference(cos_axis, b->cos_spread);
    float cos_best = cos_outside == 1 ? 1 : rsv_light_cos_difference(cos_outside, cos_width);
    return cos_best + RSV_LIGHT_SLACK > b->cos_emission ? f_max(cos_best, RSV_LIGHT_SLACK) : 0;
}

/// Estimate of the irradiance from the lights in the bounds; above 0 wherever there is any.
RSV_INLINE float rsv_light_importance(const rsv_light_bounds *b, rsv_vec3 point, rsv_vec3 normal)
{
    rsv_vec3 middle = v3_mad(v3_scale(b->low, 0.5f), 0.5f, b->high);
    rsv_vec3 half = v3_sub(b->high, middle), towards = v3_sub(middle, point);
    float radius_squared = v3_dot(half, half), distance_squared = v3_dot(towards, towards);
    float nearest = f_max(f_max(distance_squared, radius_squared), 1e-30f);
    if (distance_squared <= radius_squared) return b->strength / nearest;
    towards = v3_scale(towards, 1 / sqrtf(distance_squared));
    float cos_width = sqrtf(f_max(1 - radius_squared / distance_squared, 0));
    float emitted = rsv_light_best_emission(b, towards, cos_width), received = 1;
    if (normal.x != 0 || normal.y != 0 || normal.z != 0)
        received = rsv_light_cos_difference(v3_dot(normal, towards), cos_width) + RSV_LIGHT_SLACK;
    return received > 0 ? b->strength * emitted * received / nearest : 0;
}

/// Share of the left child among the two; negative if neither can contribute.
RSV_INLINE float rsv_light_left_share(
    const rsv_light_tree *tree, uint32_t parent, rsv_vec3 point, rsv_vec3 normal)
{
    float left = rsv_light_importance(&tree->node[parent + 1].bounds, point, normal);
    float right = rsv_light_importance(&tree->node[tree->node[parent].right].bounds, point, normal);
    return left + right > 0 ? left / (left + right) : -1;
}

/// Draws a light for a receiver. @param normal unit; zero = light from everywhere counts
/// @return its probability; 0 if no light can contribute
RSV_INLINE float rsv_light_tree_sample(
    const rsv_light_tree *tree, rsv_vec3 point, rsv_vec3 normal, float u, uint32_t *light)
{
    uint32_t index = 0;
    double probability = 1, place = u;
    while (tree->node[index].right) {
        float share = rsv_light_left_share(tree, index, point, normal);
        if (share < 0) return 0;
        bool left = place < share;
        double chosen = left ? share : 1 - (double)share;
        place = left ? place / chosen : (place - share) / chosen;
        probability *= chosen;
        index = left ? index + 1 : tree->node[index].right;
    }
    *light = tree->node[index].light;
    return rsv_light_importance(&tree->node[index].bounds, point, normal) > 0 ? (float)probability
                                                                              : 0;
}

/// Probability of rsv_light_tree_sample to draw `light`.
RSV_INLINE float rsv_light_tree_probability(
    const rsv_light_tree *tree, rsv_vec3 point, rsv_vec3 normal, uint32_t light)
{
    double probability = 1;
    uint32_t index = tree->leaf[light];
    if (!(rsv_light_importance(&tree->node[index].bounds, point, normal) > 0)) return 0;
    while (tree->node[index].parent != RSV_NONE) {
        uint32_t parent = tree->node[index].parent;
        float share = rsv_light_left_share(tree, parent, point, normal);
        if (share < 0) return 0;
        probability *= index == parent + 1 ? share : 1 - (double)share;
        index = parent;
    }
    return (float)probability;
}

#endif
