/// Light for normals that are not the surface's own; charts in a map.
#include "bake/bake_directions.h"
#include "bake/bake_pack.h"
#include "bake/bake_stitch.h"
#include "bake/bake_texels.h"
#include "resolvent/render.h"
#include "unit/light_view.h"
#include "unit/scene_fixture.h"

#define TILT 0.5235988f // 30 degrees, not what the fit looks at
#define TURNS 4

/// Sums over places and channels.
typedef struct judgement {
    double flat, directional; ///< errors relative to what the surface's own normal reads
    size_t readings;
} judgement;

static float channel(rsv_rgb c, int k) { return k == 0 ? c.r : k == 1 ? c.g : c.b; }

/// Irradiance for a normal m, reconstructed as docs/bake-reference.md describes for shaders.
static float reconstruct(float e, const rsv_rgb v[3], rsv_vec3 m, int c)
{
    float along = m.x * channel(v[0], c) + m.y * channel(v[1], c) + m.z * channel(v[2], c);
    return f_max(0, e * (1 + along) / 2);
}

static void judge_place(const rsv_bake_directions *d, uint32_t triangle, judgement *j)
{
    const rsv_light_view *s = d->solution;
    const rsv_bake_receiver receiver = { .triangle = triangle, .u = 0.3f, .v = 0.4f };
    rsv_surface_point point =
        rsv_surface_point_at(s->scene.view, triangle, receiver.u, receiver.v, false);
    rsv_rgb v[3];
    rsv_bake_directions_at(d, &receiver, v);
    rsv_probe probe[TURNS + 1] = { { point.position, point.normal } };
    rsv_vec3 x, y;
    v3_frame(point.normal, &x, &y);
    for (int k = 0; k < TURNS; k++) {
        float turn = (float)k * RSV_PI / 2;
        rsv_vec3 towards = v3_mad(v3_scale(x, cosf(turn)), sinf(turn), y);
        probe[k + 1] = (rsv_probe){ point.position,
            v3_mad(v3_scale(point.normal, cosf(TILT)), sinf(TILT), towards) };
    }
    rsv_probe_reading reading[TURNS + 1];
    assert_int_equal(rsv_probe_irradiance(s->light,
                         &(rsv_probe_desc){ sizeof(rsv_probe_desc), RSV_PROBE_REFERENCE, 4096, 1 },
                         probe, TURNS + 1, reading),
        RSV_OK);
    for (int k = 1; k <= TURNS; k++)
        for (int c = 0; c < 3; c++) {
            float e = channel(reading[0].irradiance, c), truth = channel(reading[k].irradiance, c);
            if (!(e > 0)) continue;
            float told = reconstruct(e, v, probe[k].normal, c);
            j->flat += (double)(fabsf(e - truth) / e);
            j->directional += (double)(fabsf(told - truth) / e);
            j->readings++;
        }
}

static rsv_light *solve(rsv_scene *scene)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_light *solution;
    assert_int_equal(rsv_light_create(scene, &desc, &solution), RSV_OK);
    return solution;
}

static void light_for_tilted_normals_is_what_is_measured(void **state)
{
    fixture *f = *state;
    rsv_scene *scene;
    assert_int_equal(rsv_scene_builtin(f->context, "cornell-blocks", &scene), RSV_OK);
    rsv_light *solution = solve(scene);
    rsv_bake_directions directions;
    assert_int_equal(rsv_bake_directions_create(inside(solution), &directions), RSV_OK);
    judgement j = { 0 };
    for (uint32_t t = 0; t < inside(solution)->scene.view->triangle_count; t++)
        if (inside(solution)->elements->face_of[0][t] != RSV_NONE &&
            inside(solution)->lights->triangle_emitter[t] == RSV_NONE)
            judge_place(&directions, t, &j);
    assert_true(j.readings > 300);
    print_message("mean errors: flat %.3f, directional %.3f\n", j.flat / (double)j.readings,
        j.directional / (double)j.readings);
    assert_true(j.directional < 0.65 * j.flat);
    rsv_bake_directions_destroy(&directions);
    rsv_light_destroy(solution);
    rsv_scene_destroy(scene);
}

#define CHARTS 120
#define SIDE 512

/// Right triangles of many sizes, one per chart. @param slivers whether all but a few are thinner than a texel
static void make_triangles(rsv_bake_charts *c, bool slivers)
{
    for (uint32_t k = 0; k < CHARTS; k++) {
        float w = 0.2f + 0.01f * (float)(k * 37 % 101), h = 0.2f + 0.01f * (float)(k * 53 % 97);
        if (slivers && k % 10) h *= 0.01f;
        c->chart[k] =
            (rsv_bake_chart){ .first = k, .triangle_count = 1, .size = { w, h }, .detail = 1 };
        c->triangle[k] = k;
        const float corner[3][2] = { { 0, 0 }, { w, 0 }, { k % 2 ? w : 0, h } };
        memcpy(c->corner[k], corner, sizeof corner);
    }
}

