/// Least squares within bounds, and strengths of lights that reach target readings.
#include "core/sampling.h"
#include "file_fixture.h"
#include "fit/bounded.h"

#include "resolvent/fit.h"
#include "resolvent/relight.h"

#include <math.h>

static void ok(rsv_status status)
{
    if (status != RSV_OK) fail_msg("%s", rsv_last_error());
}

// ---- bounded least squares --------------------------------------------------------------------------

enum { ROWS = 30, COLUMNS = 9 };

typedef struct problem {
    double a[ROWS * COLUMNS], b[ROWS], weight[ROWS], cost[COLUMNS], low[COLUMNS], high[COLUMNS];
} problem;

static problem random_problem(uint32_t seed, bool dependent)
{
    problem p;
    rsv_random random = rsv_random_from(seed, 0, 0);
    for (int i = 0; i < ROWS; i++) {
        p.b[i] = (double)rsv_random_float(&random) * 2;
        p.weight[i] = (double)rsv_random_float(&random);
        for (int k = 0; k < COLUMNS; k++)
            p.a[i * COLUMNS + k] = (double)rsv_random_float(&random);
        if (dependent) p.a[i * COLUMNS + 1] = 2 * p.a[i * COLUMNS];
    }
    for (int k = 0; k < COLUMNS; k++) {
        p.cost[k] = 0.01 * (double)rsv_random_float(&random);
        p.low[k] = k % 3 == 0 ? 0.1 : 0;
        p.high[k] = k % 4 == 0 ? 0.2 : 5;
    }
    return p;
}

/// The conditions of a minimum, by definition, however it was found.
static void check_minimum(const problem *p, bool one_sided, const double *x)
{
    double gradient[COLUMNS];
    memcpy(gradient, p->cost, sizeof gradient);
    for (int i = 0; i < ROWS; i++) {
        double e = -p->b[i];
        for (int k = 0; k < COLUMNS; k++)
            e += p->a[i * COLUMNS + k] * x[k];
        for (int k = 0; k < COLUMNS && (!one_sided || e < 0); k++)
            gradient[k] += p->weight[i] * e * p->a[i * COLUMNS + k];
    }
    for (int k = 0; k < COLUMNS; k++) {
        assert_true(x[k] >= p->low[k] && x[k] <= p->high[k]);
        if (x[k] > p->low[k]) assert_true(gradient[k] < 1e-6);
        if (x[k] < p->high[k]) assert_true(gradient[k] > -1e-6);
    }
}

static void minima_meet_their_conditions(void **state)
{
    fixture *f = *state;
    for (uint32_t seed = 0; seed < 400; seed++) {
        bool one_sided = seed & 1, dependent = seed & 2;
        problem p = random_problem(seed, dependent);
        double x[COLUMNS] = { 0 };
        rsv_bounded_report report;
        const rsv_bounded bounded = { f->context, ROWS, COLUMNS, p.a, p.b, p.weight, p.cost, p.low,
            p.high, one_sided };
        ok(rsv_bounded_solve(&bounded, x, &report));
        if (!(report.kkt_residual < 1e-7))
            fail_msg("problem %u: residual %g after %u steps", seed, report.kkt_residual,
                report.iterations);
        check_minimum(&p, one_sided, x);
    }
}

static void columns_that_change_nothing_go_where_they_cost_least(void **state)
{
    fixture *f = *state;
    const double a[2] = { 1, 0 }, b[1] = { 0.5 }, weight[1] = { 1 }, cost[2] = { 0, 1 },
                 low[2] = { 0, 0 }, high[2] = { 1, 1 };
    double x[2] = { 1, 1 };
    rsv_bounded_report report;
    ok(rsv_bounded_solve(
        &(rsv_bounded){ f->context, 1, 2, a, b, weight, cost, low, high, false }, x, &report));
    assert_float_equal(x[0], 0.5, 1e-9);
    assert_float_equal(x[1], 0, 1e-9);
}

// ---- lights -----------------------------------------------------------------------------------------

enum { POINTS = 12 };

