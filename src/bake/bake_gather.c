#include "bake_gather.h"

#include "../core/sampling.h"
#include "../core/stratified.h"
#include "../receiver/receiver.h"
#include "../render/fog_light.h"
#include "../render/lit_gather.h"
#include "../render/pixel_direct.h"

/// The place at which light is gathered. Must not be copied.
typedef struct gatherer {
    const rsv_light_view *s;
    rsv_lit_setting setting;
    rsv_receiver at;
    rsv_bsdf storage;
    const rsv_bsdf *coat;
    rsv_medium medium;
} gatherer;

static void set_up(gatherer *g, const rsv_light_view *s, const rsv_surface_place *p)
{
    const rsv_scene_view *view = s->scene.view;
    g->s = s;
    g->setting = (rsv_lit_setting){ &s->scene, s->lights, s->caustics.caustic != NULL };
    g->at = rsv_receiver_at(view, s->tracer, p->triangle, p->u, p->v,
        rsv_surface_point_seen(view, p->triangle, p->u, p->v, p->back, p->width));
    g->medium = rsv_medium_above(&s->scene.media, g->at.origin, g->at.point.geometric);
    const rsv_footprint footprint = { p->triangle, p->u, p->v, 0, RSV_CHANNEL_ALL };
    g->coat = rsv_surface_bsdf(view, s->bsdf, footprint, &g->storage);
}

/// Reflected light of a surface on which a ray has ended.
static rsv_rgb radiance_of_surface(
    const gatherer *g, const rsv_specular_path *end, rsv_random *random)
{
    const rsv_light_view *s = g->s;
    uint32_t face = s->elements->face_of[end->back][end->triangle];
    rsv_bsdf storage;
    rsv_rgb irradiance;
    if (face == RSV_NONE) return rgb_gray(0);
    if (rsv_is_translucent(s, face))
        irradiance = rgb_add(rsv_light_view_diffused(s, face, end->u, end->v, 0),
            rsv_light_view_diffused(s, face, end->u, end->v, RSV_NONE));
    else
        irradiance = rgb_add(rsv_sampled_irradiance(s, end, random),
            rgb_add(rsv_light_view_direct(s, face, end->u, end->v, true),
                rsv_elements_interpolate(s->elements, s->indirect, face, end->u, end->v)));
    rsv_rgb albedo = rsv_specular_bsdf(&s->scene, end, &storage)->base_color;
    return rgb_scale(rgb_mul(end->weight, rgb_mul(albedo, irradiance)), 1 / RSV_PI);
}

static rsv_rgb radiance_along(const gatherer *g, rsv_vec3 direction, rsv_random *random)
{
    const rsv_ray ray = { rsv_receiver_start(&g->at, direction), direction, INFINITY };
    rsv_gather gather = rsv_gather_lit_ray(&g->setting, &g->medium, &ray, random);
    rsv_rgb found = gather.emission;
    if (gather.end == RSV_SPECULAR_SCATTERED)
        return rgb_add(
            found, rgb_mul(gather.path.weight, rsv_fog_radiance_at(g->s, gather.place, random)));
    if (gather.end != RSV_SPECULAR_DIFFUSE) return found;
    return rgb_add(found, radiance_of_surface(g, &gather.path, random));
}

rsv_rgb rsv_bake_gather(
    const rsv_light_view *s, const rsv_surface_place *place, uint32_t rays, uint32_t seed)
{
    gatherer g;
    rsv_rgb sum = rgb_gray(0);
    uint32_t face = s->elements->face_of[place->back][place->triangle];
    set_up(&g, s, place);
    for (uint32_t k = 0; k < rays; k++) {
        float x, y;
        rsv_sobol_2d(k, seed, &x, &y);
        rsv_random random = rsv_random_from(seed, k, 0x2f6u);
        rsv_vec3 d = rsv_square_to_cosine_hemisphere(x, y);
        rsv_vec3 direction = v3_turned_to(g.at.point.normal, d);
        // directions below the surface, due to a tilted normal, count, but find nothing
        if (v3_dot(direction, g.at.point.horizon) <= 0) continue;
        sum = rgb_add(
            sum, rgb_mul(rsv_bsdf_entry(g.coat, d.z), radiance_along(&g, direction, &random)));
    }
    sum = rgb_scale(sum, RSV_PI / (float)rays);
    if (!s->caustics.caustic || face == RSV_NONE) return sum;
    return rgb_add(sum, rsv_elements_interpolate(
                            s->caustics.elements, s->caustics.caustic, face, place->u, place->v));
}
