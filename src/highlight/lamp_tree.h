/// Emitters as polygons under a tree, so that as many as there may be cost no more than a few at a point: parts of the tree
/// that matter little stand for all in them, as a rectangle that faces the point.
#ifndef RSV_LAMP_TREE_H
#define RSV_LAMP_TREE_H

#include "highlight.h"

/// One triangle, or two that make a parallelogram.
typedef struct rsv_lamp {
    rsv_vec3 corner[4];
    rsv_vec3 normal;
    rsv_rgb radiance;
    float area;
    uint32_t count;   ///< corners
    uint32_t emitter; ///< the first of it
    uint32_t group;
    bool double_sided;
} rsv_lamp;

/// Lamps side by side. What they show of themselves from a direction w, area times luminance, is close to
/// (flow.w + sqrt(w.Qw)) / 2: exact for one lamp, and for a sphere.
typedef struct rsv_lamp_node {
    rsv_vec3 middle;
    float radius;    ///< around the middle
    rsv_vec3 flow;   ///< sum of area luminance normal, of one-sided lamps
    float facing[6]; ///< Q: xx, yy, zz, xy, xz, yz
    float spread[6]; ///< covariance of place, likewise
    rsv_rgb color;   ///< of luminance 1
    uint32_t right;  ///< the left child follows its parent; 0 = leaf
    uint32_t lamp;   ///< the first of those below
    uint32_t group;  ///< RSV_NONE = of several
} rsv_lamp_node;

typedef struct rsv_lamp_tree {
    rsv_lamp *lamp;      ///< [lamp_count] in the order of the leaves
    rsv_lamp_node *node; ///< [2 lamp_count - 1]
    uint32_t *
        root; ///< [group_count] node that holds the whole of a group; RSV_NONE = none of it takes part
    size_t lamp_count;
} rsv_lamp_tree;

rsv_status rsv_lamp_tree_create(
    const rsv_lights *lights, rsv_highlight_part part, rsv_lamp_tree *tree);
void rsv_lamp_tree_destroy(rsv_context *context, rsv_lamp_tree *tree);

RSV_INLINE float rsv_quadratic(const float q[6], rsv_vec3 w)
{
    return q[0] * w.x * w.x + q[1] * w.y * w.y + q[2] * w.z * w.z +
           2 * (q[3] * w.x * w.y + q[4] * w.x * w.z + q[5] * w.y * w.z);
}

/// Area times luminance that a node shows to unit direction `w` from it.
RSV_INLINE float rsv_lamp_intensity(const rsv_lamp_node *node, rsv_vec3 w)
{
    float sum = v3_dot(node->flow, w) + sqrtf(f_max(rsv_quadratic(node->facing, w), 0));
    return f_max(0.5f * sum, 0);
}

/// The rectangle that stands for a node: faces the point, and is as wide as the lamps.
/// @param corner [4] out @return its luminance
float rsv_lamp_stand_in(const rsv_lamp_node *node, rsv_vec3 point, rsv_vec3 *corner);

#endif
