#include "cell_visibility.h"

#include "../scene/twins.h"
#include "elements_constants.h"
#include "spacing.h"

rsv_cell_shape rsv_cell_shape_of(const rsv_elements *e, uint32_t cell)
{
    rsv_cell_shape shape;
    uint32_t face = e->cell[cell].face, triangle = e->face_triangle[face];
    const uint32_t *vertex = e->scene->triangle[triangle];
    rsv_surface_point point =
        rsv_surface_point_at(e->scene, triangle, 1.0f / 3, 1.0f / 3, e->face_back[face]);
    for (int k = 0; k < 3; k++) {
        float u, v;
        rsv_cell_corner(&e->cell[cell], k, &u, &v);
        shape.corner[k] = v3_barycentric(e->scene->position[vertex[0]],
            e->scene->position[vertex[1]], e->scene->position[vertex[2]], u, v);
    }
    shape.centre =
        v3_scale(v3_add(v3_add(shape.corner[0], shape.corner[1]), shape.corner[2]), 1.0f / 3);
    shape.normal = point.geometric;
    shape.extent = point.extent;
    shape.size = sqrtf(2 * ldexpf(e->face_area[face], -2 * e->cell[cell].level));
    shape.spacing = e->spacing;
    return shape;
}

rsv_vec3 rsv_cell_inset(const rsv_cell_shape *shape, rsv_vec3 border)
{
    return v3_mad(border, INSET, v3_sub(shape->centre, border));
}

/// Where rays leave the cell from: clear of rounding errors, no more.
static rsv_vec3 leave(const rsv_cell_shape *shape, rsv_vec3 place)
{
    return rsv_offset_origin(place, shape->normal, shape->extent);
}

rsv_vec3 rsv_cell_above_gaps(const rsv_cell_shape *shape, rsv_vec3 place)
{
    return v3_mad(leave(shape, place), LIFT * f_max(shape->size, shape->spacing), shape->normal);
}

rsv_vec3 rsv_cell_within_gap(const rsv_cell_shape *shape, rsv_vec3 place)
{
    return v3_mad(leave(shape, place), 0.5f * CONTACT * shape->spacing, shape->normal);
}

static bool is_opaque(const rsv_transport_scene *scene, const rsv_hit *hit)
{
    const rsv_bsdf *bsdf = &scene->bsdf[scene->view->triangle_material[hit->triangle]];
    return bsdf->transmission == 0 && bsdf->opacity == 1;
}

float rsv_clear_part(const rsv_transport_scene *scene, rsv_vec3 from, rsv_vec3 to)
{
    rsv_hit hit;
    float passed = 0;
    for (int step = 0; step < CLEAR_STEPS; step++) {
        rsv_ray there = { from, v3_sub(to, from), 1 };
        if (!rsv_tracer_closest(scene->tracer, &there, &hit)) return 1;
        passed += (1 - passed) * f_min(hit.t, 0.999f);
        if (is_opaque(scene, &hit)) return passed;
        rsv_surface_point met =
            rsv_surface_point_at(scene->view, hit.triangle, hit.u, hit.v, false);
        rsv_vec3 onward =
            v3_dot(met.geometric, there.direction) > 0 ? met.geometric : v3_neg(met.geometric);
        from = rsv_offset_origin(met.position, onward, met.extent);
    }
    return passed;
}

static rsv_ray ray_from(rsv_vec3 origin, rsv_vec3 normal, uint32_t k, uint32_t seed)
{
    float x, y;
    rsv_sobol_2d(k, seed, &x, &y);
    rsv_vec3 d = rsv_square_to_cosine_hemisphere(x, y);
    return (rsv_ray){ origin, v3_turned_to(normal, d), INFINITY };
}

static bool meets_lamp(const rsv_transport_scene *scene, const rsv_ray *ray, rsv_hit *hit)
{
    return rsv_tracer_closest(scene->tracer, ray, hit) &&
           scene->bsdf[scene->view->triangle_material[hit->triangle]].emissive;
}

