#include "air_light.h"

#include "../media/fog_run.h"
#include "../media/phase.h"

float rsv_air_response(const rsv_fog *fog, const rsv_air_receiver *r, rsv_vec3 towards)
{
    if (fog->anisotropy == 0 || v3_dot(r->forward, r->forward) == 0) return 1;
    float cos = v3_dot(r->forward, towards);
    return 4 * RSV_PI *
           (r->uneven ? rsv_phase_uneven(fog->anisotropy, cos) : rsv_phase(fog->anisotropy, cos));
}

rsv_rgb rsv_air_passed(const rsv_air_setting *s, const rsv_ray *shadow, rsv_vec3 point,
    rsv_vec3 towards, float distance)
{
    float passed = rsv_ray_passed(s->tracer, shadow);
    if (!(passed > 0)) return rgb_gray(0);
    rsv_fog_run run = rsv_fog_run_of(s->fog, point, towards, distance);
    return rgb_scale(rsv_fog_transmittance(s->fog, run.column), passed);
}

/// @param weight over the density of the sample
static rsv_rgb add_sample(const rsv_air_setting *s, const rsv_air_receiver *r,
    const rsv_light_sample *sample, float weight, uint64_t *rays)
{
    if (rgb_is_black(sample->radiance) || !(weight > 0) || !isfinite(weight)) return rgb_gray(0);
    rsv_ray shadow = rsv_shadow_ray(s->lights->lights, sample, r->point, r->point);
    ++*rays;
    rsv_rgb seen = rsv_air_passed(s, &shadow, r->point, sample->direction, sample->distance);
    float response = rsv_air_response(s->fog, r, sample->direction);
    return rgb_scale(rgb_mul(sample->radiance, seen), weight * response);
}

static rsv_rgb from_punctual(const rsv_air_setting *s, const rsv_air_receiver *r,
    const rsv_punctual_sample *light, uint64_t *rays)
{
    rsv_ray shadow = rsv_punctual_ray(light, r->point);
    ++*rays;
    rsv_rgb seen = rsv_air_passed(s, &shadow, r->point, light->direction, light->distance);
    float response = rsv_air_response(s->fog, r, light->direction);
    return rgb_scale(rgb_mul(light->irradiance, seen), response);
}

rsv_rgb rsv_air_light_of_entry(const rsv_air_setting *s, const rsv_air_receiver *r, uint32_t entry,
    const float u[2], uint64_t *rays)
{
    rsv_punctual_sample light = { .light = rsv_fog_light_punctual(s->lights, entry) };
    const rsv_fog_choice here = { .lights = s->lights, .point = r->point };
    rsv_light_sample sample;
    if (light.light) {
        rsv_vec3 place = rsv_punctual_place_by(light.light, u[0], entry);
        const rsv_scene_view *scene = s->lights->lights->scene;
        return rsv_punctual_arriving(scene, light.light, place, r->point, &light)
                   ? from_punctual(s, r, &light, rays)
                   : rgb_gray(0);
    }
    if (!rsv_fog_sample_emitter(&here, entry, u[0], u[1], &sample)) return rgb_gray(0);
    return add_sample(s, r, &sample, 1 / sample.pdf_solid_angle, rays);
}

/// Of the choice at the receiver, emitters alone: punctual lights are asked one by one.
static rsv_rgb from_emitter(
    const rsv_air_setting *s, const rsv_air_receiver *r, const float u[3], uint64_t *rays)
{
    rsv_fog_choice choice;
    float probability = 0;
    if (!s->lights->emitters) return rgb_gray(0);
    rsv_fog_emitters_at(s->lights, r->point, &choice);
    uint32_t entry = rsv_fog_choice_draw(&choice, u[0], &probability);
    if (entry == RSV_NONE) return rgb_gray(0);
    return rgb_scale(rsv_air_light_of_entry(s, r, entry, u + 1, rays), 1 / probability);
}

static rsv_rgb from_suns_and_sky(
    const rsv_air_setting *s, const rsv_air_receiver *r, const float u[2], uint64_t *rays)
{
    const rsv_environment_light *sky = s->lights->lights->environment;
    rsv_rgb sum = rgb_gray(0);
    rsv_light_sample sample = { .distance = INFINITY, .emitter = RSV_NONE };
    for (uint32_t k = 0; sky && k < sky->sun_count; k++) {
        sample.direction = rsv_sun_sample(&sky->sun[k], u[0], u[1]);
        sample.radiance = sky->sun[k].radiance;
        sum = rgb_add(sum, add_sample(s, r, &sample, sky->sun[k].solid_angle, rays));
    }
    if (!sky || !(sky->sampler.flux > 0)) return sum;
    float pdf = rsv_sky_sample(&sky->sampler, u[0], u[1], &sample.direction);
    if (!(pdf > 0)) return sum;
    sample.radiance = rsv_sky_radiance(&sky->sampled, sample.direction);
    return rgb_add(sum, add_sample(s, r, &sample, 1 / pdf, rays));
}

rsv_rgb rsv_air_light(
    const rsv_air_setting *s, const rsv_air_receiver *r, const float u[5], uint64_t *rays)
{
    const rsv_lights *lights = s->lights->lights;
    rsv_rgb sum = rgb_add(from_emitter(s, r, u, rays), from_suns_and_sky(s, r, u + 3, rays));
    for (uint32_t k = 0; k < rsv_punctual_count(lights); k++) {
        rsv_punctual_sample light;
        if (rsv_punctual_at(lights, r->point, v3(0, 0, 0), k, u[0], &light) &&
            !rsv_air_leaves_out(r, light.light))
            sum = rgb_add(sum, from_punctual(s, r, &light, rays));
    }
    return sum;
}

rsv_rgb rsv_air_light_from_afar(
    const rsv_air_setting *s, const rsv_air_receiver *r, const float u[2], uint64_t *rays)
{
    const rsv_lights *lights = s->lights->lights;
    rsv_rgb sum = from_suns_and_sky(s, r, u, rays);
    for (uint32_t k = 0; k < lights->distant_count; k++) {
        rsv_punctual_sample light;
        if (rsv_punctual_at(lights, r->point, v3(0, 0, 0), k, u[0], &light))
            sum = rgb_add(sum, from_punctual(s, r, &light, rays));
    }
    return sum;
}
