/// The environment as a light source.
///
/// The path tracer uses it undivided: next-event estimation samples all of it, and is combined with directions from the
/// BSDF. The operator uses it divided,
///
///     whole  =  gathered  +  sampled  +  suns
///
/// where gather rays find `gathered`, which has bounded contrast, and next-event estimation the other two. Bright small
/// parts would make gather rays noisy, and large dim parts shadow rays.
#ifndef RSV_ENVIRONMENT_H
#define RSV_ENVIRONMENT_H

#include "sky.h"

/// A strong, small, bright region that was taken out of the picture: a disc of uniform radiance.
typedef struct rsv_sun {
    rsv_vec3 direction; ///< unit, towards its centre
    rsv_rgb radiance;   ///< W/(sr m2)
    float cos_radius;
    float solid_angle; ///< sr
} rsv_sun;

#define RSV_MAX_SUNS 4

typedef struct rsv_environment_light {
    rsv_context *context;
    rsv_sky whole; ///< seen by cameras
    rsv_sky gathered, sampled;
    rsv_sky_sampler sampler; ///< of `sampled`
    rsv_sky_irradiance open; ///< of `sampled`
    rsv_rgb *whole_pixels;   ///< owned
    rsv_rgb *calm_pixels;    ///< of `gathered`, NULL while undivided
    rsv_rgb *bright_pixels;  ///< of `sampled`, NULL while undivided
    rsv_sun sun[RSV_MAX_SUNS];
    uint32_t sun_count;
} rsv_environment_light;

/// Undivided. *light is NULL if the scene has no environment.
rsv_status rsv_environment_light_create(const rsv_scene *scene, rsv_environment_light **light);
/// Divided, and with another rotation: degrees as in rsv_environment. The scene must have an environment.
/// @param light destroy it, even after an error
rsv_status rsv_environment_light_create_turned(
    const rsv_scene *scene, float rotation, rsv_environment_light **light);
void rsv_environment_light_destroy(rsv_environment_light *light);

/// Divides it, once.
rsv_status rsv_environment_light_divide(rsv_environment_light *light);

/// Whether next-event estimation has anything to find.
bool rsv_environment_light_is_sampled(const rsv_environment_light *light);

/// Gathered and sampled part together: all but the suns.
rsv_rgb rsv_environment_light_sunless(const rsv_environment_light *light, rsv_vec3 direction);

/// Replaces the suns in `pixels` by the mean of their surroundings. The pixels have the shape of `sky`.
/// @param sun out, [RSV_MAX_SUNS]
rsv_status rsv_extract_suns(
    rsv_context *context, const rsv_sky *sky, rsv_rgb *pixels, rsv_sun *sun, uint32_t *count);

/// A direction uniformly within the disc. Its density is 1 / solid_angle.
RSV_INLINE rsv_vec3 rsv_sun_sample(const rsv_sun *sun, float u1, float u2)
{
    float x, y;
    rsv_square_to_disk(u1, u2, &x, &y);
    // the disk's area element is uniform in 1 - cos: (1 - cos) / (1 - cos_radius) = x^2 + y^2
    float depth = 1 - sun->cos_radius, share = x * x + y * y;
    float stretch = sqrtf(depth * (2 - share * depth));
    rsv_vec3 t, b;
    v3_frame(sun->direction, &t, &b);
    rsv_vec3 lateral = v3_mad(v3_scale(t, x * stretch), y * stretch, b);
    return v3_normalize(v3_mad(lateral, 1 - share * depth, sun->direction));
}

#endif
