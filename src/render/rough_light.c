#include "rough_light.h"

#include "../light/punctual_light.h"

/// Width of the microsurface from which on lobes count as wide.
#define WIDE_ALPHA 0.25f

void rsv_rough_meet(const rsv_transport_scene *scene, const rsv_chain *chain, rsv_rough_surface *s)
{
    s->scene = scene;
    s->chain = chain;
    s->bsdf = rsv_chain_scattering(scene, chain, &s->normal, &s->storage);
    s->point = rsv_surface_point_seen(
        scene->view, chain->triangle, chain->u, chain->v, chain->back, chain->width);
    s->wo = v3_neg(chain->direction);
    s->front = !chain->back;
}

/// Radiance at the chain's start per radiance that sources send from that distance along `wi`.
static rsv_rgb throughput(const rsv_rough_surface *s, rsv_vec3 wi, float distance)
{
    rsv_medium medium = s->chain->medium;
    if (v3_dot(s->normal, wi) < 0) medium = rsv_chain_medium_beyond(s->scene, s->chain);
    return rgb_mul(rsv_chain_throughput(s->scene, s->chain, &medium),
        rsv_medium_transmittance(&medium, s->scene->bsdf, distance));
}

/// Response of the rough lobes; nothing where the normals disagree on wi's side.
static rsv_bsdf_value respond(const rsv_rough_surface *s, rsv_vec3 wi)
{
    rsv_bsdf_value value = { rgb_gray(0), 0 };
    if (v3_dot(s->point.geometric, wi) * v3_dot(s->normal, wi) <= 0) return value;
    value = rsv_bsdf_evaluate(s->bsdf, wi, s->wo, s->normal, s->front, RSV_LOBES_ROUGH);
    value.response = rgb_scale(value.response, s->bsdf->opacity);
    float chance = rsv_bsdf_specular_chance(s->bsdf, s->wo, s->normal, s->front);
    if (value.pdf_solid_angle > 0) value.pdf_solid_angle /= chance;
    return value;
}

bool rsv_rough_is_wide(const rsv_bsdf *bsdf)
{
    bool narrow = bsdf->alpha > 0 && bsdf->alpha < WIDE_ALPHA;
    bool narrow_coat =
        bsdf->clearcoat > 0 && bsdf->clearcoat_alpha > 0 && bsdf->clearcoat_alpha < WIDE_ALPHA;
    return bsdf->rough && !narrow && !narrow_coat;
}

rsv_rgb rsv_rough_response(const rsv_rough_surface *s, rsv_vec3 wi)
{
    rsv_bsdf_value value = respond(s, wi);
    return value.pdf_solid_angle > 0 ? rgb_mul(value.response, throughput(s, wi, 0)) : rgb_gray(0);
}

static float power_heuristic(float own, float other)
{
    float ratio = other / own;
    return 1 / (1 + ratio * ratio);
}

static rsv_vec3 leaving_point(const rsv_rough_surface *s, rsv_vec3 direction)
{
    rsv_vec3 side = s->point.geometric;
    if (v3_dot(side, direction) < 0) side = v3_neg(side);
    return rsv_offset_origin(s->point.position, side, s->point.extent);
}

rsv_bsdf_event rsv_rough_draw(const rsv_rough_surface *s, const float u[3])
{
    rsv_bsdf_event event =
        rsv_bsdf_draw_specular(s->bsdf, s->wo, s->normal, s->front, u[0], u[1], u[2]);
    event.weight = rgb_scale(event.weight, s->bsdf->opacity);
    return event;
}

rsv_rough_departure rsv_rough_depart(
    const rsv_rough_surface *s, const rsv_sky_aim *aim, rsv_vec3 direction)
{
    bool below = v3_dot(s->normal, direction) < 0;
    return (rsv_rough_departure){ s->point.position, below ? v3_neg(s->normal) : s->normal,
        respond(s, direction).pdf_solid_angle, rsv_sky_aim_pdf(aim, direction), false };
}

void rsv_rough_aim(const rsv_rough_surface *s, const rsv_openings *openings, rsv_sky_aim *aim)
{
    aim->count = 0;
    if (openings)
        rsv_sky_aim_at(openings, rsv_openings_at(openings, s->chain, &s->point), s->bsdf, s->wo,
            s->normal, aim);
}

rsv_rgb rsv_rough_aimed_light(
    const rsv_rough_surface *s, const rsv_lights *lights, const rsv_sky_aim *aim, const float u[3])
{
    if (aim->count == 0) return rgb_gray(0);
    rsv_vec3 direction = rsv_sky_aim_sample(aim, u);
    rsv_bsdf_value value = respond(s, direction);
    float pdf = rsv_sky_aim_pdf(aim, direction);
    if (value.pdf_solid_angle == 0 || !(pdf > 0)) return rgb_gray(0);
    rsv_ray ray = { leaving_point(s, direction), direction, INFINITY };
    if (rsv_tracer_occluded(s->scene->tracer, &ray)) return rgb_gray(0);
    rsv_rgb arriving = rgb_mul(throughput(s, direction, INFINITY),
        rsv_sky_radiance(&lights->environment->gathered, direction));
    float weight = power_heuristic(pdf, value.pdf_solid_angle);
    return rgb_scale(rgb_mul(value.response, arriving), weight / pdf);
}

