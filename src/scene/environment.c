/// Environments: checks and copies their images.
#include "../core/vec.h"
#include "scene.h"

#include <string.h>

/// Products and sums over the sphere must stay within float. (The sun seen from Earth: 2e7.)
#define LARGEST_RADIANCE 1e12f

void rsv_scene_release_environment(rsv_scene *scene)
{
    rsv_free(scene->context, (void *)scene->environment.name);
    rsv_free(scene->context, (void *)scene->environment.pixels);
    scene->environment = (rsv_environment){ 0 };
    scene->view.environment = NULL;
}

static rsv_status check_environment(const rsv_environment *environment, const char *name)
{
    uint32_t width = environment->width, height = environment->height;
    if (!environment->pixels || width == 0 || height == 0)
        return rsv_fail(RSV_ERROR_ARGUMENT, "environment '%s': a picture of %u x %u pixels", name,
            width, height);
    if ((size_t)width * height > RSV_ENVIRONMENT_MAX_PIXELS)
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "environment '%s': %u x %u pixels are more than %zu: scale the picture down", name,
            width, height, RSV_ENVIRONMENT_MAX_PIXELS);
    if (!(environment->intensity >= 0 && environment->intensity <= LARGEST_RADIANCE))
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "environment '%s': an intensity of %g; it must be from 0 to %g", name,
            environment->intensity, LARGEST_RADIANCE);
    if (!isfinite(environment->rotation))
        return rsv_fail(RSV_ERROR_ARGUMENT, "environment '%s': the rotation is not finite", name);
    return RSV_OK;
}

/// Value of a saturated pixel: the highest value in the image.
static float largest_recorded(const rsv_environment *environment)
{
    const float *value = &environment->pixels[0].r;
    float largest = 0;
    for (size_t i = 0; i < 3 * (size_t)environment->width * environment->height; i++)
        if (isfinite(value[i])) largest = f_max(value[i], largest);
    return largest;
}

/// Pixels that need repair, by kind of fault.
typedef struct repairs {
    size_t missing;    ///< negative, infinite or not a number
    size_t too_bright; ///< finite, but above LARGEST_RADIANCE
} repairs;

/// Radiance of one channel of a pixel; says whether it had none, or too much.
static float usable_radiance(
    float value, float intensity, float brightest, bool *missing, bool *too_bright)
{
    if (!(value >= 0)) { // negative or not a number
        *missing = true;
        return 0;
    }
    if (!isfinite(value)) {
        *missing = true;
        value = brightest;
    }
    double radiance = (double)value * intensity;
    *too_bright = *too_bright || radiance > LARGEST_RADIANCE;
    return radiance > LARGEST_RADIANCE ? LARGEST_RADIANCE : (float)radiance;
}

/// Copies the pixels, intensity included.
static repairs copy_pixels(const rsv_environment *environment, rsv_rgb *pixels)
{
    float brightest = largest_recorded(environment), intensity = environment->intensity;
    repairs count = { 0 };
    for (size_t i = 0; i < (size_t)environment->width * environment->height; i++) {
        rsv_rgb value = environment->pixels[i];
        bool missing = false, bright = false;
        pixels[i] = rgb(usable_radiance(value.r, intensity, brightest, &missing, &bright),
            usable_radiance(value.g, intensity, brightest, &missing, &bright),
            usable_radiance(value.b, intensity, brightest, &missing, &bright));
        count.missing += missing;
        count.too_bright += bright;
    }
    return count;
}

static void warn_of_repairs(
    const rsv_context *context, const char *name, const repairs *count, size_t pixels)
{
    if (count->missing)
        rsv_log(context, RSV_LOG_WARNING,
            "environment '%s': %zu of %zu pixels are negative, infinite or not a number; they "
            "count as black, infinite ones as the brightest finite value",
            name, count->missing, pixels);
    if (count->too_bright)
        rsv_log(context, RSV_LOG_WARNING,
            "environment '%s': %zu of %zu pixels are brighter than %g W/(sr m2), the maximum; they count as that",
            name, count->too_bright, pixels, (double)LARGEST_RADIANCE);
}

rsv_status rsv_scene_set_environment(rsv_scene *scene, const rsv_environment *environment)
{
    rsv_status status = RSV_OK;
    rsv_context *context = scene->context;
    if (!environment) {
        rsv_scene_release_environment(scene);
        return RSV_OK;
    }
    char *name = rsv_copy_string(context, environment->name ? environment->name : "unnamed");
    rsv_rgb *pixels = NULL;
    if (!name) return RSV_ERROR_MEMORY;
    RSV_TRY(check_environment(environment, name));
    size_t count = (size_t)environment->width * environment->height;
    pixels = rsv_alloc(context, count, sizeof *pixels);
    RSV_TRY(pixels ? RSV_OK : RSV_ERROR_MEMORY);
    repairs repaired = copy_pixels(environment, pixels);
    warn_of_repairs(context, name, &repaired, count);
    rsv_scene_release_environment(scene);
    scene->environment = *environment;
    scene->environment.name = name;
    scene->environment.pixels = pixels;
    scene->environment.intensity = 1;
    scene->view.environment = &scene->environment;
    return RSV_OK;
cleanup:
    rsv_free(context, name);
    rsv_free(context, pixels);
    return status;
}
