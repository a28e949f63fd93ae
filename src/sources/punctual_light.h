/// Punctual lights after KHR_lights_punctual, and the rays that ask whether their light and that of emitters arrives. For
/// device code too.
#ifndef RSV_PUNCTUAL_LIGHT_H
#define RSV_PUNCTUAL_LIGHT_H

#include "../scene/punctual.h"
#include "../trace/offset.h"
#include "lights.h"

#define RSV_SUMMED_LIGHTS 16 ///< punctual lights of which each is worth a shadow ray
#define RSV_PUNCTUAL_PICKS 4 ///< shadow rays where there are more

/// Punctual lights that stand for all at a point: each of them, or distant ones and RSV_PUNCTUAL_PICKS of the
/// others, drawn by the tree.
RSV_INLINE uint32_t rsv_punctual_count(const rsv_lights *lights)
{
    return (uint32_t)(lights->punctual_tree ? lights->distant_count + RSV_PUNCTUAL_PICKS
                                            : lights->punctual_count);
}

typedef struct rsv_punctual_sample {
    const rsv_punctual_light *light;
    rsv_vec3 direction; ///< unit, towards it
    float distance;     ///< INFINITY for distant ones
    rsv_rgb irradiance; ///< on a surface that faces it, without occlusion, times what it stands for
} rsv_punctual_sample;

/// Share of a spot's intensity at the cosine of the angle to its axis: the extension's recommended
/// falloff, the square of a ramp in the cosine between the cones, or a smooth step; a step where they coincide.
RSV_INLINE double rsv_spot_falloff(const rsv_punctual_light *light, double cos_angle)
{
    double cos_inner = cos((double)light->inner_cone_angle);
    double cos_outer = cos((double)light->outer_cone_angle);
    if (cos_angle < cos_outer) return 0;
    double ramp = cos_inner > cos_outer ? (cos_angle - cos_outer) / (cos_inner - cos_outer) : 1;
    double falloff = ramp < 1 ? ramp * ramp * (light->smooth_cone ? 3 - 2 * ramp : 1) : 1;
    return light->exponent != 0 ? falloff * pow(fmax(cos_angle, 0.0), light->exponent) : falloff;
}

/// A light seen from `point`: unit direction to it, distance, and irradiance
/// on a surface that faces it, without occlusion. False if nothing arrives.
RSV_INLINE bool rsv_punctual_irradiance(const rsv_punctual_light *light, rsv_vec3 point,
    rsv_vec3 *direction, float *distance, rsv_rgb *irradiance)
{
    if (rgb_is_black(light->intensity)) return false;
    if (rsv_punctual_is_distant(light)) {
        *direction = v3_neg(light->direction);
        *distance = INFINITY;
        *irradiance = light->intensity;
        return true;
    }
    rsv_vec3 towards = v3_sub(light->position, point);
    *distance = v3_length(towards);
    if (!(*distance > 0)) return false;
    *direction = v3_scale(towards, 1 / *distance);
    double scale = 1 / ((double)*distance * *distance);
    if (rsv_punctual_has_cone(light))
        scale *= rsv_spot_falloff(light, -v3_dot(*direction, light->direction));
    *irradiance = rgb_scale(light->intensity, (float)scale);
    return scale > 0;
}

/// @param weight by which its light counts @return NULL if none can contribute
RSV_INLINE const rsv_punctual_light *rsv_pick_punctual(
    const rsv_lights *lights, rsv_vec3 point, rsv_vec3 normal, uint32_t k, float u, float *weight)
{
    const rsv_punctual_light *light = lights->scene->light;
    *weight = 1;
    if (!lights->punctual_tree || k < lights->distant_count) return &light[lights->punctual[k]];
    uint32_t drawn;
    float stratum = ((float)(k - (uint32_t)lights->distant_count) + u) / RSV_PUNCTUAL_PICKS;
    float probability =
        rsv_light_tree_sample(lights->punctual_tree, point, normal, stratum, &drawn);
    if (!(probability > 0)) return NULL;
    *weight = 1 / (RSV_PUNCTUAL_PICKS * probability);
    return &light[lights->punctual[lights->distant_count + drawn]];
}

/// The k-th of those. False if nothing arrives.
/// @param normal unit; zero = light from everywhere counts
/// @param u in [0, 1), the same for all k
RSV_INLINE bool rsv_punctual_at(const rsv_lights *lights, rsv_vec3 point, rsv_vec3 normal,
    uint32_t k, float u, rsv_punctual_sample *sample)
{
    float weight;
    sample->light = rsv_pick_punctual(lights, point, normal, k, u, &weight);
    if (!sample->light || !rsv_punctual_irradiance(sample->light, point, &sample->direction,
                              &sample->distance, &sample->irradiance))
        return false;
    sample->irradiance = rgb_scale(sample->irradiance, weight);
    return true;
}

// ---- shadow rays --------------------------------------------------------------------------------

RSV_INLINE rsv_ray rsv_ray_to(rsv_vec3 origin, rsv_vec3 direction, float t_max)
{
    rsv_ray ray = { origin, direction, t_max };
    return ray;
}

/// The segment that must be free for a sample's light to arrive, t_max = 1: from `origin` (off the receiver's
/// surface) to the sampled point, moved off the emitter's surface likewise. Neither end depends on the
/// other's distance, so lamps close to what they light do not shadow themselves.
/// Rays to suns and sky have no end.
/// @param point the receiver the sample was drawn for
RSV_INLINE rsv_ray rsv_shadow_ray(
    const rsv_lights *lights, const rsv_light_sample *sample, rsv_vec3 point, rsv_vec3 origin)
{
    if (sample->emitter == RSV_NONE) return rsv_ray_to(origin, sample->direction, INFINITY);
    const rsv_emitter *emitter = &lights->emitter[sample->emitter];
    bool front = v3_dot(emitter->normal, sample->direction) < 0;
    rsv_vec3 side = front ? emitter->normal : v3_neg(emitter->normal);
    // the target is reached from the receiver, so the rounding of both ends and of the way enters
    float extent = rsv_extent_of(lights->scene, emitter->triangle);
    extent = f_max(f_max(extent, sample->distance), v3_max_abs(point));
    rsv_vec3 target =
        rsv_moved_off(v3_mad(point, sample->distance, sample->direction), side, extent);
    return rsv_ray_to(origin, v3_sub(target, origin), 1);
}

/// The same for a punctual light.
RSV_INLINE rsv_ray rsv_punctual_ray(const rsv_punctual_sample *sample, rsv_vec3 origin)
{
    if (!(sample->distance < INFINITY)) return rsv_ray_to(origin, sample->direction, INFINITY);
    return rsv_ray_to(origin, v3_sub(sample->light->position, origin), 1);
}

#endif
