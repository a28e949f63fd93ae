/// The inside of solid bodies: receivers, lamps and cameras in glass and in tinted media, in mode operator
/// and in the reference, compared with exact answers.
#include "resolvent/render.h"
#include "resolvent/solve.h"
#include "unit/light_fixture.h"

/// Relative tolerance; readings may also deviate by their own noise.
#define TOLERANCE 5e-3
#define STANDARD_ERRORS 4

/// E3(1/2), the exponential integral: Abramowitz and Stegun (1964), table 5.4.
#define E3_OF_HALF 0.2216044

static rsv_material body_material(float ior, float transmittance_per_metre)
{
    rsv_material material = glass_material();
    material.ior = ior;
    material.attenuation_color = rgb_gray(transmittance_per_metre);
    material.attenuation_distance = 1;
    return material;
}

static rsv_light *solve_world(const world *w)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_light *solution;
    assert_int_equal(rsv_light_create(w->scene, &desc, &solution), RSV_OK);
    return solution;
}

/// Mean of the readings of both modes must be as expected.
static void check_probes(
    const world *w, const rsv_probe *probe, size_t count, uint32_t samples, double expected)
{
    rsv_probe_reading *reading = calloc(count, sizeof *reading);
    rsv_light *solution = solve_world(w);
    for (int reference = 0; reference < 2; reference++) {
        if (reference)
            assert_int_equal(
                rsv_probe_reference(w->scene, probe, count, samples, 5, reading), RSV_OK);
        else
            assert_int_equal(
                rsv_probe_irradiance(solution,
                    &(rsv_probe_desc){ sizeof(rsv_probe_desc), RSV_PROBE_OPERATOR, samples, 5 },
                    probe, count, reading),
                RSV_OK);
        double sum = 0, variance = 0;
        for (size_t k = 0; k < count; k++) {
            sum += (double)reading[k].irradiance.g;
            variance += (double)reading[k].standard_error.g * (double)reading[k].standard_error.g;
        }
        double mean = sum / (double)count, error = sqrt(variance) / (double)count;
        print_message("%s %.5f +- %.5f, expected %.5f\n", reference ? "reference" : "operator",
            mean, error, expected);
        assert_close(mean, expected, TOLERANCE * expected + STANDARD_ERRORS * error);
    }
    rsv_light_destroy(solution);
    free(reading);
}

/// Radiance grows by ior^2 where it enters a body, and so does the irradiance of a white ball inside.
static void furnaces_fill_glass_with_denser_light(void **state)
{
    (void)state;
    const float ior = 1.5f, radiance = 1, albedo = 0.5f;
    world *w = world_begin(2);
    world_room(w, world_lambert(w, albedo, radiance), v3(-2, -2, -2), v3(2, 2, 2));
    world_sphere(w, world_material(w, body_material(ior, 1)), v3(0, 0, 0), 1, 4);
    world_sphere(w, world_lambert(w, 1, 0), v3(0, 0, 0), 0.5f, 4);
    world_commit(w);
    const rsv_probe probe[2] = { { v3(0, 0.51f, 0), v3(0, 1, 0) },
        { v3(1.5f, 1, 1), v3(1, 0, 0) } };
    double outside = (double)(RSV_PI * radiance / (1 - albedo));
    check_probes(w, &probe[0], 1, 8192, (double)(ior * ior) * outside);
    check_probes(w, &probe[1], 1, 2048, outside);
    world_end(w);
}

/// A white lamp in a glass ball, in a room where only the walls absorb: the walls absorb all light that leaves the
/// lamp.
static void lamps_in_glass_lose_nothing(void **state)
{
    (void)state;
    const float radiance = 10, albedo = 0.6f, radius = 0.25f;
    world *w = world_begin(2);
    world_room(w, world_lambert(w, albedo, 0), v3(-1, -1, -1), v3(1, 1, 1));
    world_sphere(w, world_material(w, body_material(1.5f, 1)), v3(0, 0, 0), 0.5f, 4);
    world_sphere(w, world_lambert(w, 1, radiance), v3(0, 0, 0), radius, 3);
    world_commit(w);
    const rsv_scene_view *view = rsv_scene_get_view(w->scene);
    double lamp = 0;
    for (size_t t = 0; t < view->triangle_count; t++)
        if (view->material[view->triangle_material[t]].emission.r > 0)
            lamp += (double)rsv_triangle_area(view, (uint32_t)t);
    enum { SIDE = 12 };
    rsv_probe probe[6 * SIDE * SIDE];
    for (int k = 0; k < 6 * SIDE * SIDE; k++) {
        float x = 2 * ((float)(k % SIDE) + 0.5f) / SIDE - 1;
        float y = 2 * ((float)(k / SIDE % SIDE) + 0.5f) / SIDE - 1;
        float side = k / (SIDE * SIDE) % 2 ? 1.0f : -1.0f;
        rsv_vec3 place[3] = { v3(side, x, y), v3(x, side, y), v3(x, y, side) };
        rsv_vec3 normal[3] = { v3(-side, 0, 0), v3(0, -side, 0), v3(0, 0, -side) };
        int axis = k / (2 * SIDE * SIDE);
        probe[k] = (rsv_probe){ place[axis], normal[axis] };
    }
    double expected = M_PI * (double)radiance * lamp / (24 * (double)(1 - albedo));
    check_probes(w, probe, 6 * SIDE * SIDE, 128, expected);
    world_end(w);
}

