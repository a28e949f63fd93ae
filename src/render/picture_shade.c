#include "picture_shade.h"

#include "../elements/voxels.h"
#include "../receiver/receiver.h"
#include "../sources/partition.h"
#include "../specular/fog_flight.h"
#include "fog_light.h"

void rsv_picture_add_light(rsv_picture_row *r, uint32_t column, uint32_t order, rsv_rgb radiance)
{
    r->layer[0][column] = rgb_add(r->layer[0][column], radiance);
    if (r->is_diffuse && r->job->guides)
        r->guide[RSV_GUIDE_DIFFUSE][column] =
            rgb_add(r->guide[RSV_GUIDE_DIFFUSE][column], radiance);
    if (r->job->layer_count > 1)
        r->layer[1 + order][column] = rgb_add(r->layer[1 + order][column], radiance);
}

static void look_up_indirect(rsv_picture_row *r, uint32_t face, float u, float v, rsv_rgb weight)
{
    const rsv_light_view *s = r->job->solution;
    if (r->job->layer_count == 1) {
        rsv_rgb e = rsv_elements_interpolate(s->elements, s->indirect, face, u, v);
        rsv_picture_add_light(r, r->column, 0, rgb_mul(weight, e));
        return;
    }
    for (uint32_t order = 1; order < s->order_count; order++) {
        rsv_rgb e = rsv_elements_interpolate(s->elements, s->order[order], face, u, v);
        rsv_picture_add_light(r, r->column, 1 + order, rgb_mul(weight, e));
    }
}

/// Indirect light of a translucent surface: diffused before it is looked up.
static void look_up_diffused(rsv_picture_row *r, uint32_t face, float u, float v, rsv_rgb weight)
{
    const rsv_light_view *s = r->job->solution;
    if (r->job->layer_count == 1) {
        rsv_picture_add_light(
            r, r->column, 0, rgb_mul(weight, rsv_light_view_diffused(s, face, u, v, RSV_NONE)));
        return;
    }
    for (uint32_t order = 1; order < s->order_count; order++)
        rsv_picture_add_light(r, r->column, 1 + order,
            rgb_mul(weight, rsv_light_view_diffused(s, face, u, v, order)));
}

/// Direct light of a translucent surface: diffused, and the share of detail that only pixels or the direct level
/// resolve. @param weight radiance at the camera per irradiance
static void shade_translucent(
    rsv_picture_row *r, const rsv_specular_path *path, uint32_t face, rsv_rgb weight)
{
    const rsv_light_view *s = r->job->solution;
    bool final = r->job->desc->mode == RSV_RENDER_FINAL;
    rsv_rgb direct = rsv_light_view_diffused(s, face, path->u, path->v, 0);
    if (final || s->fine.direct) {
        rsv_unresolved detail = rsv_light_unresolved(s, face, path->u, path->v);
        rsv_rgb stored = rsv_light_view_direct(s, face, path->u, path->v, final);
        direct = rgb_add(direct, rgb_mul(detail.share, rgb_sub(stored, detail.known)));
        if (final)
            rsv_pixel_direct_add(
                &r->direct, path, rgb_mul(weight, detail.share), r->column, r->sample);
    }
    rsv_picture_add_light(r, r->column, 1, rgb_mul(weight, direct));
    look_up_diffused(r, face, path->u, path->v, weight);
}

/// One gather ray's contribution to each order at the receiver.
static void add_gathered(
    rsv_picture_row *r, const rsv_gather *gather, rsv_rgb weight, rsv_random *random)
{
    const rsv_light_view *s = r->job->solution;
    const rsv_specular_path *path = &gather->path;
    uint32_t face = s->elements->face_of[path->back][path->triangle];
    if (face == RSV_NONE) return;
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_specular_bsdf(&s->scene, path, &storage);
    weight = rgb_mul(rgb_mul(weight, path->weight), bsdf->base_color);
    bool translucent = rsv_is_translucent(s, face);
    rsv_rgb direct = translucent ? rsv_light_view_diffused(s, face, path->u, path->v, 0)
                                 : rgb_add(rsv_light_view_direct(s, face, path->u, path->v, true),
                                       rsv_sampled_irradiance(s, path, random));
    rsv_picture_add_light(r, r->column, 2, rgb_mul(weight, direct));
    if (r->job->layer_count == 1) {
        rsv_rgb e = translucent ? rsv_light_view_diffused(s, face, path->u, path->v, RSV_NONE)
                                : rsv_elements_interpolate(
                                      s->elements, s->indirect, face, path->u, path->v);
        rsv_picture_add_light(r, r->column, 0, rgb_mul(weight, e));
        return;
    }
    for (uint32_t order = 1; order < s->order_count; order++) {
        rsv_rgb e = translucent ? rsv_light_view_diffused(s, face, path->u, path->v, order)
                                : rsv_elements_interpolate(
                                      s->elements, s->order[order], face, path->u, path->v);
        uint32_t shown = order + 2 <= RSV_KEPT_ORDERS ? order + 2 : RSV_KEPT_ORDERS;
        rsv_picture_add_light(r, r->column, shown, rgb_mul(weight, e));
    }
}

