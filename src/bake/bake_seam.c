#include "bake_seam.h"

#include "bake_constants.h"
#include "bake_stitch.h"

#include "../core/vec.h"

#include <stdlib.h>
#include <string.h>

/// An edge of a triangle in a chart, known by its ends in space.
typedef struct border {
    uint64_t key;
    uint32_t chart, k, edge; ///< triangle of the charts; the edge from corner `edge`
    rsv_vec3 from, to;
} border;

typedef struct seam_search {
    const rsv_light_view *s;
    const rsv_bake_charts *charts;
    const rsv_bake_parts *parts;
    float dark;
    const rsv_bake_map *map;
    rsv_bake_stitch *stitch;
    size_t count, capacity;
} seam_search;

static int compare_borders(const void *a, const void *b)
{
    const border *x = a, *y = b;
    if (x->key != y->key) return x->key < y->key ? -1 : 1;
    return (x->k > y->k) - (x->k < y->k);
}

static rsv_vec3 corner_of(const seam_search *q, const border *b, uint32_t corner)
{
    const rsv_bake_part *part = &q->parts->part[q->charts->chart[b->chart].part];
    const rsv_scene_view *view = q->s->scene.view;
    static const uint32_t swapped[3] = { 0, 2, 1 };
    corner %= 3;
    const uint32_t *v = view->triangle[part->triangle[q->charts->triangle[b->k]]];
    return view->position[v[part->mirrored ? swapped[corner] : corner]];
}

static rsv_vec3 normal_of(const seam_search *q, const border *b)
{
    rsv_vec3 a = corner_of(q, b, 0);
    rsv_vec3 n = v3_cross(v3_sub(corner_of(q, b, 1), a), v3_sub(corner_of(q, b, 2), a));
    bool mirrored = q->parts->part[q->charts->chart[b->chart].part].mirrored;
    return v3_normalize(mirrored ? v3_neg(n) : n);
}

/// Where the map shows share `t` of the way along an edge, and the light there as elements store it.
static rsv_rgb light_on(const seam_search *q, const border *b, float t, float point[2])
{
    const rsv_bake_chart *chart = &q->charts->chart[b->chart];
    const rsv_bake_part *part = &q->parts->part[chart->part];
    float w[3] = { 0, 0, 0 }, corner[2];
    w[b->edge] = 1 - t;
    w[(b->edge + 1) % 3] = t;
    for (int a = 0; a < 2; a++)
        corner[a] = w[0] * q->charts->corner[b->k][0][a] + w[1] * q->charts->corner[b->k][1][a] +
                    w[2] * q->charts->corner[b->k][2][a];
    rsv_bake_chart_point(chart, corner, point);
    // slightly inside, on the right side of anything that stands on the edge

    for (int k = 0; k < 3; k++)
        w[k] += 1e-3f * (1.0f / 3 - w[k]);
    float u, v;
    rsv_bake_place(part, w[1], w[2], &u, &v);
    uint32_t triangle = q->charts->triangle[b->k];
    return rsv_bake_shown(q->s, part->triangle[triangle], part->back[triangle], u, v);
}

static float largest_difference(rsv_rgb a, rsv_rgb b)
{
    return f_max(fabsf(a.r - b.r), f_max(fabsf(a.g - b.g), fabsf(a.b - b.b)));
}

static int sample_count(const seam_search *q, const border *b)
{
    float from[2], to[2];
    light_on(q, b, 0, from);
    light_on(q, b, 1, to);
    float texels = hypotf(to[0] - from[0], to[1] - from[1]);
    return 2 + (int)f_min(SAMPLES_PER_TEXEL * texels, MOST_SAMPLES - 2);
}

/// Stitches of two borders that are one edge in space, where surface and light go on smoothly.
static rsv_status add_stitches(seam_search *q, const border *x, const border *y)
{
    rsv_status status = RSV_OK;
    bool reversed = x->from.x != y->from.x || x->from.y != y->from.y || x->from.z != y->from.z;
    if (v3_dot(normal_of(q, x), normal_of(q, y)) < SEAM_SMOOTH) return RSV_OK;
    int count = sample_count(q, x), other = sample_count(q, y);
    count = other > count ? other : count;
    for (int k = 0; k < count; k++) {
        rsv_bake_stitch stitch = { .chart = { x->chart, y->chart } };
        float t = ((float)k + 0.5f) / (float)count;
        rsv_rgb a = light_on(q, x, t, stitch.point[0]);
        rsv_rgb b = light_on(q, y, reversed ? 1 - t : t, stitch.point[1]);
        stitch.solved = rgb_scale(rgb_add(rsv_bake_map_lookup(q->map, stitch.point[0]),
                                      rsv_bake_map_lookup(q->map, stitch.point[1])),
            0.5f);
        stitch.least = f_max(rgb_max(stitch.solved), q->dark);
        float stored = f_max(f_max(rgb_max(a), rgb_max(b)), q->dark);
        bool continuous = largest_difference(a, b) <= CONTINUOUS * stored;
        if (!continuous || !(stitch.least > 0)) continue;
        RSV_TRY(rsv_grow(
            q->s->context, (void **)&q->stitch, &q->capacity, q->count + 1, sizeof *q->stitch));
        q->stitch[q->count++] = stitch;
    }
cleanup:
    return status;
}

static size_t list_borders(const seam_search *q, border *list)
{
    size_t count = 0;
    for (uint32_t c = 0; c < q->charts->count; c++) {
        const rsv_bake_chart *chart = &q->charts->chart[c];
        for (uint32_t k = chart->first; k < chart->first + chart->triangle_count; k++)
            for (uint32_t e = 0; e < 3; e++) {
                border b = { .chart = c, .k = k, .edge = e };
                b.from = corner_of(q, &b, e);
                b.to = corner_of(q, &b, e + 1);
                b.key = rsv_bake_edge_key(b.from, b.to);
                list[count++] = b;
            }
    }
    return count;
}

static rsv_status find_stitches(seam_search *q)
{
    rsv_status status;
    border *list = rsv_alloc(q->s->context, 3 * q->charts->triangle_count, sizeof *list);
    RSV_TRY(list ? RSV_OK : RSV_ERROR_MEMORY);
    size_t count = list_borders(q, list);
    qsort(list, count, sizeof *list, compare_borders);
    for (size_t k = 1; k < count; k++)
        if (list[k].key == list[k - 1].key && list[k].chart != list[k - 1].chart)
            RSV_TRY(add_stitches(q, &list[k - 1], &list[k]));
cleanup:
    rsv_free(q->s->context, list);
    return status;
}

static void mark_open(const seam_search *q, const rsv_bake_map *map, uint8_t *open)
{
    for (size_t k = 0; k < q->count; k++)
        if (rsv_bake_jump(map, &q->stitch[k]) > SEEN)
            open[q->stitch[k].chart[0]] = open[q->stitch[k].chart[1]] = 1;
}

rsv_status rsv_bake_close_seams(const rsv_light_view *solution, const rsv_bake_layout *layout,
    double mean, rsv_bake_map *map, uint8_t *open, double *largest)
{
    seam_search q = { .s = solution,
        .charts = &layout->charts,
        .parts = layout->parts,
        .dark = DARK * (float)mean,
        .map = map };
    rsv_status status = find_stitches(&q);
    if (status == RSV_OK)
        status = rsv_bake_stitch_up(solution->context, q.stitch, q.count, map, largest);
    if (status == RSV_OK && open) mark_open(&q, map, open);
    rsv_free(solution->context, q.stitch);
    return status;
}
