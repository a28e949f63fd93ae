/// The reference path tracer against closed forms: it can judge the rest only if it passes itself.
#include "builtin/builtin.h"
#include "builtin/shapes.h"
#include "resolvent/render.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

/// A committed value differs from the truth by more than this many standard errors once in 15,000.
#define STANDARD_ERRORS 4

typedef struct fixture {
    rsv_context *context;
    rsv_scene *scene;
    int rejected; ///< warnings about samples that were not finite
    int named;    ///< and about light that is left out
} fixture;

static void count_rejections(void *user, rsv_log_level level, const char *message)
{
    (void)level;
    ((fixture *)user)->rejected += strstr(message, "not finite") != NULL;
    ((fixture *)user)->named += strstr(message, "leaves out its reflections") != NULL;
}

static fixture *start(int threads)
{
    static fixture f;
    f = (fixture){ 0 };
    rsv_context_desc desc = rsv_default_context_desc();
    desc.log = count_rejections;
    desc.user = &f;
    desc.thread_count = threads;
    assert_int_equal(rsv_context_create(&desc, &f.context), RSV_OK);
    assert_int_equal(rsv_scene_create(f.context, &f.scene), RSV_OK);
    return &f;
}

static void finish(fixture *f)
{
    assert_int_equal(f->rejected, 0);
    rsv_scene_destroy(f->scene);
    rsv_context_destroy(f->context);
}

static uint32_t add_material(fixture *f, const rsv_material *material)
{
    uint32_t id;
    assert_int_equal(rsv_scene_add_material(f->scene, material, &id), RSV_OK);
    return id;
}

static uint32_t add_lambert(fixture *f, float albedo, float radiance)
{
    uint32_t id;
    assert_int_equal(
        rsv_add_lambert(f->scene, "wall", rgb_gray(albedo), rgb_gray(radiance), &id), RSV_OK);
    return id;
}

static rsv_material glass(void)
{
    rsv_material material = rsv_default_material();
    material.base_color = rgb_gray(1);
    material.roughness = 0;
    material.transmission = 1;
    material.thickness = 1;
    return material;
}

static void add_quad(fixture *f, uint32_t material, rsv_vec3 a, rsv_vec3 b, rsv_vec3 c, rsv_vec3 d)
{
    rsv_vec3 corner[4] = { a, b, c, d };
    assert_int_equal(rsv_add_quad((rsv_shape){ f->scene, "quad", material, NULL }, corner), RSV_OK);
}

static void add_furnace(fixture *f, float albedo)
{
    uint32_t walls = add_lambert(f, albedo, 1 / RSV_PI);
    rsv_shape shape = { f->scene, "furnace", walls, NULL };
    assert_int_equal(rsv_add_room(shape, v3(-1, -1, -1), v3(1, 1, 1)), RSV_OK);
}

static void add_sphere(fixture *f, const rsv_material *material)
{
    rsv_shape shape = { f->scene, "sphere", add_material(f, material), NULL };
    assert_int_equal(rsv_add_sphere(shape, v3(0, 0, 0), 0.5f, 3), RSV_OK);
}

static void add_point_light(fixture *f, rsv_vec3 position, float intensity)
{
    rsv_punctual_light light = { .kind = RSV_PUNCTUAL_POINT,
        .position = position,
        .direction = { 0, 0, -1 },
        .intensity = rgb_gray(intensity) };
    assert_int_equal(rsv_scene_add_light(f->scene, &light), RSV_OK);
}

static void commit(fixture *f) { assert_int_equal(rsv_scene_commit(f->scene), RSV_OK); }

static void commit_with_camera(fixture *f, rsv_vec3 position, rsv_vec3 target, float degrees)
{
    rsv_camera camera = rsv_camera_look_at("test", position, target, degrees * RSV_PI / 180, 1);
    assert_int_equal(rsv_scene_add_camera(f->scene, &camera), RSV_OK);
    commit(f);
}

