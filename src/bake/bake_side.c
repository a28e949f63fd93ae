#include "bake_side.h"

#include "../core/index_map.h"
#include "../core/vec.h"
#include "../scene/scene_internal.h"
#include "bake_chart.h"
#include "bake_receiver.h"

/// A front that receives less than this share of what its back does is in the dark.
#define DARK 0.05

/// Triangles that share edges and turn the same way, and what they receive.
typedef struct surfaces {
    const rsv_solution *s;
    const rsv_bake_part *part;
    uint32_t *root; ///< [triangle_count] another triangle of the same surface, in the end its first
    double (*power)
        [2]; ///< [triangle_count] of a first one: on the front of its surface, and on the back
} surfaces;

static uint32_t first_of(surfaces *f, uint32_t t)
{
    while (f->root[t] != t)
        t = f->root[t] = f->root[f->root[t]];
    return t;
}

static void join(surfaces *f, uint32_t a, uint32_t b)
{
    a = first_of(f, a), b = first_of(f, b);
    if (a < b)
        f->root[b] = a;
    else
        f->root[a] = b;
}

static rsv_vec3 corner_of(const surfaces *f, uint32_t own)
{
    const rsv_scene_view *view = f->s->scene.view;
    return view->position[view->triangle[f->part->triangle[own / 3]][own % 3]];
}

static uint32_t next_corner(uint32_t own) { return own - own % 3 + (own + 1) % 3; }

/// Joins triangles across edges that they run along in opposite directions.
static rsv_status join_neighbours(surfaces *f)
{
    rsv_status status;
    rsv_index_map edges = { 0 };
    RSV_TRY(rsv_index_map_create(f->s->context, 2 * f->part->triangle_count, &edges));
    for (uint32_t own = 0; own < 3 * f->part->triangle_count; own++) {
        if (f->part->triangle[own / 3] == RSV_NONE) continue;
        rsv_vec3 from = corner_of(f, own), to = corner_of(f, next_corner(own));
        uint32_t other = rsv_index_map_insert(&edges, rsv_bake_edge_key(from, to), own);
        RSV_TRY(other == RSV_NONE ? RSV_ERROR_MEMORY : RSV_OK);
        rsv_vec3 theirs = corner_of(f, other);
        if (other != own && theirs.x == to.x && theirs.y == to.y && theirs.z == to.z)
            join(f, own / 3, other / 3);
    }
cleanup:
    rsv_index_map_destroy(&edges);
    return status;
}

/// Light on a side of a triangle, the mean of a few places.
static double light_on(const rsv_solution *s, uint32_t triangle, bool back)
{
    static const float place[4][2] = { { 1.0f / 3, 1.0f / 3 }, { 0.15f, 0.15f }, { 0.7f, 0.15f },
        { 0.15f, 0.7f } };
    double sum = 0;
    for (int k = 0; k < 4; k++)
        sum += (double)rgb_max(rsv_bake_shown(s, triangle, back, place[k][0], place[k][1]));
    return sum / 4;
}

static void add_up(surfaces *f)
{
    for (uint32_t t = 0; t < f->part->triangle_count; t++) {
        uint32_t triangle = f->part->triangle[t];
        if (triangle == RSV_NONE) continue;
        double area = (double)rsv_triangle_area(f->s->scene.view, triangle);
        for (int side = 0; side < 2; side++)
            f->power[first_of(f, t)][side] += area * light_on(f->s, triangle, side);
    }
}

static bool has_backs(const rsv_solution *s, const rsv_bake_part *part)
{
    for (size_t t = 0; t < part->triangle_count; t++)
        if (part->triangle[t] != RSV_NONE)
            return s->elements->face_of[true][part->triangle[t]] != RSV_NONE;
    return false;
}

rsv_status rsv_bake_choose_sides(const rsv_solution *s, rsv_bake_part *part)
{
    rsv_status status = RSV_OK;
    size_t count = part->triangle_count;
    surfaces f = { .s = s, .part = part };
    part->back = rsv_alloc(s->context, count, sizeof *part->back);
    if (!part->back) return RSV_ERROR_MEMORY;
    if (!has_backs(s, part)) return RSV_OK;
    f.root = rsv_alloc(s->context, count, sizeof *f.root);
    f.power = rsv_alloc(s->context, count, sizeof *f.power);
    RSV_TRY(f.root && f.power ? RSV_OK : RSV_ERROR_MEMORY);
    for (uint32_t t = 0; t < count; t++)
        f.root[t] = t;
    RSV_TRY(join_neighbours(&f));
    add_up(&f);
    for (uint32_t t = 0; t < count; t++) {
        const double *power = f.power[first_of(&f, t)];
        part->back[t] = power[0] < DARK * power[1];
    }
cleanup:
    rsv_free(s->context, f.root);
    rsv_free(s->context, f.power);
    return status;
}
