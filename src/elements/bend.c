#include "bend.h"

#include "../core/index_map.h"

#include <string.h>

double rsv_elements_mean_luminance(const rsv_elements *e, const rsv_rgb *value)
{
    double sum = 0, area = 0;
    for (size_t n = 0; n < e->node_count; n++) {
        sum += (double)rgb_luminance(value[n]) * e->node_area[n];
        area += e->node_area[n];
    }
    return area > 0 ? sum / area : 0;
}

/// Which other cell lies across each edge.
typedef struct edge_partners {
    /// [4 * cell_count] by 4 * cell + corner opposite to the edge: the same of the other cell; NO_CELL at
    /// borders and where smaller or larger cells follow
    uint32_t *across;
} edge_partners;

#define NO_CELL UINT32_MAX

static uint64_t edge_key(uint32_t p, uint32_t q)
{
    return p < q ? (uint64_t)p << 32 | q : (uint64_t)q << 32 | p;
}

static uint64_t edge_of_cell(const rsv_elements *e, size_t cell, int k)
{
    return edge_key(e->cell_node[cell][(k + 1) % 3], e->cell_node[cell][(k + 2) % 3]);
}

static rsv_status find_partners(const rsv_elements *e, edge_partners *partners)
{
    rsv_index_map edges;
    partners->across = rsv_alloc(e->context, 4 * e->cell_count, sizeof *partners->across);
    if (!partners->across) return RSV_ERROR_MEMORY;
    memset(partners->across, 0xff, 4 * e->cell_count * sizeof *partners->across);
    rsv_status status = rsv_index_map_create(e->context, 2 * e->cell_count, &edges);
    for (size_t edge = 0; edge < 4 * e->cell_count && status == RSV_OK; edge++) {
        if (edge % 4 == 3) continue;
        uint64_t key = edge_of_cell(e, edge / 4, (int)(edge % 4));
        uint32_t first = rsv_index_map_insert(&edges, key, (uint32_t)edge);
        if (first == UINT32_MAX) status = RSV_ERROR_MEMORY;
        if (first == edge || first == UINT32_MAX) continue;
        partners->across[edge] = first;
        partners->across[first] = (uint32_t)edge;
    }
    rsv_index_map_destroy(&edges);
    return status;
}

/// Luminance at an edge and at the corners opposite to it: where two equal cells make a parallelogram,
/// the sums agree on a plane.
typedef struct edge_values {
    float ends, opposite;
    float noise; ///< standard deviation of what the two differ by
} edge_values;

static edge_values values_at(const rsv_elements *e, const rsv_rgb *value, const float *deviation,
    uint32_t edge, uint32_t across)
{
    const uint32_t *near = e->cell_node[edge / 4], *far = e->cell_node[across / 4];
    uint32_t k = edge % 4, p = near[(k + 1) % 3], q = near[(k + 2) % 3];
    uint32_t a = near[k], b = far[across % 4];
    edge_values v = { rgb_luminance(value[p]) + rgb_luminance(value[q]),
        rgb_luminance(value[a]) + rgb_luminance(value[b]), 0 };
    if (deviation)
        v.noise = sqrtf(deviation[p] * deviation[p] + deviation[q] * deviation[q] +
                        deviation[a] * deviation[a] + deviation[b] * deviation[b]);
    return v;
}

/// Standard deviations of noise that pass for no bend.
#define NOISE 2.0f

/// What noise does not explain, as a share of the local level; 0 where there is nothing.
static float bend_of(const edge_values *v, float floor)
{
    float level = 0.25f * (v->ends + v->opposite) + floor;
    float departure = fabsf(v->ends - v->opposite) - NOISE * v->noise;
    return departure > 0 && level > 0 ? departure / level : 0;
}

rsv_status rsv_find_bends(const rsv_elements *e, const rsv_rgb *value, const float *deviation,
    float threshold, float floor, rsv_bend_places places, rsv_bend_found found, void *user)
{
    edge_partners partners;
    rsv_status status = find_partners(e, &partners);
    for (uint32_t edge = 0; edge < 4 * e->cell_count && status == RSV_OK; edge++) {
        uint32_t across = partners.across[edge];
        bool border = across == NO_CELL && places == RSV_BENDS_AND_BORDERS;
        // an inner edge once, from its later side
        if (edge % 4 == 3 || (!border && across > edge)) continue;
        edge_values v = values_at(e, value, deviation, edge, border ? edge : across);
        float bend = bend_of(&v, floor);
        if (bend > threshold) found(user, edge / 4, (border ? edge : across) / 4, bend);
    }
    rsv_free(e->context, partners.across);
    return status;
}
