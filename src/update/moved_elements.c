#include "moved_elements.h"

#include "../elements/open_corners.h"

#include <string.h>

/// Cells that something came or went beside, and those that moved.
static void find_near(
    const rsv_elements *e, const uint8_t *moved, const rsv_scene_change *change, uint8_t *near)
{
#pragma omp parallel for schedule(dynamic, 256) num_threads(rsv_threads(e->context))
    for (uint32_t c = 0; c < e->cell_count; c++)
        near[c] = moved[e->face_triangle[e->cell[c].face]] || rsv_cell_is_beside(e, c, change);
}

/// What changed at contacts, as in rsv_elements_motion.
static uint8_t compare_contacts(uint8_t then, uint8_t now)
{
    const uint8_t contact = RSV_CELL_CUT | RSV_CELL_CUT_THROUGH | RSV_CELL_SHELTERED;
    uint8_t changed = (then ^ now) & contact ? RSV_CELL_CUT : 0;
    return changed | (now & (uint8_t)~then & RSV_CELL_CUT_THROUGH);
}

/// @return what changed at contacts
static uint8_t judge_corners(const rsv_transport_scene *scene, rsv_elements *e, const uint8_t *near)
{
    uint32_t changed = 0;
    if (!e->cell_openness) return 0;
#pragma omp parallel for schedule(dynamic, 64) num_threads(rsv_threads(e->context))                \
    reduction(|                                                                                    \
              : changed)
    for (uint32_t c = 0; c < e->cell_count; c++) {
        uint64_t rays = 0;
        if (!near[c]) continue;
        uint8_t then = e->cell_openness[c];
        e->cell_openness[c] = rsv_cell_judge_again(scene, e, c, &rays);
        changed |= compare_contacts(then, e->cell_openness[c]);
    }
    return (uint8_t)changed;
}

/// Whether the node moved, and whether its points must be judged again.
typedef struct node_change {
    bool moved, near;
} node_change;

static void add_support(const rsv_elements *e, uint32_t node, const uint8_t *moved,
    const uint8_t *near, node_change *change)
{
    for (uint32_t s = e->support_begin[node]; s < e->support_begin[node + 1]; s++) {
        uint32_t cell = e->support[s] / 4;
        change->near = change->near || near[cell];
        change->moved = change->moved || moved[e->face_triangle[e->cell[cell].face]];
    }
}

static node_change change_of(
    const rsv_elements *e, uint32_t node, const uint8_t *moved, const uint8_t *near)
{
    node_change change = { false, false };
    add_support(e, node, moved, near, &change);
    for (uint32_t k = e->led_begin ? e->led_begin[node] : 0;
         e->led_begin && k < e->led_begin[node + 1]; k++)
        add_support(e, e->led[k].follower, moved, near, &change);
    return change;
}

/// Where bodies of glass are, what lies in one may have another medium around it now: all beside something is found anew.
static void judge_points(const rsv_transport_scene *scene, const rsv_elements *e,
    const rsv_elements_motion *m, const uint8_t *near, uint16_t *valid_points, uint8_t *anew)
{
#pragma omp parallel for schedule(dynamic, 64) num_threads(rsv_threads(e->context))
    for (uint32_t n = 0; n < e->node_count; n++) {
        node_change change = change_of(e, n, m->moved, near);
        uint64_t rays = 0;
        anew[n] = 0;
        if (e->node_hanging[n] != RSV_NONE || !(change.near || change.moved)) continue;
        uint16_t valid = rsv_judge_points(scene, e, n, rsv_elements_draw_of(e, n), m->draw, &rays);
        anew[n] = change.moved || valid != valid_points[n] || scene->media.bodies;
        valid_points[n] = valid;
    }
}

void rsv_elements_unbridge(rsv_elements *e)
{
    for (uint32_t n = 0; n < e->node_count; n++)
        for (uint32_t s = e->support_begin[n]; s < e->support_begin[n + 1]; s++)
            e->cell_node[e->support[s] / 4][e->support[s] & 3] = n;
    for (size_t h = e->follower_count; h < e->hanging_count; h++) {
        rsv_hanging *hanging = &e->hanging[h];
        if (hanging->weight[0] + hanging->weight[1] == 1) // one of them was buried
            hanging->weight[0] = hanging->weight[1] = 0.5f;
    }
}

static rsv_status bridge_again(
    rsv_elements *e, const uint16_t *valid_points, rsv_scene_change *change)
{
    size_t bytes = e->cell_count * sizeof *e->cell_node;
    uint32_t(*before)[3] = rsv_reserve(e->context, e->cell_count, sizeof *before);
    if (!before) return RSV_ERROR_MEMORY;
    memcpy(before, e->cell_node, bytes);
    rsv_elements_unbridge(e);
    rsv_status status = rsv_elements_bridge_buried(e, valid_points);
    for (uint32_t c = 0; c < e->cell_count && status == RSV_OK; c++) {
        if (memcmp(before[c], e->cell_node[c], sizeof before[c]) == 0) continue;
        rsv_box b = rsv_box_of_cell(e, c);
        rsv_scene_change_cover(change, b.low, b.high);
    }
    rsv_free(e->context, before);
    return status;
}

static bool changes_size(const rsv_elements *e, const uint8_t *moved)
{
    for (size_t face = 0; face < e->face_count; face++) {
        uint32_t t = e->face_triangle[face];
        float area = e->face_area[face];
        if (moved[t] && fabsf(rsv_triangle_area(e->scene, t) - area) > 1e-4f * area) return true;
    }
    return false;
}

rsv_status rsv_elements_follow(const rsv_transport_scene *scene, rsv_elements *e,
    const rsv_elements_motion *m, uint16_t *valid_points, uint8_t *anew)
{
    rsv_status status = RSV_ERROR_MEMORY;
    uint8_t *near = rsv_reserve(e->context, e->cell_count, 1);
    if (!near) return status;
    if (changes_size(e, m->moved)) rsv_elements_find_areas(e);
    find_near(e, m->moved, m->change, near);
    uint8_t contacts = judge_corners(scene, e, near);
    if (m->contacts) *m->contacts = contacts;
    judge_points(scene, e, m, near, valid_points, anew);
    status = bridge_again(e, valid_points, m->change);
    rsv_free(e->context, near);
    return status;
}