static rsv_image *render(fixture *f, uint32_t size, uint32_t samples, bool layers, double *error)
{
    rsv_render_desc desc = rsv_default_render_desc();
    desc.width = desc.height = size;
    desc.samples = samples;
    desc.layers = layers;
    rsv_image *image;
    assert_int_equal(rsv_render_reference(f->scene, &desc, &image, error), RSV_OK);
    return image;
}

static double mean_green(const rsv_image *image, uint32_t layer)
{
    size_t count = (size_t)rsv_image_width(image) * rsv_image_height(image);
    const rsv_rgb *pixel = rsv_image_const_pixels(image, layer);
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += (double)pixel[i].g;
    return sum / (double)count;
}

/// Renders, checks the mean radiance and ends the fixture.
static void check_mean_radiance(fixture *f, uint32_t samples, double expected, double worst_error)
{
    double error;
    rsv_image *image = render(f, 32, samples, false, &error);
    double mean = mean_green(image, 0);
    rsv_image_destroy(image);
    finish(f);
    // 2e-6: radiance is summed in float along a path
    if (fabs(mean / expected - 1) > STANDARD_ERRORS * error + 2e-6 || error > worst_error)
        fail_msg("mean %.6g, expected %.6g, standard error %.2g", mean, expected, error);
}

static rsv_probe_reading probe_at(fixture *f, rsv_vec3 position, rsv_vec3 normal, uint32_t samples)
{
    rsv_probe probe = { position, normal };
    rsv_probe_reading reading;
    assert_int_equal(rsv_probe_reference(f->scene, &probe, 1, samples, 1, &reading), RSV_OK);
    return reading;
}

static void check_probe(fixture *f, rsv_vec3 position, rsv_vec3 normal, uint32_t samples,
    double expected, double worst_relative_error)
{
    rsv_probe_reading reading = probe_at(f, position, normal, samples);
    double error = (double)reading.standard_error.g, value = (double)reading.irradiance.g;
    if (fabs(value - expected) > STANDARD_ERRORS * error || error > worst_relative_error * expected)
        fail_msg("irradiance %.7g, expected %.7g, standard error %.2g", value, expected, error);
}

static void furnace_of_medium_albedo_is_uniform(void **state)
{
    (void)state;
    fixture *f = start(0);
    add_furnace(f, 0.5f);
    commit_with_camera(f, v3(0.3f, 0.2f, 0.9f), v3(0, 0, 0), 70);
    check_mean_radiance(f, 16, 2 / (double)RSV_PI, 5e-3);
}

static void furnace_of_high_albedo_keeps_all_bounces(void **state)
{
    (void)state;
    fixture *f = start(0);
    add_furnace(f, 0.99f);
    commit_with_camera(f, v3(0.3f, 0.2f, 0.9f), v3(0, 0, 0), 70);
    check_mean_radiance(f, 16, 100 / (double)RSV_PI, 1.5e-2);
}

static void lossless_glass_sphere_is_invisible(void **state)
{
    (void)state;
    fixture *f = start(0);
    add_furnace(f, 0.5f);
    rsv_material material = glass();
    add_sphere(f, &material);
    commit_with_camera(f, v3(0, 0, 0.95f), v3(0, 0, 0), 60);
    check_mean_radiance(f, 32, 2 / (double)RSV_PI, 5e-3);
}

static void tinted_specular_scale_of_glass_loses_nothing(void **state)
{
    (void)state;
    fixture *f = start(0);
    add_furnace(f, 0.5f);
    rsv_material material = glass();
    material.specular = 0.4f;
    material.ior = 2;
    add_sphere(f, &material);
    commit_with_camera(f, v3(0, 0, 0.95f), v3(0, 0, 0), 60);
    check_mean_radiance(f, 32, 2 / (double)RSV_PI, 5e-3);
}

