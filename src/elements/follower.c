#include "follower.h"

#include "elements_constants.h"
#include "elements_internal.h"

bool rsv_cell_follows(const rsv_elements *e, uint32_t cell)
{
    for (int k = 0; k < 3; k++)
        if (e->node_hanging[e->cell_node[cell][k]] < e->follower_count) return true;
    return false;
}

/// Twice the area of a cell is that of the hats at its corners where nothing follows.
float rsv_cell_spacing(const rsv_elements *e, uint32_t cell)
{
    float largest = 2 * rsv_cell_area(e, cell);
    for (int k = 0; k < 3 && e->cell[cell].level == 0; k++) {
        uint32_t index = e->node_hanging[e->cell_node[cell][k]];
        if (index == RSV_NONE) continue;
        const rsv_hanging *follower = &e->hanging[index];
        float area = 0;
        for (int p = 0; p < RSV_PARENTS; p++)
            area += follower->weight[p] * e->node_area[follower->parent[p]];
        largest = f_max(largest, area);
    }
    return sqrtf(largest);
}

/// No more than there are nodes: half a one for each cell.
float rsv_cell_new_leaders(const rsv_elements *e, uint32_t cell)
{
    float radius = rsv_cluster_radius_at(e, cell);
    return f_min(0.5f, 2 * rsv_cell_area(e, cell) / (radius * radius));
}

/// How far apart the luminances of the leaders of one follower lie, beyond noise, as a share of the local level.
static float disagreement(const rsv_hanging *follower, const rsv_curvature_field *field)
{
    const rsv_rgb *value = field->value;
    uint32_t darkest = follower->parent[0], brightest = darkest;
    for (int p = 1; p < RSV_PARENTS; p++) {
        uint32_t leader = follower->parent[p];
        if (follower->weight[p] < LEAST_WEIGHT) continue;
        if (rgb_luminance(value[leader]) < rgb_luminance(value[darkest])) darkest = leader;
        if (rgb_luminance(value[leader]) > rgb_luminance(value[brightest])) brightest = leader;
    }
    float low = rgb_luminance(value[darkest]), high = rgb_luminance(value[brightest]);
    float level = 0.5f * (low + high) + field->floor;
    float apart =
        high - low - NOISE * hypotf(field->deviation[darkest], field->deviation[brightest]);
    return apart > 0 && level > 0 ? apart / level : 0;
}

void rsv_find_cluster_curvature(const rsv_elements *e, const rsv_curvature_field *field,
    rsv_curved_edge_found found, void *user)
{
    for (size_t h = 0; h < e->follower_count; h++) {
        const rsv_hanging *follower = &e->hanging[h];
        float curvature = disagreement(follower, field);
        if (!(curvature > field->threshold)) continue;
        for (uint32_t s = e->support_begin[follower->node];
             s < e->support_begin[follower->node + 1]; s++)
            found(user, e->support[s] / 4, e->support[s] / 4, curvature);
    }
}
