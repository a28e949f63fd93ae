#include "bvh_internal.h"

#define WIDTH 8
#define NODE_COST 1.0f
#define TRIANGLE_COST 0.3f ///< relative to a node's

/// Costs of the subtrees of a binary tree.
typedef struct forest_costs {
    const rsv_binary_node *root;
    float (
        *cost)[WIDTH - 1]; ///< [2 triangle_count - 1] cheapest as at most 1, 2, ... wide subtrees
} forest_costs;

static float cost_of(const forest_costs *f, const rsv_binary_node *node, int trees)
{
    return f->cost[node - f->root][trees - 1];
}

/// The cheapest way to have at most `trees` subtrees, 2 to 8, below a binary node with children.
/// @param left how many of them are the left child's
static float distribute(const forest_costs *f, const rsv_binary_node *node, int trees, int *left)
{
    const rsv_binary_node *a = rsv_binary_left(node), *b = rsv_binary_right(node);
    float best = INFINITY;
    *left = 1;
    for (int k = 1; k < trees; k++) {
        float cost = cost_of(f, a, k) + cost_of(f, b, trees - k);
        if (cost >= best) continue;
        best = cost;
        *left = k;
    }
    return best;
}

static float leaf_cost(const rsv_binary_node *node)
{
    return (float)rsv_box_area(&node->box) * (TRIANGLE_COST * (float)node->count);
}

static float inner_cost(const forest_costs *f, const rsv_binary_node *node)
{
    int left;
    return (float)rsv_box_area(&node->box) * NODE_COST + distribute(f, node, WIDTH, &left);
}

static bool is_leaf(const forest_costs *f, const rsv_binary_node *node)
{
    return node->count == 1 ||
           (node->count <= RSV_BVH_LEAF && leaf_cost(node) <= inner_cost(f, node));
}

static void find_costs(forest_costs *f)
{
    for (size_t k = 2 * (size_t)f->root->count - 1; k-- > 0;) { // children before parents
        const rsv_binary_node *node = f->root + k;
        f->cost[k][0] = is_leaf(f, node) ? leaf_cost(node) : inner_cost(f, node);
        for (int trees = 2; trees < WIDTH; trees++) {
            int left;
            float cost = node->count > 1 ? distribute(f, node, trees, &left) : INFINITY;
            f->cost[k][trees - 1] = f_min(cost, f->cost[k][trees - 2]);
        }
    }
}

// ---- children -----------------------------------------------------------------------------------

typedef struct children {
    const rsv_binary_node *node[WIDTH];
    int count;
} children;

static void gather_below(
    const forest_costs *f, const rsv_binary_node *node, int trees, children *into);

/// The subtrees that `node` is best represented by, at most `trees`.
static void gather(const forest_costs *f, const rsv_binary_node *node, int trees, children *into)
{
    while (trees > 1 && cost_of(f, node, trees) >= cost_of(f, node, trees - 1))
        trees--;
    if (trees == 1)
        into->node[into->count++] = node;
    else
        gather_below(f, node, trees, into);
}

static void gather_below(
    const forest_costs *f, const rsv_binary_node *node, int trees, children *into)
{
    int left;
    distribute(f, node, trees, &left);
    gather(f, rsv_binary_left(node), left, into);
    gather(f, rsv_binary_right(node), trees - left, into);
}

/// How far a child lies towards the octant that a slot stands for.
static float towards_slot(rsv_vec3 from_middle, int slot)
{
    return (slot & 1 ? from_middle.x : -from_middle.x) +
           (slot & 2 ? from_middle.y : -from_middle.y) +
           (slot & 4 ? from_middle.z : -from_middle.z);
}

/// Gives every child a slot, the most decided first. @param slot [WIDTH] out: NULL = empty
static void place_in_slots(
    const rsv_binary_node *parent, const children *from, const rsv_binary_node *slot[WIDTH])
{
    rsv_vec3 middle = rsv_box_centre(&parent->box), offset[WIDTH];
    bool placed[WIDTH] = { false };
    for (int k = 0; k < WIDTH; k++)
        slot[k] = NULL;
    for (int k = 0; k < from->count; k++)
        offset[k] = v3_sub(rsv_box_centre(&from->node[k]->box), middle);
    for (int n = 0; n < from->count; n++) {
        float best = -INFINITY;
        int child = -1, into = -1;
        for (int k = 0; k < from->count; k++)
            for (int s = 0; s < WIDTH && !placed[k]; s++) {
                float gain = towards_slot(offset[k], s);
                if (slot[s] || (child >= 0 && !(gain > best))) continue;
                best = gain, child = k, into = s;
            }
        RSV_ASSERT(child >= 0 && into >= 0); // no more children than slots
        slot[into] = from->node[child];
        placed[child] = true;
    }
}

