/// Sources on rough surfaces (rough_light.h).
#ifndef RSV_ROUGH_LIGHT_BODY_H
#define RSV_ROUGH_LIGHT_BODY_H

#include "rough_light.h"

/// Width of the microsurface from which on lobes count as wide.
#define WIDE_ALPHA 0.25f

RSV_SHARED void rsv_rough_see(
    const rsv_transport_scene *scene, const rsv_specular_path *path, rsv_rough_surface *s)
{
    s->scene = scene;
    s->path = path;
    s->bsdf = rsv_specular_bsdf(scene, path, &s->storage);
    s->point = rsv_surface_point_seen(
        scene->view, path->triangle, path->u, path->v, path->back, path->width);
    s->normal = rsv_specular_bsdf_normal(s->bsdf, path, &s->point);
    s->wo = v3_neg(path->direction);
    s->front = !path->back;
    s->turns = 0;
}

/// Normals across a footprint, and the change of normals from which on they are looked at, in widths of the lobes.
#define FOOTPRINT_NORMALS 16
#define LEAST_TURN 0.3f
/// Largest change along a side, radian. Normals farther apart are often not of the visible surface: without a limit,
/// small balls of metal in the sun were a fifth too bright with 16 camera rays in a pixel, which was larger than a ball.
#define MOST_TURN 0.8f
/// Least cosine that footprints are stretched by.
#define LEAST_COSINE 0.25f

/// The change along a way in the plane.
RSV_INLINE rsv_vec3 rsv_turn_along(const rsv_normal_change *n, rsv_vec3 way)
{
    float p = v3_dot(way, n->edge[0]), q = v3_dot(way, n->edge[1]);
    rsv_vec3 first = v3_scale(n->turn[0], (n->c * p - n->b * q) / n->squared_area);
    return v3_mad(first, (n->a * q - n->b * p) / n->squared_area, n->turn[1]);
}

RSV_SHARED void rsv_rough_find_turns(rsv_rough_surface *s)
{
    const rsv_bsdf *bsdf = s->bsdf;
    const rsv_normal_change change = rsv_normal_change_of(s->scene->view, s->path->triangle);
    float cos = v3_dot(s->wo, s->point.geometric), squares = 0, alpha = bsdf->alpha;
    if (fabsf(cos) < LEAST_COSINE) cos = copysignf(LEAST_COSINE, cos);
    rsv_vec3 side[2];
    v3_frame(s->wo, &side[0], &side[1]);
    for (int k = 0; k < 2; k++) {
        float rise = v3_dot(side[k], s->point.geometric) / cos;
        rsv_vec3 way = v3_mad(side[k], -rise, s->wo);
        s->turn[k] = v3_scale(rsv_turn_along(&change, way), s->path->width);
        float square = v3_dot(s->turn[k], s->turn[k]);
        if (square > MOST_TURN * MOST_TURN)
            s->turn[k] = v3_scale(s->turn[k], MOST_TURN / sqrtf(square));
        squares += f_min(square, MOST_TURN * MOST_TURN);
    }
    if (bsdf->clearcoat > 0 && bsdf->clearcoat_alpha > 0)
        alpha = f_min(alpha, bsdf->clearcoat_alpha);
    s->turns = squares > LEAST_TURN * LEAST_TURN * alpha * alpha ? FOOTPRINT_NORMALS : 0;
}

RSV_SHARED void rsv_rough_lift(rsv_rough_surface *s)
{
    const rsv_specular_path *path = s->path;
    rsv_surface_lift(s->scene->view, s->scene->tracer, path->triangle, path->u, path->v, &s->point);
}

RSV_SHARED void rsv_rough_meet(
    const rsv_transport_scene *scene, const rsv_specular_path *path, rsv_rough_surface *s)
{
    rsv_rough_see(scene, path, s);
    rsv_rough_lift(s);
}

RSV_SHARED bool rsv_rough_is_wide(const rsv_bsdf *bsdf)
{
    bool narrow = bsdf->alpha > 0 && bsdf->alpha < WIDE_ALPHA;
    bool narrow_coat =
        bsdf->clearcoat > 0 && bsdf->clearcoat_alpha > 0 && bsdf->clearcoat_alpha < WIDE_ALPHA;
    return bsdf->rough && !narrow && !narrow_coat;
}

