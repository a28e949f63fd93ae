/// A lamp between the camera and the floor that it lights, which covers a thousandth of the background: exact answers.
#include "resolvent/frame.h"
#include "resolvent/render.h"
#include "resolvent/solve.h"
#include "unit/light_fixture.h"

#define COVERAGE 1e-3f
#define ALBEDO 0.5f
#define HALF_SIDE 0.5
#define SIDE 16
#define TOLERANCE 2e-3
#define TOLERANCE_OF_ELEMENTS 1e-2 ///< they flatten the peak below the lamp

/// A square lamp of both sides and radiance 1, one metre above a floor; a camera above both looks straight down.
static world *floor_below_lamp(float camera_emission)
{
    world *w = world_begin(2);
    rsv_material floor = rsv_default_material();
    floor.specular = 0;
    floor.base_color = rgb_gray(ALBEDO);
    world_quad(w, world_material(w, floor), v3(-4, 0, 4), v3(4, 0, 4), v3(4, 0, -4), v3(-4, 0, -4));
    rsv_material lamp = floor;
    lamp.base_color = rgb_gray(0);
    lamp.emission = rgb_gray(1 / COVERAGE);
    lamp.opacity = COVERAGE;
    lamp.double_sided = true;
    lamp.camera_emission = camera_emission;
    float a = (float)HALF_SIDE;
    world_quad(w, world_material(w, lamp), v3(-a, 1, -a), v3(a, 1, -a), v3(a, 1, a), v3(-a, 1, a));
    rsv_camera camera = rsv_camera_look_at("eye", v3(0, 2, 0), v3(0, 0, 1e-4f), 0.02f, 1);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    world_commit(w);
    return w;
}

/// Radiance of the floor below the middle of the lamp: the form factor of a square.
static double floor_radiance(void)
{
    double s = sqrt(HALF_SIDE * HALF_SIDE + 1);
    return ALBEDO / 3.14159265358979 * 4 * HALF_SIDE / s * atan(HALF_SIDE / s);
}

static double mean_of(const rsv_image *image)
{
    const rsv_rgb *pixel = rsv_image_const_pixels(image, 0);
    double sum = 0;
    for (size_t i = 0; i < SIDE * SIDE; i++)
        sum += (double)pixel[i].g;
    return sum / (SIDE * SIDE);
}

/// Ways to make a picture: the modes of rsv_render, then frames.
typedef enum way { REFERENCE, FINAL, OPERATOR, FRAMES, GLOSSY_FRAMES, WAYS } way;

static rsv_status render(const world *w, const rsv_light *solution, way by, rsv_image **image)
{
    static const rsv_render_mode mode[WAYS] = { RSV_RENDER_REFERENCE, RSV_RENDER_FINAL,
        RSV_RENDER_OPERATOR, RSV_RENDER_OPERATOR, RSV_RENDER_OPERATOR };
    rsv_render_desc desc = rsv_default_render_desc();
    desc.width = desc.height = SIDE;
    desc.mode = mode[by];
    desc.samples = by == REFERENCE ? 256 : by >= FRAMES ? 8 : 64;
    if (by == REFERENCE) return rsv_render_reference(w->scene, &desc, image, NULL);
    if (by < FRAMES) return rsv_render(solution, &desc, image);
    return rsv_render_operator(
        solution, &desc, by == FRAMES ? RSV_GLOSS_PATHS : RSV_GLOSS_REUSED, image);
}

static double picture(const world *w, const rsv_light *solution, way by)
{
    rsv_image *image;
    assert_int_equal(render(w, solution, by, &image), RSV_OK);
    double mean = mean_of(image);
    rsv_image_destroy(image);
    return mean;
}

/// All ways show a mean of `expected`; frames and mode operator as well as elements can hold the light.
/// @param noise that the path tracer may have
static void compare(world *w, double expected, double noise)
{
    rsv_solve_desc solve = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_light *solution;
    assert_int_equal(rsv_light_create(w->scene, &solve, &solution), RSV_OK);
    for (way by = REFERENCE; by < WAYS; by++) {
        double found = picture(w, solution, by);
        print_message("way %d: %.5f, expected %.5f\n", (int)by, found, expected);
        double tolerance = (by >= OPERATOR ? TOLERANCE_OF_ELEMENTS : TOLERANCE) * floor_radiance();
        assert_float_equal(found, expected, tolerance + (by == REFERENCE ? noise : 0));
    }
    rsv_light_destroy(solution);
    world_end(w);
}

static void check_lamp(float camera_emission)
{
    compare(
        floor_below_lamp(camera_emission), camera_emission + (1 - COVERAGE) * floor_radiance(), 0);
}

static void cameras_look_through_hidden_lamps(void **state)
{
    (void)state;
    check_lamp(0);
}

static void cameras_see_a_share_of_the_emission(void **state)
{
    (void)state;
    check_lamp(0.25f);
}

/// What a camera sees of a lamp of radiance 1 that covers all behind it: straight, through a pane that passes half, or in
/// a mirror that turns the view by 90 degrees.
typedef enum sight { STRAIGHT, BEHIND_A_PANE, IN_A_MIRROR } sight;

static world *opaque_lamp(sight seen, float camera_emission)
{
    world *w = world_begin(2);
    rsv_material lamp = rsv_default_material(), pane = lamp;
    lamp.specular = pane.specular = 0;
    lamp.base_color = pane.base_color = rgb_gray(0);
    lamp.emission = rgb_gray(1);
    lamp.double_sided = pane.double_sided = true;
    lamp.camera_emission = camera_emission;
    pane.opacity = 0.5f;
    rsv_material mirror = rsv_default_material();
    mirror.metallic = 1;
    mirror.roughness = 0;
    mirror.base_color = rgb_gray(1);
    mirror.double_sided = true;
    uint32_t shining = world_material(w, lamp);
    if (seen == IN_A_MIRROR)
        world_quad(w, shining, v3(2, -3, 3), v3(2, -3, -3), v3(2, 3, -3), v3(2, 3, 3));
    else
        world_quad(w, shining, v3(-3, 0, 3), v3(3, 0, 3), v3(3, 0, -3), v3(-3, 0, -3));
    if (seen == BEHIND_A_PANE)
        world_quad(
            w, world_material(w, pane), v3(-1, 1, 1), v3(1, 1, 1), v3(1, 1, -1), v3(-1, 1, -1));
    if (seen == IN_A_MIRROR)
        world_quad(
            w, world_material(w, mirror), v3(-1, 1, 1), v3(1, -1, 1), v3(1, -1, -1), v3(-1, 1, -1));
    rsv_camera camera = rsv_camera_look_at("eye", v3(0, 2, 0), v3(0, 0, 1e-4f), 0.02f, 1);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    world_commit(w);
    return w;
}

/// Hidden from the camera, but not from its mirrors.
static void opaque_lamps_are_hidden_too(void **state)
{
    (void)state;
    // each of the path tracer's samples passes the pane or not: four standard deviations
    double noise = 4 * 0.5 / sqrt(256.0 * SIDE * SIDE);
    compare(opaque_lamp(STRAIGHT, 0), 0, 0);
    compare(opaque_lamp(BEHIND_A_PANE, 0.25f), 0.125, 0.25 * noise);
    compare(opaque_lamp(IN_A_MIRROR, 0), 1, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cameras_look_through_hidden_lamps),
        cmocka_unit_test(cameras_see_a_share_of_the_emission),
        cmocka_unit_test(opaque_lamps_are_hidden_too),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