static void lossless_mirror_sphere_is_invisible(void **state)
{
    (void)state;
    fixture *f = start(0);
    add_furnace(f, 0.5f);
    rsv_material material = rsv_default_material();
    material.base_color = rgb_gray(1);
    material.metallic = 1;
    material.roughness = 0;
    add_sphere(f, &material);
    commit_with_camera(f, v3(0, 0, 0.95f), v3(0, 0, 0), 60);
    check_mean_radiance(f, 32, 2 / (double)RSV_PI, 5e-3);
}

static void white_coated_box_is_invisible(void **state)
{
    (void)state;
    fixture *f = start(0);
    add_furnace(f, 0.5f);
    rsv_material material = rsv_default_material();
    material.base_color = rgb_gray(1);
    material.roughness = 0;
    rsv_shape box = { f->scene, "box", add_material(f, &material), NULL };
    assert_int_equal(rsv_add_box(box, v3(-0.4f, -0.4f, -0.4f), v3(0.4f, 0.4f, 0.4f)), RSV_OK);
    commit_with_camera(f, v3(0.5f, 0.6f, 0.9f), v3(0, 0, 0), 60);
    check_mean_radiance(f, 32, 2 / (double)RSV_PI, 5e-3);
}

static void half_transmitting_sheet_is_invisible(void **state)
{
    (void)state;
    fixture *f = start(0);
    add_furnace(f, 0.5f);
    rsv_material material = glass();
    material.thickness = 0;
    material.transmission = 0.5f;
    material.double_sided = true;
    add_quad(f, add_material(f, &material), v3(-1, -1, 0), v3(1, -1, 0), v3(1, 1, 0), v3(-1, 1, 0));
    commit_with_camera(f, v3(0.1f, 0.2f, 0.9f), v3(0, 0, 0), 60);
    check_mean_radiance(f, 32, 2 / (double)RSV_PI, 5e-3);
}

// validation case d.point.h2: E = I cos^3 / h^2
static void point_light_follows_the_inverse_square_law(void **state)
{
    (void)state;
    fixture *f = start(0);
    add_quad(f, add_lambert(f, 0, 0), v3(-5, -5, 0), v3(5, -5, 0), v3(5, 5, 0), v3(-5, 5, 0));
    add_point_light(f, v3(0, 0, 2), 100);
    commit(f);
    check_probe(f, v3(0, 0, 0), v3(0, 0, 1), 32, 25, 2e-6);
    check_probe(f, v3(0.5f, 0, 0), v3(0, 0, 1), 32, 22.8268823564, 2e-6);
    check_probe(f, v3(4, 0, 0), v3(0, 0, 1), 32, 2.2360679775, 2e-6);
    finish(f);
}

/// Forty lights are drawn from instead of summed; their irradiances still add up.
static void many_point_lights_add_up(void **state)
{
    (void)state;
    fixture *f = start(0);
    add_quad(f, add_lambert(f, 0, 0), v3(-5, -5, 0), v3(5, -5, 0), v3(5, 5, 0), v3(-5, 5, 0));
    for (int i = 0; i < 40; i++)
        add_point_light(f, v3(i % 2 ? 0 : 4, 0, 2), 5);
    commit(f);
    check_probe(f, v3(0, 0, 0), v3(0, 0, 1), 20000, 25 + 2.2360679775, 1e-2);
    finish(f);
}

static void point_light_shines_through_thin_glass(void **state)
{
    (void)state;
    fixture *f = start(0);
    rsv_material pane = glass();
    pane.thickness = 0;
    add_quad(f, add_material(f, &pane), v3(-5, -5, 1), v3(5, -5, 1), v3(5, 5, 1), v3(-5, 5, 1));
    add_point_light(f, v3(0, 0, 2), 100);
    commit(f);
    check_probe(f, v3(0, 0, 0), v3(0, 0, 1), 32, 25 * 0.96, 2e-6);
    finish(f);
}

