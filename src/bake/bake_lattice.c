#include "bake_lattice.h"

#include "../core/sampling.h"
#include "../core/vec.h"
#include "bake_constants.h"

#include <string.h>

// ---- places ---------------------------------------------------------------------------------------

/// Parallelogram of places around one of a triangle's, those that lie on it. @param step its sides, weights of corners
static void spread(const rsv_surface_place *around, const float step[2], rsv_bake_patch *patch)
{
    patch->count = 0;
    for (uint32_t k = 0; k < RSV_BAKE_PLACES; k++) {
        float x, y;
        rsv_surface_place place = *around;
        rsv_sobol_2d(k, 0, &x, &y);
        place.u += step[0] * (x - 0.5f);
        place.v += step[1] * (y - 0.5f);
        bool within = place.u >= 0 && place.v >= 0 && place.u + place.v <= 1;
        if (within) patch->place[patch->count++] = place;
    }
    if (patch->count == 0) patch->place[patch->count++] = *around;
}

/// A little inside the triangle.
static void pull_inside(rsv_surface_place *place)
{
    place->u += PULL * (1.0f / 3 - place->u);
    place->v += PULL * (1.0f / 3 - place->v);
}

/// Halvings of a triangle's sides until they are no longer than `finest`.
static uint8_t depth_of(const rsv_scene_view *view, uint32_t triangle, float finest)
{
    const uint32_t *v = view->triangle[triangle];
    float longest = 0;
    for (int k = 0; k < 3; k++)
        longest =
            f_max(longest, v3_length(v3_sub(view->position[v[k]], view->position[v[(k + 1) % 3]])));
    uint8_t depth = 0;
    for (; depth < RSV_BAKE_DEEPEST && longest > finest; longest *= 0.5f)
        depth++;
    return depth;
}

/// The patch around a place, as wide as the finest cells whether or not the triangle is divided.
static void patch_around(const rsv_light_view *s, rsv_surface_place place, rsv_bake_patch *patch)
{
    float size = ldexpf(1, -depth_of(s->scene.view, place.triangle, place.width));
    const float step[2] = { size, size };
    pull_inside(&place);
    spread(&place, step, patch);
}

void rsv_bake_vertex_patch(
    const rsv_light_view *s, const rsv_bake_receiver *receiver, float finest, rsv_bake_patch *patch)
{
    const rsv_surface_place place = { receiver->triangle, receiver->u, receiver->v, receiver->back,
        finest };
    patch_around(s, place, patch);
}

/// The same for all triangles at the point, so that their light there uses the same random numbers.
static uint32_t number_of_point(const rsv_bake_lattices *l, const rsv_surface_place *place)
{
    const rsv_scene_view *view = l->s->scene.view;
    const uint32_t *c = view->triangle[place->triangle];
    rsv_vec3 p = v3_barycentric(
        view->position[c[0]], view->position[c[1]], view->position[c[2]], place->u, place->v);
    float step = l->finest / 16;
    return rsv_hash3(
        (uint32_t)lrintf(p.x / step), (uint32_t)lrintf(p.y / step), (uint32_t)lrintf(p.z / step));
}

static uint32_t lattice_patch(const void *user, size_t index, rsv_bake_patch *patch)
{
    const rsv_bake_lattices *l = user;
    uint32_t t = l->group[index], side = 1u << l->depth[t];
    size_t offset = index - l->first[t];
    float size = 1 / (float)side;
    rsv_surface_place place = {
        .triangle = l->part->triangle[t], .back = l->part->back[t], .width = l->finest
    };
    rsv_bake_place(l->part, (float)(offset % l->width) * size, (float)(offset / l->width) * size,
        &place.u, &place.v);
    uint32_t number = number_of_point(l, &place);
    patch_around(l->s, place, patch);
    return number;
}

// ---- lattices side by side ------------------------------------------------------------------------

/// Rows of lattices of one size, one below the other. @return rows of points
static size_t arrange(rsv_bake_lattices *l)
{
    size_t row = 0;
    for (int depth = RSV_BAKE_DEEPEST; depth >= 0; depth--) {
        uint32_t side = (1u << depth) + 1, column = 0;
        bool any = false;
        for (uint32_t t = 0; t < l->part->triangle_count; t++) {
            if (l->part->triangle[t] == RSV_NONE || l->depth[t] != depth) continue;
            if (column + side > l->width) row += side, column = 0;
            l->first[t] = row * l->width + column;
            column += side;
            any = true;
        }
        if (any) row += side;
    }
    return row;
}