RSV_SHARED rsv_rgb rsv_rough_response(const rsv_rough_surface *s, rsv_vec3 wi)
{
    rsv_bsdf_value value = rsv_rough_respond(s, wi);
    if (!(value.pdf_solid_angle > 0)) return rgb_gray(0);
    rsv_rough_side side;
    rsv_rough_set_side(s, v3_dot(s->normal, wi) < 0, &side);
    return rgb_mul(value.response, side.entrance.weight);
}

RSV_SHARED rsv_bsdf_event rsv_rough_draw(const rsv_rough_surface *s, const float u[3])
{
    rsv_bsdf_event event = rsv_bsdf_draw_specular(s->bsdf, s->wo, s->normal, s->front, u);
    event.weight = rgb_scale(event.weight, s->bsdf->opacity);
    return event;
}

RSV_SHARED rsv_rough_departure rsv_rough_depart(
    const rsv_rough_surface *s, rsv_vec3 direction, float sky_pdf)
{
    bool below = v3_dot(s->normal, direction) < 0;
    rsv_rough_departure departure;
    departure.point = s->point.position;
    departure.side = below ? v3_neg(s->normal) : s->normal;
    departure.pdf_solid_angle = rsv_rough_respond(s, direction).pdf_solid_angle;
    departure.sky_pdf = sky_pdf;
    departure.shot = false;
    return departure;
}

/// Of the times that a source would be aimed at from within a body, those that one is: the body's own surface is nearly
/// always in the way.
#define AIMED_WITHIN 0.25f

RSV_INLINE rsv_rgb rsv_rough_sampled_light(const rsv_rough_surface *s, const rsv_rough_side *side,
    const rsv_lights *lights, bool shot, const float u[3])
{
    rsv_local_lights local;
    rsv_light_sample light;
    rsv_next_event event;
    float chance = side->medium.depth ? AIMED_WITHIN : 1;
    if (u[0] >= chance) return rgb_gray(0);
    rsv_lights_about(lights, side->receiver.point.position, side->receiver.point.normal, &local);
    if (!rsv_local_lights_sample(&local, u[0] / chance, u[1], u[2], &light)) return rgb_gray(0);
    if (shot && !light.from_sky) return rgb_gray(0);
    rsv_response response =
        rsv_rough_aimed_response(s, light.direction, light.pdf_solid_angle, u + 1);
    if (rgb_is_black(response.share)) return rgb_gray(0);
    rsv_next_event_clear(&event);
    rsv_next_event_at_place(&side->receiver, &side->entrance, lights, &light, response, &event);
    return rgb_scale(event.light, rsv_next_event_passed(s->scene->tracer, &event) / chance);
}

RSV_INLINE rsv_rgb rsv_rough_punctual_light(const rsv_rough_surface *s, const rsv_rough_side *side,
    const rsv_lights *lights, const rsv_punctual_sample *light, const float u[2])
{
    rsv_next_event event;
    rsv_response response = rsv_rough_aimed_response(s, light->direction, INFINITY, u);
    if (rgb_is_black(response.share)) return rgb_gray(0);
    rsv_next_event_clear(&event);
    rsv_next_event_at_light(&side->receiver, &side->entrance, lights, light, response, &event);
    return rgb_scale(event.light, rsv_next_event_passed(s->scene->tracer, &event));
}

/// Sides that light comes from.
RSV_INLINE int rsv_rough_sides(const rsv_rough_surface *s)
{
    return s->bsdf->transmission > 0 || s->bsdf->passed > 0 ? 2 : 1;
}

RSV_SHARED rsv_rgb rsv_rough_light_from(
    const rsv_rough_surface *s, const rsv_lights *lights, uint32_t k, const float u[3])
{
    rsv_punctual_sample light;
    rsv_rough_side side;
    if (!rsv_punctual_at(lights, s->point.position, v3(0, 0, 0), k, u[0], &light))
        return rgb_gray(0);
    bool below = v3_dot(s->normal, light.direction) < 0;
    if (below >= rsv_rough_sides(s)) return rgb_gray(0);
    rsv_rough_set_side(s, below, &side);
    return rsv_rough_punctual_light(s, &side, lights, &light, u + 1);
}

/// Widths by normals that vary: lobes become no wider than this.
#define WIDEST_ALPHA 0.5f

RSV_INLINE float rsv_widened(float alpha, float variance)
{
    float wider = sqrtf(alpha * alpha + variance);
    return alpha > 0 && alpha < WIDEST_ALPHA ? f_min(wider, WIDEST_ALPHA) : alpha;
}

