/// Pictures from a solution: layers, the two modes against each other, cameras and their specular paths.
#include "resolvent/render.h"

#include "light_fixture.h"
#include "render/camera_path.h"
#include "slow_tests.h"
#include "solve/light.h"

static rsv_light *solve(const world *w, uint32_t elements, uint32_t rays)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = elements;
    desc.rays_per_element = rays;
    desc.photon_count = 20000;
    rsv_light *solution;
    assert_int_equal(rsv_light_create(w->scene, &desc, &solution), RSV_OK);
    return solution;
}

static rsv_render_desc picture_desc(rsv_render_mode mode, uint32_t size, uint32_t samples)
{
    rsv_render_desc desc = rsv_default_render_desc();
    desc.mode = mode;
    desc.width = desc.height = size;
    desc.samples = samples;
    desc.gather_rays = 0;
    desc.layers = false;
    return desc;
}

static rsv_image *render(const rsv_light *solution, const rsv_render_desc *desc)
{
    rsv_image *image;
    rsv_status status = rsv_render(solution, desc, &image);
    if (status != RSV_OK) fail_msg("%s", rsv_last_error());
    return image;
}

static size_t pixel_count(const rsv_image *image)
{
    return (size_t)rsv_image_width(image) * rsv_image_height(image);
}

static double mean_of(const rsv_image *image, uint32_t layer)
{
    const rsv_rgb *pixel = rsv_image_const_pixels(image, layer);
    double sum = 0;
    for (size_t k = 0; k < pixel_count(image); k++)
        sum += rgb_luminance(pixel[k]);
    return sum / (double)pixel_count(image);
}

// ---- layers and modes ---------------------------------------------------------------------------

static void check_layers(rsv_render_mode mode, uint32_t gather_rays)
{
    world *w = world_builtin(2, "cornell-spheres");
    rsv_light *s = solve(w, 400, 64);
    rsv_render_desc desc = picture_desc(mode, 24, 4);
    desc.gather_rays = gather_rays;
    desc.noise = 0.05f;
    rsv_image *plain = render(s, &desc);
    desc.layers = true;
    rsv_image *image = render(s, &desc);
    uint32_t layers = rsv_image_layer_count(image);
    assert_int_equal(rsv_image_find_layer(image, "emission"), 1);
    assert_int_equal(rsv_image_find_layer(image, "direct"), 2);
    assert_int_equal(rsv_image_find_layer(image, "bounce1"), 3);
    double mean = mean_of(image, 0);
    for (size_t k = 0; k < pixel_count(image); k++) {
        double sum = 0, whole = rsv_image_const_pixels(image, 0)[k].g;
        for (uint32_t layer = 1; layer < layers; layer++)
            sum += rsv_image_const_pixels(image, layer)[k].g;
        assert_close(sum, whole, 1e-4 * whole + 1e-4 * mean);
    }
    assert_close(mean_of(plain, 0), mean, 2e-3 * mean); // layers do not change the picture
    for (uint32_t layer = 1; layer < 5; layer++)
        assert_true(mean_of(image, layer) > 0);
    rsv_image_destroy(plain);
    rsv_image_destroy(image);
    rsv_light_destroy(s);
    world_end(w);
}

static void layers_sum_to_the_picture(void **state)
{
    (void)state;
    check_layers(RSV_RENDER_OPERATOR, 0);
    check_layers(RSV_RENDER_FINAL, 0);
    check_layers(RSV_RENDER_FINAL, 2);
}

static void operator_and_final_agree_in_the_mean(void **state)
{
    (void)state;
    world *w = world_builtin(2, "cornell-blocks");
    rsv_light *s = solve(w, 1500, 128);
    rsv_render_desc desc = picture_desc(RSV_RENDER_OPERATOR, 48, 9);
    rsv_image *image = render(s, &desc);
    double operator_mean = mean_of(image, 0);
    rsv_image_destroy(image);
    desc.mode = RSV_RENDER_FINAL;
    image = render(s, &desc);
    assert_close(mean_of(image, 0), operator_mean, 0.01 * operator_mean);
    rsv_image_destroy(image);
    desc.gather_rays = 1;
    image = render(s, &desc);
    assert_close(mean_of(image, 0), operator_mean, 0.01 * operator_mean);
    rsv_image_destroy(image);
    rsv_light_destroy(s);
    world_end(w);
}

