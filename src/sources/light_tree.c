#include "light_tree.h"

#include "../core/core.h"
#include "resolvent/scene.h"

#include <stdlib.h>
#include <string.h>

#define BUCKETS 12
/// Below this depth, cells are halved by number, which keeps the tree shallow for any lights.
#define SPLIT_DEPTH 32

// ---- bounds -------------------------------------------------------------------------------------

/// A cone of directions that holds two others.
static void merge_cones(
    const rsv_light_bounds *a, const rsv_light_bounds *b, rsv_vec3 *axis, float *cos_spread)
{
    float spread_a = acosf(a->cos_spread), spread_b = acosf(b->cos_spread);
    const rsv_light_bounds *wide = spread_a >= spread_b ? a : b;
    float narrow = f_min(spread_a, spread_b), widest = f_max(spread_a, spread_b);
    float between = acosf(f_min(f_max(v3_dot(a->axis, b->axis), -1), 1));
    *axis = wide->axis;
    *cos_spread = wide->cos_spread;
    if (between + narrow <= widest) return;
    float spread = 0.5f * (narrow + between + widest);
    rsv_vec3 other = wide == a ? b->axis : a->axis;
    rsv_vec3 lateral = v3_mad(other, -v3_dot(other, wide->axis), wide->axis);
    *cos_spread = spread < RSV_PI ? cosf(spread) : -1;
    if (spread >= RSV_PI || v3_length(lateral) < 1e-6f) {
        *cos_spread = -1;
        return;
    }
    float turn = spread - widest;
    *axis =
        v3_normalize(v3_mad(v3_scale(wide->axis, cosf(turn)), sinf(turn), v3_normalize(lateral)));
}

static rsv_light_bounds merge(const rsv_light_bounds *a, const rsv_light_bounds *b)
{
    if (!(a->strength > 0)) return *b;
    if (!(b->strength > 0)) return *a;
    rsv_light_bounds all = { .low = v3_min(a->low, b->low), .high = v3_max(a->high, b->high) };
    merge_cones(a, b, &all.axis, &all.cos_spread);
    all.cos_emission = f_min(a->cos_emission, b->cos_emission);
    all.strength = a->strength + b->strength;
    return all;
}

/// The surface area orientation heuristic: strength times extent times the solid angle shone into.
static double cost(const rsv_light_bounds *b)
{
    if (!(b->strength > 0)) return 0;
    rsv_vec3 d = v3_sub(b->high, b->low);
    double area = 2.0 * ((double)d.x * d.y + (double)d.y * d.z + (double)d.z * d.x);
    double diagonal = v3_dot(d, d);
    double spread = acos(b->cos_spread), emission = acos(b->cos_emission);
    double reach = fmin(spread + emission, M_PI);
    double orientation =
        2 * M_PI * (1 - cos(spread)) + M_PI / 2 *
                                           (2 * reach * sin(spread) - cos(spread - 2 * reach) -
                                               2 * spread * sin(spread) + cos(spread));
    // flat sets of lights have no area in one or two of the directions
    return b->strength * orientation * (area + 1e-3 * diagonal);
}

// ---- building -----------------------------------------------------------------------------------

typedef struct builder {
    const rsv_light_bounds *bounds;
    rsv_light_tree *tree;
    uint32_t *order; ///< [light_count] lights, those of one node side by side
    uint32_t node_count;
} builder;

