/// The binary tree from which a wide one is built.
#ifndef RSV_BVH_INTERNAL_H
#define RSV_BVH_INTERNAL_H

#include "../core/core.h"
#include "../core/vec.h"
#include "bvh.h"

typedef struct rsv_box {
    rsv_vec3 low, high;
} rsv_box;

RSV_INLINE rsv_box rsv_box_join(rsv_box a, rsv_box b)
{
    rsv_box both = { v3_min(a.low, b.low), v3_max(a.high, b.high) };
    return both;
}

RSV_INLINE rsv_vec3 rsv_box_centre(const rsv_box *box)
{
    return v3_add(v3_scale(box->low, 0.5f), v3_scale(box->high, 0.5f));
}

RSV_INLINE float v3_component(rsv_vec3 a, int axis)
{
    return axis == 0 ? a.x : axis == 1 ? a.y : a.z;
}

/// Half the surface of a box, the measure of how many rays meet it.
RSV_INLINE double rsv_box_area(const rsv_box *box)
{
    double x = (double)box->high.x - box->low.x, y = (double)box->high.y - box->low.y,
           z = (double)box->high.z - box->low.z;
    return x * y + y * z + z * x;
}

typedef struct rsv_boxed_triangle {
    rsv_box box;
    uint32_t triangle;
} rsv_boxed_triangle;

/// A node over `count` triangles from `first` on. A leaf holds one; else the left child follows the node, and the
/// right one follows the 2 n - 1 nodes of the left one's n triangles.
typedef struct rsv_binary_node {
    rsv_box box;
    uint32_t first, count;
} rsv_binary_node;

RSV_INLINE const rsv_binary_node *rsv_binary_left(const rsv_binary_node *node) { return node + 1; }

RSV_INLINE const rsv_binary_node *rsv_binary_right(const rsv_binary_node *node)
{
    return node + 2 * (size_t)node[1].count;
}

/// Splits by the surface area heuristic over bins (Wald 2007), and in halves where that would get deeper than
/// RSV_BVH_DEPTH.
/// @param part [count], at least 1; brought into the order of the leaves @param node [2 count - 1] out
void rsv_binary_build(
    rsv_context *context, rsv_boxed_triangle *part, uint32_t count, rsv_binary_node *node);

/// Makes the cheapest wide tree of a binary one (the dynamic programming of Ylitie et al., section 3.1).
/// @param node [triangle_count] out @param order [triangle_count] out: which of the binary tree's parts comes when
rsv_status rsv_bvh_widen(rsv_context *context, const rsv_binary_node *binary, rsv_bvh_node *node,
    uint32_t *order, uint32_t *node_count);

#endif