/// Two wide plates in a body of index 1, one of which emits: E = 2 M E3(absorption times distance).
static void tinted_bodies_dim_light_between_what_they_hold(void **state)
{
    (void)state;
    const float size = 6, distance = 1;
    world *w = world_begin(2);
    float passed = expf(-0.5f / distance);
    world_box(w, world_material(w, body_material(1, passed)), v3(-8, -1, -8), v3(8, 2, 8));
    world_quad(w, world_lambert(w, 0, 0), v3(-size, 0, size), v3(size, 0, size), v3(size, 0, -size),
        v3(-size, 0, -size));
    world_quad(w, world_lambert(w, 0, 1), v3(-size, distance, -size), v3(size, distance, -size),
        v3(size, distance, size), v3(-size, distance, size));
    world_commit(w);
    const rsv_probe probe = { v3(0.1f, 0, 0.2f), v3(0, 1, 0) };
    check_probes(w, &probe, 1, 16384, 2 * M_PI * E3_OF_HALF);
    world_end(w);
}

/// I exp(-a d) / d^2; the surface of the body reflects nothing.
static void tinted_bodies_dim_lights_inside(void **state)
{
    (void)state;
    world *w = world_begin(2);
    world_box(w, world_material(w, body_material(1, 0.5f)), v3(-4, -1, -4), v3(4, 3, 4));
    world_quad(w, world_lambert(w, 0, 0), v3(-3, 0, 3), v3(3, 0, 3), v3(3, 0, -3), v3(-3, 0, -3));
    rsv_punctual_light lamp = {
        .kind = RSV_PUNCTUAL_POINT, .position = v3(0, 2, 0), .intensity = rgb_gray(100)
    };
    assert_int_equal(rsv_scene_add_light(w->scene, &lamp), RSV_OK);
    world_commit(w);
    const rsv_probe probe = { v3(0, 0, 0), v3(0, 1, 0) };
    check_probes(w, &probe, 1, 64, 100 * 0.25 * 0.25);
    world_end(w);
}

/// Nested bodies: in the pocket between both surfaces the outer body absorbs, in the inner one that one does.
static void bodies_within_bodies_absorb_by_turns(void **state)
{
    (void)state;
    world *w = world_begin(1);
    uint32_t outer = world_material(w, body_material(1, 0.5f));
    uint32_t inner = world_material(w, body_material(1, 0.1f));
    world_box(w, outer, v3(-4, 0, -4), v3(4, 4, 4));
    world_box(w, inner, v3(-3, 1, -3), v3(3, 2, 3));
    world_quad(w, world_lambert(w, 0.5f, 0), v3(-2, 2.5f, 2), v3(2, 2.5f, 2), v3(2, 2.5f, -2),
        v3(-2, 2.5f, -2));
    world_commit(w);
    rsv_ray ray = { v3(0, -1, 0), v3(0, 1, 0), INFINITY };
    rsv_hit hit;
    rsv_specular_path path;
    assert_true(rsv_tracer_closest(w->tracer, &ray, &hit));
    path = rsv_specular_begin(&w->transport, NULL, ray.direction, hit);
    for (int k = 0; k < 3; k++)
        assert_int_equal(rsv_specular_step(&w->transport, &path, true, ray.direction, rgb_gray(1)),
            RSV_SPECULAR_MOVED);
    assert_close((double)path.weight.g, 0.5 * 0.1 * sqrt(0.5), 1e-5);
    assert_int_equal(path.medium.depth, 1);
    world_end(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(furnaces_fill_glass_with_denser_light),
        cmocka_unit_test(lamps_in_glass_lose_nothing),
        cmocka_unit_test(tinted_bodies_dim_light_between_what_they_hold),
        cmocka_unit_test(tinted_bodies_dim_lights_inside),
        cmocka_unit_test(bodies_within_bodies_absorb_by_turns),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
