#include "tracked_row.h"

#include <string.h>

static size_t bytes_of(const rsv_row_tail *t)
{
    return t->tinted_count * (sizeof(rsv_rgb) + sizeof(uint32_t) + sizeof(uint16_t)) +
           t->bin_count * 2 * sizeof(uint16_t) +
           t->tinted_bin_count * (sizeof(rsv_rgb) + 2 * sizeof(uint16_t)) +
           t->color_count * sizeof(rsv_rgb) + t->light_count * 2 * sizeof(uint16_t) +
           t->trail_count * sizeof(rsv_trail_point);
}

static void copy(void *to, const void *from, size_t count, size_t size)
{
    if (count) memcpy(to, from, count * size);
}

static bool is_same(rsv_rgb a, rsv_rgb b) { return a.r == b.r && a.g == b.g && a.b == b.b; }

/// Colours of emission, each of which is looked for among the last few. @param color, index [light_count], out
static uint32_t list_colors(const rsv_row_track *k, rsv_rgb *color, uint16_t *index)
{
    enum { LAST = 4 };
    uint32_t count = 0;
    for (uint32_t i = 0; i < k->light_count; i++) {
        uint32_t at = count > LAST ? count - LAST : 0;
        while (at < count && !is_same(color[at], k->light[i]))
            at++;
        if (at == count) color[count++] = k->light[i];
        index[i] = (uint16_t)at;
    }
    return count;
}

static void fill(const rsv_row_tail *t, const rsv_row_scratch *s)
{
    const rsv_row_track *k = s->track;
    rsv_row_tail_view v = rsv_row_tail_view_of(t);
    copy(v.tinted_weight, s->tinted_weight, t->tinted_count, sizeof *v.tinted_weight);
    copy(v.tinted_column, s->tinted_column, t->tinted_count, sizeof *v.tinted_column);
    copy(v.tinted_ray, k->tinted_ray, t->tinted_count, sizeof *v.tinted_ray);
    copy(v.bin, s->escapes.bin, t->bin_count, sizeof *v.bin);
    copy(v.bin_ray, k->bin_ray, t->bin_count, sizeof *v.bin_ray);
    copy(v.bin_weight, s->escapes.tinted_weight, t->tinted_bin_count, sizeof *v.bin_weight);
    copy(v.tinted_bin, s->escapes.tinted_bin, t->tinted_bin_count, sizeof *v.tinted_bin);
    copy(v.tinted_bin_ray, k->tinted_bin_ray, t->tinted_bin_count, sizeof *v.tinted_bin_ray);
    copy(v.color, k->color, t->color_count, sizeof *v.color);
    copy(v.light_color, k->light_color, t->light_count, sizeof *v.light_color);
    copy(v.light_ray, k->light_ray, t->light_count, sizeof *v.light_ray);
    copy(v.trail, k->trail, t->trail_count, sizeof *v.trail);
}

rsv_status rsv_row_tail_store(rsv_context *context, const rsv_row_scratch *s, rsv_row_tail **tail)
{
    rsv_row_tail now = { .tinted_count = s->tinted_count,
        .bin_count = s->escapes.count,
        .tinted_bin_count = s->escapes.tinted_count,
        .light_count = s->track->light_count,
        .color_count = list_colors(s->track, s->track->color, s->track->light_color),
        .trail_count = (uint32_t)s->track->trail_count };
    if (s->track->failed) return RSV_ERROR_MEMORY;
    size_t bytes = bytes_of(&now);
    if (bytes == 0 && !*tail) return RSV_OK;
    now.capacity = *tail ? (*tail)->capacity : 0;
    if (bytes > now.capacity) {
        now.capacity = (uint32_t)(bytes + (*tail ? bytes / 16 : 0)); // it may grow again
        rsv_row_tail *grown = rsv_reserve(context, sizeof now + now.capacity, 1);
        if (!grown) return RSV_ERROR_MEMORY;
        rsv_free(context, *tail);
        *tail = grown;
    }
    **tail = now;
    fill(*tail, s);
    return RSV_OK;
}

static void keep_tinted(
    const rsv_row_tail *t, const rsv_row_tail_view *v, const uint64_t *touched, rsv_row_scratch *s)
{
    for (uint32_t k = 0; k < t->tinted_count; k++) {
        if (rsv_ray_is_marked(touched, v->tinted_ray[k])) continue;
        s->track->tinted_ray[s->tinted_count] = v->tinted_ray[k];
        s->tinted_column[s->tinted_count] = v->tinted_column[k];
        s->tinted_weight[s->tinted_count++] = v->tinted_weight[k];
    }
}

