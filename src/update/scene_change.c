#include "scene_change.h"

#include "element_keys.h"
#include "update_constants.h"

#include <stdlib.h>

static bool has_holes(const rsv_scene_view *scene, uint32_t triangle)
{
    return scene->material[scene->triangle_material[triangle]].alpha_cutoff > 0;
}

static int compare_keys(const void *left, const void *right)
{
    uint64_t a = *(const uint64_t *)left, b = *(const uint64_t *)right;
    return (a > b) - (a < b);
}

rsv_status rsv_scene_change_keys(
    rsv_context *context, const rsv_scene_view *scene, uint64_t **keys, size_t *count)
{
    uint64_t *key = rsv_alloc(context, scene->triangle_count, sizeof *key);
    if (!key) return RSV_ERROR_MEMORY;
    *count = 0;
    for (uint32_t t = 0; t < scene->triangle_count; t++)
        if (!has_holes(scene, t)) key[(*count)++] = rsv_triangle_key(scene, t);
    qsort(key, *count, sizeof *key, compare_keys);
    *keys = key;
    return RSV_OK;
}

static void cover(rsv_scene_change *c, uint32_t box, rsv_vec3 low, rsv_vec3 high)
{
    c->low[box] = v3_min(c->low[box], low);
    c->high[box] = v3_max(c->high[box], high);
}

static float half_surface(rsv_vec3 low, rsv_vec3 high)
{
    rsv_vec3 d = v3_sub(high, low);
    return d.x * d.y + d.y * d.z + d.z * d.x;
}

/// Puts the two boxes into one that waste the least surface by that.
static void merge_two(rsv_scene_change *c)
{
    uint32_t best[2] = { 0, 1 };
    float least = INFINITY;
    for (uint32_t a = 0; a < c->count; a++)
        for (uint32_t b = a + 1; b < c->count; b++) {
            float waste =
                half_surface(v3_min(c->low[a], c->low[b]), v3_max(c->high[a], c->high[b])) -
                half_surface(c->low[a], c->high[a]) - half_surface(c->low[b], c->high[b]);
            if (waste < least) least = waste, best[0] = a, best[1] = b;
        }
    cover(c, best[0], c->low[best[1]], c->high[best[1]]);
    c->count--;
    c->low[best[1]] = c->low[c->count];
    c->high[best[1]] = c->high[c->count];
}

void rsv_scene_change_cover(rsv_scene_change *c, rsv_vec3 low, rsv_vec3 high)
{
    uint32_t best = 0;
    float least = INFINITY;
    for (uint32_t k = 0; k < c->count; k++) {
        float waste = half_surface(v3_min(c->low[k], low), v3_max(c->high[k], high)) -
                      half_surface(c->low[k], c->high[k]);
        if (waste < least) least = waste, best = k;
    }
    if (c->count == 0)
        rsv_scene_change_add(c, low, high, false);
    else
        cover(c, best, low, high);
}

void rsv_scene_change_add(rsv_scene_change *c, rsv_vec3 low, rsv_vec3 high, bool runs_on)
{
    if (runs_on) {
        cover(c, c->count - 1, low, high);
        return;
    }
    if (c->count == RSV_MOST_CHANGES) merge_two(c);
    c->low[c->count] = low;
    c->high[c->count++] = high;
}

void rsv_scene_change_add_all(rsv_scene_change *c, const rsv_scene_change *more)
{
    for (uint32_t k = 0; k < more->count; k++)
        rsv_scene_change_add(c, more->low[k], more->high[k], false);
}

static void add_triangle(rsv_scene_change *c, const rsv_scene_view *scene, uint32_t t, bool runs_on)
{
    const uint32_t *corner = scene->triangle[t];
    rsv_vec3 p[3];
    for (int k = 0; k < 3; k++)
        p[k] = scene->position[corner[k]];
    rsv_vec3 low = v3_min(v3_min(p[0], p[1]), p[2]), high = v3_max(v3_max(p[0], p[1]), p[2]);
    rsv_scene_change_add(c, low, high, runs_on);
}

void rsv_scene_change_add_margins(rsv_scene_change *c)
{
    for (uint32_t k = 0; k < c->count; k++) {
        float margin = MARGIN * f_max(v3_max_abs(c->low[k]), v3_max_abs(c->high[k]));
        rsv_vec3 more = v3(margin, margin, margin);
        c->low[k] = v3_sub(c->low[k], more);
        c->high[k] = v3_add(c->high[k], more);
    }
}

rsv_scene_change rsv_scene_change_since(
    const rsv_scene_view *scene, const uint64_t *keys, size_t count)
{
    rsv_scene_change change = { .count = 0 };
    uint32_t object = RSV_NONE; // of the new triangle just before
    for (uint32_t t = 0; t < scene->triangle_count; t++) {
        uint64_t key = rsv_triangle_key(scene, t);
        bool is_new = has_holes(scene, t) || !bsearch(&key, keys, count, sizeof key, compare_keys);
        if (is_new) add_triangle(&change, scene, t, object == scene->triangle_object[t]);
        object = is_new ? scene->triangle_object[t] : RSV_NONE;
    }
    rsv_scene_change_add_margins(&change);
    return change;
}

/// Narrows the part of a line that lies between two planes across an axis.
static void clip(float origin, float direction, float low, float high, float *from, float *to)
{
    float step = fabsf(direction) > 1e-30f ? direction : 1e-30f; // no 0 / 0
    float a = (low - origin) / step, b = (high - origin) / step;
    *from = f_max(*from, f_min(a, b));
    *to = f_min(*to, f_max(a, b));
}

void rsv_scene_change_meets(
    const rsv_scene_change *c, const rsv_ray_packet *p, float at[RSV_PACKET_WIDTH])
{
    for (uint32_t k = 0; k < RSV_PACKET_WIDTH; k++)
        at[k] = INFINITY;
    for (uint32_t box = 0; box < c->count; box++) {
        rsv_vec3 low = c->low[box], high = c->high[box];
        for (uint32_t k = 0; k < RSV_PACKET_WIDTH; k++) {
            float from = 0, to = INFINITY;
            clip(p->origin_x[k], p->direction_x[k], low.x, high.x, &from, &to);
            clip(p->origin_y[k], p->direction_y[k], low.y, high.y, &from, &to);
            clip(p->origin_z[k], p->direction_z[k], low.z, high.z, &from, &to);
            at[k] = f_min(at[k], from <= to ? from : INFINITY);
        }
    }
}
