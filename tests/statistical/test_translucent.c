/// Translucent bodies in scenes: the operator and the reference, which share formulas but no code, against closed
/// forms and each other.
#include "bake/bake_receiver.h"
#include "relight/light_response.h"
#include "resolvent/render.h"
#include "subsurface/scatter_profile.h"
#include "unit/light_fixture.h"

static rsv_material translucent(float albedo, float d)
{
    rsv_material m = lambert_material(albedo, 0);
    m.scatter_distance = rgb_gray(d * (float)rsv_diffuse_surface_scale(albedo));
    return m;
}

static void add_camera(world *w, rsv_vec3 position, rsv_vec3 target, float degrees)
{
    rsv_camera camera = rsv_camera_look_at("test", position, target, degrees * RSV_PI / 180, 1);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
}

static rsv_light *solve(const world *w)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_light *solution;
    assert_int_equal(rsv_light_create(w->scene, &desc, &solution), RSV_OK);
    return solution;
}

static rsv_image *show(const rsv_light *solution, uint32_t size, uint32_t samples)
{
    rsv_render_desc desc = rsv_default_render_desc();
    desc.width = desc.height = size;
    desc.samples = samples;
    rsv_image *image;
    assert_int_equal(rsv_render(solution, &desc, &image), RSV_OK);
    return image;
}

static rsv_image *trace(const world *w, uint32_t size, uint32_t samples, double *error)
{
    rsv_render_desc desc = rsv_default_render_desc();
    desc.mode = RSV_RENDER_REFERENCE;
    desc.width = desc.height = size;
    desc.samples = samples;
    rsv_image *image;
    assert_int_equal(rsv_render_reference(w->scene, &desc, &image, error), RSV_OK);
    return image;
}

/// Mean green of a block of pixels.
static double mean_of(const rsv_image *image, uint32_t x0, uint32_t y0, uint32_t side)
{
    const rsv_rgb *pixel = rsv_image_const_pixels(image, 0);
    uint32_t width = rsv_image_width(image);
    double sum = 0;
    for (uint32_t y = y0; y < y0 + side; y++)
        for (uint32_t x = x0; x < x0 + side; x++)
            sum += (double)pixel[y * width + x].g;
    return sum / side / side;
}

/// Mean over the bodies of what bakes show of them, green.
static double baked_mean(const rsv_light_view *s)
{
    const rsv_scene_view *view = s->scene.view;
    double sum = 0, area = 0;
    for (uint32_t t = 0; t < view->triangle_count; t++) {
        if (!rsv_material_scatters_below(&view->material[view->triangle_material[t]])) continue;
        double own = (double)rsv_triangle_area(view, t);
        sum += own * (double)rsv_bake_shown(s, t, false, 1.0f / 3, 1.0f / 3).g;
        area += own;
    }
    return sum / area;
}

/// Under a uniform sky of radiance 1 a convex body without thin parts shows albedo times the share of the profile
/// within its diameter: caps of a sphere have the area of the flat disk with the same chord.
static void a_sphere_in_a_furnace_shows_its_albedo(void **state)
{
    (void)state;
    const float d = 0.12f;
    world *w = world_begin(2);
    world_room(w, world_lambert(w, 0, 1), v3(-2, -2, -2), v3(2, 2, 2));
    world_sphere(w, world_material(w, translucent(0.8f, d)), v3(0, 0, 0), 0.5f, 4);
    add_camera(w, v3(0, 0, 1.9f), v3(0, 0, 0), 15);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    double expected = 0.8 * rsv_diffusion_cdf(d, 1), error;
    rsv_image *traced = trace(w, 16, 256, &error);
    assert_close(mean_of(traced, 0, 0, 16), expected, 4 * error * expected);
    rsv_light *solution = solve(w);
    rsv_image *shown = show(solution, 16, 4);
    assert_close(mean_of(shown, 0, 0, 16), expected, 0.005 * expected);
    assert_close(0.8 * baked_mean(rsv_light_get_view(solution)) / (double)RSV_PI, expected,
        0.005 * expected);
    rsv_image_destroy(traced);
    rsv_image_destroy(shown);
    rsv_light_destroy(solution);
    world_end(w);
}