static void noisy_pixels_get_more_rays_and_no_bias(void **state)
{
    (void)state;
    world *w = world_builtin(2, "cornell-spheres");
    rsv_light *s = solve(w, 400, 64);
    rsv_render_desc desc = picture_desc(RSV_RENDER_FINAL, 24, 16);
    rsv_image *even = render(s, &desc);
    desc.noise = 0.02f;
    rsv_image *planned = render(s, &desc);
    desc = picture_desc(RSV_RENDER_FINAL, 24, 1024);
    desc.seed = 1;
    rsv_image *truth = render(s, &desc);
    rsv_image_difference before, after;
    assert_int_equal(rsv_image_compare(truth, 0, even, 0, &before), RSV_OK);
    assert_int_equal(rsv_image_compare(truth, 0, planned, 0, &after), RSV_OK);
    // the first pass is far from what is wanted; a few pixels at the lamp's rim stay at the most rays they may have
    assert_true(before.relative_mse > 4e-3 && after.relative_mse < 8e-4);
    assert_close(after.mean_ratio, 1, 2e-3);
    rsv_image_destroy(even);
    rsv_image_destroy(planned);
    rsv_image_destroy(truth);
    rsv_light_destroy(s);
    world_end(w);
}

/// Pixels in penumbrae send further shadow rays, as their neighbours ask for: the light stays what it is with one ray for
/// each of many samples.
static void further_shadow_rays_do_not_change_the_light(void **state)
{
    (void)state;
    world *w = world_builtin(2, "cornell-blocks");
    rsv_light *s = solve(w, 400, 64);
    rsv_render_desc desc = picture_desc(RSV_RENDER_FINAL, 24, 1024);
    desc.layers = true;
    rsv_image *truth = render(s, &desc);
    double mean = 0, expected = mean_of(truth, 2);
    const int pictures = 64;
    desc.samples = 4;
    for (int k = 0; k < pictures; k++) {
        desc.seed = 1 + (uint32_t)k;
        rsv_image *image = render(s, &desc);
        mean += mean_of(image, 2) / pictures;
        rsv_image_destroy(image);
    }
    // standard error 3e-4; if pixels decided by their own samples, they would be 1.7e-3 too bright
    assert_close(mean, expected, 1e-3 * expected);
    rsv_image_destroy(truth);
    rsv_light_destroy(s);
    world_end(w);
}

static uint64_t hash_of_picture_with(int threads, uint32_t gather_rays)
{
    world *w = world_builtin(threads, "cornell-spheres");
    rsv_light *s = solve(w, 200, 64);
    rsv_render_desc desc = picture_desc(RSV_RENDER_FINAL, 20, 3);
    desc.gather_rays = gather_rays;
    desc.layers = true;
    desc.noise = 0.05f;
    rsv_image *image = render(s, &desc);
    uint64_t hash = HASH_START;
    for (uint32_t layer = 0; layer < rsv_image_layer_count(image); layer++)
        hash = hash_bytes(
            hash, rsv_image_const_pixels(image, layer), pixel_count(image) * sizeof(rsv_rgb));
    rsv_image_destroy(image);
    rsv_light_destroy(s);
    world_end(w);
    return hash;
}

static void pictures_are_the_same_bytes_for_any_thread_count(void **state)
{
    (void)state;
    assert_true(hash_of_picture_with(1, 0) == hash_of_picture_with(2, 0));
    assert_true(hash_of_picture_with(1, 2) == hash_of_picture_with(3, 2));
}

// ---- cameras ------------------------------------------------------------------------------------