// ---- boxes on a grid ----------------------------------------------------------------------------

static void set_byte(uint32_t word[2], int k, uint32_t byte) { word[k / 4] |= byte << 8 * (k % 4); }

/// The finest grid of 255 steps that spans an extent; single steps are normal numbers.
static int grid_exponent(double extent)
{
    int exponent;
    if (extent == 0) return -126;
    frexp(extent / 255, &exponent); // extent / 255 < 2^exponent
    return exponent < -126 ? -126 : exponent;
}

static void set_grid(rsv_bvh_node *node, const rsv_box *box, double step[3])
{
    for (int axis = 0; axis < 3; axis++) {
        float low = v3_component(box->low, axis);
        int exponent = grid_exponent((double)v3_component(box->high, axis) - low);
        node->origin[axis] = low;
        node->exponents |= (uint32_t)(exponent + 127) << 8 * axis;
        step[axis] = ldexp(1, exponent);
    }
}

static void set_box(rsv_bvh_node *node, int slot, const rsv_box *box, const double step[3])
{
    for (int axis = 0; axis < 3; axis++) {
        double low = (double)v3_component(box->low, axis) - node->origin[axis];
        double high = (double)v3_component(box->high, axis) - node->origin[axis];
        set_byte(node->low[axis], slot, (uint32_t)floor(low / step[axis]));
        set_byte(node->high[axis], slot, (uint32_t)ceil(high / step[axis]));
    }
}

// ---- nodes --------------------------------------------------------------------------------------

/// The wide tree in the making.
typedef struct widening {
    forest_costs costs;
    rsv_bvh_node *node;
    const rsv_binary_node **source; ///< [triangle_count] binary node of each wide one
    uint32_t *order;
    uint32_t node_count, triangle_count; ///< so far
} widening;

static uint32_t add_leaf(widening *w, const rsv_bvh_node *node, const rsv_binary_node *leaf)
{
    uint32_t first = w->triangle_count - node->first_triangle;
    for (uint32_t k = 0; k < leaf->count; k++)
        w->order[w->triangle_count++] = leaf->first + k;
    return ((1u << leaf->count) - 1) << 5 | first;
}

static uint32_t add_inner(widening *w, rsv_bvh_node *node, int slot, const rsv_binary_node *child)
{
    node->exponents |= 1u << (24 + slot);
    w->source[w->node_count++] = child;
    return 1u << 5 | (uint32_t)(24 + slot);
}

static void fill_node(widening *w, uint32_t index)
{
    const rsv_binary_node *source = w->source[index], *slot[WIDTH];
    rsv_bvh_node *node = &w->node[index];
    children below = { .count = 0 };
    double step[3];
    if (source->count == 1)
        below.node[below.count++] = source;
    else
        gather_below(&w->costs, source, WIDTH, &below);
    place_in_slots(source, &below, slot);
    *node = (rsv_bvh_node){ .first_child = w->node_count, .first_triangle = w->triangle_count };
    set_grid(node, &source->box, step);
    for (int k = 0; k < WIDTH; k++) {
        if (!slot[k]) continue;
        bool leaf = is_leaf(&w->costs, slot[k]);
        set_byte(node->meta, k, leaf ? add_leaf(w, node, slot[k]) : add_inner(w, node, k, slot[k]));
        set_box(node, k, &slot[k]->box, step);
    }
}

rsv_status rsv_bvh_widen(rsv_context *context, const rsv_binary_node *binary, rsv_bvh_node *node,
    uint32_t *order, uint32_t *node_count)
{
    rsv_status status = RSV_ERROR_MEMORY;
    widening w = { .costs = { .root = binary }, .node = node, .order = order, .node_count = 1 };
    size_t binary_count = 2 * (size_t)binary->count - 1;
    w.costs.cost = rsv_reserve(context, binary_count, sizeof *w.costs.cost);
    w.source = rsv_reserve(context, binary->count, sizeof(rsv_binary_node *));
    if (!w.costs.cost || !w.source) goto cleanup;
    find_costs(&w.costs);
    w.source[0] = binary;
    for (uint32_t k = 0; k < w.node_count; k++)
        fill_node(&w, k);
    *node_count = w.node_count;
    status = RSV_OK;
cleanup:
    rsv_free(context, w.costs.cost);
    rsv_free(context, w.source);
    return status;
}
