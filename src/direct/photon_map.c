#include "photon_map.h"

#include "../core/team.h"

#include <string.h>

rsv_status rsv_photon_map_create(
    rsv_context *context, const rsv_elements *elements, double unit, rsv_photon_map *map)
{
    map->context = context;
    map->elements = elements;
    map->unit = unit;
    map->flux = rsv_alloc(context, elements->node_count, sizeof *map->flux);
    map->hits = rsv_alloc(context, elements->node_count, sizeof *map->hits);
    return map->flux && map->hits ? RSV_OK : RSV_ERROR_MEMORY;
}

void rsv_photon_map_clear(rsv_photon_map *map)
{
    memset(map->flux, 0, map->elements->node_count * sizeof *map->flux);
    memset(map->hits, 0, map->elements->node_count * sizeof *map->hits);
}

void rsv_photon_map_destroy(rsv_photon_map *map)
{
    if (!map->context) return;
    rsv_free(map->context, map->flux);
    rsv_free(map->context, map->hits);
    *map = (rsv_photon_map){ 0 };
}

void rsv_photon_map_unite(rsv_photon_map *map)
{
    size_t nodes = map->elements->node_count;
    rsv_team_sum(map->context, &map->flux[0][0], 3 * nodes);
    rsv_team_sum(map->context, (int64_t *)map->hits, nodes);
}

void rsv_photon_map_settle(rsv_photon_map *map)
{
    const rsv_elements *e = map->elements;
    for (size_t h = e->hanging_count; h-- > 0;) {
        const rsv_hanging *hanging = &e->hanging[h];
        for (int p = 0; p < RSV_PARENTS; p++) {
            double share = hanging->weight[p];
            for (int c = 0; c < 3; c++)
                map->flux[hanging->parent[p]][c] +=
                    (int64_t)llrint(share * (double)map->flux[hanging->node][c]);
            map->hits[hanging->parent[p]] += (uint64_t)(share * (double)map->hits[hanging->node]);
        }
    }
}

void rsv_photon_map_irradiance(const rsv_photon_map *map, rsv_rgb *irradiance)
{
    for (size_t node = 0; node < map->elements->node_count; node++) {
        float area = map->elements->node_area[node];
        double scale = area > 0 ? map->unit / area : 0;
        irradiance[node] = rgb((float)((double)map->flux[node][0] * scale),
            (float)((double)map->flux[node][1] * scale),
            (float)((double)map->flux[node][2] * scale));
    }
    rsv_elements_constrain(map->elements, irradiance);
}

static double total_flux(const rsv_elements *e, const rsv_rgb *irradiance)
{
    double flux = 0;
    for (size_t node = 0; node < e->node_count; node++)
        flux += (double)rgb_luminance(irradiance[node]) * e->node_area[node];
    return flux;
}

/// Photons per square metre around the nodes, in all three channels.
static rsv_rgb *photon_density(const rsv_photon_map *map)
{
    rsv_rgb *density = rsv_alloc(map->context, map->elements->node_count, sizeof *density);
    for (size_t node = 0; density && node < map->elements->node_count; node++) {
        float area = map->elements->node_area[node];
        density[node] = rgb_gray(area > 0 ? (float)map->hits[node] / (65536.0f * area) : 0);
    }
    if (density) rsv_elements_constrain(map->elements, density);
    return density;
}

rsv_status rsv_photon_map_shrink(const rsv_photon_map *map, const rsv_photon_map *coarse_map,
    const rsv_rgb *coarse, rsv_rgb *irradiance)
{
    const rsv_elements *e = map->elements;
    rsv_rgb *density = photon_density(coarse_map);
    if (!density) return RSV_ERROR_MEMORY;
    double before = total_flux(e, irradiance);
    for (size_t node = 0; node < e->node_count; node++) {
        uint32_t face;
        float u, v;
        rsv_elements_place_node(e, (uint32_t)node, &face, &u, &v);
        rsv_rgb around = rsv_elements_interpolate(coarse_map->elements, coarse, face, u, v);
        float expected = e->node_area[node] *
                         rsv_elements_interpolate(coarse_map->elements, density, face, u, v).r;
        // no photons where many were expected is as good a measurement as many
        float photons = f_max((float)map->hits[node] / 65536.0f, expected);
        float trust = photons / (photons + RSV_PHOTON_PRIOR);
        irradiance[node] = rgb_mad(rgb_scale(irradiance[node], trust), 1 - trust, around);
    }
    rsv_free(map->context, density);
    double after = total_flux(e, irradiance);
    float keep = after > 0 ? (float)(before / after) : 1;
    for (size_t node = 0; node < e->node_count; node++)
        irradiance[node] = rgb_scale(irradiance[node], keep);
    rsv_elements_constrain(e, irradiance);
    return RSV_OK;
}
