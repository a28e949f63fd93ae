#include "moved_elements.h"

#include "../core/parallel.h"
#include "../elements/cut_cells.h"
#include "../elements/open_corners.h"

#include <string.h>

typedef struct follow_job {
    const rsv_transport_scene *scene;
    rsv_elements *elements;
    const rsv_elements_motion *motion;
    uint8_t *near;                  ///< [cell_count]
    uint16_t *valid_points;         ///< [node_count]
    uint8_t *anew;                  ///< [node_count]
    atomic_uint_least32_t contacts; ///< changes at contacts
} follow_job;

/// Cells near something that moved, and cells that moved themselves.
static void find_near(void *data, rsv_span span)
{
    const follow_job *job = data;
    const rsv_elements *e = job->elements;
    const rsv_elements_motion *m = job->motion;
    for (uint32_t c = (uint32_t)span.begin; c < span.end; c++) {
        uint8_t moved = m->moved[e->face_triangle[e->cell[c].face]];
        job->near[c] = moved == RSV_MOVE_TURN ||
                       (moved == RSV_MOVE_NONE && rsv_cell_is_beside(e, c, m->change));
    }
}

/// Changes at contacts, as in rsv_elements_motion.
static uint8_t compare_contacts(uint8_t then, uint8_t now)
{
    const uint8_t contact = RSV_CELL_CUT | RSV_CELL_CUT_THROUGH | RSV_CELL_SHELTERED;
    uint8_t changed = (then ^ now) & contact ? RSV_CELL_CUT : 0;
    return changed | (now & (uint8_t)~then & RSV_CELL_CUT_THROUGH);
}

static void judge_corners(void *data, rsv_span span)
{
    follow_job *job = data;
    rsv_elements *e = job->elements;
    uint32_t changed = 0;
    for (uint32_t c = (uint32_t)span.begin; c < span.end; c++) {
        uint64_t rays = 0;
        if (!job->near[c]) continue;
        uint8_t then = e->cell_openness[c];
        e->cell_openness[c] = rsv_cell_judge_again(job->scene, e, c, &rays);
        changed |= compare_contacts(then, e->cell_openness[c]);
    }
    atomic_fetch_or(&job->contacts, changed);
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

bool rsv_node_waits(const rsv_elements *e, uint32_t node, const uint8_t *moved)
{
    uint32_t face = e->node_face[node];
    return face != RSV_NONE && moved[e->face_triangle[face]] == RSV_MOVE_WAITS;
}

/// In scenes with glass bodies, points inside one may be in another medium now, so all points near a motion are checked
/// again.
static void judge_points(void *data, rsv_span span)
{
    const follow_job *job = data;
    const rsv_transport_scene *scene = job->scene;
    const rsv_elements *e = job->elements;
    const rsv_elements_motion *m = job->motion;
    uint16_t *valid_points = job->valid_points;
    uint8_t *anew = job->anew;
    for (uint32_t n = (uint32_t)span.begin; n < span.end; n++) {
        uint64_t rays = 0;
        anew[n] = rsv_node_waits(e, n, m->moved) ? RSV_MOVE_WAITS : RSV_MOVE_NONE;
        if (anew[n] == RSV_MOVE_WAITS) continue;
        node_change change = change_of(e, n, m->moved, job->near);
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

/// @param then, now [3] as in rsv_cell_sides
static bool are_same_sides(const float *then, const float *now)
{
    if (!then || !now) return !then && !now;
    return then[0] == now[0] && then[1] == now[1] && then[2] == now[2];
}

/// Lines on which walls stand, as they are now; what they part otherwise than before belongs to the change.
static rsv_status cut_again(
    const rsv_transport_scene *scene, rsv_elements *e, rsv_scene_change *change)
{
    uint64_t rays = 0;
    uint32_t *cut = e->cell_cut;
    float(*side)[3] = e->cut_side;
    if (!e->cell_openness) return RSV_OK;
    e->cell_cut = NULL;
    e->cut_side = NULL;
    rsv_status status = rsv_elements_find_cuts(scene, e, &rays);
    for (uint32_t c = 0; c < e->cell_count && status == RSV_OK && (cut || e->cell_cut); c++) {
        const float *then = cut && cut[c] != RSV_NONE ? side[cut[c]] : NULL,
                    *now = rsv_cell_sides(e, c);
        if (are_same_sides(then, now)) continue;
        rsv_box b = rsv_box_of_cell(e, c);
        rsv_scene_change_cover(change, b.low, b.high);
    }
    rsv_free(e->context, cut);
    rsv_free(e->context, side);
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
    follow_job job = { scene, e, m, near, valid_points, anew, 0 };
    rsv_parallel_for(e->context, e->cell_count, 256, find_near, &job);
    if (e->cell_openness) rsv_parallel_for(e->context, e->cell_count, 64, judge_corners, &job);
    if (m->contacts) *m->contacts = (uint8_t)job.contacts;
    rsv_parallel_for(e->context, e->node_count, 64, judge_points, &job);
    status = cut_again(scene, e, m->change);
    if (status == RSV_OK) status = bridge_again(e, valid_points, m->change);
    rsv_free(e->context, near);
    return status;
}
