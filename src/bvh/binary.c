#include "bvh_internal.h"

#define BINS 16
#define TASK_SIZE 8192 ///< triangles that are worth a task of their own

static const rsv_box empty_box = { { INFINITY, INFINITY, INFINITY },
    { -INFINITY, -INFINITY, -INFINITY } };

/// Where parts are binned along an axis, by the middles of their boxes.
typedef struct axis_bins {
    int axis;
    float low, scale;
} axis_bins;

/// Parts whose bin is below `bin` go left.
typedef struct split {
    axis_bins bins;
    int bin; ///< 0 = no split found
    double cost;
} split;

static int bin_of(const axis_bins *bins, const rsv_box *box)
{
    float middle = v3_component(rsv_box_centre(box), bins->axis);
    int k = (int)((middle - bins->low) * bins->scale);
    return k < 0 ? 0 : k > BINS - 1 ? BINS - 1 : k;
}

static rsv_box box_of_middles(const rsv_boxed_triangle *part, uint32_t count)
{
    rsv_box box = empty_box;
    for (uint32_t k = 0; k < count; k++) {
        rsv_vec3 middle = rsv_box_centre(&part[k].box);
        box = rsv_box_join(box, (rsv_box){ middle, middle });
    }
    return box;
}

/// Compares the splits between bins.
static void try_axis(
    const rsv_boxed_triangle *part, uint32_t count, const axis_bins *bins, split *best)
{
    rsv_box box[BINS], below = empty_box, above = empty_box;
    uint32_t filled[BINS] = { 0 }, left = 0;
    double right_cost[BINS];
    for (int k = 0; k < BINS; k++)
        box[k] = empty_box;
    for (uint32_t k = 0; k < count; k++) {
        int b = bin_of(bins, &part[k].box);
        box[b] = rsv_box_join(box[b], part[k].box);
        filled[b]++;
    }
    for (int k = BINS - 1, right = 0; k > 0; k--) {
        above = rsv_box_join(above, box[k]);
        right += (int)filled[k];
        right_cost[k] = right ? right * rsv_box_area(&above) : 0;
    }
    for (int k = 1; k < BINS; k++) {
        below = rsv_box_join(below, box[k - 1]);
        left += filled[k - 1];
        if (left == 0 || left == count) continue;
        double cost = left * rsv_box_area(&below) + right_cost[k];
        if (!best->bin || cost < best->cost) *best = (split){ *bins, k, cost };
    }
}

static split find_split(const rsv_boxed_triangle *part, uint32_t count)
{
    split best = { .bin = 0 };
    rsv_box middles = box_of_middles(part, count);
    for (int axis = 0; axis < 3; axis++) {
        float low = v3_component(middles.low, axis);
        float scale = BINS / (v3_component(middles.high, axis) - low);
        if (!isfinite(scale)) continue;
        axis_bins bins = { axis, low, scale };
        try_axis(part, count, &bins, &best);
    }
    return best;
}

/// Brings those that go left to the front. @return how many
static uint32_t divide(rsv_boxed_triangle *part, uint32_t count, const split *at)
{
    uint32_t left = 0;
    for (uint32_t k = 0; k < count; k++) {
        if (bin_of(&at->bins, &part[k].box) >= at->bin) continue;
        rsv_boxed_triangle moved = part[k];
        part[k] = part[left];
        part[left++] = moved;
    }
    return left;
}

/// Depth of a tree that halves `count` down to 1.
static uint32_t depth_of_halves(uint32_t count)
{
    uint32_t depth = 0;
    while (((uint64_t)1 << depth) < count)
        depth++;
    return depth;
}

static void build_node(
    rsv_boxed_triangle *part, uint32_t first, uint32_t count, uint32_t depth, rsv_binary_node *node)
{
    rsv_box box = empty_box;
    for (uint32_t k = 0; k < count; k++)
        box = rsv_box_join(box, part[first + k].box);
    *node = (rsv_binary_node){ box, first, count };
    if (count == 1) return;
    uint32_t left = count / 2;
    if (depth + depth_of_halves(count) < RSV_BVH_DEPTH) {
        split at = find_split(part + first, count);
        if (at.bin) left = divide(part + first, count, &at);
    }
#pragma omp task if (count > TASK_SIZE)
    build_node(part, first, left, depth + 1, node + 1);
    build_node(part, first + left, count - left, depth + 1, node + 2 * (size_t)left);
}

void rsv_binary_build(
    rsv_context *context, rsv_boxed_triangle *part, uint32_t count, rsv_binary_node *node)
{
    (void)context; // its only use is in the pragma
#pragma omp parallel num_threads(rsv_threads(context))
#pragma omp single
    build_node(part, 0, count, 0, node);
}
