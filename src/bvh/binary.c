#include "../core/parallel.h"
#include "bvh_internal.h"

#define BINS 16
#define WHOLE_SIZE 8192 ///< triangles whose subtree one thread builds
#define SUBTREES 256    ///< at most so many are built at a time

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

/// Triangles and the node above them.
typedef struct subtree {
    uint32_t first, count, depth;
    rsv_binary_node *node;
} subtree;

/// Sets the node, and brings the triangles of its left child to the front. @return how many; 0 = it is a leaf
static uint32_t split_node(rsv_boxed_triangle *part, const subtree *t)
{
    rsv_box box = empty_box;
    for (uint32_t k = 0; k < t->count; k++)
        box = rsv_box_join(box, part[t->first + k].box);
    *t->node = (rsv_binary_node){ box, t->first, t->count };
    if (t->count > 1 && t->depth + depth_of_halves(t->count) < RSV_BVH_DEPTH) {
        split at = find_split(part + t->first, t->count);
        if (at.bin) return divide(part + t->first, t->count, &at);
    }
    return t->count / 2;
}

static subtree left_of(const subtree *t, uint32_t left)
{
    return (subtree){ t->first, left, t->depth + 1, t->node + 1 };
}

static subtree right_of(const subtree *t, uint32_t left)
{
    return (subtree){ t->first + left, t->count - left, t->depth + 1, t->node + 2 * (size_t)left };
}

static void build_subtree(rsv_boxed_triangle *part, subtree t)
{
    uint32_t left = split_node(part, &t);
    if (left == 0) return;
    build_subtree(part, left_of(&t, left));
    build_subtree(part, right_of(&t, left));
}

/// Subtrees that remain to be built.
typedef struct build_job {
    rsv_boxed_triangle *part;
    uint32_t count;
    subtree tree[SUBTREES];
    uint32_t left[SUBTREES]; ///< triangles of the left child; 0 = not split
} build_job;

static void split_large(void *data, rsv_span span)
{
    build_job *job = data;
    for (size_t k = span.begin; k < span.end; k++)
        job->left[k] = job->tree[k].count > WHOLE_SIZE ? split_node(job->part, &job->tree[k]) : 0;
}

/// Puts the children of those that were split in their place. @return whether any was
static bool put_children(build_job *job)
{
    uint32_t count = job->count;
    for (uint32_t k = 0; k < count; k++) {
        uint32_t left = job->left[k];
        if (left == 0) continue;
        job->tree[job->count++] = right_of(&job->tree[k], left);
        job->tree[k] = left_of(&job->tree[k], left);
    }
    return job->count > count;
}

static void build_subtrees(void *data, rsv_span span)
{
    const build_job *job = data;
    for (size_t k = span.begin; k < span.end; k++)
        build_subtree(job->part, job->tree[k]);
}

/// Splits the upper nodes level by level until there are enough subtrees for all threads.
void rsv_binary_build(
    rsv_context *context, rsv_boxed_triangle *part, uint32_t count, rsv_binary_node *node)
{
    build_job job = { .part = part, .count = 1, .tree = { { 0, count, 0, node } } };
    bool any = true;
    while (any && 2 * job.count <= SUBTREES) {
        rsv_parallel_for(context, job.count, 1, split_large, &job);
        any = put_children(&job);
    }
    rsv_parallel_for(context, job.count, 1, build_subtrees, &job);
}