static rsv_rgb sampled_light(const rsv_rough_surface *s, const rsv_lights *lights, rsv_vec3 side,
    bool shot, const float u[3])
{
    rsv_local_lights local;
    rsv_light_sample light;
    rsv_lights_at(lights, s->point.position, side, &local);
    if (!rsv_local_lights_sample(&local, u[0], u[1], u[2], &light)) return rgb_gray(0);
    rsv_bsdf_value value = respond(s, light.direction);
    if (value.pdf_solid_angle == 0 || (shot && !light.from_sky)) return rgb_gray(0);
    rsv_ray ray =
        rsv_shadow_ray(lights, &light, s->point.position, leaving_point(s, light.direction));
    if (rsv_tracer_occluded(s->scene->tracer, &ray)) return rgb_gray(0);
    float weight = power_heuristic(light.pdf_solid_angle, value.pdf_solid_angle);
    rsv_rgb arriving = rgb_mul(throughput(s, light.direction, light.distance), light.radiance);
    return rgb_scale(rgb_mul(value.response, arriving), weight / light.pdf_solid_angle);
}

static rsv_rgb punctual_light(const rsv_rough_surface *s, const rsv_punctual_sample *light)
{
    rsv_bsdf_value value = respond(s, light->direction);
    if (value.pdf_solid_angle == 0) return rgb_gray(0);
    rsv_ray ray = rsv_punctual_ray(light, leaving_point(s, light->direction));
    if (rsv_tracer_occluded(s->scene->tracer, &ray)) return rgb_gray(0);
    return rgb_mul(value.response,
        rgb_mul(throughput(s, light->direction, light->distance), light->irradiance));
}

rsv_rgb rsv_rough_light(
    const rsv_rough_surface *s, const rsv_lights *lights, bool shot, const float u[3])
{
    rsv_rgb sum = sampled_light(s, lights, s->normal, shot, u);
    if (s->bsdf->transmission > 0 || s->bsdf->passed > 0)
        sum = rgb_add(sum, sampled_light(s, lights, v3_neg(s->normal), shot, u));
    for (uint32_t k = 0; !shot && k < rsv_punctual_count(lights); k++) {
        rsv_punctual_sample light;
        if (rsv_punctual_at(lights, s->point.position, v3(0, 0, 0), k, u[0], &light))
            sum = rgb_add(sum, punctual_light(s, &light));
    }
    return sum;
}

float rsv_rough_emission_weight(const rsv_transport_scene *scene, const rsv_lights *lights,
    const rsv_chain *chain, const rsv_rough_departure *departure)
{
    uint32_t emitter = rsv_emitter_at(lights, chain->triangle, chain->u, chain->v);
    if (emitter == RSV_NONE || lights->group[lights->emitter[emitter].group].gathered) return 1;
    if (departure->shot) return 0;
    if (departure->pdf_solid_angle == 0) return 1;
    rsv_surface_point point =
        rsv_surface_point_at(scene->view, chain->triangle, chain->u, chain->v, chain->back);
    rsv_local_lights local;
    rsv_lights_at(lights, departure->point, departure->side, &local);
    float distance = v3_length(v3_sub(point.position, departure->point));
    float pdf = rsv_local_lights_pdf(&local, emitter, chain->direction, distance);
    return power_heuristic(departure->pdf_solid_angle, pdf);
}

rsv_rgb rsv_rough_sky(
    const rsv_lights *lights, rsv_vec3 direction, const rsv_rough_departure *departure)
{
    const rsv_environment_light *environment = lights->environment;
    float own = departure->pdf_solid_angle;
    if (!environment) return rgb_gray(0);
    if (own == 0 && !departure->shot) return rsv_sky_radiance(&environment->whole, direction);
    rsv_rgb sum = rsv_sky_radiance(&environment->gathered, direction);
    rsv_rgb sampled = rsv_sky_radiance(&environment->sampled, direction);
    if (own == 0) return rgb_add(sum, sampled);
    sum = rgb_scale(sum, power_heuristic(own, departure->sky_pdf));
    rsv_local_lights local;
    rsv_lights_at(lights, departure->point, departure->side, &local);
    float weight = power_heuristic(own, rsv_local_lights_sky_pdf(&local, direction));
    sum = rgb_mad(sum, weight, sampled);
    for (uint32_t k = 0; !departure->shot && k < environment->sun_count; k++) {
        float pdf = rsv_local_lights_sun_pdf(&local, k, direction);
        if (pdf > 0) sum = rgb_mad(sum, power_heuristic(own, pdf), environment->sun[k].radiance);
    }
    return sum;
}
