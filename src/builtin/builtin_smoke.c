/// Smoke that rises in the Cornell box: a procedural plume, lit by the lamp of the box.
#include "../core/sampling.h"
#include "builtin.h"

#define SIDE_X 48 // points of the grid
#define SIDE_Y 72
#define SIDE_Z 48
#define OCTAVES 4

rsv_status rsv_build_smoke(rsv_scene *scene) { return rsv_build_cornell_box(scene); }

static float corner_value(int x, int y, int z)
{
    return rsv_unit_float(rsv_hash3((uint32_t)x, (uint32_t)y, (uint32_t)z));
}

static float fade(float t) { return t * t * t * (t * (6 * t - 15) + 10); }

static float mix(float a, float b, float share) { return a + share * (b - a); }

/// Value noise in [0, 1] with cells of edge 1.
static float noise(rsv_vec3 p)
{
    int x = (int)floorf(p.x), y = (int)floorf(p.y), z = (int)floorf(p.z);
    float u = fade(p.x - (float)x), v = fade(p.y - (float)y), plane[2];
    for (int k = 0; k < 2; k++) {
        float near = mix(corner_value(x, y, z + k), corner_value(x + 1, y, z + k), u);
        float far = mix(corner_value(x, y + 1, z + k), corner_value(x + 1, y + 1, z + k), u);
        plane[k] = mix(near, far, v);
    }
    return mix(plane[0], plane[1], fade(p.z - (float)z));
}

/// Sum of octaves, each twice as fine and half as strong, in [0, 1).
static float turbulence(rsv_vec3 p)
{
    float sum = 0, strength = 0.5f;
    for (int k = 0; k < OCTAVES; k++) {
        sum += strength * noise(p);
        p = v3_add(v3_scale(p, 2), v3(17.3f, 5.1f, 9.7f));
        strength /= 2;
    }
    return sum;
}

/// Density of a plume in the unit cube that widens and thins as it rises and is blown about.
static float plume(rsv_vec3 p)
{
    rsv_vec3 eddy = v3_scale(p, 4);
    eddy.y -= 0.7f;
    float sway = 0.28f * p.y;
    float x = p.x - 0.5f + sway * (2 * turbulence(eddy) - 1);
    float z = p.z - 0.5f + sway * (2 * turbulence(v3_add(eddy, v3(31, 7, 3))) - 1);
    float radius = 0.07f + 0.25f * p.y;
    float inside = 1 - (x * x + z * z) / (radius * radius);
    float clumps = 2.6f * turbulence(v3_scale(p, 7)) - 0.7f;
    float ends = f_min(p.y / 0.06f, 1) * f_min((1 - p.y) / 0.3f, 1);
    float border = f_min(f_min(p.x, 1 - p.x), f_min(p.z, 1 - p.z)) / 0.05f;
    return f_max(inside, 0) * f_max(clumps, 0) * ends * f_min(border, 1) * (0.12f / radius);
}

static void fill_grid(float *density)
{
    for (int k = 0; k < SIDE_X * SIDE_Y * SIDE_Z; k++)
        density[k] = f_max(plume(v3((float)(k % SIDE_X) / (SIDE_X - 1),
                               (float)(k / SIDE_X % SIDE_Y) / (SIDE_Y - 1),
                               (float)(k / SIDE_X / SIDE_Y) / (SIDE_Z - 1))),
            0);
}

rsv_status rsv_fill_smoke(rsv_scene *scene)
{
    rsv_context *context = scene->context;
    rsv_fog smoke = rsv_default_fog();
    float *density = rsv_alloc(context, SIDE_X * SIDE_Y * SIDE_Z, sizeof *density);
    if (!density) return RSV_ERROR_MEMORY;
    fill_grid(density);
    const rsv_volume_grid grid = { .side = { SIDE_X, SIDE_Y, SIDE_Z },
        .low = { -0.45f, 0.005f, -0.45f },
        .high = { -0.1f, 0.53f, -0.1f },
        .density = density };
    smoke.extinction = rgb_gray(40);
    smoke.albedo = rgb(0.85f, 0.85f, 0.88f);
    rsv_status status = rsv_scene_set_volume(scene, &smoke, &grid);
    rsv_free(context, density);
    return status;
}
