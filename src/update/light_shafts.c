#include "light_shafts.h"

#include "../core/parallel.h"
#include "../scene/punctual.h"
#include "update_constants.h"

static void add_source(rsv_light_shafts *p, uint32_t at, rsv_vec3 place)
{
    if (at >= p->source_count) {
        p->source[at] = (rsv_box){ place, place };
        p->source_count = at + 1;
    }
    p->source[at].low = v3_min(p->source[at].low, place);
    p->source[at].high = v3_max(p->source[at].high, place);
}

static void add_light(rsv_light_shafts *p, uint32_t at, const rsv_punctual_light *light)
{
    float r = rsv_punctual_radius(light);
    add_source(p, at, v3_sub(light->position, v3(r, r, r)));
    add_source(p, at, v3_add(light->position, v3(r, r, r)));
}

/// Emitters and punctual lights in their order share the boxes.
void rsv_light_shafts_find_sources(rsv_light_shafts *p, const rsv_lights *lights)
{
    const rsv_scene_view *scene = lights->scene;
    size_t count = lights->sampled_count + lights->punctual_count, at = 0;
    size_t share = (count + RSV_HISTORY_SOURCES - 1) / RSV_HISTORY_SOURCES;
    for (size_t k = 0; k < lights->sampled_count; k++, at++)
        for (int corner = 0; corner < 3; corner++)
            add_source(
                p, (uint32_t)(at / share), lights->emitter[lights->sampled[k]].corner[corner]);
    for (size_t k = lights->distant_count; k < lights->punctual_count; k++, at++)
        add_light(p, (uint32_t)(at / share), &scene->light[lights->punctual[k]]);
    p->all_light_changed = p->all_light_changed || lights->distant_count > RSV_HISTORY_SOURCES;
    for (size_t k = 0; k < lights->distant_count && !p->all_light_changed; k++)
        p->sun[p->sun_count++] = v3_neg(scene->light[lights->punctual[k]].direction);
    // suns of an environment have a size, and its sky has one anyway
    p->sky = lights->environment && rsv_environment_light_is_sampled(lights->environment);
}

rsv_box rsv_box_grow(rsv_box b, float by)
{
    rsv_vec3 more = v3(by, by, by);
    return (rsv_box){ v3_sub(b.low, more), v3_add(b.high, more) };
}

rsv_box rsv_box_of_cell(const rsv_elements *e, uint32_t cell)
{
    const rsv_cell *c = &e->cell[cell];
    const uint32_t *corner = e->scene->triangle[e->face_triangle[c->face]];
    rsv_box b = { v3(INFINITY, INFINITY, INFINITY), v3(-INFINITY, -INFINITY, -INFINITY) };
    for (int k = 0; k < 3; k++) {
        float u, v;
        rsv_cell_corner(c, k, &u, &v);
        rsv_vec3 p = v3_scale(e->scene->position[corner[0]], 1 - u - v);
        p = v3_mad(p, u, e->scene->position[corner[1]]);
        p = v3_mad(p, v, e->scene->position[corner[2]]);
        b.low = v3_min(b.low, p);
        b.high = v3_max(b.high, p);
    }
    return b;
}

rsv_box rsv_reach_of_cell(const rsv_elements *e, uint32_t cell)
{
    float size = sqrtf(2 * rsv_cell_area(e, cell));
    return rsv_box_grow(
        rsv_box_of_cell(e, cell), REACH_OF_SIZE * size + REACH_OF_SPACING * e->spacing);
}

static bool overlap(const rsv_box *b, rsv_vec3 low, rsv_vec3 high)
{
    return b->low.x <= high.x && b->low.y <= high.y && b->low.z <= high.z && b->high.x >= low.x &&
           b->high.y >= low.y && b->high.z >= low.z;
}

bool rsv_box_meets(const rsv_box *b, const rsv_scene_change *change)
{
    for (uint32_t k = 0; k < change->count; k++)
        if (overlap(b, change->low[k], change->high[k])) return true;
    return false;
}

bool rsv_cell_is_beside(const rsv_elements *e, uint32_t cell, const rsv_scene_change *change)
{
    rsv_box b = rsv_reach_of_cell(e, cell);
    return rsv_box_meets(&b, change);
}

static bool is_support_beside(const rsv_elements *e, uint32_t node, const rsv_scene_change *change)
{
    for (uint32_t s = e->support_begin[node]; s < e->support_begin[node + 1]; s++)
        if (rsv_cell_is_beside(e, e->support[s] / 4, change)) return true;
    return false;
}

bool rsv_node_is_beside(const rsv_elements *e, uint32_t node, const rsv_scene_change *change)
{
    if (is_support_beside(e, node, change)) return true;
    for (uint32_t k = e->led_begin ? e->led_begin[node] : 0;
         e->led_begin && k < e->led_begin[node + 1]; k++)
        if (is_support_beside(e, e->led[k].follower, change)) return true;
    return false;
}

typedef struct interval {
    float low, high;
} interval;

