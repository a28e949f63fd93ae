/// The mean sky of a year, as surroundings of a scene.
#include "../core/core.h"
#include "../core/descriptor.h"
#include "daylight.h"

enum { width = 192, height = 96, subdivision = 2 };

/// Adds a sun as a disk of the size of a patch.
static void add_sun(const rsv_sky_patches *p, rsv_vec3 sun, double illuminance, double *sum)
{
    uint32_t patch = rsv_sky_patch_at(p, sun);
    if (patch > 0) sum[patch] += illuminance / rsv_sky_patch_solid_angle(p, patch);
}

/// Sums of luminance over all hours.
static void add_hours(
    const rsv_weather *w, const rsv_sky_patches *p, double albedo, float *luminance, double *sum)
{
    for (size_t k = 0; k < w->count; k++) {
        rsv_solar_position sun;
        rsv_perez_sky sky = rsv_weather_sky(w, k, &sun);
        double direct = sun.elevation > 0 ? sky.direct_illuminance : 0, h = w->hour[k].hours;
        if (!(sky.diffuse_illuminance + direct > 0)) continue;
        rsv_sky_patch_luminances(p, &sky.shape, sky.diffuse_illuminance, luminance);
        luminance[0] =
            (float)(albedo / M_PI * (sky.diffuse_illuminance + direct * sin(sun.elevation)));
        for (uint32_t i = 0; i < p->count; i++)
            sum[i] += h * (double)luminance[i];
        if (direct > 0) add_sun(p, sun.direction, h * direct, sum);
    }
}

/// @param sum by patch, divided by `hours`; a sky that is dark all year shines evenly: there is geometry to judge all
/// the same
static void paint(const rsv_daylight *frame, const double *sum, double hours, rsv_rgb *pixel)
{
    double total = 0;
    for (uint32_t k = 0; k < frame->patches.count; k++)
        total += sum[k];
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            double polar = M_PI * (y + 0.5) / height, turn = 2 * M_PI * ((x + 0.5) / width - 0.5);
            rsv_vec3 direction = v3((float)(sin(polar) * cos(turn)), (float)cos(polar),
                (float)(sin(polar) * sin(turn)));
            uint32_t patch =
                rsv_sky_patch_at(&frame->patches, rsv_daylight_to_sky(frame, direction));
            float value = total > 0 ? (float)(sum[patch] / hours) : 1;
            pixel[y * width + x] = (rsv_rgb){ value, value, value };
        }
}

rsv_status rsv_daylight_surround(
    rsv_scene *scene, const rsv_weather *weather, const rsv_daylight_desc *desc)
{
    rsv_context *context = rsv_scene_get_context(scene);
    rsv_daylight_desc settings = rsv_default_daylight_desc(RSV_QUALITY_MEDIUM);
    rsv_status status = RSV_READ_DESC(rsv_daylight_desc, &settings, desc);
    if (status != RSV_OK) return status;
    rsv_daylight frame = { .patches = rsv_sky_patches_of(subdivision),
        .north = { cos(settings.north * M_PI / 180), sin(settings.north * M_PI / 180) } };
    double hours = 0;
    status = RSV_ERROR_MEMORY;
    rsv_rgb *pixel = rsv_alloc(context, (size_t)width * height, sizeof *pixel);
    double *sum = rsv_alloc(context, frame.patches.count, sizeof *sum);
    float *luminance = rsv_alloc(context, frame.patches.count, sizeof *luminance);
    if (!pixel || !sum || !luminance) goto cleanup;
    for (size_t k = 0; k < weather->count; k++)
        hours += weather->hour[k].hours;
    add_hours(weather, &frame.patches, (double)settings.ground_albedo, luminance, sum);
    paint(&frame, sum, hours > 0 ? hours : 1, pixel);
    rsv_environment sky = { "mean sky", pixel, width, height, 1, 0 };
    status = rsv_scene_set_environment(scene, &sky);
cleanup:
    rsv_free(context, pixel);
    rsv_free(context, sum);
    rsv_free(context, luminance);
    return status;
}