/// Whether filtering at a place of a chart touches its own texels alone.
static bool is_alone(const rsv_bake_map *map, const rsv_bake_chart *chart, const float corner[2])
{
    float point[2], part[2];
    uint32_t at[2];
    rsv_bake_chart_point(chart, corner, point);
    rsv_bake_map_locate(map, point, at, part);
    for (uint32_t k = 0; k < 4; k++) {
        size_t texel = (size_t)(at[1] + k / 2) * map->width + at[0] + k % 2;
        float weight = (k % 2 ? part[0] : 1 - part[0]) * (k / 2 ? part[1] : 1 - part[1]);
        if (weight > 1e-4f && map->owner[texel] != chart->first) return false;
    }
    return true;
}

static void judge_packing(const fixture *f, bool slivers, double least_coverage)
{
    rsv_bake_chart chart[CHARTS];
    uint32_t triangle[CHARTS], height;
    float corner[CHARTS][3][2];
    rsv_bake_charts charts = { .context = f->context,
        .chart = chart,
        .count = CHARTS,
        .triangle = triangle,
        .corner = corner,
        .triangle_count = CHARTS };
    static uint8_t back[CHARTS];
    const rsv_bake_part part = { .triangle_count = CHARTS, .triangle = triangle, .back = back };
    rsv_bake_map map;
    make_triangles(&charts, slivers);
    assert_int_equal(rsv_bake_pack(&charts, 76, 2, SIDE, SIDE, &height), RSV_OK);
    assert_true(height <= SIDE);
    assert_int_equal(
        rsv_bake_map_create(&charts, &part, (rsv_bake_extent){ SIDE, height, 2 }, &map, NULL),
        RSV_OK);
    print_message("triangles cover %.1f %%\n", 100 * rsv_bake_map_coverage(&map));
    assert_true(rsv_bake_map_coverage(&map) > least_coverage);
    for (uint32_t k = 0; k < CHARTS; k++)
        for (uint32_t n = 0; n < 256; n++) {
            float a = (float)(n % 16) / 15, b = (1 - a) * (float)(n / 16) / 15, at[2];
            for (int c = 0; c < 2; c++)
                at[c] = corner[k][0][c] * (1 - a - b) + corner[k][1][c] * a + corner[k][2][c] * b;
            assert_true(is_alone(&map, &chart[k], at));
        }
    for (size_t k = 0; k < (size_t)map.width * map.height; k++)
        assert_int_not_equal(map.receiver[k].triangle, RSV_NONE); // gaps show what is next to them
    assert_int_equal(rsv_bake_pack(&charts, 110, 2, slivers ? 64 : SIDE, SIDE, &height), RSV_OK);
    assert_int_equal(height, UINT32_MAX);
    rsv_bake_map_destroy(f->context, &map);
}

static void charts_lie_close_and_filtering_keeps_them_apart(void **state)
{
    judge_packing(*state, false, 0.68); // rectangles around them would leave less than half
    judge_packing(*state, true, 0.62);  // 0.55 with two texels between slivers
}

#define ROWS 24
#define COLUMNS 16
#define STITCHES 40

/// Light of a lamp in a map, on both sides of a seam that crosses it twice at an angle.
static void light_seam(int lamp, rsv_rgb *light, rsv_bake_stitch *stitch)
{
    for (int k = 0; k < ROWS * COLUMNS; k++)
        light[k] = rgb_gray((lamp ? 5 : 1) + sinf((float)(k * (lamp + 1))) +
                            (float)(k % COLUMNS) * (lamp ? -0.2f : 1));
    for (int k = 0; k < STITCHES; k++) {
        float t = (float)k / STITCHES;
        stitch[k] = (rsv_bake_stitch){ .solved = rgb_gray(lamp ? 4 - t : 8 + t),
            .point = { { 3 + t, 2 + 18 * t }, { 11 + 2 * t, 3 + 17 * t } },
            .least = lamp ? 3 : 8 };
    }
}

static void seams_of_single_lights_are_closed_for_all_their_strengths(void **state)
{
    const fixture *f = *state;
    static rsv_rgb light[3][ROWS * COLUMNS];
    static float distance[ROWS * COLUMNS];
    rsv_bake_stitch stitch[STITCHES];
    rsv_bake_map map = { .width = COLUMNS, .height = ROWS, .distance = distance };
    double largest;
    for (int lamp = 0; lamp < 2; lamp++) {
        map.light = light[lamp];
        light_seam(lamp, map.light, stitch);
        assert_int_equal(rsv_bake_stitch_up(f->context, stitch, STITCHES, &map, &largest), RSV_OK);
        assert_true(largest < 0.01);
    }
    static const float strength[][2] = { { 1, 1 }, { 4, 0.1f }, { 0.05f, 3 }, { 0, 1 } };
    map.light = light[2];
    for (int mix = 0; mix < 4; mix++) {
        for (int k = 0; k < ROWS * COLUMNS; k++)
            light[2][k] =
                rgb_mad(rgb_scale(light[0][k], strength[mix][0]), strength[mix][1], light[1][k]);
        for (int k = 0; k < STITCHES; k++)
            stitch[k].least = 8 * strength[mix][0] + 3 * strength[mix][1];
        for (int k = 0; k < STITCHES; k++)
            assert_true(rsv_bake_jump(&map, &stitch[k]) < 0.01);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(seams_of_single_lights_are_closed_for_all_their_strengths,
            fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            charts_lie_close_and_filtering_keeps_them_apart, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            light_for_tilted_normals_is_what_is_measured, fixture_setup, fixture_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