/// Narrows `part` to that part of the way of an interval from `a` to `b` in which it meets `place`.
static void narrow(interval a, interval b, interval place, interval *part)
{
    // its lower end is below the upper one of `place`, its upper end above the lower one: two half lines
    const float at[2] = { a.low - place.high, place.low - a.high },
                rise[2] = { b.low - a.low, a.high - b.high };
    for (int k = 0; k < 2; k++) {
        if (rise[k] == 0) {
            if (at[k] > 0) part->high = -1;
        } else if (rise[k] > 0) {
            part->high = f_min(part->high, -at[k] / rise[k]);
        } else {
            part->low = f_max(part->low, -at[k] / rise[k]);
        }
    }
}

/// Whether any line from a point in `a` to one in `b` may meet the box between low and high: whether that box meets the
/// hull of both, which is the union of all boxes between one and the other.
static bool shaft_meets(const rsv_box *a, const rsv_box *b, rsv_vec3 low, rsv_vec3 high)
{
    interval part = { 0, 1 };
    narrow((interval){ a->low.x, a->high.x }, (interval){ b->low.x, b->high.x },
        (interval){ low.x, high.x }, &part);
    narrow((interval){ a->low.y, a->high.y }, (interval){ b->low.y, b->high.y },
        (interval){ low.y, high.y }, &part);
    narrow((interval){ a->low.z, a->high.z }, (interval){ b->low.z, b->high.z },
        (interval){ low.z, high.z }, &part);
    return part.low <= part.high + 1e-5f && part.high >= 0;
}

/// Whether a box reaches above the plane of a cell.
static bool rises_above(
    const rsv_elements *e, uint32_t cell, const rsv_box *place, rsv_vec3 low, rsv_vec3 high)
{
    uint32_t face = e->cell[cell].face;
    rsv_vec3 normal = rsv_surface_point_at(
        e->scene, e->face_triangle[face], 1.0f / 3, 1.0f / 3, e->face_back[face])
                          .geometric;
    rsv_vec3 top = v3(normal.x > 0 ? high.x - place->low.x : low.x - place->high.x,
        normal.y > 0 ? high.y - place->low.y : low.y - place->high.y,
        normal.z > 0 ? high.z - place->low.z : low.z - place->high.z);
    return v3_dot(top, normal) > 0;
}

bool rsv_light_shafts_meet(const rsv_light_shafts *p, const rsv_elements *e, uint32_t cell)
{
    if (p->all_light_changed) return true;
    const rsv_scene_view *scene = e->scene;
    float far = 2 * v3_length(v3_sub(scene->bounds_max, scene->bounds_min));
    rsv_box place = rsv_reach_of_cell(e, cell);
    for (uint32_t k = 0; k < p->change->count; k++) {
        rsv_vec3 low = p->change->low[k], high = p->change->high[k];
        if (!rises_above(e, cell, &place, low, high)) continue;
        if (p->sky) return true;
        for (uint32_t s = 0; s < p->source_count; s++)
            if (shaft_meets(&place, &p->source[s], low, high)) return true;
        for (uint32_t s = 0; s < p->sun_count; s++) {
            rsv_vec3 away = v3_scale(p->sun[s], far);
            rsv_box end = { v3_add(place.low, away), v3_add(place.high, away) };
            if (shaft_meets(&place, &end, low, high)) return true;
        }
    }
    return false;
}

typedef struct shaft_job {
    const rsv_light_shafts *shafts;
    const rsv_elements *elements;
    uint8_t *light_changed;
} shaft_job;

static void test_cells(void *data, rsv_span span)
{
    const shaft_job *job = data;
    for (uint32_t c = (uint32_t)span.begin; c < span.end; c++)
        job->light_changed[c] = rsv_light_shafts_meet(job->shafts, job->elements, c);
}

rsv_status rsv_light_shafts_find_changed(
    const rsv_light_shafts *p, const rsv_elements *e, uint8_t **light_changed)
{
    shaft_job job = { p, e, *light_changed = rsv_alloc(e->context, e->cell_count, 1) };
    if (!job.light_changed) return RSV_ERROR_MEMORY;
    rsv_parallel_for(e->context, e->cell_count, 256, test_cells, &job);
    return RSV_OK;
}

static bool is_support_light_changed(
    const rsv_elements *e, uint32_t node, const uint8_t *cell_light_changed)
{
    for (uint32_t s = e->support_begin[node]; s < e->support_begin[node + 1]; s++)
        if (cell_light_changed[e->support[s] / 4]) return true;
    return false;
}

bool rsv_node_light_is_changed(
    const rsv_elements *e, uint32_t node, const uint8_t *cell_light_changed)
{
    bool changed = is_support_light_changed(e, node, cell_light_changed);
    for (uint32_t k = e->led_begin ? e->led_begin[node] : 0;
         e->led_begin && !changed && k < e->led_begin[node + 1]; k++)
        changed = is_support_light_changed(e, e->led[k].follower, cell_light_changed);
    return changed;
}
