#include "environment.h"

#include "../core/core.h"

#include <string.h>

static rsv_status prepare_sampling(rsv_environment_light *light)
{
    rsv_context *context = light->context;
    rsv_sky_sampler_destroy(context, &light->sampler);
    rsv_sky_irradiance_destroy(context, &light->open);
    rsv_status status = rsv_sky_sampler_create(context, &light->sampled, &light->sampler);
    if (status == RSV_OK && light->sampler.flux > 0)
        status = rsv_sky_irradiance_create(context, &light->sampled, &light->open);
    return status;
}

/// Copies the pixels, because the scene's may be replaced. The copy is not ready to be sampled.
static rsv_status copy_environment(
    rsv_context *context, const rsv_environment *environment, rsv_environment_light **result)
{
    rsv_status status = RSV_OK;
    rsv_environment_light *light = rsv_alloc(context, 1, sizeof *light);
    if (!light) return RSV_ERROR_MEMORY;
    light->context = context;
    size_t count = (size_t)environment->width * environment->height;
    light->whole_pixels = rsv_alloc(context, count, sizeof *light->whole_pixels);
    RSV_TRY(light->whole_pixels ? RSV_OK : RSV_ERROR_MEMORY);
    memcpy(light->whole_pixels, environment->pixels, count * sizeof *light->whole_pixels);
    light->whole = rsv_sky_from_environment(environment);
    light->whole.pixel = light->whole_pixels;
    light->sampled = light->whole;
    *result = light;
    light = NULL;
cleanup:
    rsv_environment_light_destroy(light);
    return status;
}

rsv_status rsv_environment_light_create(const rsv_scene *scene, rsv_environment_light **result)
{
    const rsv_environment *environment = rsv_scene_get_view(scene)->environment;
    rsv_environment_light *light = NULL;
    rsv_status status = RSV_OK;
    *result = NULL;
    if (!environment) return RSV_OK;
    RSV_TRY(copy_environment(rsv_scene_get_context(scene), environment, &light));
    RSV_TRY(prepare_sampling(light));
    *result = light;
    light = NULL;
cleanup:
    rsv_environment_light_destroy(light);
    return status;
}

rsv_status rsv_environment_light_create_turned(
    const rsv_scene *scene, float rotation, rsv_environment_light **light)
{
    rsv_environment turned = *rsv_scene_get_view(scene)->environment;
    turned.rotation = rotation;
    *light = NULL;
    rsv_status status = copy_environment(rsv_scene_get_context(scene), &turned, light);
    return status == RSV_OK ? rsv_environment_light_divide(*light) : status;
}

void rsv_environment_light_destroy(rsv_environment_light *light)
{
    if (!light) return;
    rsv_context *context = light->context;
    rsv_sky_sampler_destroy(context, &light->sampler);
    rsv_sky_irradiance_destroy(context, &light->open);
    rsv_free(context, light->whole_pixels);
    rsv_free(context, light->calm_pixels);
    rsv_free(context, light->bright_pixels);
    rsv_free(context, light);
}

/// Pixels brighter than this times the mean over the sphere keep that much for gather rays; the rest is
/// sampled. The same contrast decides whether emitters are gathered.
#define GATHERED_CONTRAST 4
/// Below this share of the light, shadow rays are not worth their while.
#define SAMPLED_SHARE 0.01

/// Moves the excess over `limit` from the gathered to the sampled pixels, with the same fraction of each channel.
static void clip_pixels(const rsv_environment_light *light, float limit)
{
    size_t count = (size_t)light->whole.width * light->whole.height;
    for (size_t i = 0; i < count; i++) {
        rsv_rgb value = light->calm_pixels[i];
        float luminance = rgb_luminance(value), kept = luminance > limit ? limit / luminance : 1;
        light->calm_pixels[i] = rgb_scale(value, kept);
        light->bright_pixels[i] = rgb_scale(value, 1 - kept);
    }
}

static rsv_sky with_pixels(const rsv_sky *sky, const rsv_rgb *pixels)
{
    return (rsv_sky){ pixels, sky->width, sky->height, sky->turn };
}

rsv_status rsv_environment_light_divide(rsv_environment_light *light)
{
    rsv_context *context = light->context;
    rsv_status status;
    size_t count = (size_t)light->whole.width * light->whole.height;
    light->calm_pixels = rsv_alloc(context, count, sizeof *light->calm_pixels);
    light->bright_pixels = rsv_alloc(context, count, sizeof *light->bright_pixels);
    if (!light->calm_pixels || !light->bright_pixels) return RSV_ERROR_MEMORY;
    memcpy(light->calm_pixels, light->whole_pixels, count * sizeof *light->calm_pixels);
    RSV_TRY(rsv_extract_suns(
        context, &light->whole, light->calm_pixels, light->sun, &light->sun_count));
    light->gathered = with_pixels(&light->whole, light->calm_pixels);
    double flux = rgb_luminance(rsv_sky_flux(&light->gathered));
    clip_pixels(light, GATHERED_CONTRAST * (float)(flux / (4 * M_PI)));
    light->sampled = with_pixels(&light->whole, light->bright_pixels);
    RSV_TRY(prepare_sampling(light));
    if (light->sampler.flux < SAMPLED_SHARE * flux) {
        for (size_t i = 0; i < count; i++)
            light->calm_pixels[i] = rgb_add(light->calm_pixels[i], light->bright_pixels[i]);
        light->sampled.pixel = NULL;
        RSV_TRY(prepare_sampling(light));
    }
cleanup:
    return status;
}

bool rsv_environment_light_is_sampled(const rsv_environment_light *light)
{
    return light && (light->sampler.flux > 0 || light->sun_count > 0);
}

rsv_rgb rsv_environment_light_sunless(const rsv_environment_light *light, rsv_vec3 direction)
{
    if (light->sun_count == 0) return rsv_sky_radiance(&light->whole, direction);
    return rgb_add(rsv_sky_radiance(&light->gathered, direction),
        rsv_sky_radiance(&light->sampled, direction));
}