static bool no_emission(const void *user, uint32_t triangle, uint32_t turns)
{
    (void)user, (void)triangle, (void)turns;
    return false;
}

static bool counts(const void *user, uint32_t triangle, uint32_t turns)
{
    const rsv_light_view *s = user;
    return rsv_gathering_counts(s->lights, triangle, turns, rsv_has_unseen_caustics(s));
}

/// The same where a ray ends in the fog.
static void add_gathered_in_fog(
    rsv_picture_row *r, const rsv_gather *gather, rsv_rgb weight, rsv_random *random)
{
    const rsv_light_view *s = r->job->solution;
    uint32_t node = rsv_elements_find_voxel(s->elements, s->tracer, gather->place);
    if (node == RSV_NONE) return;
    weight = rgb_mul(weight, gather->path.weight);
    rsv_rgb direct = rgb_add(rsv_light_view_scattered(s, node, 0, true),
        rsv_fog_scattered_sample(s, gather->place, random));
    weight = rgb_scale(weight, RSV_PI); // of radiance, not of irradiance
    rsv_picture_add_light(r, r->column, 2, rgb_mul(weight, direct));
    if (r->job->layer_count == 1) {
        rsv_rgb scattered = rsv_light_view_scattered(s, node, RSV_NONE, true);
        rsv_picture_add_light(r, r->column, 0, rgb_mul(weight, scattered));
        return;
    }
    for (uint32_t order = 1; order < s->order_count; order++) {
        uint32_t shown = order + 2 <= RSV_KEPT_ORDERS ? order + 2 : RSV_KEPT_ORDERS;
        rsv_picture_add_light(
            r, r->column, shown, rgb_mul(weight, rsv_light_view_scattered(s, node, order, true)));
    }
}

static rsv_gather follow_gather_ray(const rsv_light_view *s, const rsv_ray *ray,
    const rsv_medium *medium, const rsv_emission_wanted *wanted, rsv_random *random)
{
    rsv_hit hit;
    if (!rsv_tracer_closest(s->tracer, ray, &hit))
        return rsv_specular_gather_beyond(&s->scene, medium, ray, random, wanted);
    rsv_specular_path first = rsv_specular_begin(&s->scene, medium, ray->direction, hit);
    return rsv_specular_gather(&s->scene, first, random, wanted->filter, wanted->user);
}

/// Adds the light of sources that a gather ray has come to, of those that no other estimate counts.
static void add_sources(rsv_picture_row *r, const rsv_gather *gather, rsv_rgb weight)
{
    const rsv_light_view *s = r->job->solution;
    const rsv_specular_path *path = &gather->path;
    rsv_rgb radiance = gather->emission;
    if (gather->end == RSV_SPECULAR_ESCAPED)
        radiance =
            rgb_add(radiance, rgb_mul(path->weight, rsv_gathering_sky(s->lights, path->direction,
                                                        path->turns, rsv_has_unseen_caustics(s))));
    rsv_picture_add_light(r, r->column, 1, rgb_scale(rgb_mul(weight, radiance), RSV_PI));
}

/// Follows one gather ray, and adds what it finds. @param weight radiance at the camera per irradiance
static void gather_along(rsv_picture_row *r, const rsv_ray *ray, const rsv_medium *medium,
    rsv_rgb weight, rsv_random *random)
{
    const rsv_light_view *s = r->job->solution;
    const rsv_emission_wanted none = { no_emission, NULL }, sources = { counts, s };
    rsv_gather gather =
        follow_gather_ray(s, ray, medium, r->job->gathers_sources ? &sources : &none, random);
    if (r->job->gathers_sources) add_sources(r, &gather, weight);
    if (gather.end == RSV_SPECULAR_DIFFUSE) add_gathered(r, &gather, weight, random);
    if (gather.end == RSV_SPECULAR_SCATTERED) add_gathered_in_fog(r, &gather, weight, random);
    // otherwise emission on the way, also of fog and by way of fog, is in the stored light of order 0
}

