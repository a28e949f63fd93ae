#include "bake_open.h"

#include "../core/sampling.h"
#include "../core/vec.h"
#include "../elements/cell_visibility.h"
#include "bake_constants.h"

rsv_bake_cover rsv_bake_cover_of(const rsv_light_view *s)
{
    return (rsv_bake_cover){ &s->scene, rsv_touch_distance(&s->scene) };
}

/// How far a ray gets to the back of an opaque surface; -1 = it meets a front, or nothing.
static float way_to_back(const rsv_transport_scene *scene, const rsv_ray *ray)
{
    rsv_hit hit;
    if (!rsv_tracer_closest(scene->tracer, ray, &hit)) return -1;
    const rsv_bsdf *bsdf = &scene->bsdf[scene->view->triangle_material[hit.triangle]];
    rsv_surface_point met = rsv_surface_point_at(scene->view, hit.triangle, hit.u, hit.v, false);
    bool back = v3_dot(met.geometric, ray->direction) > 0;
    return back && bsdf->transmission == 0 && bsdf->opacity == 1 ? hit.t : -1;
}

/// Whether only near backs are visible from a place. (Rooms modelled inside out also show backs.)
static bool is_in_pocket(
    const rsv_transport_scene *scene, const rsv_surface_point *at, rsv_vec3 origin)
{
    float sum = 0;
    for (uint32_t k = 0; k < POCKET_RAYS; k++) {
        float x, y;
        rsv_sobol_2d(k, 0, &x, &y);
        rsv_vec3 d = rsv_square_to_cosine_hemisphere(x, y);
        const rsv_ray ray = { origin, v3_turned_to(at->geometric, d), INFINITY };
        float way = way_to_back(scene, &ray);
        if (way < 0) return false;
        sum += way;
    }
    return sum < POCKET * POCKET_RAYS;
}

bool rsv_bake_is_covered(const rsv_bake_cover *cover, const rsv_surface_place *place)
{
    uint64_t rays = 0;
    const rsv_transport_scene *scene = cover->scene;
    const rsv_hit hit = { .triangle = place->triangle, .u = place->u, .v = place->v };
    rsv_surface_point at =
        rsv_surface_point_at(scene->view, place->triangle, place->u, place->v, place->back);
    rsv_vec3 origin = rsv_offset_origin(at.position, at.geometric, at.extent);
    return rsv_is_touched_or_hidden(scene, hit, &at, cover->touch, &rays) ||
           rsv_is_within_body(scene, origin, at.geometric, 0, &rays) ||
           is_in_pocket(scene, &at, origin);
}

uint16_t rsv_bake_covered_places(const rsv_bake_cover *cover, const rsv_bake_patch *patch)
{
    uint16_t covered = 0;
    for (uint32_t k = 0; k < patch->count; k++)
        if (rsv_bake_is_covered(cover, &patch->place[k])) covered |= (uint16_t)(1u << k);
    return covered;
}

void rsv_bake_remove_places(rsv_bake_patch *patch, uint16_t covered)
{
    uint32_t left = 0;
    for (uint32_t k = 0; k < patch->count; k++)
        if (!(covered >> k & 1)) patch->place[left++] = patch->place[k];
    patch->count = left;
}

bool rsv_bake_keep_open(const rsv_bake_cover *cover, rsv_bake_patch *patch)
{
    uint16_t covered = rsv_bake_covered_places(cover, patch);
    if (covered == (1u << patch->count) - 1) return false;
    rsv_bake_remove_places(patch, covered);
    return true;
}