static float coordinate(rsv_vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

static float centre(const rsv_light_bounds *b, int axis)
{
    return 0.5f * coordinate(b->low, axis) + 0.5f * coordinate(b->high, axis);
}

typedef struct bucket_axis {
    int axis;
    float low, scale; ///< bucket = (centre - low) * scale
} bucket_axis;

static int bucket_of(const bucket_axis *buckets, const rsv_light_bounds *b)
{
    int k = (int)((centre(b, buckets->axis) - buckets->low) * buckets->scale);
    return k < 0 ? 0 : k < BUCKETS ? k : BUCKETS - 1;
}

/// The longest axis of the centres' bounds; scale 0 if they coincide.
static bucket_axis choose_axis(const builder *b, size_t begin, size_t end)
{
    bucket_axis best = { 0 };
    float longest = 0;
    for (int axis = 0; axis < 3; axis++) {
        float low = INFINITY, high = -INFINITY;
        for (size_t k = begin; k < end; k++) {
            float c = centre(&b->bounds[b->order[k]], axis);
            low = f_min(low, c);
            high = f_max(high, c);
        }
        if (!(high - low > longest)) continue;
        longest = high - low;
        best = (bucket_axis){ axis, low, BUCKETS / longest };
    }
    return best;
}

/// The last bucket of the cheaper left side; -1 if no split separates anything.
static int choose_split(const builder *b, const bucket_axis *buckets, size_t begin, size_t end)
{
    rsv_light_bounds filled[BUCKETS] = { 0 }, right = { 0 }, left = { 0 };
    double right_cost[BUCKETS];
    for (size_t k = begin; k < end; k++) {
        const rsv_light_bounds *bounds = &b->bounds[b->order[k]];
        int bucket = bucket_of(buckets, bounds);
        filled[bucket] = merge(&filled[bucket], bounds);
    }
    for (int k = BUCKETS - 1; k > 0; k--) {
        right = merge(&right, &filled[k]);
        right_cost[k] = right.strength > 0 ? cost(&right) : INFINITY;
    }
    int best = -1;
    double lowest = INFINITY;
    for (int k = 0; k < BUCKETS - 1; k++) {
        left = merge(&left, &filled[k]);
        double total = left.strength > 0 ? cost(&left) + right_cost[k + 1] : INFINITY;
        if (!(total < lowest)) continue;
        lowest = total;
        best = k;
    }
    return best;
}

/// Brings the lights of the left side to the front; returns where the right side begins.
static size_t partition(builder *b, size_t begin, size_t end, int depth)
{
    size_t middle = begin, half = begin + (end - begin) / 2;
    bucket_axis buckets = choose_axis(b, begin, end);
    if (buckets.scale == 0 || depth >= SPLIT_DEPTH) return half;
    int split = choose_split(b, &buckets, begin, end);
    for (size_t k = begin; k < end; k++) {
        if (bucket_of(&buckets, &b->bounds[b->order[k]]) > split) continue;
        uint32_t light = b->order[k];
        b->order[k] = b->order[middle];
        b->order[middle++] = light;
    }
    return middle > begin && middle < end ? middle : half;
}

static uint32_t build(builder *b, size_t begin, size_t end, uint32_t parent, int depth)
{
    uint32_t index = b->node_count++;
    rsv_light_node *node = &b->tree->node[index];
    node->parent = parent;
    if (end - begin == 1) {
        node->light = b->order[begin];
        node->bounds = b->bounds[node->light];
        b->tree->leaf[node->light] = index;
        return index;
    }
    size_t middle = partition(b, begin, end, depth);
    build(b, begin, middle, index, depth + 1);
    node->right = build(b, middle, end, index, depth + 1);
    node->bounds = merge(&b->tree->node[index + 1].bounds, &b->tree->node[node->right].bounds);
    return index;
}

rsv_status rsv_light_tree_create(rsv_context *context, const rsv_light_bounds *bounds,
    size_t light_count, rsv_light_tree **result)
{
    RSV_ASSERT(light_count > 0);
    rsv_light_tree *tree = rsv_alloc(context, 1, sizeof *tree);
    if (!tree) return RSV_ERROR_MEMORY;
    tree->context = context;
    tree->light_count = light_count;
    tree->node = rsv_alloc(context, 2 * light_count - 1, sizeof *tree->node);
    tree->leaf = rsv_alloc(context, light_count, sizeof *tree->leaf);
    builder b = { bounds, tree, rsv_alloc(context, light_count, sizeof *b.order), 0 };
    bool complete = tree->node && tree->leaf && b.order;
    for (size_t k = 0; complete && k < light_count; k++)
        b.order[k] = (uint32_t)k;
    if (complete) build(&b, 0, light_count, RSV_NONE, 0);
    rsv_free(context, b.order);
    if (!complete) {
        rsv_light_tree_destroy(tree);
        return RSV_ERROR_MEMORY;
    }
    *result = tree;
    return RSV_OK;
}

void rsv_light_tree_destroy(rsv_light_tree *tree)
{
    if (!tree) return;
    rsv_free(tree->context, tree->node);
    rsv_free(tree->context, tree->leaf);
    rsv_free(tree->context, tree);
}
