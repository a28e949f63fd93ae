#include "node_groups.h"

#include "../core/parallel.h"
#include "../elements/voxels.h"
#include "solve_constants.h"

#include <math.h>
#include <stdlib.h>

enum { dimensions = 6 };

/// A node as a point of six dimensions: position in units of the scene's size, and normal.
typedef struct placed_node {
    float at[dimensions];
    uint32_t node;
} placed_node;

static void place(const rsv_elements *e, uint32_t node, placed_node *p)
{
    size_t surface_nodes = rsv_elements_surface_nodes(e);
    if (node >= surface_nodes) {
        rsv_vec3 centre = rsv_voxel_centre(e->voxels, node - (uint32_t)surface_nodes);
        *p = (placed_node){ { centre.x, centre.y, centre.z }, node };
        return;
    }
    uint32_t face;
    float u, v;
    rsv_elements_place_node(e, node, &face, &u, &v);
    rsv_surface_point s =
        rsv_surface_point_at(e->scene, e->face_triangle[face], u, v, e->face_back[face]);
    *p = (placed_node){ { s.position.x, s.position.y, s.position.z, s.geometric.x, s.geometric.y,
                            s.geometric.z },
        node };
}

/// The longest side of the box around some nodes.
static int longest_axis(const placed_node *nodes, size_t count, float *length)
{
    int longest = 0;
    *length = 0;
    for (int k = 0; k < dimensions; k++) {
        float low = nodes[0].at[k], high = low;
        for (size_t n = 1; n < count; n++) {
            low = f_min(low, nodes[n].at[k]);
            high = f_max(high, nodes[n].at[k]);
        }
        if (high - low > *length) *length = high - low, longest = k;
    }
    return longest;
}

/// Positions in units of the longest side of the scene.
static void normalise(placed_node *nodes, size_t count)
{
    float size = 0;
    for (int k = 0; k < 3; k++) {
        float low = nodes[0].at[k], high = low;
        for (size_t n = 1; n < count; n++) {
            low = f_min(low, nodes[n].at[k]);
            high = f_max(high, nodes[n].at[k]);
        }
        size = f_max(size, high - low);
    }
    for (size_t n = 0; n < count && size > 0; n++)
        for (int k = 0; k < 3; k++)
            nodes[n].at[k] /= size;
}

static bool before(const placed_node *a, const placed_node *b, int axis)
{
    return a->at[axis] != b->at[axis] ? a->at[axis] < b->at[axis] : a->node < b->node;
}

static void swap(placed_node *a, placed_node *b)
{
    placed_node keep = *a;
    *a = *b;
    *b = keep;
}

/// Reorders nodes so that the first `half` come before the others along an axis (Hoare's selection).
static void split(placed_node *nodes, size_t count, size_t half, int axis)
{
    while (count > 1) {
        swap(&nodes[count / 2], &nodes[count - 1]);
        size_t smaller = 0;
        for (size_t n = 0; n + 1 < count; n++)
            if (before(&nodes[n], &nodes[count - 1], axis)) swap(&nodes[n], &nodes[smaller++]);
        swap(&nodes[smaller], &nodes[count - 1]);
        if (smaller == half) return;
        if (half < smaller) {
            count = smaller;
        } else {
            nodes += smaller + 1;
            count -= smaller + 1;
            half -= smaller + 1;
        }
    }
}

/// Halves the nodes until `parts` groups are left.
static void assign(
    placed_node *nodes, size_t count, size_t parts, uint32_t *group, size_t *group_count)
{
    float length;
    int axis = longest_axis(nodes, count, &length);
    if (parts <= 1 || count < 2 || length == 0) {
        for (size_t n = 0; n < count; n++)
            group[nodes[n].node] = (uint32_t)*group_count;
        ++*group_count;
        return;
    }
    size_t half = count / 2;
    split(nodes, count, half, axis);
    assign(nodes, half, parts / 2, group, group_count);
    assign(nodes + half, count - half, parts - parts / 2, group, group_count);
}

typedef struct place_job {
    const rsv_elements *elements;
    placed_node *nodes;
} place_job;

static void place_span(void *data, rsv_span span)
{
    const place_job *job = data;
    for (size_t k = span.begin; k < span.end; k++)
        place(job->elements, job->nodes[k].node, &job->nodes[k]);
}

/// Places the nodes that do not hang. @return how many there are
static size_t place_free_nodes(const rsv_elements *e, placed_node *nodes)
{
    size_t count = 0;
    for (size_t n = 0; n < e->node_count; n++)
        if (e->node_hanging[n] == RSV_NONE) nodes[count++].node = (uint32_t)n;
    place_job job = { e, nodes };
    rsv_parallel_for(e->context, count, count > 4096 ? 0 : count, place_span, &job);
    return count;
}

rsv_status rsv_group_nodes(const rsv_elements *e, uint32_t *group, size_t *group_count)
{
    *group_count = 0;
    if (e->node_count == 0) return RSV_OK;
    placed_node *nodes = rsv_alloc(e->context, e->node_count, sizeof *nodes);
    if (!nodes) return RSV_ERROR_MEMORY;
    size_t count = place_free_nodes(e, nodes), parts = count / NODES_PER_GROUP;
    if (count > 0) {
        normalise(nodes, count);
        assign(nodes, count, parts < MAX_GROUPS ? parts : MAX_GROUPS, group, group_count);
    }
    for (size_t h = 0; h < e->hanging_count; h++) // parents come before their children
        group[e->hanging[h].node] = group[e->hanging[h].parent[0]];
    rsv_free(e->context, nodes);
    return RSV_OK;
}