/// TINTED: grey but for rounding.
typedef enum room_kind { COLOURED, MIRROR, GREY, TINTED } room_kind;

/// A floor and a wall under three point lights; where all is grey, so are the lights.
static rsv_light *room_of(rsv_context *context, room_kind kind, rsv_scene **scene)
{
    static const float corner[8][3] = { { -2, 0, -2 }, { -2, 0, 2 }, { 2, 0, 2 }, { 2, 0, -2 },
        { -2, 0, -2 }, { 2, 0, -2 }, { 2, 3, -2 }, { -2, 3, -2 } };
    static const uint32_t index[12] = { 0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7 };
    static const float identity[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    rsv_material grey = rsv_default_material();
    rsv_light *light;
    uint32_t material, mesh;
    bool mirror = kind == MIRROR;
    grey.base_color = kind < GREY ? rgb(0.6f, 0.5f, 0.4f) : rgb_gray(0.5f);
    if (kind == TINTED) grey.base_color.b = nextafterf(0.5f, 1);
    grey.specular = 0;
    grey.metallic = mirror ? 1 : 0;
    grey.roughness = mirror ? 0 : 1;
    ok(rsv_scene_create(context, scene));
    ok(rsv_scene_add_material(*scene, &grey, &material));
    ok(rsv_scene_add_mesh(*scene,
        &(rsv_mesh_desc){ .size = sizeof(rsv_mesh_desc),
            .name = "room",
            .positions = (const rsv_vec3 *)corner,
            .vertex_count = 8,
            .indices = index,
            .triangle_count = 4,
            .material = material },
        &mesh));
    ok(rsv_scene_add_instance(*scene, mesh, identity, NULL));
    static const char *const name[3] = { "left", "middle", "right" };
    for (int k = 0; k < 3; k++)
        ok(rsv_scene_add_light(
            *scene, &(rsv_punctual_light){ .name = name[k],
                        .kind = RSV_PUNCTUAL_POINT,
                        .position = { 1.3f * (float)(k - 1), 2, 0.3f },
                        .intensity = kind >= GREY ? rgb_gray(1.5f) : rgb(1, 1.5f, 2) }));
    ok(rsv_scene_commit(*scene));
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    ok(rsv_light_create(*scene, &desc, &light));
    return light;
}

static rsv_light *room(rsv_context *context, rsv_scene **scene)
{
    return room_of(context, COLOURED, scene);
}

static void place_points(rsv_fit_wanted wanted[POINTS])
{
    for (int k = 0; k < POINTS; k++)
        wanted[k] = (rsv_fit_wanted){
            .probe = { v3(-1.6f + 0.3f * (float)k, 0.8f, 0.25f * (float)(k % 5) - 0.5f),
                v3(0, 1, 0) },
            .weight = 1
        };
}

static float lux_of(rsv_rgb e) { return 683 * rgb_luminance(e); }

/// Readings at the points with the fitted factors, by relighting and path tracing, as the reference.
static void judge(const rsv_light *light, const rsv_rgb factor[3],
    const rsv_fit_wanted wanted[POINTS], rsv_probe_reading reading[POINTS])
{
    rsv_light *lit;
    rsv_probe probe[POINTS];
    const rsv_light_scale scale[3] = { { "left", factor[0] }, { "middle", factor[1] },
        { "right", factor[2] } };
    for (int k = 0; k < POINTS; k++)
        probe[k] = wanted[k].probe;
    ok(rsv_light_copy(light, &lit));
    ok(rsv_light_relight(lit,
        &(rsv_relight_desc){ .size = sizeof(rsv_relight_desc), .light = scale, .light_count = 3 }));
    ok(rsv_probe_reference(rsv_light_scene(lit), probe, POINTS, 65536, 0, reading));
    rsv_light_destroy(lit);
}

static void find_factors_again(fixture *f, room_kind kind)
{
    const rsv_rgb truth[3] = { rgb_gray(0.3f), rgb_gray(0.9f), rgb_gray(0.05f) };
    rsv_scene *scene;
    rsv_light *light = room_of(f->context, kind, &scene);
    rsv_fit_wanted wanted[POINTS];
    rsv_probe_reading reading[POINTS];
    rsv_fit *fit;
    rsv_fit_desc desc = rsv_default_fit_desc();
    desc.samples = 4096;
    place_points(wanted);
    judge(light, truth, wanted, reading);
    for (int k = 0; k < POINTS; k++)
        wanted[k].reading.r = lux_of(reading[k].irradiance);
    ok(rsv_fit_create(light, wanted, POINTS, &desc, &fit));
    rsv_fit_report report = rsv_fit_get_report(fit);
    assert_int_equal(rsv_fit_light_count(fit), 3);
    for (size_t k = 0; k < 3; k++)
        assert_float_equal(rsv_fit_get_light(fit, k).factor.r, truth[k].r, 0.01);
    for (size_t k = 0; k < POINTS; k++)
        assert_float_equal(
            rsv_fit_reading(fit, k).r, wanted[k].reading.r, 0.005 * wanted[k].reading.r);
    assert_true(report.kkt_residual < 1e-4 && report.error_rms < 0.005);
    assert_float_equal(report.lumens / report.lumens_before, 1.25 / 3, 0.01);
    rsv_fit_destroy(fit);
    rsv_light_destroy(light);
    rsv_scene_destroy(scene);
}

static void factors_that_made_readings_are_found_again(void **state)
{
    find_factors_again(*state, COLOURED);
}

/// What mirrors send of lamps is in the readings, too.
static void lamps_in_mirrors_count(void **state) { find_factors_again(*state, MIRROR); }

/// Where nothing has a colour, three lights share a field of the solve. The slightest tint separates them, without
/// changing the results.
static void grey_lights_are_solved_as_coloured_ones(void **state)
{
    fixture *f = *state;
    rsv_rgb reading[2][POINTS];
    for (int k = 0; k < 2; k++) {
        rsv_scene *scene;
        rsv_light *light = room_of(f->context, k ? TINTED : GREY, &scene);
        rsv_fit_wanted wanted[POINTS];
        rsv_fit *fit;
        rsv_fit_desc desc = rsv_default_fit_desc();
        place_points(wanted);
        for (int p = 0; p < POINTS; p++)
            wanted[p].reading.r = 20 * (float)(p + 1);
        ok(rsv_fit_create(light, wanted, POINTS, &desc, &fit));
        for (size_t p = 0; p < POINTS; p++)
            reading[k][p] = rsv_fit_reading(fit, p);
        rsv_fit_destroy(fit);
        rsv_light_destroy(light);
        rsv_scene_destroy(scene);
    }
    for (int p = 0; p < POINTS; p++)
        assert_float_equal(reading[1][p].r, reading[0][p].r, 1e-5 * reading[0][p].r);
}

static void colours_are_found_channel_by_channel(void **state)
{
    fixture *f = *state;
    const rsv_rgb truth[3] = { rgb(0.2f, 0.6f, 0), rgb(1, 0.4f, 0.3f), rgb(0.5f, 0.1f, 0.8f) };
    rsv_scene *scene;
    rsv_light *light = room(f->context, &scene);
    rsv_fit_wanted wanted[POINTS];
    rsv_probe_reading reading[POINTS];
    rsv_fit *fit;
    rsv_fit_desc desc = rsv_default_fit_desc();
    desc.samples = 4096;
    desc.colors = true;
    place_points(wanted);
    judge(light, truth, wanted, reading);
    for (int k = 0; k < POINTS; k++)
        wanted[k].reading = reading[k].irradiance;
    ok(rsv_fit_create(light, wanted, POINTS, &desc, &fit));
    for (size_t k = 0; k < 3; k++) {
        rsv_rgb found = rsv_fit_get_light(fit, k).factor;
        assert_float_equal(found.r, truth[k].r, 0.015);
        assert_float_equal(found.g, truth[k].g, 0.015);
        assert_float_equal(found.b, truth[k].b, 0.015);
    }
    rsv_fit_destroy(fit);
    rsv_light_destroy(light);
    rsv_scene_destroy(scene);
}

/// Targets above what all lights give: the result is as bright as the bounds allow, and is reported. Kept lights do not
/// change.
static void what_cannot_be_met_is_told(void **state)
{
    fixture *f = *state;
    rsv_scene *scene;
    rsv_light *light = room(f->context, &scene);
    rsv_fit_wanted wanted[POINTS];
    rsv_fit *fit;
    rsv_fit_desc desc = rsv_default_fit_desc();
    const char *keep = "mid*";
    desc.highest = 0.5;
    desc.keep = &keep, desc.keep_count = 1;
    place_points(wanted);
    for (int k = 0; k < POINTS; k++)
        wanted[k].reading.r = 1e5f;
    ok(rsv_fit_create(light, wanted, POINTS, &desc, &fit));
    for (size_t k = 0; k < 3; k++)
        assert_float_equal(rsv_fit_get_light(fit, k).factor.r, k == 1 ? 1 : 0.5f, 1e-6);
    rsv_fit_report report = rsv_fit_get_report(fit);
    assert_float_equal(report.error_largest, 1e5 - (double)rsv_fit_reading(fit, report.worst).r, 1);
    assert_true(report.error_rms > 0.9);
    rsv_fit_destroy(fit);
    // the targets are below the light of the kept one: with at_least, they are met, and the other lights are off
    desc.at_least = true;
    for (int k = 0; k < POINTS; k++)
        wanted[k].reading.r = 1;
    ok(rsv_fit_create(light, wanted, POINTS, &desc, &fit));
    assert_float_equal(rsv_fit_get_light(fit, 0).factor.r, 0, 1e-6);
    assert_float_equal(rsv_fit_get_report(fit).error_largest, 0, 0);
    rsv_fit_destroy(fit);
    rsv_light_destroy(light);
    rsv_scene_destroy(scene);
}

static void wrong_wishes_are_refused(void **state)
{
    fixture *f = *state;
    rsv_scene *scene;
    rsv_light *light = room(f->context, &scene);
    rsv_fit_wanted wanted[POINTS];
    rsv_fit *fit;
    const rsv_fit_desc usual = rsv_default_fit_desc();
    rsv_fit_desc desc = usual;
    const char *unknown = "chandelier", *all = "*";
    place_points(wanted);
    assert_int_equal(rsv_fit_create(light, wanted, 0, &desc, &fit), RSV_ERROR_ARGUMENT);
    assert_int_equal(rsv_fit_create(light, wanted, POINTS, &desc, &fit), RSV_ERROR_ARGUMENT);
    wanted[3].reading.r = 100;
    desc.lowest = 2;
    assert_int_equal(rsv_fit_create(light, wanted, POINTS, &desc, &fit), RSV_ERROR_ARGUMENT);
    desc = usual, desc.keep = &unknown, desc.keep_count = 1;
    assert_int_equal(rsv_fit_create(light, wanted, POINTS, &desc, &fit), RSV_ERROR_ARGUMENT);
    assert_mentions(rsv_last_error(), "chandelier");
    desc.keep = &all;
    assert_int_equal(rsv_fit_create(light, wanted, POINTS, &desc, &fit), RSV_ERROR_ARGUMENT);
    wanted[5].reading.r = -1;
    assert_int_equal(rsv_fit_create(light, wanted, POINTS, &usual, &fit), RSV_ERROR_ARGUMENT);
    assert_mentions(rsv_last_error(), "point 6");
    rsv_light_destroy(light);
    rsv_scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(
            minima_meet_their_conditions, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            columns_that_change_nothing_go_where_they_cost_least, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            factors_that_made_readings_are_found_again, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(lamps_in_mirrors_count, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            grey_lights_are_solved_as_coloured_ones, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            colours_are_found_channel_by_channel, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            what_cannot_be_met_is_told, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(wrong_wishes_are_refused, fixture_setup, fixture_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