RSV_SHARED bool rsv_rough_widen(rsv_rough_surface *s, float variance)
{
    float alpha = rsv_widened(s->bsdf->alpha, variance);
    float clearcoat = rsv_widened(s->bsdf->clearcoat_alpha, variance);
    if (s->bsdf->brushed ||
        !(alpha + clearcoat > 1.1f * (s->bsdf->alpha + s->bsdf->clearcoat_alpha)))
        return false;
    if (s->bsdf != &s->storage) s->storage = *s->bsdf;
    s->bsdf = &s->storage;
    s->storage.alpha = alpha;
    s->storage.clearcoat_alpha = clearcoat;
    s->storage.alpha_place = rsv_table_alpha(alpha);
    return true;
}

RSV_SHARED rsv_rgb rsv_rough_light(
    const rsv_rough_surface *s, const rsv_lights *lights, bool shot, const float u[3])
{
    return rsv_rough_light_by(s, s, lights, shot, u);
}

RSV_SHARED rsv_rgb rsv_rough_light_by(const rsv_rough_surface *s, const rsv_rough_surface *punctual,
    const rsv_lights *lights, bool shot, const float u[3])
{
    rsv_rough_side side[2];
    int sides = rsv_rough_sides(s);
    rsv_rgb sum = rgb_gray(0);
    for (int below = 0; below < sides; below++) {
        rsv_rough_set_side(s, below, &side[below]);
        sum = rgb_add(sum, rsv_rough_sampled_light(s, &side[below], lights, shot, u));
    }
    for (uint32_t k = 0; punctual && !shot && k < rsv_punctual_count(lights); k++) {
        rsv_punctual_sample light;
        if (!rsv_punctual_at(lights, s->point.position, v3(0, 0, 0), k, u[0], &light)) continue;
        bool below = v3_dot(s->normal, light.direction) < 0;
        if (below < sides)
            sum = rgb_add(
                sum, rsv_rough_punctual_light(punctual, &side[below], lights, &light, u + 1));
    }
    return sum;
}

RSV_SHARED float rsv_rough_emission_weight(const rsv_transport_scene *scene,
    const rsv_lights *lights, const rsv_specular_path *path, const rsv_rough_departure *departure)
{
    uint32_t emitter = rsv_emitter_at(lights, path->triangle, path->u, path->v);
    if (emitter == RSV_NONE || lights->group[lights->emitter[emitter].group].gathered) return 1;
    if (departure->shot) return 0;
    if (departure->pdf_solid_angle == 0) return 1;
    rsv_surface_point point =
        rsv_surface_point_at(scene->view, path->triangle, path->u, path->v, path->back);
    rsv_local_lights local;
    rsv_lights_about(lights, departure->point, departure->side, &local);
    float distance = v3_length(v3_sub(point.position, departure->point));
    float pdf = rsv_local_lights_pdf(&local, emitter, path->direction, distance);
    return rsv_power_heuristic(departure->pdf_solid_angle, pdf);
}

RSV_SHARED rsv_rgb rsv_rough_sky(
    const rsv_lights *lights, rsv_vec3 direction, const rsv_rough_departure *departure)
{
    const rsv_environment_light *environment = lights->environment;
    float own = departure->pdf_solid_angle;
    if (!environment) return rgb_gray(0);
    if (own == 0 && !departure->shot) return rsv_sky_radiance(&environment->whole, direction);
    rsv_rgb sum = rsv_sky_radiance(&environment->gathered, direction);
    rsv_rgb sampled = rsv_sky_radiance(&environment->sampled, direction);
    if (own == 0) return rgb_add(sum, sampled);
    sum = rgb_scale(sum, rsv_power_heuristic(own, departure->sky_pdf));
    rsv_local_lights local;
    rsv_lights_about(lights, departure->point, departure->side, &local);
    float weight = rsv_power_heuristic(own, rsv_local_lights_sky_pdf(&local, direction));
    sum = rgb_mad(sum, weight, sampled);
    for (uint32_t k = 0; !departure->shot && k < environment->sun_count; k++) {
        float pdf = rsv_local_lights_sun_pdf(&local, k, direction);
        if (pdf > 0)
            sum = rgb_mad(sum, rsv_power_heuristic(own, pdf), environment->sun[k].radiance);
    }
    return sum;
}

#endif