/// An emissive unit square seen by an orthographic camera 2 m high: a quarter of the picture, at any
/// distance.
static void an_orthographic_camera_keeps_sizes(void **state)
{
    (void)state;
    for (int far = 0; far < 2; far++) {
        world *w = world_begin(1);
        float z = far ? -50 : -1;
        world_quad(w, world_lambert(w, 0, 2), v3(-0.5f, -0.5f, z), v3(0.5f, -0.5f, z),
            v3(0.5f, 0.5f, z), v3(-0.5f, 0.5f, z));
        rsv_camera camera = rsv_camera_look_at("flat", v3(0, 0, 1), v3(0, 0, 0), 1, 1);
        camera.vertical_fov = 0;
        camera.vertical_extent = 1;
        assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
        world_commit(w);
        rsv_light *s = solve(w, 16, 64);
        rsv_render_desc desc = picture_desc(RSV_RENDER_OPERATOR, 32, 1);
        rsv_image *image = render(s, &desc);
        const rsv_rgb *pixel = rsv_image_const_pixels(image, 0);
        for (int y = 0; y < 32; y++)
            for (int x = 0; x < 32; x++) {
                bool inside = x >= 8 && x < 24 && y >= 8 && y < 24;
                assert_close(pixel[32 * y + x].g, inside ? 2 : 0, 1e-6);
            }
        rsv_image_destroy(image);
        rsv_light_destroy(s);
        world_end(w);
    }
}

/// A furnace of exitance 1 and albedo 1/2 with a body in it, seen from inside: radiance 2 / pi everywhere,
/// if the body neither swallows nor makes light.
static rsv_image *picture_of_furnace_with(
    world **out, rsv_material body, int level, uint32_t samples)
{
    world *w = *out = world_begin(2);
    world_room(w, world_lambert(w, 0.5f, 1 / RSV_PI), v3(-1, -1, -1), v3(1, 1, 1));
    world_sphere(w, world_material(w, body), v3(0, 0, 0), 0.5f, level);
    rsv_camera camera = rsv_camera_look_at("inside", v3(0.1f, 0.2f, 0.95f), v3(0, 0, 0), 1, 1);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    world_commit(w);
    rsv_light *s = solve(w, 150, 64);
    rsv_render_desc desc = picture_desc(RSV_RENDER_OPERATOR, 32, samples);
    rsv_image *image = render(s, &desc);
    rsv_light_destroy(s);
    return image;
}

static void a_mirror_sphere_in_a_furnace_is_invisible(void **state)
{
    (void)state;
    world *w;
    rsv_image *image = picture_of_furnace_with(&w, mirror_material(1), 3, 1);
    for (size_t k = 0; k < pixel_count(image); k++)
        assert_close(rsv_image_const_pixels(image, 0)[k].g, 2 / RSV_PI, 3e-3 * 2 / RSV_PI);
    rsv_image_destroy(image);
    world_end(w);
}

/// In a closed room of perfect mirrors every ray meets the lamp in the end, after a hundred reflections or more.
static void a_room_of_mirrors_shows_its_lamp_everywhere(void **state)
{
    (void)state;
    const rsv_probe probe = { { 0.1f, 0.2f, -0.3f }, { 0, 0, 1 } };
    world *w = world_begin(2);
    world_room(w, world_material(w, mirror_material(1)), v3(-1, -1, -1), v3(1, 1, 1));
    rsv_material lamp = lambert_material(0, 5);
    lamp.double_sided = true;
    world_quad(w, world_material(w, lamp), v3(-0.3f, 0.5f, -0.3f), v3(0.3f, 0.5f, -0.3f),
        v3(0.3f, 0.5f, 0.3f), v3(-0.3f, 0.5f, 0.3f));
    const rsv_camera camera =
        rsv_camera_look_at("eye", v3(0.13f, -0.2f, 0.9f), v3(0, -0.33f, -1), 1.2f, 1);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    world_commit(w);
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.photon_count = 0;
    rsv_light *s;
    assert_int_equal(rsv_light_create(w->scene, &desc, &s), RSV_OK);
    const rsv_render_desc picture = picture_desc(RSV_RENDER_FINAL, 16, 16);
    rsv_image *image = render(s, &picture);
    assert_close(mean_of(image, 0), 5, 0.15);
    rsv_image_destroy(image);
    rsv_probe_reading reading;
    assert_int_equal(rsv_probe_irradiance(s,
                         &(rsv_probe_desc){ sizeof(rsv_probe_desc), RSV_PROBE_OPERATOR, 4096, 0 },
                         &probe, 1, &reading),
        RSV_OK);
    assert_close(reading.irradiance.g, 5 * RSV_PI, 0.15 * (double)RSV_PI);
    rsv_light_destroy(s);
    world_end(w);
}

