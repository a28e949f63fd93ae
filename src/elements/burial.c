#include "burial.h"

#include "../core/parallel.h"
#include "../core/team.h"
#include "open_corners.h"

uint16_t rsv_judge_points(const rsv_transport_scene *scene, const rsv_elements *e, uint32_t node,
    uint32_t index, rsv_support_draw draw, uint64_t *rays)
{
    rsv_support_point sample[16];
    rsv_elements_sample_support_as(e, node, index, draw.points, draw.seed, sample);
    uint16_t valid = 0;
    uint32_t last = RSV_NONE; // points of one cell come one after the other
    bool open = false;
    uint8_t openness = 0;
    rsv_cell_shape shape;
    rsv_vec3 outlook = { 0 };
    for (uint32_t k = 0; k < draw.points; k++) {
        uint32_t support = sample[k].support, cell = support / 4, face = e->cell[cell].face;
        if (support != last) {
            shape = rsv_cell_shape_of(e, cell);
            openness = rsv_cell_openness(scene, e, cell, &shape, rays);
            open = rsv_cell_outlook(openness, &shape, support & 3, &outlook);
            last = support;
        }
        if (!open) continue;
        rsv_surface_point point = rsv_surface_point_at(
            scene->view, e->face_triangle[face], sample[k].u, sample[k].v, e->face_back[face]);
        *rays += 2;
        if (rsv_cell_sees(scene, openness, &shape, outlook, point.position))
            valid |= (uint16_t)(1u << k);
    }
    return valid;
}

typedef struct burial_search {
    const rsv_transport_scene *scene;
    const rsv_elements *e;
    rsv_support_draw draw;
    const uint8_t *known;   ///< [node_count], or NULL
    uint16_t *valid_points; ///< [node_count], out
    rsv_team_place place;
    _Atomic uint64_t rays;
} burial_search;

static void judge_nodes(void *user, rsv_span span)
{
    burial_search *s = user;
    const rsv_elements *e = s->e;
    uint64_t rays = 0;
    for (size_t n = span.begin; n < span.end; n++) {
        uint32_t node = (uint32_t)n;
        if (!rsv_team_owns(s->place, node, RSV_TEAM_BLOCK) || (s->known && s->known[node]))
            continue;
        if (rsv_cancelled(e->context)) continue;
        s->valid_points[node] =
            e->node_hanging[node] == RSV_NONE
                ? rsv_judge_points(s->scene, e, node, rsv_elements_draw_of(e, node), s->draw, &rays)
                : 0;
    }
    atomic_fetch_add(&s->rays, rays);
}

rsv_status rsv_find_buried(const rsv_transport_scene *scene, const rsv_elements *e,
    rsv_support_draw draw, const uint8_t *known, uint16_t *valid_points, uint64_t *rays)
{
    burial_search search = { scene, e, draw, known, valid_points, rsv_team_place_of(e->context),
        0 };
    rsv_parallel_for(e->context, e->node_count, 64, judge_nodes, &search);
    *rays += rsv_team_total(e->context, search.rays);
    rsv_team_merge(e->context, valid_points, sizeof *valid_points, e->node_count, RSV_TEAM_BLOCK);
    return rsv_progress(e->context, "assemble", 0);
}

/// Hanging nodes are as sound as their parents; those with a buried parent follow the others.
static void bridge_hanging(rsv_elements *e, uint8_t *sound)
{
    for (size_t h = 0; h < e->hanging_count; h++) {
        rsv_hanging *hanging = &e->hanging[h];
        float left = 0;
        for (int p = 0; p < RSV_PARENTS; p++)
            left += sound[hanging->parent[p]] ? hanging->weight[p] : 0;
        sound[hanging->node] = left > 0;
        for (int p = 0; p < RSV_PARENTS && left > 0; p++)
            hanging->weight[p] = sound[hanging->parent[p]] ? hanging->weight[p] / left : 0;
    }
}

static void bridge_cell(uint32_t node[3], const uint8_t *sound)
{
    uint32_t stand_in[3];
    int count = 0;
    for (int k = 0; k < 3; k++)
        if (sound[node[k]]) stand_in[count++] = node[k];
    if (count == 0 || count == 3) return;
    for (int k = 0, next = 0; k < 3; k++)
        if (!sound[node[k]]) node[k] = stand_in[next++ % count];
}

/// Of a cell that a wall cuts: corners take the value of the other one on their side of the wall, if there is one.
static void bridge_sides(uint32_t node[3], const float side[3], const uint8_t *sound)
{
    const uint32_t own[3] = { node[0], node[1], node[2] };
    for (int k = 0; k < 3; k++)
        for (int other = 0; other < 3 && !sound[node[k]]; other++)
            if (side[k] * side[other] > 0 && sound[own[other]]) node[k] = own[other];
}

rsv_status rsv_elements_bridge_buried(rsv_elements *e, const uint16_t *valid_points)
{
    uint8_t *sound = rsv_alloc(e->context, e->node_count, 1);
    if (!sound) return RSV_ERROR_MEMORY;
    for (size_t n = 0; n < e->node_count; n++)
        sound[n] = valid_points[n] != 0;
    bridge_hanging(e, sound);
    for (size_t c = 0; c < e->cell_count; c++) {
        const float *side = rsv_cell_sides(e, (uint32_t)c);
        if (side) bridge_sides(e->cell_node[c], side, sound);
        bridge_cell(e->cell_node[c], sound);
    }
    rsv_free(e->context, sound);
    return RSV_OK;
}

void rsv_mark_buried(const rsv_elements *e, const uint16_t *valid_points, float *deviation)
{
    for (size_t n = 0; n < e->node_count; n++)
        if (!valid_points[n] && e->node_hanging[n] == RSV_NONE) deviation[n] = INFINITY;
    for (size_t h = 0; h < e->hanging_count; h++) {
        const rsv_hanging *hanging = &e->hanging[h];
        float largest = 0;
        for (int p = 0; p < RSV_PARENTS; p++)
            if (hanging->weight[p] > 0) largest = f_max(largest, deviation[hanging->parent[p]]);
        deviation[hanging->node] = largest;
    }
}