// validation cases d.rect_light.center and d.rect_light.near
static void rectangular_light_matches_lamberts_formula(void **state)
{
    (void)state;
    fixture *f = start(0);
    uint32_t lamp = add_lambert(f, 0, 1), black = add_lambert(f, 0, 0);
    add_quad(f, lamp, v3(-0.5f, -1, 2), v3(-0.5f, 1, 2), v3(0.5f, 1, 2), v3(0.5f, -1, 2));
    add_quad(f, black, v3(-5, -5, 0), v3(5, -5, 0), v3(5, 5, 0), v3(-5, 5, 0));
    commit(f);
    rsv_vec3 tilted = v3(0.9578262852f, 0, 0.2873478856f);
    check_probe(f, v3(0, 0, 0), v3(0, 0, 1), 4096, 0.415837626515, 1e-3);
    check_probe(f, v3(1, 0.5f, 0), v3(0, 0, 1), 4096, 0.26654250073, 2e-3);
    check_probe(f, v3(0.2f, 0, 0.5f), tilted, 16384, 0.122386968327, 8e-3);
    finish(f);
}

/// On black walls, no light is sampled, so light that paths hit there must keep its full weight.
static void black_rooms_show_their_lamp_alone(void **state)
{
    (void)state;
    fixture *f = start(0);
    rsv_shape room = { f->scene, "room", add_lambert(f, 0, 0), NULL };
    assert_int_equal(rsv_add_room(room, v3(-1, -1, -1), v3(1, 1, 1)), RSV_OK);
    uint32_t lamp = add_lambert(f, 0, 3);
    add_quad(f, lamp, v3(-0.2f, -0.2f, 0.9f), v3(-0.2f, 0.2f, 0.9f), v3(0.2f, 0.2f, 0.9f),
        v3(0.2f, -0.2f, 0.9f));
    commit_with_camera(f, v3(0, 0, 0), v3(0.5f, 0, -1), 60);
    double error;
    rsv_image *image = render(f, 32, 64, false, &error);
    assert_float_equal(mean_green(image, 0), 0, 0);
    rsv_image_destroy(image);
    finish(f);
}

static void near_rectangular_light_matches_lamberts_formula(void **state)
{
    (void)state;
    fixture *f = start(0);
    uint32_t lamp = add_lambert(f, 0, 5), black = add_lambert(f, 0, 0);
    add_quad(f, lamp, v3(-1, -1, 0.5f), v3(-1, 1, 0.5f), v3(1, 1, 0.5f), v3(1, -1, 0.5f));
    add_quad(f, black, v3(-5, -5, 0), v3(5, -5, 0), v3(5, 5, 0), v3(-5, 5, 0));
    commit(f);
    check_probe(f, v3(0, 0, 0), v3(0, 0, 1), 16384, 13.0537651551, 1e-3);
    check_probe(f, v3(0.9f, 0.9f, 0), v3(0, 0, 1), 16384, 5.43575654416, 4e-3);
    finish(f);
}

// validation case f.mirror_area.partial: direct light plus what a mirror's edge lets through
static void mirror_adds_the_clipped_image_of_the_light(void **state)
{
    (void)state;
    fixture *f = start(0);
    rsv_material mirror = rsv_default_material();
    mirror.base_color = rgb_gray(0.9f);
    mirror.metallic = 1;
    mirror.roughness = 0;
    uint32_t lamp = add_lambert(f, 0, 10);
    add_quad(f, lamp, v3(1, -1, 2), v3(1, 1, 2), v3(2, 1, 2), v3(2, -1, 2));
    // In the case, reflectance does not rise towards grazing angles (Schlick); here this adds below 0.05 %
    add_quad(
        f, add_material(f, &mirror), v3(0, -9, 0), v3(0, 9, 0), v3(0, 9, 1.2f), v3(0, -9, 1.2f));
    commit(f);
    check_probe(f, v3(1, 0, 0), v3(0, 0, 1), 20000, 4.43184720297, 5e-3);
    finish(f);
}