static void a_glass_sphere_in_a_furnace_keeps_the_energy(void **state)
{
    (void)state;
    world *w;
    rsv_image *image = picture_of_furnace_with(&w, glass_material(), 3, 4);
    assert_close(mean_of(image, 0), 2 / RSV_PI, 3e-3 * 2 / RSV_PI);
    rsv_image_destroy(image);
    world_end(w);
}

static void a_thin_sheet_of_glass_in_a_furnace_is_invisible(void **state)
{
    (void)state;
    world *w;
    rsv_material sheet = glass_material();
    sheet.thickness = 0;
    rsv_image *image = picture_of_furnace_with(&w, sheet, 2, 1);
    assert_close(mean_of(image, 0), 2 / RSV_PI, 3e-3 * 2 / RSV_PI);
    rsv_image_destroy(image);
    world_end(w);
}

static void add_weight(void *user, const rsv_specular_path *path, rsv_rgb weight)
{
    (void)path;
    *(double *)user += weight.g;
}

/// The branches of one camera ray together carry weight 1 through clear glass, on average over the roulette
/// of faint ones.
static void branches_of_a_camera_ray_carry_all_its_weight(void **state)
{
    (void)state;
    world *w = world_begin(1);
    world_room(w, world_lambert(w, 0.5f, 0), v3(-1, -1, -1), v3(1, 1, 1));
    world_sphere(w, world_material(w, glass_material()), v3(0, 0, 0), 0.5f, 3);
    world_commit(w);
    const uint32_t count = 4000;
    double sum = 0;
    for (uint32_t k = 0; k < count; k++) {
        float x, y;
        rsv_sobol_2d(k, 3, &x, &y);
        rsv_ray ray = { v3(x - 0.5f, y - 0.5f, 0.99f), v3(0, 0, -1), INFINITY };
        rsv_hit hit;
        assert_true(rsv_tracer_closest(w->tracer, &ray, &hit));
        rsv_specular_path path = rsv_specular_begin(&w->transport, NULL, ray.direction, hit);
        const rsv_camera_setting setting = {
            .scene = &w->transport, .lights = w->lights, .max_events = 64
        };
        rsv_rgb emission = rsv_camera_path(&setting, path, k, NULL, add_weight, &sum);
        assert_true(rgb_is_black(emission));
    }
    assert_close(sum / count, 1, 3e-3);
    world_end(w);
}

/// Balls of metal smaller than a pixel, in the sun.
static world *metal_balls(void)
{
    world *w = world_begin(2);
    rsv_material metal = mirror_material(0.9f);
    metal.roughness = 0.3f;
    uint32_t material = world_material(w, metal);
    for (int k = 0; k < 49; k++)
        world_sphere(w, material,
            v3(-1.2f + 0.4f * (float)(k % 7), -1.2f + 0.4f * (float)(k / 7), 0), 0.06f, 3);
    const rsv_punctual_light sun = { .name = "sun",
        .kind = RSV_PUNCTUAL_DIRECTIONAL,
        .direction = { -0.6f, -0.3f, -0.74f },
        .intensity = { 1, 1, 1 } };
    rsv_camera camera = rsv_camera_look_at("front", v3(0, 0, 4), v3(0, 0, 0), 0.7f, 1);
    assert_int_equal(rsv_scene_add_light(w->scene, &sun), RSV_OK);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    world_commit(w);
    return w;
}

/// Mean of pictures of so many seeds. @param noise out: variance of pixels between seeds, on average
static double mean_of_seeds(
    const world *w, const rsv_light *s, rsv_render_desc desc, uint32_t seeds, double *noise)
{
    enum { PIXELS = 16 * 16 };
    double sum[PIXELS] = { 0 }, squares = 0, total = 0;
    for (desc.seed = 0; desc.seed < seeds; desc.seed++) {
        rsv_image *image;
        if (desc.mode == RSV_RENDER_REFERENCE)
            assert_int_equal(rsv_render_reference(w->scene, &desc, &image, NULL), RSV_OK);
        else
            image = render(s, &desc);
        for (int k = 0; k < PIXELS; k++) {
            double value = (double)rgb_luminance(rsv_image_const_pixels(image, 0)[k]);
            sum[k] += value;
            squares += value * value;
        }
        rsv_image_destroy(image);
    }
    for (int k = 0; k < PIXELS; k++) {
        total += sum[k];
        squares -= sum[k] * sum[k] / seeds;
    }
    *noise = squares / (seeds - 1) / PIXELS;
    return total / seeds / PIXELS;
}