static void name_points(rsv_bake_lattices *l)
{
    memset(l->group, 0xff, (size_t)l->width * l->height * sizeof *l->group);
    for (uint32_t t = 0; t < l->part->triangle_count; t++) {
        if (l->part->triangle[t] == RSV_NONE) continue;
        uint32_t side = 1u << l->depth[t];
        for (uint32_t j = 0; j <= side; j++)
            for (uint32_t i = 0; i + j <= side; i++)
                l->group[l->first[t] + (size_t)j * l->width + i] = t;
    }
}

rsv_status rsv_bake_lattices_create(const rsv_light_view *s, const rsv_bake_part *part,
    float finest, bool divide, rsv_bake_lattices *l)
{
    rsv_status status;
    *l = (rsv_bake_lattices){ .context = s->context,
        .s = s,
        .part = part,
        .finest = finest,
        .width = (1u << RSV_BAKE_DEEPEST) + 1 };
    l->depth = rsv_alloc(s->context, part->triangle_count, sizeof *l->depth);
    l->first = rsv_alloc(s->context, part->triangle_count, sizeof *l->first);
    RSV_TRY(l->depth && l->first ? RSV_OK : RSV_ERROR_MEMORY);
    for (uint32_t t = 0; t < part->triangle_count; t++)
        if (part->triangle[t] != RSV_NONE && divide)
            l->depth[t] = depth_of(s->scene.view, part->triangle[t], finest);
    l->height = (uint32_t)arrange(l);
    size_t points = (size_t)l->width * l->height;
    l->group = rsv_alloc(s->context, points, sizeof *l->group);
    l->light = rsv_alloc(s->context, points, sizeof *l->light);
    l->stand_in = rsv_alloc(s->context, points, sizeof *l->stand_in);
    RSV_TRY(l->group && l->light && l->stand_in ? RSV_OK : RSV_ERROR_MEMORY);
    name_points(l);
cleanup:
    return status;
}

void rsv_bake_lattices_destroy(rsv_bake_lattices *l)
{
    if (!l->context) return;
    rsv_free(l->context, l->depth);
    rsv_free(l->context, l->first);
    rsv_free(l->context, l->group);
    rsv_free(l->context, l->light);
    rsv_free(l->context, l->stand_in);
    *l = (rsv_bake_lattices){ .context = NULL };
}

rsv_status rsv_bake_lattices_light(rsv_bake_lattices *l, const rsv_bake_accuracy *accuracy)
{
    const rsv_bake_grid grid = { l->width, l->height, l->group, LATTICE_PILOT_SAMPLES, l,
        lattice_patch };
    return rsv_bake_light_grid(l->s, &grid, accuracy, l->light, l->stand_in);
}

static size_t nearest_point(const rsv_bake_lattices *l, uint32_t t, float w1, float w2)
{
    float side = (float)(1u << l->depth[t]);
    uint32_t i = (uint32_t)lrintf(f_min(f_max(w1, 0), 1) * side),
             j = (uint32_t)lrintf(f_min(f_max(w2, 0), 1) * side);
    if (i + j > 1u << l->depth[t]) j = (1u << l->depth[t]) - i;
    return l->first[t] + (size_t)j * l->width + i;
}

bool rsv_bake_lattices_is_open(const rsv_bake_lattices *l, uint32_t t, float w1, float w2)
{
    size_t point = nearest_point(l, t, w1, w2);
    return l->stand_in[point] == point;
}

void rsv_bake_lattices_stand_in(const rsv_bake_lattices *l, uint32_t t, float w[2])
{
    size_t point = nearest_point(l, t, w[0], w[1]);
    if (l->stand_in[point] == point) return;
    size_t offset = l->stand_in[point] - l->first[t];
    w[0] = ldexpf((float)(offset % l->width), -l->depth[t]);
    w[1] = ldexpf((float)(offset / l->width), -l->depth[t]);
}

rsv_rgb rsv_bake_lattices_at(const rsv_bake_lattices *l, uint32_t t, float w1, float w2)
{
    uint32_t side = 1u << l->depth[t];
    float x = f_min(f_max(w1, 0), 1) * (float)side, y = f_min(f_max(w2, 0), 1) * (float)side;
    uint32_t i = (uint32_t)x, j = (uint32_t)y;
    if (i >= side) i = side - 1;
    if (j >= side - i) j = side - i - 1;
    x -= (float)i, y -= (float)j;
    const rsv_rgb *at = l->light + l->first[t] + (size_t)j * l->width + i, *next = at + l->width;
    if (x + y <= 1 || i + j + 2 > side)
        return rgb_mad(rgb_mad(rgb_scale(at[0], f_max(1 - x - y, 0)), x, at[1]), y, next[0]);
    return rgb_mad(rgb_mad(rgb_scale(next[1], x + y - 1), 1 - y, at[1]), 1 - x, next[0]);
}