// validation case c.cube.rho0p8: the floor emits M = 1; E = (B - M) / rho
static void interreflection_in_a_cube_matches_the_continuous_solution(void **state)
{
    (void)state;
    fixture *f = start(0);
    uint32_t wall = add_lambert(f, 0.8f, 0), floor = add_lambert(f, 0.8f, 1 / RSV_PI);
    rsv_vec3 p[8];
    for (int i = 0; i < 8; i++)
        p[i] = v3((float)(i & 1), (float)(i >> 1 & 1), (float)(i >> 2));
    add_quad(f, floor, p[0], p[1], p[3], p[2]);
    add_quad(f, wall, p[4], p[6], p[7], p[5]);
    add_quad(f, wall, p[0], p[2], p[6], p[4]);
    add_quad(f, wall, p[1], p[5], p[7], p[3]);
    add_quad(f, wall, p[0], p[4], p[5], p[1]);
    add_quad(f, wall, p[2], p[3], p[7], p[6]);
    commit(f);
    const double rho = 0.8;
    const uint32_t samples = 40000;
    check_probe(f, v3(0.5f, 0.5f, 1), v3(0, 0, -1), samples, 0.713082444524 / rho, 4e-3);
    check_probe(f, v3(0, 0.5f, 0.1f), v3(1, 0, 0), samples, 0.872136588727 / rho, 4e-3);
    check_probe(f, v3(0.5f, 0.5f, 0), v3(0, 0, 1), samples, 0.55226230971 / rho, 6e-3);
    finish(f);
}

/// A lamp seen straight through an index-matched slab of 1 m that halves the light every 0.5 m.
static void slab_absorbs_by_beer_and_lambert(void **state)
{
    (void)state;
    fixture *f = start(0);
    rsv_material slab = glass();
    slab.ior = 1;
    slab.attenuation_color = rgb_gray(0.5f);
    slab.attenuation_distance = 0.5f;
    rsv_shape box = { f->scene, "slab", add_material(f, &slab), NULL };
    assert_int_equal(rsv_add_box(box, v3(-2, -2, -0.5f), v3(2, 2, 0.5f)), RSV_OK);
    uint32_t lamp = add_lambert(f, 0, 3);
    add_quad(f, lamp, v3(-3, -3, -1), v3(3, -3, -1), v3(3, 3, -1), v3(-3, 3, -1));
    rsv_camera camera = rsv_camera_look_at("test", v3(0, 0, 2), v3(0, 0, 0), 0, 1);
    camera.vertical_extent = 1;
    assert_int_equal(rsv_scene_add_camera(f->scene, &camera), RSV_OK);
    commit(f);
    check_mean_radiance(f, 4, 0.75, 1e-6);
}

static void unlit_surfaces_show_themselves_and_light_nothing(void **state)
{
    (void)state;
    fixture *f = start(0);
    rsv_material sign = rsv_default_material();
    sign.base_color = rgb_gray(0.25f);
    sign.unlit = true;
    add_quad(f, add_material(f, &sign), v3(-5, -5, 0), v3(5, -5, 0), v3(5, 5, 0), v3(-5, 5, 0));
    commit_with_camera(f, v3(0, 0, 2), v3(0, 0, 0), 40);
    rsv_probe_reading reading = probe_at(f, v3(0, 0, 1), v3(0, 0, -1), 64);
    assert_float_equal(reading.irradiance.g, 0, 0);
    check_mean_radiance(f, 1, 0.25, 1e-6);
}

static void layers_are_named_by_order_and_sum_to_the_picture(void **state)
{
    (void)state;
    fixture *f = start(0);
    add_furnace(f, 0.5f);
    commit_with_camera(f, v3(0.3f, 0.2f, 0.9f), v3(0, 0, 0), 70);
    rsv_image *image = render(f, 16, 4, true, NULL);
    assert_int_equal(rsv_image_layer_count(image), 10);
    assert_string_equal(rsv_image_layer_name(image, 0), "");
    assert_string_equal(rsv_image_layer_name(image, 1), "emission");
    assert_string_equal(rsv_image_layer_name(image, 2), "direct");
    assert_string_equal(rsv_image_layer_name(image, 3), "bounce1");
    assert_string_equal(rsv_image_layer_name(image, 9), "bounce7+");
    double sum = 0;
    for (uint32_t layer = 1; layer < 10; layer++)
        sum += mean_green(image, layer);
    assert_true(fabs(sum - mean_green(image, 0)) < 1e-6);
    // a furnace is T^n Le = albedo^n Le, exactly while roulette has not begun
    for (uint32_t order = 0; order < 5; order++) {
        double expected = pow(0.5, order) / (double)RSV_PI;
        assert_true(fabs(mean_green(image, 1 + order) - expected) < 1e-6);
    }
    rsv_image_destroy(image);
    finish(f);
}