/// Highlights far smaller than a pixel make no sparks, and are as bright as they should be.
static void small_highlights_are_averaged_over_footprints(void **state)
{
    (void)state;
    world *w = metal_balls();
    rsv_light *s = solve(w, 400, 64);
    const rsv_render_desc path_traced = picture_desc(RSV_RENDER_REFERENCE, 16, 16);
    const rsv_render_desc reference = picture_desc(RSV_RENDER_REFERENCE, 16, 1024);
    const rsv_render_desc few = picture_desc(RSV_RENDER_FINAL, 16, 16);
    const rsv_render_desc many = picture_desc(RSV_RENDER_FINAL, 16, 256);
    double path_traced_noise, few_noise, unused;
    double truth = mean_of_seeds(w, s, reference, 8, &unused);
    assert_close(mean_of_seeds(w, s, few, 32, &few_noise), truth, 0.06 * truth);
    assert_close(mean_of_seeds(w, s, many, 8, &unused), truth, 0.04 * truth);
    mean_of_seeds(w, s, path_traced, 8, &path_traced_noise);
    assert_true(few_noise < 0.1 * path_traced_noise);
    rsv_light_destroy(s);
    world_end(w);
}

static void unlit_surfaces_show_their_colour(void **state)
{
    (void)state;
    world *w = world_begin(1);
    rsv_material sign = lambert_material(0, 0);
    sign.base_color = rgb(0.2f, 0.4f, 0.6f);
    sign.unlit = true;
    world_quad(w, world_material(w, sign), v3(-9, -9, 0), v3(9, -9, 0), v3(9, 9, 0), v3(-9, 9, 0));
    rsv_camera camera = rsv_camera_look_at("front", v3(0, 0, 1), v3(0, 0, 0), 1, 1);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    world_commit(w);
    rsv_light *s = solve(w, 16, 64);
    rsv_render_desc desc = picture_desc(RSV_RENDER_FINAL, 4, 1);
    rsv_image *image = render(s, &desc);
    rsv_rgb pixel = rsv_image_const_pixels(image, 0)[5];
    assert_close(pixel.r, 0.2, 1e-6);
    assert_close(pixel.g, 0.4, 1e-6);
    assert_close(pixel.b, 0.6, 1e-6);
    rsv_image_destroy(image);
    rsv_light_destroy(s);
    world_end(w);
}

// ---- bad arguments and memory -------------------------------------------------------------------

static void bad_descriptors_are_refused(void **state)
{
    (void)state;
    world *w = world_builtin(1, "furnace");
    rsv_light *s = solve(w, 30, 64);
    const rsv_render_desc good = picture_desc(RSV_RENDER_OPERATOR, 8, 1);
    rsv_render_desc bad[8] = { good, good, good, good, good, good, good, good };
    bad[0].width = 0;
    bad[1].height = 0;
    bad[2].width = 70000;
    bad[3].samples = 0;
    bad[4].camera = 7;
    bad[5].mode = RSV_RENDER_REFERENCE;
    bad[6].noise = -1;
    bad[7].noise = NAN;
    for (int k = 0; k < 8; k++) {
        rsv_image *image = NULL;
        assert_int_equal(rsv_render(s, &bad[k], &image), RSV_ERROR_ARGUMENT);
        assert_null(image);
        assert_non_null(strstr(rsv_last_error(), "render:"));
    }
    rsv_light_destroy(s);
    world_end(w);
}

static void memory_that_runs_out_is_an_error_and_nothing_leaks(void **state)
{
    (void)state;
    world *w = world_builtin(1, "cornell-blocks");
    rsv_light *s = solve(w, 50, 64);
    rsv_render_desc desc = picture_desc(RSV_RENDER_FINAL, 12, 2);
    desc.layers = true;
    for (int once = 0; once < 2; once++) {
        w->fail_once = once;
        long before = w->alive, allocations = 0;
        for (rsv_status status = RSV_ERROR_MEMORY; status != RSV_OK; allocations++) {
            rsv_image *image = NULL;
            w->until_failure = allocations;
            status = rsv_render(s, &desc, &image);
            w->until_failure = -1;
            if (status != RSV_OK) {
                assert_int_equal(status, RSV_ERROR_MEMORY);
                assert_null(image);
            }
            rsv_image_destroy(image);
            assert_int_equal(w->alive, before);
        }
        assert_true(allocations > 10);
    }
    rsv_light_destroy(s);
    world_end(w);
}

