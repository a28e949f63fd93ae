/// Surroundings without a file.
#include "../core/core.h"
#include "../core/vec.h"
#include "resolvent/scene.h"

#include <string.h>

enum { SKY_WIDTH = 512, SKY_HEIGHT = 256 };

static const char *const names[] = { "white", "sky", NULL };

const char *const *rsv_environment_builtin_names(void) { return names; }

bool rsv_environment_is_builtin(const char *name)
{
    for (size_t i = 0; names[i]; i++)
        if (strcmp(names[i], name) == 0) return true;
    return false;
}

/// A clear day without its sun: blue above, whitish at the horizon, lit ground below.
static rsv_rgb clear_sky(float up)
{
    static const rsv_rgb zenith = { 0.14f, 0.24f, 0.52f }, horizon = { 0.5f, 0.53f, 0.56f },
                         ground = { 0.16f, 0.15f, 0.13f };
    float blue = sqrtf(f_max(up, 0));
    return up < 0 ? ground : rgb_mad(rgb_scale(horizon, 1 - blue), blue, zenith);
}

/// The sun stands 45 degrees high in a single pixel, and brings this irradiance across its rays.
static const rsv_rgb sun_irradiance = { 3.1f, 2.9f, 2.5f }; // W/m2

static void paint_sky(rsv_rgb *pixels)
{
    const float step = RSV_PI / SKY_HEIGHT;
    for (int row = 0; row < SKY_HEIGHT; row++)
        for (int column = 0; column < SKY_WIDTH; column++)
            pixels[row * SKY_WIDTH + column] = clear_sky(cosf(((float)row + 0.5f) * step));
    const int row = SKY_HEIGHT / 4, column = 5 * SKY_WIDTH / 8; // towards +x and +z
    float solid_angle = step * step * sinf(((float)row + 0.5f) * step);
    pixels[row * SKY_WIDTH + column] = rgb_scale(sun_irradiance, 1 / solid_angle);
}

static rsv_status set_sky(rsv_scene *scene, rsv_environment environment)
{
    rsv_context *context = rsv_scene_get_context(scene);
    rsv_rgb *pixels = rsv_alloc(context, (size_t)SKY_WIDTH * SKY_HEIGHT, sizeof *pixels);
    if (!pixels) return RSV_ERROR_MEMORY;
    paint_sky(pixels);
    environment.pixels = pixels;
    environment.width = SKY_WIDTH;
    environment.height = SKY_HEIGHT;
    rsv_status status = rsv_scene_set_environment(scene, &environment);
    rsv_free(context, pixels);
    return status;
}

rsv_status rsv_scene_set_builtin_environment(
    rsv_scene *scene, const char *name, float intensity, float rotation)
{
    const rsv_rgb white = { 1, 1, 1 };
    rsv_environment environment = { .name = name,
        .pixels = &white,
        .width = 1,
        .height = 1,
        .intensity = intensity,
        .rotation = rotation };
    if (!rsv_environment_is_builtin(name))
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "environment '%s' is not known; use white or sky", name);
    return strcmp(name, "white") == 0 ? rsv_scene_set_environment(scene, &environment)
                                      : set_sky(scene, environment);
}