static rsv_image *render_cornell(int threads, fixture **f)
{
    *f = start(threads);
    rsv_scene_destroy((*f)->scene);
    assert_int_equal(rsv_scene_builtin((*f)->context, "cornell-spheres", &(*f)->scene), RSV_OK);
    return render(*f, 24, 4, false, NULL);
}

static void pictures_do_not_depend_on_the_number_of_threads(void **state)
{
    (void)state;
    enum { BYTES = 24 * 24 * sizeof(rsv_rgb) };
    fixture *f;
    rsv_rgb first[24 * 24];
    rsv_image *image = render_cornell(1, &f);
    memcpy(first, rsv_image_const_pixels(image, 0), BYTES);
    rsv_image_destroy(image);
    finish(f);
    image = render_cornell(3, &f);
    assert_memory_equal(first, rsv_image_const_pixels(image, 0), BYTES);
    rsv_image_destroy(image);
    finish(f);
}

/// The reported standard error against the spread of pictures with different seeds.
static void standard_error_tells_the_spread_over_seeds(void **state)
{
    (void)state;
    enum { PICTURES = 24 };
    fixture *f = start(0);
    add_furnace(f, 0.8f);
    commit_with_camera(f, v3(0.3f, 0.2f, 0.9f), v3(0, 0, 0), 70);
    double sum = 0, squares = 0, error_sum = 0;
    for (uint32_t seed = 0; seed < PICTURES; seed++) {
        rsv_render_desc desc = rsv_default_render_desc();
        desc.width = desc.height = 16;
        desc.samples = 4;
        desc.seed = seed;
        rsv_image *image;
        double error;
        assert_int_equal(rsv_render_reference(f->scene, &desc, &image, &error), RSV_OK);
        double mean = mean_green(image, 0);
        sum += mean;
        squares += mean * mean;
        error_sum += error;
        rsv_image_destroy(image);
    }
    double mean = sum / PICTURES;
    double spread = sqrt((squares / PICTURES - mean * mean) * PICTURES / (PICTURES - 1)) / mean;
    // the spread of 24 values is known to 15 %; stratification may make it smaller still
    assert_true(spread < 1.6 * error_sum / PICTURES);
    assert_true(spread > 0.3 * error_sum / PICTURES);
    finish(f);
}

static void impossible_requests_are_refused(void **state)
{
    (void)state;
    fixture *f = start(0);
    add_furnace(f, 0.5f);
    commit(f);
    rsv_image *image = NULL;
    rsv_render_desc desc = rsv_default_render_desc();
    desc.camera = 7;
    assert_int_equal(rsv_render_reference(f->scene, &desc, &image, NULL), RSV_ERROR_ARGUMENT);
    assert_non_null(strstr(rsv_last_error(), "camera 7"));
    desc = rsv_default_render_desc();
    desc.samples = 0;
    assert_int_equal(rsv_render_reference(f->scene, &desc, &image, NULL), RSV_ERROR_ARGUMENT);
    rsv_probe probe = { { 0, 0, 0 }, { 0, 0, 0 } };
    rsv_probe_reading reading;
    assert_int_equal(rsv_probe_reference(f->scene, &probe, 1, 32, 1, &reading), RSV_ERROR_ARGUMENT);
    assert_non_null(strstr(rsv_last_error(), "probe 0"));
    finish(f);
}

