#include "bake_side.h"

#include "../core/index_map.h"
#include "../core/sampling.h"
#include "../core/vec.h"
#include "../scene/scene.h"
#include "../surface/surface.h"
#include "bake_chart.h"
#include "bake_constants.h"
#include "bake_receiver.h"

/// Triangles that share edges and turn the same way.
typedef struct surface {
    double area;
    double power[2]; ///< that its front and its back receive
    double swept;    ///< area of its triangles that rays were sent from
    double sight[2]; ///< sum of how far rays from its front and its back go
    uint32_t rays;   ///< sent from each
} surface;

typedef struct surfaces {
    const rsv_light_view *s;
    const rsv_bake_part *part;
    const double (*power)[2]; ///< [triangle_count] that front and back of each triangle receive
    uint32_t *root; ///< [triangle_count] another triangle of the same surface, in the end its first
    surface *surface; ///< [triangle_count] of a first one
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

static rsv_vec3 normal_of(const surfaces *f, uint32_t t)
{
    rsv_vec3 normal = v3(0, 0, 0);
    rsv_triangle_normal(
        corner_of(f, 3 * t), corner_of(f, 3 * t + 1), corner_of(f, 3 * t + 2), &normal);
    return normal;
}

static uint32_t next_corner(uint32_t own) { return own - own % 3 + (own + 1) % 3; }

/// Joins triangles across edges that they run along in opposite directions.
/// @param least_cosine of their normals
static rsv_status join_neighbours(surfaces *f, float least_cosine)
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
        if (other != own && theirs.x == to.x && theirs.y == to.y && theirs.z == to.z &&
            v3_dot(normal_of(f, own / 3), normal_of(f, other / 3)) >= least_cosine)
            join(f, own / 3, other / 3);
    }
cleanup:
    rsv_index_map_destroy(&edges);
    return status;
}

/// Light on a side of a triangle, the mean of a few places.
static double light_on(const rsv_light_view *s, uint32_t triangle, bool back)
{
    static const float place[4][2] = { { 1.0f / 3, 1.0f / 3 }, { 0.15f, 0.15f }, { 0.7f, 0.15f },
        { 0.15f, 0.7f } };
    double sum = 0;
    for (int k = 0; k < 4; k++)
        sum += (double)rgb_max(rsv_bake_shown(s, triangle, back, place[k][0], place[k][1]));
    return sum / 4;
}

/// @param power [triangle_count] out; see surfaces
static void find_power(const rsv_light_view *s, const rsv_bake_part *part, double (*power)[2])
{
    for (uint32_t t = 0; t < part->triangle_count; t++) {
        if (part->triangle[t] == RSV_NONE) continue;
        double area = (double)rsv_triangle_area(s->scene.view, part->triangle[t]);
        for (int side = 0; side < 2; side++)
            power[t][side] = area * light_on(s, part->triangle[t], side);
    }
}

static void add_up(surfaces *f)
{
    for (uint32_t t = 0; t < f->part->triangle_count; t++) {
        if (f->part->triangle[t] == RSV_NONE) continue;
        surface *own = &f->surface[first_of(f, t)];
        own->area += (double)rsv_triangle_area(f->s->scene.view, f->part->triangle[t]);
        for (int side = 0; side < 2; side++)
            own->power[side] += f->power[t][side];
    }
}

/// Visible distance from a place on a side of a triangle, at most FAR. In the void there is nothing to see.
static double sight_from(const rsv_light_view *s, uint32_t triangle, bool back, uint32_t k)
{
    float x, y, u, v;
    rsv_hit hit;
    rsv_sobol_2d(k, 0, &x, &y);
    rsv_sobol_2d(k, 1, &u, &v);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    rsv_surface_point p = rsv_surface_point_at(s->scene.view, triangle, u, v, back);
    rsv_vec3 d = rsv_square_to_cosine_hemisphere(x, y);
    rsv_ray ray = { rsv_offset_origin(p.position, p.geometric, p.extent),
        v3_turned_to(p.geometric, d), INFINITY };
    if (!rsv_tracer_closest(s->tracer, &ray, &hit)) return s->lights->environment ? FAR : 0;
    return (double)f_min(hit.t, FAR);
}

