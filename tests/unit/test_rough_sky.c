/// A matt or glossy plate under a hole in a black ceiling: rough lobes look for the sky where rows of G saw it.
#include "light_fixture.h"
#include "render/rough_aim.h"
#include "resolvent/render.h"

#define SIDE 32
#define SAMPLES 32
/// The hole reaches from LOW to HIGH along x and z.
#define LOW (-0.7f)
#define HIGH 0.1f

static const rsv_vec3 eye = { 0.4f, -0.4f, 0.6f }, spot = { 0.05f, -1, 0.1f };

static void add_ceiling(world *w, uint32_t black)
{
    const float edge[4] = { -1, LOW, HIGH, 1 };
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            if (i != 1 || j != 1)
                world_quad(w, black, v3(edge[i], 1, edge[j]), v3(edge[i + 1], 1, edge[j]),
                    v3(edge[i + 1], 1, edge[j + 1]), v3(edge[i], 1, edge[j + 1]));
}

/// Under a sky of radiance 1. The camera sees a coin-sized patch of the plate.
static world *room_with_skylight(float roughness)
{
    static const rsv_rgb sky = { 1, 1, 1 };
    const rsv_environment environment = { .pixels = &sky, .width = 1, .height = 1, .intensity = 1 };
    const rsv_vec3 corner[4] = { v3(-1, 0, -1), v3(-1, 0, 1), v3(1, 0, 1), v3(1, 0, -1) };
    const rsv_vec3 down = v3(0, -1, 0), up = v3(0, 1, 0);
    world *w = world_begin(2);
    rsv_material floor = rsv_default_material(), black = lambert_material(0, 0);
    floor.roughness = roughness;
    floor.base_color = rgb_gray(0.2f);
    black.double_sided = true;
    uint32_t wall = world_material(w, black), ground = world_material(w, floor);
    for (int k = 0; k < 4; k++) {
        rsv_vec3 a = corner[k], b = corner[(k + 1) % 4];
        world_quad(w, wall, v3_add(a, down), v3_add(b, down), v3_add(b, up), v3_add(a, up));
    }
    const float left = spot.x - 0.2f, right = spot.x + 0.2f, far = spot.z - 0.2f,
                near = spot.z + 0.2f;
    world_quad(
        w, ground, v3(left, -1, far), v3(left, -1, near), v3(right, -1, near), v3(right, -1, far));
    add_ceiling(w, wall);
    assert_int_equal(rsv_scene_set_environment(w->scene, &environment), RSV_OK);
    rsv_camera camera = rsv_camera_look_at("eye", eye, spot, 0.02f, 1);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    world_commit(w);
    return w;
}

/// Radiance that the rough lobe sends to the eye: its response, integrated over the hole.
static double reflected(const rsv_bsdf *bsdf)
{
    enum { STEPS = 200 };
    const rsv_vec3 normal = v3(0, 1, 0), wo = v3_normalize(v3_sub(eye, spot));
    double sum = 0, step = (double)(HIGH - LOW) / STEPS;
    for (int k = 0; k < STEPS * STEPS; k++) {
        rsv_vec3 at =
            v3(LOW + (float)((k % STEPS + 0.5) * step), 1, LOW + (float)((k / STEPS + 0.5) * step));
        rsv_vec3 towards = v3_sub(at, spot), wi = v3_normalize(towards);
        rsv_bsdf_value value = rsv_bsdf_evaluate(bsdf, wi, wo, normal, true, RSV_LOBES_ROUGH);
        sum += (double)(value.response.g * wi.y / v3_dot(towards, towards)) * step * step;
    }
    return sum;
}