static void cancelled_work_leaves_no_picture(void **state)
{
    (void)state;
    fixture *f = start(0);
    add_furnace(f, 0.5f);
    commit(f);
    rsv_context_cancel(f->context);
    rsv_image *image = NULL;
    rsv_render_desc desc = rsv_default_render_desc();
    assert_int_equal(rsv_render_reference(f->scene, &desc, &image, NULL), RSV_ERROR_CANCELLED);
    assert_null(image);
    finish(f);
}

/// A wall in the material, lit by a point light. @return whether a warning says that light is left out
static bool names_what_is_left_out(const rsv_material *material)
{
    fixture *f = start(1);
    const rsv_vec3 corner[4] = { v3(-1, 0, 1), v3(1, 0, 1), v3(1, 0, -1), v3(-1, 0, -1) };
    const rsv_punctual_light light = { .position = v3(0, 1, 0), .intensity = rgb_gray(1) };
    rsv_shape wall = { f->scene, "wall", add_material(f, material), NULL };
    assert_int_equal(rsv_add_quad(wall, corner), RSV_OK);
    assert_int_equal(rsv_scene_add_light(f->scene, &light), RSV_OK);
    assert_int_equal(rsv_scene_commit(f->scene), RSV_OK);
    double error;
    rsv_image_destroy(render(f, 2, 1, false, &error));
    int named = f->named;
    finish(f);
    return named > 0;
}

static void light_of_points_in_mirrors_and_panes_is_named(void **state)
{
    (void)state;
    rsv_material material = rsv_default_material();
    material.roughness = 0.5f;
    assert_false(names_what_is_left_out(&material));
    material.clearcoat = 1;
    assert_true(names_what_is_left_out(&material));
    material.clearcoat_roughness = 0.5f;
    material.metallic = 1;
    assert_false(names_what_is_left_out(&material));
    material.roughness = 0;
    assert_true(names_what_is_left_out(&material));
    material = rsv_default_material();
    material.transmission = 1;
    material.roughness = 0; // a pane
    assert_true(names_what_is_left_out(&material));
    material = rsv_default_material();
    material.specular = 0;
    material.roughness = 0;
    assert_false(names_what_is_left_out(&material));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(furnace_of_medium_albedo_is_uniform),
        cmocka_unit_test(furnace_of_high_albedo_keeps_all_bounces),
        cmocka_unit_test(lossless_glass_sphere_is_invisible),
        cmocka_unit_test(tinted_specular_scale_of_glass_loses_nothing),
        cmocka_unit_test(lossless_mirror_sphere_is_invisible),
        cmocka_unit_test(white_coated_box_is_invisible),
        cmocka_unit_test(half_transmitting_sheet_is_invisible),
        cmocka_unit_test(point_light_follows_the_inverse_square_law),
        cmocka_unit_test(many_point_lights_add_up),
        cmocka_unit_test(point_light_shines_through_thin_glass),
        cmocka_unit_test(rectangular_light_matches_lamberts_formula),
        cmocka_unit_test(black_rooms_show_their_lamp_alone),
        cmocka_unit_test(near_rectangular_light_matches_lamberts_formula),
        cmocka_unit_test(mirror_adds_the_clipped_image_of_the_light),
        cmocka_unit_test(interreflection_in_a_cube_matches_the_continuous_solution),
        cmocka_unit_test(slab_absorbs_by_beer_and_lambert),
        cmocka_unit_test(unlit_surfaces_show_themselves_and_light_nothing),
        cmocka_unit_test(layers_are_named_by_order_and_sum_to_the_picture),
        cmocka_unit_test(pictures_do_not_depend_on_the_number_of_threads),
        cmocka_unit_test(standard_error_tells_the_spread_over_seeds),
        cmocka_unit_test(light_of_points_in_mirrors_and_panes_is_named),
        cmocka_unit_test(impossible_requests_are_refused),
        cmocka_unit_test(cancelled_work_leaves_no_picture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