static bool is_darker(const surface *own) { return own->power[0] < own->power[1]; }

/// Looks around from surfaces whose front is darker, from places spread evenly over each.
static void look_around(surfaces *f)
{
    for (uint32_t t = 0; t < f->part->triangle_count; t++) {
        uint32_t triangle = f->part->triangle[t];
        if (triangle == RSV_NONE) continue;
        surface *own = &f->surface[first_of(f, t)];
        if (!is_darker(own)) continue;
        own->swept += (double)rsv_triangle_area(f->s->scene.view, triangle);
        for (; own->rays < SIDE_RAYS && (own->rays + 0.5) * own->area < SIDE_RAYS * own->swept;
             own->rays++)
            for (int side = 0; side < 2; side++)
                own->sight[side] += sight_from(f->s, triangle, side, own->rays);
    }
}

/// From light alone, a front that is buried or faces the void cannot be distinguished from the inside of a room in the
/// sun.
static bool shows_back(const surface *own)
{
    bool narrow = own->sight[0] < NARROW * own->rays;
    bool narrower = own->sight[0] < NARROWER * own->sight[1];
    bool dark = own->power[0] < DARK_FRONT * own->power[1];
    return is_darker(own) && narrow && (narrower || dark);
}

static bool has_backs(const rsv_light_view *s, const rsv_bake_part *part)
{
    for (size_t t = 0; t < part->triangle_count; t++)
        if (part->triangle[t] != RSV_NONE)
            return s->elements->face_of[true][part->triangle[t]] != RSV_NONE;
    return false;
}

static void surfaces_destroy(surfaces *f)
{
    rsv_free(f->s->context, f->root);
    rsv_free(f->s->context, f->surface);
}

/// Surfaces with the light on both of their sides, divided at creases.
/// @param least_cosine see join_neighbours; -INFINITY = nothing is a crease
/// @param f in: solution, part and power; out: all
static rsv_status surfaces_create(float least_cosine, surfaces *f)
{
    rsv_status status;
    size_t count = f->part->triangle_count;
    f->root = rsv_alloc(f->s->context, count, sizeof *f->root);
    f->surface = rsv_alloc(f->s->context, count, sizeof *f->surface);
    RSV_TRY(f->root && f->surface ? RSV_OK : RSV_ERROR_MEMORY);
    for (uint32_t t = 0; t < count; t++)
        f->root[t] = t;
    RSV_TRY(join_neighbours(f, least_cosine));
    add_up(f);
cleanup:
    return status;
}

rsv_status rsv_bake_choose_sides(const rsv_light_view *s, rsv_bake_part *part)
{
    rsv_status status;
    size_t count = part->triangle_count;
    part->back = rsv_alloc(s->context, count, sizeof *part->back);
    if (!part->back) return RSV_ERROR_MEMORY;
    if (!has_backs(s, part)) return RSV_OK;
    double(*power)[2] = rsv_alloc(s->context, count, sizeof *power);
    surfaces whole = { .s = s, .part = part, .power = power }, pieces = whole;
    RSV_TRY(power ? RSV_OK : RSV_ERROR_MEMORY);
    find_power(s, part, power);
    RSV_TRY(surfaces_create(-INFINITY, &whole));
    RSV_TRY(surfaces_create(SIDE_CREASE, &pieces));
    look_around(&whole);
    for (uint32_t t = 0; t < count; t++) {
        const surface *piece = &pieces.surface[first_of(&pieces, t)];
        bool shows_front = piece->power[0] > LIGHTER * piece->power[1];
        part->back[t] = shows_back(&whole.surface[first_of(&whole, t)]) && !shows_front;
    }
cleanup:
    surfaces_destroy(&whole);
    surfaces_destroy(&pieces);
    rsv_free(s->context, power);
    return status;
}
