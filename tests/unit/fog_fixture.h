/// Scenes full of fog with exact answers, and readings of them.
#ifndef FOG_FIXTURE_H
#define FOG_FIXTURE_H

#include "resolvent/operator.h"
#include "resolvent/render.h"
#include "unit/light_fixture.h"

/// Largest error of an estimate, relative, or else in standard errors.
#define TOLERANCE 5e-3
#define STANDARD_ERRORS 4
/// Relative: a larger one would let much pass.
#define LARGEST_STANDARD_ERROR 1e-2

/// One channel of a picture or a probe.
typedef struct estimate {
    double mean, error;
} estimate;

static inline void check(const char *what, estimate found, double expected)
{
    print_message("%-28s %.6g +- %.2g, expected %.6g\n", what, found.mean, found.error, expected);
    assert_true(found.error <= LARGEST_STANDARD_ERROR * fabs(expected));
    assert_close(
        found.mean, expected, fmax(TOLERANCE * fabs(expected), STANDARD_ERRORS * found.error));
}

static inline float channel(rsv_rgb c, int k) { return k == 0 ? c.r : k == 1 ? c.g : c.b; }

/// A scene needs a surface: one far from everything.
static inline void add_speck(world *w)
{
    const rsv_vec3 corner[3] = { v3(4e3f, 4e3f, 4e3f), v3(4e3f, 4e3f, 4001), v3(4001, 4e3f, 4e3f) };
    static const uint32_t index[3] = { 0, 1, 2 };
    world_triangles(w, world_lambert(w, 0, 0), corner, 3, index, 1);
}

static inline void add_lamp(world *w, rsv_punctual_light lamp)
{
    assert_int_equal(rsv_scene_add_light(w->scene, &lamp), RSV_OK);
}

static inline void fill(world *w, rsv_fog fog)
{
    world_commit(w);
    assert_int_equal(rsv_scene_set_fog(w->scene, &fog), RSV_OK);
}

/// Between two heights, without end to the sides.
static inline rsv_fog slab(rsv_rgb extinction, rsv_rgb albedo, float low, float high)
{
    rsv_fog fog = rsv_default_fog();
    fog.extinction = extinction;
    fog.albedo = albedo;
    fog.bounds_min = v3(-INFINITY, low, -INFINITY);
    fog.bounds_max = v3(INFINITY, high, INFINITY);
    return fog;
}

static inline rsv_fog everywhere(rsv_rgb extinction, rsv_rgb albedo)
{
    return slab(extinction, albedo, -INFINITY, INFINITY);
}

/// Power that elements of surfaces absorb, W.
static inline double power_at_walls(const rsv_light *light)
{
    const rsv_operator *op = rsv_light_operator(light);
    const rsv_rgb *irradiance = rsv_light_irradiance_field(light);
    size_t count = rsv_operator_element_count(op);
    rsv_element *element = calloc(count, sizeof *element);
    double power = 0;
    assert_int_equal(rsv_operator_elements(op, element), RSV_OK);
    for (size_t n = 0; n < count; n++)
        if (element[n].triangle != UINT32_MAX)
            power += (double)element[n].area * (double)irradiance[n].g *
                     (1 - (double)element[n].albedo.g);
    free(element);
    return power;
}

/// A picture one millimetre wide: practically a single ray.
static inline rsv_camera needle(rsv_vec3 from, rsv_vec3 towards)
{
    rsv_camera camera = rsv_camera_look_at("needle", from, towards, 0, 1);
    camera.vertical_fov = 0;
    camera.vertical_extent = 5e-4f;
    return camera;
}

/// A point on the walls of the room from -1 to 1, anywhere in cell k.
static inline rsv_probe wall_place(int k, int side, rsv_random *random)
{
    float x = 2 * ((float)(k % side) + rsv_random_float(random)) / (float)side - 1;
    float y = 2 * ((float)(k / side % side) + rsv_random_float(random)) / (float)side - 1;
    float wall = k / (side * side) % 2 ? 1.0f : -1.0f;
    rsv_vec3 place[3] = { v3(wall, x, y), v3(x, wall, y), v3(x, y, wall) };
    rsv_vec3 normal[3] = { v3(-wall, 0, 0), v3(0, -wall, 0), v3(0, 0, -wall) };
    int axis = k / (2 * side * side);
    return (rsv_probe){ place[axis], normal[axis] };
}

static inline double henyey_greenstein(double g, double cos)
{
    return (1 - g * g) / (4 * M_PI * pow(1 + g * g - 2 * g * cos, 1.5));
}

/// int exp(-sigma s) sigma_s p I(s) exp(-sigma r) / r^2 ds along a line that passes a light at distance h, from s = 0
/// to `length`, the light's foot being at `foot`: over the angle at the light, where it is smooth.
static inline double once_along_line(
    double sigma, double g, double h, double foot, double length, double cos_cone)
{
    enum { STEPS = 20000 };
    double low = atan2(-foot, h), high = atan2(length - foot, h), sum = 0;
    for (int i = 0; i < STEPS; i++) {
        double angle = low + (high - low) * (i + 0.5) / STEPS;
        double s = foot + h * tan(angle), r = h / cos(angle);
        // light turns from (foot - s, h) reversed into the direction towards the eye
        double cos_turn = (foot - s) / r; // forward along the view ray, from it to the light
        double lit = cos(angle) >= cos_cone ? 1 : 0;
        sum += lit * exp(-sigma * (s + r)) * henyey_greenstein(g, cos_turn) * (high - low) / STEPS;
    }
    return sigma * sum / h;
}

/// The same bytes for any number of threads. @param take a small picture of boxes in coloured fog
static inline void assert_same_for_threads(
    rsv_image *(*take)(world *w, const rsv_render_desc *desc))
{
    uint64_t hash[2];
    for (int many = 0; many < 2; many++) {
        world *w = world_builtin(many ? 3 : 1, "cornell-blocks");
        rsv_fog fog = rsv_default_fog();
        fog.extinction = rgb(1, 2, 3);
        fog.albedo = rgb_gray(0.9f);
        fill(w, fog);
        rsv_render_desc desc = rsv_default_render_desc();
        desc.width = desc.height = 16;
        desc.samples = 4;
        rsv_image *image = take(w, &desc);
        hash[many] = hash_bytes(HASH_START, rsv_image_pixels(image, 0), 256 * sizeof(rsv_rgb));
        rsv_image_destroy(image);
        world_end(w);
    }
    assert_true(hash[0] == hash[1]);
}

#endif
