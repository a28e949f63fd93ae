/// Punctual lights as in KHR_lights_punctual, measured luminaires, and shadow rays to lights and emitters. Also for
/// device code.
#ifndef RSV_PUNCTUAL_LIGHT_H
#define RSV_PUNCTUAL_LIGHT_H

#include "../core/sampling.h"
#include "../luminaire/intensity.h"
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
    rsv_vec3 place;     ///< of the light, that its light comes from
    rsv_vec3 direction; ///< unit, towards it
    float distance;     ///< INFINITY for distant ones
    rsv_rgb irradiance; ///< on a surface that faces it, unoccluded, times the sample's weight
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

/// Metres by which light leaves in front of a luminaire's opening, which often lies in a ceiling.
#define RSV_LUMINAIRE_GAP 1e-4f

/// A place on a light, evenly on an opening. @param u three numbers in [0, 1)
RSV_INLINE rsv_vec3 rsv_punctual_place(const rsv_punctual_light *light, const float u[3])
{
    if (light->kind != RSV_PUNCTUAL_LUMINAIRE) return light->position;
    rsv_vec3 size = light->opening, up = v3_cross(light->side, light->direction);
    rsv_vec3 place = v3_mad(light->position, RSV_LUMINAIRE_GAP, light->direction);
    float x = u[0] - 0.5f, y = u[1] - 0.5f;
    if (!rsv_punctual_is_extended(light)) return place;
    if (size.x < 0) {
        rsv_square_to_disk(u[0], u[1], &x, &y);
        x *= 0.5f, y *= 0.5f;
    }
    place = v3_mad(v3_mad(place, x * size.x, light->side), y * size.y, up);
    return v3_mad(place, (u[2] - 0.5f) * size.z, light->direction);
}

/// Every other bit of 24: of stratified numbers, these halves are stratified in the plane (Morton's order).
RSV_INLINE uint32_t rsv_even_bits(uint32_t x)
{
    x &= 0x555555u;
    x = (x | x >> 1) & 0x333333u;
    x = (x | x >> 2) & 0x0f0f0fu;
    x = (x | x >> 4) & 0xff00ffu;
    return (x | x >> 8) & 0xfffu;
}

/// 12 bits as a number in [0, 1), shifted around by a random one.
RSV_INLINE float rsv_luminaire_turned(uint32_t bits, uint32_t random)
{
    uint32_t turned = (bits << 20) + random;
    return rsv_unit_float(turned);
}

/// The same by one number, evenly for evenly spread ones. @param stream differs from light to light
RSV_INLINE rsv_vec3 rsv_punctual_place_by(const rsv_punctual_light *light, float u, uint32_t stream)
{
    float numbers[3];
    if (!rsv_punctual_is_extended(light)) {
        numbers[0] = numbers[1] = numbers[2] = 0.5f;
        return rsv_punctual_place(light, numbers);
    }
    uint32_t bits = (uint32_t)(u * 16777216.0f);
    numbers[0] = rsv_luminaire_turned(rsv_even_bits(bits >> 1), rsv_hash(stream));
    numbers[1] = rsv_luminaire_turned(rsv_even_bits(bits), rsv_hash2(stream, 1));
    numbers[2] = rsv_unit_float(rsv_hash3(bits, stream, 2));
    return rsv_punctual_place(light, numbers);
}

/// Emission of a light along its way, per intensity. @param towards the light, unit
RSV_INLINE double rsv_punctual_share(
    const rsv_scene_view *scene, const rsv_punctual_light *light, rsv_vec3 towards)
{
    if (light->kind == RSV_PUNCTUAL_LUMINAIRE) {
        rsv_vec3 up = v3_cross(light->side, light->direction);
        return rsv_luminaire_towards(&scene->luminaire[light->luminaire],
            -(double)v3_dot(towards, light->side), -(double)v3_dot(towards, up),
            -(double)v3_dot(towards, light->direction));
    }
    return rsv_punctual_has_cone(light)
               ? rsv_spot_falloff(light, -(double)v3_dot(towards, light->direction))
               : 1;
}

/// A light seen from `point`: unit direction to a place of it, distance, and irradiance
/// on a surface that faces it, without occlusion. False if nothing arrives.
RSV_INLINE bool rsv_punctual_arriving(const rsv_scene_view *scene, const rsv_punctual_light *light,
    rsv_vec3 place, rsv_vec3 point, rsv_punctual_sample *sample)
{
    sample->light = light;
    sample->place = place;
    if (rgb_is_black(light->intensity)) return false;
    if (rsv_punctual_is_distant(light)) {
        sample->direction = v3_neg(light->direction);
        sample->distance = INFINITY;
        sample->irradiance = light->intensity;
        return true;
    }
    rsv_vec3 towards = v3_sub(place, point);
    float distance = sample->distance = v3_length(towards);
    if (!(distance > 0)) return false;
    sample->direction = v3_scale(towards, 1 / distance);
    double scale = rsv_punctual_share(scene, light, sample->direction);
    scale *= 1 / ((double)distance * distance);
    sample->irradiance = rgb_scale(light->intensity, (float)scale);
    return scale > 0;
}

/// Luminance of the total emission of a light, W; 0 for directional lights.
double rsv_punctual_flux(const rsv_scene_view *scene, const rsv_punctual_light *light);

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
    const rsv_punctual_light *light = rsv_pick_punctual(lights, point, normal, k, u, &weight);
    if (!light) return false;
    if (!rsv_punctual_arriving(
            lights->scene, light, rsv_punctual_place_by(light, u, k), point, sample))
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

/// The segment that must be unoccluded for a sample's light to arrive, t_max = 1: from `origin` (off the receiver's
/// surface) to the sampled point, moved off the emitter's surface in the same way. Neither end depends on the distance
/// of the other, so lamps close to a receiver do not shadow themselves. Rays to suns and sky are infinite.
/// @param point the receiver for which the sample was drawn
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

/// Tested part of the way to a punctual light, so that a wall does not hide a light that lies on it.
#define RSV_PUNCTUAL_WAY 0.99999f

/// The same for a punctual light.
RSV_INLINE rsv_ray rsv_punctual_ray(const rsv_punctual_sample *sample, rsv_vec3 origin)
{
    if (!(sample->distance < INFINITY)) return rsv_ray_to(origin, sample->direction, INFINITY);
    return rsv_ray_to(origin, v3_sub(sample->place, origin), RSV_PUNCTUAL_WAY);
}

#endif