static void what_bakes_show_light_by_light_adds_up(void **state)
{
    (void)state;
    world *w = world_begin(2);
    world_sphere(w, world_material(w, translucent(0.8f, 0.2f)), v3(0, 0, 0), 0.5f, 3);
    world_quad(w, world_lambert(w, 0, 10), v3(-0.5f, 2, -0.5f), v3(0.5f, 2, -0.5f),
        v3(0.5f, 2, 0.5f), v3(-0.5f, 2, 0.5f));
    const rsv_punctual_light light = { .name = "point",
        .kind = RSV_PUNCTUAL_POINT,
        .position = v3(2, 0, 0),
        .intensity = rgb_gray(10) };
    assert_int_equal(rsv_scene_add_light(w->scene, &light), RSV_OK);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    rsv_light *solution = solve(w);
    rsv_light_responses *responses;
    assert_int_equal(rsv_light_responses_create(solution, &responses), RSV_OK);
    assert_int_equal(responses->count, 2);
    double whole = baked_mean(rsv_light_get_view(solution)), first = baked_mean(responses->view[0]);
    double second = baked_mean(responses->view[1]);
    assert_true(first > 0.1 * whole && second > 0.1 * whole);
    assert_close(first + second, whole, 0.002 * whole);
    rsv_light_responses_destroy(responses);
    rsv_light_destroy(solution);
    world_end(w);
}

/// A translucent ball and box in a lamp's light: half-lit, with edges, on a floor that reflects.
static world *still_life(float d)
{
    world *w = world_begin(2);
    uint32_t body = world_material(w, d > 0 ? translucent(0.8f, d) : lambert_material(0.8f, 0));
    world_room(w, world_lambert(w, 0.5f, 0), v3(-1, 0, -1), v3(1, 2, 1));
    world_quad(w, world_lambert(w, 0, 10), v3(-0.9f, 1.9f, -0.3f), v3(-0.3f, 1.9f, -0.3f),
        v3(-0.3f, 1.9f, 0.3f), v3(-0.9f, 1.9f, 0.3f));
    world_sphere(w, body, v3(-0.35f, 0.5f, 0), 0.3f, 4);
    world_box(w, body, v3(0.15f, 0.1f, -0.25f), v3(0.65f, 0.7f, 0.2f));
    add_camera(w, v3(0, 0.6f, 0.99f), v3(0, 0.42f, 0), 62);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    return w;
}

static void operator_and_reference_agree(void **state)
{
    (void)state;
    world *w = still_life(0.05f);
    rsv_light *solution = solve(w);
    double error;
    rsv_image *shown = show(solution, 32, 16), *traced = trace(w, 32, 256, &error);
    assert_true(error < 4e-3);
    double mean = mean_of(traced, 0, 0, 32), squares = 0;
    assert_close(mean_of(shown, 0, 0, 32) / mean, 1, 0.01);
    for (uint32_t y = 0; y < 32; y += 8) {
        for (uint32_t x = 0; x < 32; x += 8) {
            double difference = mean_of(shown, x, y, 8) - mean_of(traced, x, y, 8);
            squares += difference * difference / 16;
        }
    }
    assert_true(squares < 2e-3 * mean * mean);
    rsv_image_destroy(shown);
    rsv_image_destroy(traced);
    rsv_light_destroy(solution);
    world_end(w);
}

static void a_vanishing_mean_free_path_is_lambert(void **state)
{
    (void)state;
    world *w[2] = { still_life(1e-7f), still_life(0) };
    rsv_image *image[2];
    for (int k = 0; k < 2; k++) {
        rsv_light *solution = solve(w[k]);
        image[k] = show(solution, 32, 4);
        rsv_light_destroy(solution);
    }
    double mean = mean_of(image[1], 0, 0, 32), squares = 0;
    for (size_t k = 0; k < 32 * 32; k++) {
        double difference =
            (double)rsv_image_pixels(image[0], 0)[k].g - (double)rsv_image_pixels(image[1], 0)[k].g;
        squares += difference * difference / (32 * 32);
    }
    assert_close(mean_of(image[0], 0, 0, 32), mean, 3e-3 * mean);
    assert_close(sqrt(squares), 0, 0.01 * mean);
    for (int k = 0; k < 2; k++) {
        rsv_image_destroy(image[k]);
        world_end(w[k]);
    }
}