static void gather_indirect(rsv_picture_row *r, const rsv_specular_path *path, rsv_rgb weight)
{
    const rsv_light_view *s = r->job->solution;
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_specular_bsdf(&s->scene, path, &storage);
    const rsv_receiver receiver =
        rsv_receiver_at(s->scene.view, s->tracer, path->triangle, path->u, path->v,
            rsv_surface_point_seen(s->scene.view, path->triangle, path->u, path->v, path->back,
                rsv_width_of_sample(path->width, r->sample)));
    const rsv_surface_point *point = &receiver.point;
    uint32_t rays = r->job->desc->gather_rays, total = rays * r->sample.count;
    uint32_t seed = rsv_hash2(r->sample.seed, 11 + r->job->gather_seed);
    for (uint32_t k = 0; k < rays; k++) {
        float x, y;
        rsv_stratified_2d(r->sample.index * rays + k, total, seed, &x, &y);
        rsv_vec3 d = rsv_square_to_cosine_hemisphere(x, y);
        rsv_vec3 direction = v3_turned_to(point->normal, d);
        rsv_ray ray = { rsv_receiver_start(&receiver, direction), direction, INFINITY };
        rsv_random random = rsv_random_from(r->sample.seed, r->sample.index, 97 + k);
        if (v3_dot(direction, point->horizon) <= 0) continue;
        rsv_rgb entered = rgb_scale(rgb_mul(weight, rsv_bsdf_entry(bsdf, d.z)), 1 / (float)rays);
        gather_along(r, &ray, &path->medium, entered, &random);
    }
}

void rsv_picture_gather_in_fog(
    rsv_picture_row *r, rsv_vec3 place, rsv_rgb weight, rsv_random *random)
{
    const rsv_medium air = { .depth = 0 };
    uint32_t rays = r->job->desc->gather_rays;
    weight = rgb_scale(weight, 1 / (RSV_PI * (float)rays));
    for (uint32_t k = 0; k < rays; k++) {
        float u = rsv_random_float(random), v = rsv_random_float(random);
        rsv_ray ray = { place, rsv_square_to_sphere(u, v), INFINITY };
        gather_along(r, &ray, &air, weight, random);
    }
}

/// Light straight from sources as elements store it, without what shadow rays or gather rays bring.
static rsv_rgb stored_direct(const rsv_picture_row *r, uint32_t face, float u, float v)
{
    const rsv_picture_job *job = r->job;
    const rsv_light_view *s = job->solution;
    if (!job->gathers_sources || !rsv_picture_gathers(r))
        return rsv_light_view_direct(s, face, u, v, job->desc->mode == RSV_RENDER_FINAL);
    if (!rsv_has_unseen_caustics(s)) return rgb_gray(0);
    return rsv_elements_interpolate(s->caustics.elements, s->caustics.caustic, face, u, v);
}

/// @param weight radiance at the camera per irradiance of the surface
static void shade(rsv_picture_row *r, const rsv_specular_path *path, uint32_t face, rsv_rgb weight)
{
    const rsv_light_view *s = r->job->solution;
    if (rsv_is_translucent(s, face)) {
        shade_translucent(r, path, face, weight);
        return;
    }
    bool final = r->job->desc->mode == RSV_RENDER_FINAL;
    rsv_rgb stored = stored_direct(r, face, path->u, path->v);
    rsv_picture_add_light(r, r->column, 1, rgb_mul(weight, stored));
    if (final) rsv_pixel_direct_add(&r->direct, path, weight, r->column, r->sample);
    if (rsv_picture_gathers(r))
        gather_indirect(r, path, weight);
    else
        look_up_indirect(r, face, path->u, path->v, weight);
}

void rsv_picture_shade(void *user, const rsv_specular_path *path, rsv_rgb weight)
{
    rsv_picture_row *r = user;
    const rsv_light_view *s = r->job->solution;
    uint32_t face = s->elements->face_of[path->back][path->triangle];
    if (face == RSV_NONE) return;
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_specular_bsdf(&s->scene, path, &storage);
    weight = rgb_mul(weight, bsdf->base_color);
    r->is_diffuse = path->events == 0;
    if (r->is_diffuse && r->job->guides) {
        rsv_rgb *albedo = &r->guide[RSV_GUIDE_ALBEDO][r->column];
        *albedo = rgb_add(*albedo, weight);
    }
    shade(r, path, face, rgb_scale(weight, 1 / RSV_PI));
    r->is_diffuse = false;
}
