#include "bend.h"

#include "../core/index_map.h"

double rsv_elements_mean_luminance(const rsv_elements *e, const rsv_rgb *value)
{
    double sum = 0, area = 0;
    for (size_t n = 0; n < e->node_count; n++) {
        sum += (double)rgb_luminance(value[n]) * e->node_area[n];
        area += e->node_area[n];
    }
    return area > 0 ? sum / area : 0;
}

/// The values at the ends of an edge and at the corners opposite to it: where two equal cells make a
/// parallelogram, the sums agree on a plane.
static bool bends(const rsv_elements *e, const rsv_rgb *value, const float *deviation,
    uint32_t cell, int k, uint32_t other, int other_k, float threshold, float floor)
{
    const uint32_t *node = e->cell_node[cell], *far = e->cell_node[other];
    float ends = rgb_luminance(value[node[(k + 1) % 3]]) + rgb_luminance(value[node[(k + 2) % 3]]);
    float opposite = rgb_luminance(value[node[k]]) + rgb_luminance(value[far[other_k]]);
    float noise = 0;
    for (int c = 0; deviation && c < 4; c++) {
        float d = deviation[c < 3 ? node[c] : far[other_k]];
        noise += d * d;
    }
    return fabsf(ends - opposite) >
           threshold * (0.25f * (ends + opposite) + floor) + 2.5f * sqrtf(noise);
}

rsv_status rsv_find_bends(const rsv_elements *e, const rsv_rgb *value, const float *deviation,
    float threshold, float floor, rsv_bend_found found, void *user)
{
    rsv_index_map edges;
    rsv_status status = rsv_index_map_create(e->context, 2 * e->cell_count, &edges);
    for (size_t c = 0; c < e->cell_count && status == RSV_OK; c++) {
        for (int k = 0; k < 3; k++) {
            uint32_t p = e->cell_node[c][(k + 1) % 3], q = e->cell_node[c][(k + 2) % 3];
            uint64_t key = p < q ? (uint64_t)p << 32 | q : (uint64_t)q << 32 | p;
            uint32_t mine = (uint32_t)(4 * c) + (uint32_t)k;
            uint32_t first = rsv_index_map_insert(&edges, key, mine);
            if (first == UINT32_MAX) status = RSV_ERROR_MEMORY;
            if (first == UINT32_MAX || first == mine) continue;
            if (bends(e, value, deviation, (uint32_t)c, k, first / 4, (int)(first & 3), threshold,
                    floor))
                found(user, (uint32_t)c, first / 4);
        }
    }
    rsv_index_map_destroy(&edges);
    return status;
}