/// Mean and variance over the picture of what rough lobes alone show. @param aimed whether they look for the sky
static void measure(const rsv_light *solution, bool aimed, double *mean, double *variance)
{
    rsv_render_desc desc = rsv_default_render_desc();
    rsv_image *image;
    double sum = 0, squares = 0;
    desc.mode = RSV_RENDER_FINAL;
    desc.width = desc.height = SIDE;
    desc.samples = SAMPLES;
    desc.layers = true;
    desc.shared_pattern = !aimed;
    assert_int_equal(rsv_render(solution, &desc, &image), RSV_OK);
    const rsv_rgb *pixel = rsv_image_const_pixels(image, 1);
    for (int k = 0; k < SIDE * SIDE; k++) {
        sum += (double)pixel[k].g;
        squares += (double)pixel[k].g * (double)pixel[k].g;
    }
    *mean = sum / (SIDE * SIDE);
    *variance = squares / (SIDE * SIDE) - *mean * *mean;
    rsv_image_destroy(image);
}

/// @param gain least factor between variances by chance and by aiming
static void check(float roughness, double gain)
{
    world *w = room_with_skylight(roughness);
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.rays_per_element = 1024;
    desc.element_target = 1000;
    rsv_light *solution;
    assert_int_equal(rsv_light_create(w->scene, &desc, &solution), RSV_OK);
    double mean[2], variance[2], expected = reflected(&w->bsdf[1]);
    for (int aimed = 0; aimed < 2; aimed++)
        measure(solution, aimed, &mean[aimed], &variance[aimed]);
    double error = sqrt(variance[1]) / SIDE;
    print_message("roughness %g: %g, aimed %g +- %g, by chance %g; variance %g : %g\n",
        (double)roughness, expected, mean[1], error, mean[0], variance[0], variance[1]);
    assert_true(error < 0.01 * expected);
    assert_close(mean[1], expected, 3 * error + 1e-3 * expected);
    assert_true(variance[0] > gain * variance[1]);
    rsv_light_destroy(solution);
    world_end(w);
}

static void a_matt_coat_finds_the_sky(void **state)
{
    (void)state;
    check(1, 20);
}

static void a_glossy_coat_finds_the_sky(void **state)
{
    (void)state;
    check(0.5f, 8);
}

/// A direction is drawn as often as its density says: the density's integral over the sphere is 1, and that of what was
/// drawn is the solid angle drawn from.
static void aims_have_the_density_that_they_say(void **state)
{
    (void)state;
    world *w = room_with_skylight(0.6f);
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.rays_per_element = 1024;
    desc.element_target = 1000;
    rsv_light *solution;
    rsv_sky_visibility *visibility;
    rsv_sky_aim aim;
    assert_int_equal(rsv_light_create(w->scene, &desc, &solution), RSV_OK);
    assert_int_equal(rsv_sky_visibility_create(rsv_light_get_view(solution), &visibility), RSV_OK);
    const rsv_vec3 up = v3(0, 1, 0), wo = v3_normalize(v3_sub(eye, spot));
    rsv_sky_aim_at(visibility, &visibility->visible[0], &w->bsdf[1], wo, up, &aim);
    assert_true(aim.count > 0);
    const uint32_t count = 1 << 18;
    double whole = 0, covered = 0, drawn = 0;
    for (uint32_t k = 0; k < count; k++) {
        float x, y;
        rsv_sobol_2d(k, 5, &x, &y);
        float pdf = rsv_sky_aim_pdf(&aim, rsv_square_to_sphere(x, y));
        whole += 4 * M_PI * (double)pdf / count;
        covered += pdf > 0 ? 4 * M_PI / count : 0;
        const float u[3] = { rsv_unit_float(rsv_hash(k)), x, y };
        pdf = rsv_sky_aim_pdf(&aim, rsv_sky_aim_sample(&aim, u));
        drawn += pdf > 0 ? 1 / (double)pdf / count : 0;
    }
    assert_close(whole, 1, 5e-3);
    assert_close(drawn, covered, 5e-3 * covered);
    rsv_sky_visibility_destroy(visibility);
    rsv_light_destroy(solution);
    world_end(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_matt_coat_finds_the_sky),
        cmocka_unit_test(a_glossy_coat_finds_the_sky),
        cmocka_unit_test(aims_have_the_density_that_they_say),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
