/// Light of the sky that rows of G gather is stored on coarse elements, which must be split where it has a kink.
#include "light_fixture.h"
#include "solve/light.h"
#include "sources/polygon_irradiance.h"

#define HALF 1.0f   ///< side of the floor, halved
#define HEIGHT 0.4f ///< of the ceiling above it
#define HOLE 0.5f   ///< side of the hole in the ceiling, halved
#define STEPS 40

static void add_ceiling(world *w, uint32_t black)
{
    const float edge[4] = { -HALF, -HOLE, HOLE, HALF };
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            if (i != 1 || j != 1)
                world_quad(w, black, v3(edge[i], HEIGHT, edge[j]), v3(edge[i + 1], HEIGHT, edge[j]),
                    v3(edge[i + 1], HEIGHT, edge[j + 1]), v3(edge[i], HEIGHT, edge[j + 1]));
}

/// Chips far below, each with nodes of its own.
static void add_clutter(world *w, uint32_t material, int count)
{
    for (int k = 0; k < count; k++) {
        float x = 0.02f * (float)k, y = -1, s = 0.01f;
        world_quad(w, material, v3(x, y, 0), v3(x, y, s), v3(x + s, y, s), v3(x + s, y, 0));
    }
}

/// A dark floor in a low black box with a hole towards a sky of radiance 1. The floor's triangles are the first two.
static world *cellar(int clutter)
{
    static const rsv_rgb sky = { 1, 1, 1 };
    const rsv_environment environment = { .pixels = &sky, .width = 1, .height = 1, .intensity = 1 };
    const rsv_vec3 corner[4] = { v3(-HALF, 0, -HALF), v3(-HALF, 0, HALF), v3(HALF, 0, HALF),
        v3(HALF, 0, -HALF) };
    const rsv_vec3 up = v3(0, HEIGHT, 0);
    world *w = world_begin(2);
    rsv_material black = lambert_material(0, 0);
    black.double_sided = true;
    uint32_t ground = world_material(w, lambert_material(0.1f, 0)), wall = world_material(w, black);
    world_quad(w, ground, corner[0], corner[1], corner[2], corner[3]);
    for (int k = 0; k < 4; k++) {
        rsv_vec3 a = corner[k], b = corner[(k + 1) % 4];
        world_quad(w, wall, a, b, v3_add(b, up), v3_add(a, up));
    }
    add_ceiling(w, wall);
    add_clutter(w, ground, clutter);
    assert_int_equal(rsv_scene_set_environment(w->scene, &environment), RSV_OK);
    world_commit(w);
    return w;
}

/// Mean absolute difference between stored and exact irradiance over the floor, relative to the mean.
static double error_on_floor(const world *w, const rsv_light *solution)
{
    const rsv_vec3 hole[4] = { v3(-HOLE, HEIGHT, -HOLE), v3(HOLE, HEIGHT, -HOLE),
        v3(HOLE, HEIGHT, HOLE), v3(-HOLE, HEIGHT, HOLE) };
    const rsv_scene_view *view = w->transport.view;
    double sum = 0, difference = 0;
    for (uint32_t k = 0; k < STEPS * STEPS; k++) {
        uint32_t triangle = k % 2;
        float x, y, u, v;
        rsv_sobol_2d(k, 7, &x, &y);
        rsv_square_to_triangle(x, y, &u, &v);
        const uint32_t *c = view->triangle[triangle];
        rsv_vec3 p =
            v3_barycentric(view->position[c[0]], view->position[c[1]], view->position[c[2]], u, v);
        double exact = fabs((double)rsv_polygon_irradiance(hole, 4, p, v3(0, 1, 0)));
        rsv_rgb stored = rsv_light_irradiance(solution, triangle, u, v, false, 0);
        sum += exact;
        difference += fabs((double)stored.g - exact);
    }
    return difference / sum;
}

/// @param pilots that may split elements
static double error_after(const world *w, uint32_t pilots)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_MEDIUM);
    desc.element_target = 100;
    desc.rays_per_element = 4096;
    desc.refinements = pilots;
    rsv_light *solution;
    assert_int_equal(rsv_light_create(w->scene, &desc, &solution), RSV_OK);
    double error = error_on_floor(w, solution);
    print_message("%u pilots: mean error %.1f %%, %zu rows\n", pilots, 100 * error,
        rsv_light_report(solution)->rows);
    rsv_light_destroy(solution);
    return error;
}

/// Three pilots halve elements three times, so the error could fall to a 64th. Noise and averages over nodes leave a
/// third of it.
static void check(int clutter)
{
    world *w = cellar(clutter);
    double without = error_after(w, 0), with = error_after(w, 3);
    assert_true(with < without / 3);
    world_end(w);
}

static void elements_are_split_where_the_sky_is_seen_in_part(void **state)
{
    (void)state;
    check(0);
}

static void surfaces_with_many_rows_leave_some_for_that(void **state)
{
    (void)state;
    check(200);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(elements_are_split_where_the_sky_is_seen_in_part),
        cmocka_unit_test(surfaces_with_many_rows_leave_some_for_that),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
