/// A lamp that covers a thousandth of what is behind it, between a camera and the floor that it lights: exact answers.
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

static double picture(const world *w, const rsv_light *solution, rsv_render_mode mode)
{
    rsv_render_desc desc = rsv_default_render_desc();
    rsv_image *image;
    desc.width = desc.height = SIDE;
    desc.mode = mode;
    desc.samples = mode == RSV_RENDER_REFERENCE ? 256 : 64;
    rsv_status status = mode == RSV_RENDER_REFERENCE
                            ? rsv_render_reference(w->scene, &desc, &image, NULL)
                            : rsv_render(solution, &desc, &image);
    assert_int_equal(status, RSV_OK);
    double mean = mean_of(image);
    rsv_image_destroy(image);
    return mean;
}

static void check_lamp(float camera_emission)
{
    static const rsv_render_mode modes[] = { RSV_RENDER_REFERENCE, RSV_RENDER_FINAL,
        RSV_RENDER_OPERATOR };
    world *w = floor_below_lamp(camera_emission);
    rsv_solve_desc solve = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_light *solution;
    assert_int_equal(rsv_light_create(w->scene, &solve, &solution), RSV_OK);
    double expected = camera_emission + (1 - COVERAGE) * floor_radiance();
    for (size_t m = 0; m < sizeof modes / sizeof *modes; m++) {
        double found = picture(w, solution, modes[m]);
        print_message("mode %d: %.5f, expected %.5f\n", (int)modes[m], found, expected);
        bool coarse = modes[m] == RSV_RENDER_OPERATOR;
        assert_float_equal(
            found, expected, (coarse ? TOLERANCE_OF_ELEMENTS : TOLERANCE) * floor_radiance());
    }
    rsv_light_destroy(solution);
    world_end(w);
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
    check_lamp(1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cameras_look_through_hidden_lamps),
        cmocka_unit_test(cameras_see_a_share_of_the_emission),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