static void keep_escapes(
    const rsv_row_tail *t, const rsv_row_tail_view *v, const uint64_t *touched, rsv_row_scratch *s)
{
    rsv_escape_row *e = &s->escapes;
    for (uint32_t k = 0; k < t->bin_count; k++) {
        if (rsv_ray_is_marked(touched, v->bin_ray[k])) continue;
        s->track->bin_ray[e->count] = v->bin_ray[k];
        e->bin[e->count++] = v->bin[k];
    }
    for (uint32_t k = 0; k < t->tinted_bin_count; k++) {
        if (rsv_ray_is_marked(touched, v->tinted_bin_ray[k])) continue;
        s->track->tinted_bin_ray[e->tinted_count] = v->tinted_bin_ray[k];
        e->tinted_bin[e->tinted_count] = v->tinted_bin[k];
        e->tinted_weight[e->tinted_count++] = v->bin_weight[k];
    }
}

void rsv_row_tail_keep(const rsv_row_tail *t, const uint64_t *touched, rsv_row_scratch *s)
{
    rsv_row_tail_view v = rsv_row_tail_view_of(t);
    rsv_row_track *track = s->track;
    if (!t) return;
    keep_tinted(t, &v, touched, s);
    keep_escapes(t, &v, touched, s);
    for (uint32_t k = 0; k < t->light_count; k++) {
        if (rsv_ray_is_marked(touched, v.light_ray[k])) continue;
        rsv_rgb light = v.color[v.light_color[k]];
        s->emission = rgb_add(s->emission, light);
        track->light_ray[track->light_count] = v.light_ray[k];
        track->light[track->light_count++] = light;
    }
    if (rsv_grow(track->context, (void **)&track->trail, &track->trail_capacity, t->trail_count,
            sizeof *track->trail) != RSV_OK) {
        track->failed = true;
        return;
    }
    for (uint32_t k = 0; k < t->trail_count; k++)
        if (!rsv_ray_is_marked(touched, v.trail[k].ray))
            track->trail[track->trail_count++] = v.trail[k];
}

// ---- paths that touch boxes -----------------------------------------------------------------------

/// A box on the lattice, a step larger than it is.
typedef struct lattice_box {
    int32_t low[3], high[3];
} lattice_box;

static lattice_box on_lattice(const rsv_trail_frame *f, rsv_vec3 low, rsv_vec3 high)
{
    const float size[3] = { f->high.x - f->low.x, f->high.y - f->low.y, f->high.z - f->low.z };
    const float from[3] = { low.x - f->low.x, low.y - f->low.y, low.z - f->low.z };
    const float to[3] = { high.x - f->low.x, high.y - f->low.y, high.z - f->low.z };
    lattice_box b;
    for (int k = 0; k < 3; k++) {
        float scale = size[k] > 0 ? 65535 / size[k] : 0;
        b.low[k] = (int32_t)f_min(f_max(from[k] * scale, -2), 65537) - 2;
        b.high[k] = (int32_t)f_min(f_max(to[k] * scale, -2), 65537) + 2;
    }
    return b;
}

/// Whether the box around a segment misses a box.
static bool is_beside(const lattice_box *b, const uint16_t p[3], const uint16_t q[3])
{
    bool beside = false;
    for (int k = 0; k < 3; k++)
        beside |= (p[k] < b->low[k] && q[k] < b->low[k]) | (p[k] > b->high[k] && q[k] > b->high[k]);
    return beside;
}

/// Whether the segment between two places may meet a box.
static bool segment_meets(const lattice_box *b, const uint16_t p[3], const uint16_t q[3])
{
    float from = 0, to = 1;
    if (is_beside(b, p, q)) return false;
    for (int k = 0; k < 3; k++) {
        float d = (float)q[k] - (float)p[k];
        if (d == 0) continue;
        float x = ((float)b->low[k] - (float)p[k]) / d, y = ((float)b->high[k] - (float)p[k]) / d;
        from = f_max(from, f_min(x, y));
        to = f_min(to, f_max(x, y));
    }
    return from <= to;
}

void rsv_row_tail_touch(const rsv_row_tail *t, const rsv_trail_frame *frame,
    const rsv_scene_change *change, uint64_t *touched)
{
    if (!t) return;
    const rsv_trail_point *trail = rsv_row_tail_view_of(t).trail;
    lattice_box box[RSV_MOST_CHANGES], all = { { 65537, 65537, 65537 }, { -2, -2, -2 } };
    for (uint32_t k = 0; k < change->count; k++) {
        box[k] = on_lattice(frame, change->low[k], change->high[k]);
        for (int i = 0; i < 3; i++) {
            if (box[k].low[i] < all.low[i]) all.low[i] = box[k].low[i];
            if (box[k].high[i] > all.high[i]) all.high[i] = box[k].high[i];
        }
    }
    for (uint32_t k = 1; k < t->trail_count; k++) {
        uint32_t ray = trail[k].ray;
        if (ray != trail[k - 1].ray || is_beside(&all, trail[k - 1].at, trail[k].at)) continue;
        for (uint32_t b = 0; b < change->count; b++)
            if (segment_meets(&box[b], trail[k - 1].at, trail[k].at))
                touched[ray / 64] |= (uint64_t)1 << (ray % 64);
    }
}