bool rsv_is_touched(const rsv_tracer *tracer, const rsv_cell_shape *shape, rsv_vec3 place)
{
    rsv_ray up = { leave(shape, place), shape->normal, CONTACT * shape->spacing };
    return rsv_tracer_occluded(tracer, &up);
}

/// Whether a nearby lamp fills nearly all of the view from a place.
static bool is_behind_lamp(
    const rsv_transport_scene *scene, const rsv_cell_shape *shape, rsv_vec3 place)
{
    rsv_hit hit;
    int lamps = 0;
    rsv_vec3 origin = leave(shape, place);
    rsv_ray up = { origin, shape->normal, LAMP_GAP * shape->size };
    if (!meets_lamp(scene, &up, &hit)) return false;
    for (uint32_t k = 0; k < BURIAL_RAYS; k++) {
        rsv_ray ray = ray_from(origin, shape->normal, k, 0);
        lamps += meets_lamp(scene, &ray, &hit);
    }
    return lamps >= BURIAL_MAJORITY;
}

bool rsv_is_covered(const rsv_transport_scene *scene, const rsv_cell_shape *shape, rsv_vec3 place)
{
    rsv_hit hit;
    rsv_ray up = { leave(shape, place), shape->normal, COVER * f_max(shape->size, shape->spacing) };
    if (!rsv_tracer_closest(scene->tracer, &up, &hit)) return is_behind_lamp(scene, shape, place);
    if (hit.t <= CONTACT * shape->spacing) return true;
    bool lamp = scene->bsdf[scene->view->triangle_material[hit.triangle]].emissive;
    if (lamp && hit.t > COVER * shape->size) return is_behind_lamp(scene, shape, place);
    return is_opaque(scene, &hit);
}

/// SIGHT_BOTH: faces of both windings in one place, of which the front is seen. That is a wall written twice, and says
/// that one is in the open; or two bodies touch, and one is inside of the first.
typedef enum sight { SIGHT_NOTHING, SIGHT_BACK, SIGHT_FRONT, SIGHT_BOTH } sight;

/// The first hit of a ray: the back of a one-sided opaque surface, or anything else.
static sight look(const rsv_transport_scene *scene, const rsv_ray *ray, rsv_specular_path *path)
{
    rsv_hit hit;
    if (!rsv_tracer_closest(scene->tracer, ray, &hit)) return SIGHT_NOTHING;
    const rsv_bsdf *bsdf = &scene->bsdf[scene->view->triangle_material[hit.triangle]];
    *path = rsv_specular_begin(scene, NULL, ray->direction, hit);
    if (rsv_twins_meet(scene->view, ray->direction, hit)) return SIGHT_BOTH;
    return path->back && rsv_bounds_body(bsdf) ? SIGHT_BACK : SIGHT_FRONT;
}

bool rsv_is_buried(const rsv_transport_scene *scene, rsv_vec3 place, rsv_vec3 normal, uint32_t seed,
    uint64_t *rays)
{
    int backs = 0;
    if (scene->no_insides) return false;
    for (uint32_t k = 0; k < BURIAL_RAYS; k++) {
        rsv_specular_path path;
        rsv_ray ray = ray_from(place, normal, k, seed);
        ++*rays;
        sight seen = look(scene, &ray, &path);
        if (seen != SIGHT_BACK && seen != SIGHT_BOTH) return false;
        backs += seen == SIGHT_BACK;
    }
    return backs > 0;
}

bool rsv_is_mostly_buried(const rsv_transport_scene *scene, rsv_vec3 place, rsv_vec3 normal,
    uint32_t seed, uint64_t *rays)
{
    int backs = 0;
    if (scene->no_insides) return false;
    for (int k = 0; k < BURIAL_RAYS; k++) {
        if (backs >= BURIAL_MAJORITY || backs + BURIAL_RAYS - k < BURIAL_MAJORITY) break; // decided
        rsv_specular_path path;
        rsv_ray ray = ray_from(place, normal, (uint32_t)k, seed);
        sight seen = look(scene, &ray, &path);
        ++*rays;
        for (uint32_t step = 1; step < BURIAL_STEPS && seen >= SIGHT_FRONT; step++) {
            // the surface met may be inside the same body: look on from there
            rsv_surface_point point =
                rsv_surface_point_at(scene->view, path.triangle, path.u, path.v, path.back);
            rsv_vec3 origin = rsv_offset_origin(point.position, point.geometric, point.extent);
            ray = ray_from(origin, point.geometric, (uint32_t)k, seed + step);
            seen = look(scene, &ray, &path);
            ++*rays;
        }
        backs += seen == SIGHT_BACK;
    }
    return backs >= BURIAL_MAJORITY;
}