// ---- probes -------------------------------------------------------------------------------------

/// Points in the air, and on a wall under a coat, see the lamp by way of rough metal.
static void probes_see_lights_by_way_of_rough_metal(void **state)
{
    (void)state;
    world *w = world_begin(2);
    rsv_material metal = mirror_material(0.9f);
    metal.roughness = 0.5f;
    rsv_material coated = lambert_material(0.5f, 0);
    coated.specular = 1;
    coated.roughness = 0.6f;
    world_room(w, world_material(w, coated), v3(-1, -1, -1), v3(1, 1, 1));
    world_quad(w, world_material(w, metal), v3(-1, -0.9f, 1), v3(1, -0.9f, 1), v3(1, -0.9f, -1),
        v3(-1, -0.9f, -1));
    const rsv_punctual_light lamp = { .name = "lamp",
        .kind = RSV_PUNCTUAL_POINT,
        .position = { 0.2f, 0.3f, 0.1f },
        .intensity = { 3, 3, 3 } };
    assert_int_equal(rsv_scene_add_light(w->scene, &lamp), RSV_OK);
    world_commit(w);
    rsv_light *s = solve(w, 1000, 256);
    const rsv_probe probe[] = { { { 0, 0, 0 }, { 0, -1, 0 } },
        { { 0.9f, 0.9f, 0 }, { -0.7f, -0.7f, 0 } }, { { -1, 0.2f, 0.1f }, { 1, 0, 0 } } };
    enum { COUNT = sizeof probe / sizeof *probe };
    rsv_probe_reading found[COUNT], expected[COUNT];
    assert_int_equal(rsv_probe_irradiance(s,
                         &(rsv_probe_desc){ sizeof(rsv_probe_desc), RSV_PROBE_OPERATOR, 4096, 1 },
                         probe, COUNT, found),
        RSV_OK);
    assert_int_equal(rsv_probe_reference(w->scene, probe, COUNT, 8192, 1, expected), RSV_OK);
    for (int k = 0; k < COUNT; k++) {
        double error =
            hypot((double)found[k].standard_error.g, (double)expected[k].standard_error.g);
        assert_close((double)found[k].irradiance.g, (double)expected[k].irradiance.g,
            4 * error + 0.01 * (double)expected[k].irradiance.g);
    }
    rsv_light_destroy(s);
    world_end(w);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest quick[] = {
        cmocka_unit_test(an_orthographic_camera_keeps_sizes),
        cmocka_unit_test(probes_see_lights_by_way_of_rough_metal),
        cmocka_unit_test(a_mirror_sphere_in_a_furnace_is_invisible),
        cmocka_unit_test(a_glass_sphere_in_a_furnace_keeps_the_energy),
        cmocka_unit_test(a_thin_sheet_of_glass_in_a_furnace_is_invisible),
        cmocka_unit_test(branches_of_a_camera_ray_carry_all_its_weight),
        cmocka_unit_test(unlit_surfaces_show_their_colour),
        cmocka_unit_test(bad_descriptors_are_refused),
        cmocka_unit_test(memory_that_runs_out_is_an_error_and_nothing_leaks),
    };
    const struct CMUnitTest slow[] = {
        cmocka_unit_test(a_room_of_mirrors_shows_its_lamp_everywhere),
        cmocka_unit_test(small_highlights_are_averaged_over_footprints),
        cmocka_unit_test(layers_sum_to_the_picture),
        cmocka_unit_test(pictures_are_the_same_bytes_for_any_thread_count),
        cmocka_unit_test(operator_and_final_agree_in_the_mean),
        cmocka_unit_test(noisy_pixels_get_more_rays_and_no_bias),
        cmocka_unit_test(further_shadow_rays_do_not_change_the_light),
    };
    return RUN_HALF(argc, argv, quick, slow);
}