/// In a closed box with one albedo everywhere, and no loss below surfaces, the mean irradiance is the mean emission /
/// (1 - albedo), for any objects in the box.
static void a_translucent_ball_keeps_the_balance_of_a_closed_box(void **state)
{
    (void)state;
    world *w = world_begin(2);
    uint32_t walls = world_material(w, lambert_material(0.5f, 1 / RSV_PI));
    world_room(w, walls, v3(-1, -1, -1), v3(1, 1, 1));
    world_sphere(w, world_material(w, translucent(0.5f, 0.05f)), v3(0.2f, 0.1f, 0), 0.5f, 4);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    rsv_light *solution = solve(w);
    const rsv_scene_view *view = rsv_scene_get_view(w->scene);
    double total = 0;
    for (uint32_t t = 0; t < view->triangle_count; t++)
        total += (double)rsv_triangle_area(view, t);
    double emission = 24 / total; // 1 W/m2 from six walls of 4 m2
    assert_close(rsv_light_report(solution)->mean_irradiance / (emission / 0.5), 1, 3e-3);
    rsv_light_destroy(solution);
    world_end(w);
}

/// What the coat of a ball reflects of a sky with one bright quarter, path traced; d as in translucent().
static double reflected_by_the_coat(float d)
{
    world *w = world_begin(2);
    rsv_material coated = d > 0 ? translucent(0.8f, d) : lambert_material(0.8f, 0);
    coated.specular = 1;
    coated.roughness = 0.5f;
    world_sphere(w, world_material(w, coated), v3(0, 0, 0), 0.5f, 4);
    const rsv_rgb quarter[4] = { { 0, 0, 0 }, { 10, 10, 10 }, { 0, 0, 0 }, { 0, 0, 0 } };
    const rsv_environment sky = { .pixels = quarter, .width = 2, .height = 2, .intensity = 1 };
    assert_int_equal(rsv_scene_set_environment(w->scene, &sky), RSV_OK);
    add_camera(w, v3(0, 0, 2), v3(0, 0, 0), 20);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    rsv_render_desc desc = rsv_default_render_desc();
    desc.width = desc.height = 16;
    desc.samples = 256;
    desc.layers = true;
    rsv_image *image;
    assert_int_equal(rsv_render_reference(w->scene, &desc, &image, NULL), RSV_OK);
    const rsv_rgb *emission =
        rsv_image_const_pixels(image, rsv_image_find_layer(image, "emission"));
    double sum = 0;
    for (int i = 0; i < 256; i++)
        sum += (double)emission[i].g;
    rsv_image_destroy(image);
    world_end(w);
    return sum / 256;
}

static void what_lies_below_a_coat_does_not_change_its_reflection(void **state)
{
    (void)state;
    double opaque = reflected_by_the_coat(0);
    assert_true(opaque > 0.01);
    // 65,536 paths with a spread of about their mean, twice: 0.6 %
    assert_close(reflected_by_the_coat(0.1f) / opaque, 1, 0.02);
}

static void any_number_of_threads_gives_the_same_bytes(void **state)
{
    (void)state;
    uint64_t hash[2];
    for (int k = 0; k < 2; k++) {
        world *w = world_begin(k + 1);
        world_sphere(w, world_material(w, translucent(0.8f, 0.1f)), v3(0, 0, 0), 0.5f, 3);
        rsv_punctual_light light = {
            .kind = RSV_PUNCTUAL_DIRECTIONAL, .direction = { 0, -1, 0 }, .intensity = { 1, 1, 1 }
        };
        assert_int_equal(rsv_scene_add_light(w->scene, &light), RSV_OK);
        assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
        rsv_light *solution = solve(w);
        rsv_image *shown = show(solution, 16, 4), *traced = trace(w, 16, 4, NULL);
        hash[k] = hash_bytes(HASH_START, rsv_image_pixels(shown, 0), 256 * sizeof(rsv_rgb));
        hash[k] = hash_bytes(hash[k], rsv_image_pixels(traced, 0), 256 * sizeof(rsv_rgb));
        rsv_image_destroy(shown);
        rsv_image_destroy(traced);
        rsv_light_destroy(solution);
        world_end(w);
    }
    assert_true(hash[0] == hash[1]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_sphere_in_a_furnace_shows_its_albedo),
        cmocka_unit_test(what_bakes_show_light_by_light_adds_up),
        cmocka_unit_test(operator_and_reference_agree),
        cmocka_unit_test(a_vanishing_mean_free_path_is_lambert),
        cmocka_unit_test(a_translucent_ball_keeps_the_balance_of_a_closed_box),
        cmocka_unit_test(what_lies_below_a_coat_does_not_change_its_reflection),
        cmocka_unit_test(any_number_of_threads_gives_the_same_bytes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