bool rsv_is_behind_twin(const rsv_scene_view *scene, rsv_hit place, rsv_vec3 normal)
{
    rsv_hit seen = place;
    if (scene->twins) rsv_twins_settle(scene, v3_neg(normal), &seen);
    return seen.triangle != place.triangle;
}

float rsv_touch_distance(const rsv_transport_scene *scene)
{
    return CONTACT * rsv_spacing_for(scene, DRAFT_ELEMENTS).metres;
}

bool rsv_is_touched_or_hidden(const rsv_transport_scene *scene, rsv_hit place,
    const rsv_surface_point *at, float touch, uint64_t *rays)
{
    if (rsv_is_behind_twin(scene->view, place, at->geometric)) return true;
    const rsv_ray up = { rsv_offset_origin(at->position, at->geometric, at->extent), at->geometric,
        touch };
    ++*rays;
    return rsv_tracer_occluded(scene->tracer, &up);
}

/// Whether a ray leaves a body that it did not enter: it sees the body's skin from inside, whatever other bodies are in
/// it. Transparent surfaces and two-sided ones do not bound a body.
static bool leaves_body(const rsv_transport_scene *scene, rsv_ray ray, uint64_t *rays)
{
    rsv_hit hit;
    int entered = 0;
    for (int step = 0; step < SKIN_STEPS; step++) {
        ++*rays;
        if (!rsv_tracer_closest(scene->tracer, &ray, &hit)) return false;
        const rsv_bsdf *bsdf = &scene->bsdf[scene->view->triangle_material[hit.triangle]];
        rsv_surface_point met =
            rsv_surface_point_at(scene->view, hit.triangle, hit.u, hit.v, false);
        bool back = v3_dot(met.geometric, ray.direction) > 0;
        // where bodies touch, one is left and another entered; a wall written twice is neither
        bool skin = rsv_bounds_body(bsdf) && !rsv_twins_meet(scene->view, ray.direction, hit);
        if (skin) {
            if (back && entered == 0) return true;
            entered += back ? -1 : 1;
        }
        rsv_vec3 onward = back ? met.geometric : v3_neg(met.geometric);
        ray.origin = rsv_offset_origin(met.position, onward, met.extent);
    }
    return false;
}

/// The same on a way from surface to surface: one-sided sheets that run on into a body are entered, and never left.
static bool wanders_to_skin(
    const rsv_transport_scene *scene, rsv_ray ray, uint32_t k, uint32_t seed, uint64_t *rays)
{
    rsv_specular_path path;
    for (uint32_t step = 1; step <= SKIN_STEPS; step++) {
        ++*rays;
        sight seen = look(scene, &ray, &path);
        if (seen != SIGHT_FRONT) return seen == SIGHT_BACK;
        rsv_surface_point point =
            rsv_surface_point_at(scene->view, path.triangle, path.u, path.v, path.back);
        rsv_vec3 origin = rsv_offset_origin(point.position, point.geometric, point.extent);
        ray = ray_from(origin, point.geometric, k, seed + step);
    }
    return false;
}

bool rsv_is_within_body(const rsv_transport_scene *scene, rsv_vec3 place, rsv_vec3 normal,
    uint32_t seed, uint64_t *rays)
{
    if (scene->no_insides) return false;
    for (uint32_t k = 0; k < BURIAL_RAYS; k++) {
        rsv_ray ray = ray_from(place, normal, k, seed);
        if (!leaves_body(scene, ray, rays) && !wanders_to_skin(scene, ray, k, seed, rays))
            return false;
    }
    return true;
}
