/// Daylight at sensors: open ground, a room compared with the path tracer, panes, annual results, errors.
#include "light_fixture.h"
#include "resolvent/daylight.h"
#include "resolvent/io.h"
#include "resolvent/render.h"
#include "slow_tests.h"

#include <stdio.h>

#define DEGREES (M_PI / 180)

// ---- scenes and weather -----------------------------------------------------------------------------

static rsv_probe up_at(float x, float y, float z)
{
    return (rsv_probe){ { x, y, z }, { 0, 1, 0 } };
}

/// Nothing but a black tile far below.
static void build_open(world *w)
{
    uint32_t black = world_lambert(w, 0, 0);
    world_quad(w, black, v3(-1, -50, -1), v3(-1, -50, 1), v3(1, -50, 1), v3(1, -50, -1));
    world_commit(w);
}

static void turned_quad(world *w, uint32_t material, const float corner[4][3], double turn)
{
    rsv_vec3 c[4];
    float cosine = (float)cos(turn), sine = (float)sin(turn);
    for (int k = 0; k < 4; k++) // about +y, clockwise from above
        c[k] = v3(cosine * corner[k][0] - sine * corner[k][2], corner[k][1],
            sine * corner[k][0] + cosine * corner[k][2]);
    world_quad(w, material, c[0], c[1], c[2], c[3]);
}

/// 4 x 3 x 5 m, open at 0.8 to 2.6 m of the south wall (z = 0), one wall red; turned about the origin.
/// @param pane in the opening; RSV_NONE = none
static void build_room(world *w, double turn, uint32_t pane)
{
    rsv_material red_wall = lambert_material(0.5f, 0);
    red_wall.base_color = rgb(0.7f, 0.2f, 0.15f);
    uint32_t dark = world_lambert(w, 0.3f, 0), light = world_lambert(w, 0.7f, 0);
    uint32_t red = world_material(w, red_wall);
    static const float floor[4][3] = { { 0, 0, -5 }, { 0, 0, 0 }, { 4, 0, 0 }, { 4, 0, -5 } };
    static const float ceiling[4][3] = { { 0, 3, -5 }, { 4, 3, -5 }, { 4, 3, 0 }, { 0, 3, 0 } };
    static const float west[4][3] = { { 0, 0, -5 }, { 0, 3, -5 }, { 0, 3, 0 }, { 0, 0, 0 } };
    static const float east[4][3] = { { 4, 0, 0 }, { 4, 3, 0 }, { 4, 3, -5 }, { 4, 0, -5 } };
    static const float north[4][3] = { { 4, 0, -5 }, { 4, 3, -5 }, { 0, 3, -5 }, { 0, 0, -5 } };
    static const float sill[4][3] = { { 0, 0, 0 }, { 0, .8f, 0 }, { 4, .8f, 0 }, { 4, 0, 0 } };
    static const float lintel[4][3] = { { 0, 2.6f, 0 }, { 0, 3, 0 }, { 4, 3, 0 }, { 4, 2.6f, 0 } };
    static const float opening[4][3] = { { 0, .8f, 0 }, { 0, 2.6f, 0 }, { 4, 2.6f, 0 },
        { 4, .8f, 0 } };
    turned_quad(w, dark, floor, turn);
    turned_quad(w, light, ceiling, turn);
    turned_quad(w, red, west, turn);
    turned_quad(w, light, east, turn);
    turned_quad(w, light, north, turn);
    turned_quad(w, light, sill, turn);
    turned_quad(w, light, lintel, turn);
    if (pane != RSV_NONE) turned_quad(w, pane, opening, turn);
    world_commit(w);
}

static void add_pane(world *w, uint32_t pane, bool upright)
{
    if (upright)
        world_quad(w, pane, v3(1, 1, 0), v3(1, 2, 0), v3(3, 2, 0), v3(3, 1, 0));
    else
        world_quad(w, pane, v3(1, 3, -3), v3(3, 3, -3), v3(3, 3, -2), v3(1, 3, -2));
}

/// Walls of 4 by 3 by 5 m around an opening of 2 by 1 m in the roof, in the south wall, or both.
static void build_lit_room(world *w, bool roof, bool window)
{
    uint32_t grey = world_lambert(w, 0.5f, 0);
    world_box(w, grey, v3(-0.2f, -0.2f, -5.2f), v3(4.2f, 0, 0.2f)); // floor
    world_box(w, grey, v3(-0.2f, 0, -5), v3(0, 3, 0));
    world_box(w, grey, v3(4, 0, -5), v3(4.2f, 3, 0));
    world_box(w, grey, v3(0, 0, -5.2f), v3(4, 3, -5));
    world_box(w, grey, v3(0, 0, 0), v3(window ? 1 : 4, 3, 0.05f));
    if (window) world_box(w, grey, v3(3, 0, 0), v3(4, 3, 0.05f));
    if (window) world_box(w, grey, v3(1, 0, 0), v3(3, 1, 0.05f));
    if (window) world_box(w, grey, v3(1, 2, 0), v3(3, 3, 0.05f));
    world_box(w, grey, v3(0, 3, -5), v3(roof ? 1 : 4, 3.05f, 0));
    if (roof) world_box(w, grey, v3(3, 3, -5), v3(4, 3.05f, 0));
    if (roof) world_box(w, grey, v3(1, 3, -5), v3(3, 3.05f, -3));
    if (roof) world_box(w, grey, v3(1, 3, -2), v3(3, 3.05f, 0));
}

enum { most_hours = 48 };

static rsv_weather weather_of(rsv_weather_hour *hour, size_t count)
{
    rsv_weather w = {
        .name = "Chicago", .site = { 41.98, -87.92, -6, 201 }, .hour = hour, .count = count
    };
    return w;
}

static rsv_weather_hour record_at(int month, int day, double hour, double direct, double diffuse)
{
    rsv_weather_hour h = { .moment = { 2001, month, day, hour },
        .hours = 1,
        .record = { direct, diffuse, 5, rsv_day_of_year(2001, month, day) },
        .direct_illuminance = NAN,
        .diffuse_illuminance = NAN };
    return h;
}

typedef struct solved {
    rsv_light *light;
    rsv_daylight *daylight;
} solved;

static solved solve_with(world *w, const rsv_weather *weather, const rsv_probe *sensor,
    size_t count, const rsv_daylight_desc *desc, uint32_t elements)
{
    solved s;
    rsv_solve_desc solve = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    solve.element_target = elements;
    solve.seed = desc->seed;
    solve.direct_level = false;
    solve.goal_points = sensor;
    solve.goal_point_count = count;
    assert_int_equal(rsv_daylight_surround(w->scene, weather, desc), RSV_OK);
    assert_int_equal(rsv_light_create(w->scene, &solve, &s.light), RSV_OK);
    assert_int_equal(rsv_daylight_create(s.light, sensor, count, desc, &s.daylight), RSV_OK);
    return s;
}

static void release(solved *s)
{
    rsv_daylight_destroy(s->daylight);
    rsv_light_destroy(s->light);
}

// ---- exact ------------------------------------------------------------------------------------------

/// In the open, a sensor on its back reads what the station measured, one that faces down the ground's light, and one on the side
/// half of what comes from an even ground and its part of the sky.
static void open_ground_reads_what_the_sky_gives(void **state)
{
    (void)state;
    world *w = world_begin(2);
    build_open(w);
    rsv_weather_hour hour[] = { record_at(6, 21, 10.5, 700, 150), record_at(1, 5, 2.5, 0, 0) };
    rsv_weather weather = weather_of(hour, 2);
    rsv_probe sensor[] = { up_at(20, 0, 0), { { 20, 0, 0 }, { 0, -1, 0 } } };
    rsv_daylight_desc desc = rsv_default_daylight_desc(RSV_QUALITY_DRAFT);
    solved s = solve_with(w, &weather, sensor, 2, &desc, 500);
    rsv_solar_position sun;
    rsv_perez_sky sky = rsv_weather_sky(&weather, 0, &sun);
    double global = sky.diffuse_illuminance + sky.direct_illuminance * sin(sun.elevation);
    float hourly[4];
    rsv_daylight_run_desc run = rsv_default_daylight_run_desc();
    rsv_daylight_report report;
    run.hourly = hourly;
    assert_int_equal(rsv_daylight_run(s.daylight, &weather, &run, &report), RSV_OK);
    assert_close((double)hourly[0], global, 0.004 * global);
    assert_close((double)hourly[1], 0.2 * global, 0.004 * global);
    assert_true(hourly[2] == 0 && hourly[3] == 0);
    assert_close(report.sensor[0][RSV_SENSOR_MEAN].value, (double)hourly[0] / 2, 0.01);
    assert_close(report.sensor[0][RSV_SENSOR_DAYLIGHT_FACTOR].value, 1, 0.003);
    double sum = 0;
    for (uint32_t p = 0; p < rsv_sky_patches_of(4).count; p++)
        sum += rsv_daylight_coefficient(s.daylight, 0, p);
    assert_close(sum, M_PI, 1e-4);
    rsv_daylight_report_free(s.daylight, &report);
    release(&s);
    world_end(w);
}

/// Transmittance of a thin sheet of ior 1.5, including reflections within it: (1 - F) / (1 + F) unpolarised.
static double sheet_transmittance(double cosine)
{
    double inner = sqrt(1 - (1 - cosine * cosine) / 2.25), sum = 0;
    double rs = (cosine - 1.5 * inner) / (cosine + 1.5 * inner),
           rp = (1.5 * cosine - inner) / (1.5 * cosine + inner);
    double reflected[2] = { rs * rs, rp * rp };
    for (int k = 0; k < 2; k++)
        sum += 0.5 * reflected[k];
    return 1 - sum;
}

static void sun_passes_clear_panes(void **state)
{
    (void)state;
    world *w = world_begin(2);
    rsv_material glass = glass_material();
    glass.thickness = 0;
    uint32_t pane = world_material(w, glass), black = world_lambert(w, 0, 0);
    world_quad(w, pane, v3(-9, 2, -9), v3(-9, 2, 9), v3(9, 2, 9), v3(9, 2, -9));
    world_quad(w, black, v3(-1, -50, -1), v3(-1, -50, 1), v3(1, -50, 1), v3(1, -50, -1));
    world_commit(w);
    rsv_weather_hour hour = record_at(6, 21, 12.5, 800, 1);
    rsv_weather weather = weather_of(&hour, 1);
    rsv_probe sensor = up_at(0, 1, 0);
    rsv_daylight_desc desc = rsv_default_daylight_desc(RSV_QUALITY_DRAFT);
    solved s = solve_with(w, &weather, &sensor, 1, &desc, 500);
    float lux[2];
    rsv_daylight_run_desc run = rsv_default_daylight_run_desc();
    for (int k = 0; k < 2; k++) {
        rsv_daylight_report report;
        run.hourly = &lux[k];
        run.sky_only = k;
        assert_int_equal(rsv_daylight_run(s.daylight, &weather, &run, &report), RSV_OK);
        rsv_daylight_report_free(s.daylight, &report);
    }
    rsv_solar_position sun;
    rsv_perez_sky sky = rsv_weather_sky(&weather, 0, &sun);
    double expected =
        sky.direct_illuminance * sin(sun.elevation) * sheet_transmittance(sin(sun.elevation));
    assert_close((double)(lux[0] - lux[1]), expected, 0.002 * expected);
    release(&s);
    world_end(w);
}

/// Pi times the form factor of a vertical rectangle W wide and H high, for a sensor that faces up. The sensor is at a
/// distance D in front of a lower corner of the rectangle.
static double corner_illuminance(double wide, double high, double before)
{
    double apart = hypot(before, high);
    return 0.5 * (atan(wide / before) - before / apart * atan(wide / apart));
}

/// In a black room under a uniform sky, sensors level with the sill read the closed form of a vertical rectangle (CIE
/// 171:2006 has such cases).
static void windows_give_their_form_factor(void **state)
{
    (void)state;
    enum { count = 3 };
    world *w = world_begin(2);
    uint32_t black = world_lambert(w, 0, 0);
    world_quad(w, black, v3(-9, .8f, 0), v3(-9, 9, 0), v3(-1, 9, 0),
        v3(-1, .8f, 0)); // around an opening of
    world_quad(w, black, v3(2, .8f, 0), v3(2, 9, 0), v3(9, 9, 0), v3(9, .8f, 0)); // 3 by 1.5 m
    world_quad(w, black, v3(-1, 2.3f, 0), v3(-1, 9, 0), v3(2, 9, 0), v3(2, 2.3f, 0));
    world_quad(w, black, v3(-9, 9, -9), v3(9, 9, -9), v3(9, 9, 0), v3(-9, 9, 0));
    world_quad(w, black, v3(-9, .8f, -9), v3(-9, 9, -9), v3(-9, 9, 0), v3(-9, .8f, 0));
    world_quad(w, black, v3(9, .8f, 0), v3(9, 9, 0), v3(9, 9, -9), v3(9, .8f, -9));
    world_quad(w, black, v3(9, .8f, -9), v3(9, 9, -9), v3(-9, 9, -9), v3(-9, .8f, -9));
    world_commit(w);
    rsv_weather_hour hour = record_at(6, 21, 12.5, 0, 100);
    rsv_weather weather = weather_of(&hour, 1);
    rsv_probe sensor[count] = { up_at(0, .8f, -1), up_at(0, .8f, -3), up_at(0, .8f, -6) };
    rsv_daylight_desc desc = rsv_default_daylight_desc(RSV_QUALITY_MEDIUM);
    solved s = solve_with(w, &weather, sensor, count, &desc, 500);
    for (int k = 0; k < count; k++) {
        double before = -(double)sensor[k].position.z, sum = 0;
        double expected = corner_illuminance(1, 1.5, before) + corner_illuminance(2, 1.5, before);
        for (uint32_t p = 1; p < rsv_sky_patches_of(4).count; p++)
            sum += rsv_daylight_coefficient(s.daylight, (size_t)k, p);
        assert_close(sum, expected, 0.004 * expected);
    }
    release(&s);
    world_end(w);
}

static void rooms_without_windows_are_dark(void **state)
{
    (void)state;
    world *w = world_begin(2);
    world_room(w, world_lambert(w, 0.5f, 0), v3(0, 0, -5), v3(4, 3, 0));
    world_commit(w);
    rsv_weather_hour hour = record_at(6, 21, 12.5, 800, 100);
    rsv_weather weather = weather_of(&hour, 1);
    rsv_probe sensor[] = { up_at(2, 1, -2), up_at(2, -1, -2) };
    rsv_daylight_desc desc = rsv_default_daylight_desc(RSV_QUALITY_DRAFT);
    solved s = solve_with(w, &weather, sensor, 2, &desc, 500);
    rsv_daylight_run_desc run = rsv_default_daylight_run_desc();
    rsv_daylight_report report;
    assert_int_equal(rsv_daylight_run(s.daylight, &weather, &run, &report), RSV_OK);
    assert_true(report.sensor[0][RSV_SENSOR_MEAN].value == 0);
    assert_true(report.sensor[0][RSV_SENSOR_UDI_BELOW].value == 1);
    assert_int_equal(rsv_daylight_class(report.space[RSV_SPACE_TARGET].value, 0), 0);
    assert_false(rsv_daylight_is_buried(s.daylight, 0));
    assert_true(rsv_daylight_is_buried(s.daylight, 1)); // behind the floor's back
    rsv_daylight_report_free(s.daylight, &report);
    release(&s);
    world_end(w);
}

/// The walls' outsides are bright, and vary: the little that gets in where boxes touch at edges is not as uncertain.
static void errors_of_dark_rooms_are_small(void **state)
{
    (void)state;
    world *w = world_begin(2);
    build_lit_room(w, false, false);
    world_commit(w);
    rsv_weather_hour hour = record_at(6, 21, 12.5, 800, 100);
    rsv_weather weather = weather_of(&hour, 1);
    rsv_probe sensor[] = { up_at(1, 0.8f, -1), up_at(2, 0.8f, -2.5f), up_at(3, 0.8f, -4) };
    rsv_daylight_desc desc = rsv_default_daylight_desc(RSV_QUALITY_DRAFT);
    desc.sensor_rays = 3840;
    solved s = solve_with(w, &weather, sensor, 3, &desc, 1000);
    rsv_daylight_run_desc run = rsv_default_daylight_run_desc();
    rsv_daylight_report report;
    assert_int_equal(rsv_daylight_run(s.daylight, &weather, &run, &report), RSV_OK);
    for (int k = 0; k < 3; k++) {
        rsv_figure mean = report.sensor[k][RSV_SENSOR_MEAN];
        assert_true(mean.value < 3 && mean.standard_error <= fmax(mean.value, 1e-3));
    }
    rsv_daylight_report_free(s.daylight, &report);
    release(&s);
    world_end(w);
}

// ---- compared with the path tracer -------------------------------------------------------------------------

enum { sky_width = 720, sky_height = 360 };

/// The scene under the sky of one hour, patch by patch, with the sun as a directional light: without the code under
/// test.
static void surround_by_hour(
    rsv_scene *scene, const rsv_weather *weather, double north, bool sky_only, bool with_light)
{
    rsv_sky_patches patches = rsv_sky_patches_of(4);
    rsv_solar_position sun;
    rsv_perez_sky sky = rsv_weather_sky(weather, 0, &sun);
    float *luminance = calloc(patches.count, sizeof *luminance);
    rsv_rgb *pixel = calloc(sky_width * sky_height, sizeof *pixel);
    assert_true(luminance && pixel);
    rsv_sky_patch_luminances(&patches, &sky.shape, sky.diffuse_illuminance, luminance);
    luminance[0] = (float)(0.2 / M_PI *
                           (sky.diffuse_illuminance + sin(sun.elevation) * sky.direct_illuminance));
    for (int y = 0; y < sky_height; y++)
        for (int x = 0; x < sky_width; x++) {
            double polar = M_PI * (y + 0.5) / sky_height,
                   turn = 2 * M_PI * ((x + 0.5) / sky_width - 0.5) - north;
            rsv_vec3 direction = v3((float)(sin(polar) * cos(turn)), (float)cos(polar),
                (float)(sin(polar) * sin(turn)));
            pixel[y * sky_width + x] = rgb_gray(luminance[rsv_sky_patch_at(&patches, direction)]);
        }
    rsv_environment environment = { "hour", pixel, sky_width, sky_height, 1, 0 };
    assert_int_equal(rsv_scene_set_environment(scene, &environment), RSV_OK);
    if (with_light && !sky_only) {
        float c = (float)cos(north), s = (float)sin(north);
        rsv_vec3 d = v3_neg(sun.direction);
        rsv_punctual_light light = { .name = "sun",
            .kind = RSV_PUNCTUAL_DIRECTIONAL,
            .direction = v3(c * d.x - s * d.z, d.y, s * d.x + c * d.z),
            .intensity = rgb_gray((float)sky.direct_illuminance) };
        assert_int_equal(rsv_scene_add_light(scene, &light), RSV_OK);
    }
    free(luminance);
    free(pixel);
}

/// What may close the opening.
typedef enum closure { OPEN, CLEAR, DIFFUSING, FROSTED } closure;

static uint32_t closure_material(world *w, closure kind)
{
    rsv_material pane = glass_material();
    pane.thickness = 0;
    if (kind == FROSTED) pane.roughness = 0.4f;
    if (kind == DIFFUSING) {
        pane = lambert_material(0.8f, 0);
        pane.diffuse_transmission = 0.6f;
        pane.diffuse_transmission_color = rgb_gray(0.9f);
        pane.double_sided = true;
    }
    return kind == OPEN ? RSV_NONE : world_material(w, pane);
}

static void read_reference(double turn, closure pane, const rsv_weather *weather,
    const rsv_probe *sensor, size_t count, rsv_probe_reading *reading)
{
    world *w = world_begin(2);
    surround_by_hour(w->scene, weather, turn, pane, true);
    build_room(w, turn, closure_material(w, pane));
    assert_int_equal(rsv_probe_reference(w->scene, sensor, count, 1 << 18, 3, reading), RSV_OK);
    world_end(w);
}

static void read_daylight(double turn, closure pane, const rsv_weather *weather,
    const rsv_probe *sensor, size_t count, float *lux, double *error)
{
    world *w = world_begin(2);
    build_room(w, turn, closure_material(w, pane));
    rsv_daylight_desc desc = rsv_default_daylight_desc(RSV_QUALITY_MEDIUM);
    desc.north = turn / DEGREES;
    solved s = solve_with(w, weather, sensor, count, &desc, 5000);
    rsv_daylight_run_desc run = rsv_default_daylight_run_desc();
    rsv_daylight_report report;
    run.hourly = lux;
    run.sky_only = pane; // shadow rays of the path tracer do not pass panes
    assert_int_equal(rsv_daylight_run(s.daylight, weather, &run, &report), RSV_OK);
    for (size_t k = 0; k < count; k++)
        error[k] = report.sensor[k][RSV_SENSOR_MEAN].standard_error;
    rsv_daylight_report_free(s.daylight, &report);
    release(&s);
    world_end(w);
}

/// Within 1 % or four standard errors.
static void compare_with_reference(double turn, closure pane)
{
    enum { count = 4 };
    rsv_weather_hour hour = record_at(3, 21, 10.5, 650, 140);
    rsv_weather weather = weather_of(&hour, 1);
    rsv_probe sensor[count] = { up_at(1, 0.8f, -1), up_at(3, 0.8f, -2.5f), up_at(2, 0.8f, -4.5f),
        { { 2, 1.2f, -3 }, { -1, 0, 0 } } };
    for (int k = 0; k < count; k++) {
        float c = (float)cos(turn), s = (float)sin(turn);
        rsv_vec3 p = sensor[k].position, n = sensor[k].normal;
        sensor[k].position = v3(c * p.x - s * p.z, p.y, s * p.x + c * p.z);
        sensor[k].normal = v3(c * n.x - s * n.z, n.y, s * n.x + c * n.z);
    }
    rsv_probe_reading reading[count];
    float lux[count];
    double error[count];
    read_reference(turn, pane, &weather, sensor, count, reading);
    read_daylight(turn, pane, &weather, sensor, count, lux, error);
    for (int k = 0; k < count; k++) {
        double expected = (double)rgb_luminance(reading[k].irradiance);
        double noise = hypot((double)rgb_luminance(reading[k].standard_error), error[k]);
        assert_close((double)lux[k], expected, fmax(0.01 * expected, 4 * noise));
    }
}

static void hours_are_those_of_the_path_tracer(void **state)
{
    (void)state;
    compare_with_reference(0, OPEN);
}

static void scenes_may_be_turned(void **state)
{
    (void)state;
    compare_with_reference(130 * DEGREES, OPEN);
}

static void skies_behind_panes_are_those_of_the_path_tracer(void **state)
{
    (void)state;
    compare_with_reference(0, CLEAR);
}

static void frosted_panes_spread_the_sky(void **state)
{
    (void)state;
    compare_with_reference(0, FROSTED);
}

static void diffusing_panes_spread_the_sky(void **state)
{
    (void)state;
    compare_with_reference(0, DIFFUSING);
}

// ---- figures ----------------------------------------------------------------------------------------

/// On open ground, under skies with closed forms: 24 hours, 10 of them occupied.
static void figures_count_hours(void **state)
{
    (void)state;
    world *w = world_begin(2);
    build_open(w);
    rsv_weather_hour hour[24];
    const double diffuse[10] = { 0.5, 1, 1.5, 2, 5, 20, 200, 200, 200, 200 };
    for (int k = 0; k < 24; k++)
        hour[k] = record_at(6, 21, k + 0.5, 0, k >= 8 && k < 18 ? diffuse[k - 8] : 0);
    rsv_weather weather = weather_of(hour, 24);
    rsv_probe sensor = up_at(20, 0, 0);
    rsv_daylight_desc desc = rsv_default_daylight_desc(RSV_QUALITY_DRAFT);
    solved s = solve_with(w, &weather, &sensor, 1, &desc, 500);
    rsv_daylight_run_desc run = rsv_default_daylight_run_desc();
    rsv_daylight_report report;
    assert_int_equal(rsv_daylight_run(s.daylight, &weather, &run, &report), RSV_OK);
    double counts[3] = { 0 }, autonomy = 0;
    for (int k = 8; k < 18; k++) {
        double lux = rsv_weather_sky(&weather, (size_t)k, NULL).diffuse_illuminance;
        counts[lux < 100 ? 0 : lux < 300 ? 1 : 2] += 0.1;
        autonomy += 0.1 * fmin(lux / 300, 1);
    }
    const rsv_figure *f = report.sensor[0];
    assert_close(report.occupied_hours, 10, 1e-9);
    assert_close(f[RSV_SENSOR_UDI_BELOW].value, counts[0], 1e-9);
    assert_close(f[RSV_SENSOR_UDI_SUPPLEMENTARY].value, counts[1], 1e-9);
    assert_close(f[RSV_SENSOR_DA].value, counts[2], 1e-9);
    assert_close(f[RSV_SENSOR_UDI_EXCEEDED].value, 0.4, 1e-9);
    assert_close(f[RSV_SENSOR_CDA].value, autonomy, 0.003);
    assert_close(f[RSV_SENSOR_SUN_HOURS].value, 0, 0);
    assert_close(report.space[RSV_SPACE_SDA].value, counts[2] >= 0.5, 0);
    assert_int_equal(rsv_daylight_class(750, 500), 3);
    assert_int_equal(rsv_daylight_class(749, 500), 2);
    assert_int_equal(rsv_daylight_class(900, 120), 1);
    rsv_daylight_report_free(s.daylight, &report);
    release(&s);
    world_end(w);
}

/// One sensor in the sun, one in the shade of a wall; shades that block all light, except in hours without sun.
static void shades_go_down_in_the_sun(void **state)
{
    (void)state;
    world *w = world_begin(2), *closed = world_begin(2);
    build_open(w);
    world_box(closed, world_lambert(closed, 0, 0), v3(10, -1, -10), v3(30, 1, 10));
    world_commit(closed);
    rsv_weather_hour hour[] = { record_at(6, 21, 10.5, 700, 150), record_at(6, 21, 11.5, 0, 150) };
    rsv_weather weather = weather_of(hour, 2);
    rsv_probe sensor[] = { up_at(20, 0, 0), { { 20, 0, 0 }, { 0, -1, 0 } } };
    rsv_daylight_desc desc = rsv_default_daylight_desc(RSV_QUALITY_DRAFT);
    solved open = solve_with(w, &weather, sensor, 2, &desc, 300);
    solved down = solve_with(closed, &weather, sensor, 2, &desc, 300);
    float plain[4], shaded[4];
    rsv_daylight_run_desc run = rsv_default_daylight_run_desc();
    for (
        int k = 0; k < 4;
        k++) { // without shades, with them, with more sun asked for than there is, with too few sensors
        rsv_daylight_report report;
        run.hourly = k ? shaded : plain;
        run.shaded = k ? down.daylight : NULL;
        run.shade_lux = k == 2 ? 2e5 : 1000;
        run.shade_share = k == 3 ? 0.75 : 0.02;
        assert_int_equal(rsv_daylight_run(open.daylight, &weather, &run, &report), RSV_OK);
        assert_close(report.shaded_hours, k == 1, 0);
        assert_close(report.sensor[0][RSV_SENSOR_SUN_HOURS].value, 1, 0);
        if (k == 1) assert_true(shaded[0] == 0 && shaded[1] == 0 && plain[0] > 10000);
        if (k == 1) assert_true(shaded[2] == plain[2] && shaded[3] == plain[3]);
        if (k > 1) assert_memory_equal(shaded, plain, sizeof plain);
        rsv_daylight_report_free(open.daylight, &report);
    }
    solved other = solve_with(closed, &weather, sensor, 1, &desc, 300);
    rsv_daylight_report report;
    run.shaded = other.daylight;
    assert_int_equal(rsv_daylight_run(open.daylight, &weather, &run, &report), RSV_ERROR_ARGUMENT);
    release(&other);
    release(&down);
    release(&open);
    world_end(closed);
    world_end(w);
}

/// Shades of a room go down if more than 2 % of its own sensors are in the sun: one of 50 is not, one of 49 is.
static void shades_go_down_room_by_room(void **state)
{
    (void)state;
    enum { first = 50, count = 99 };
    world *w = world_begin(2), *closed = world_begin(2);
    build_open(w);
    world_box(closed, world_lambert(closed, 0, 0), v3(10, -1, -10), v3(30, 1, 10));
    world_commit(closed);
    rsv_weather_hour hour = record_at(6, 21, 10.5, 700, 150);
    rsv_weather weather = weather_of(&hour, 1);
    rsv_probe sensor[count];
    uint32_t room[count];
    for (uint32_t k = 0; k < count; k++) { // the others face down, and their rooms are mixed
        room[k] = k < 2 * (count - first) ? k % 2 : 0;
        sensor[k] = up_at(20, 0, 0);
        sensor[k].normal.y = k < 2 ? 1 : -1;
    }
    rsv_daylight_desc desc = rsv_default_daylight_desc(RSV_QUALITY_DRAFT);
    desc.sensor_rays = 240;
    solved open = solve_with(w, &weather, sensor, count, &desc, 300);
    solved down = solve_with(closed, &weather, sensor, count, &desc, 300);
    float lux[count];
    rsv_daylight_report report;
    rsv_daylight_run_desc run = rsv_default_daylight_run_desc();
    run.hourly = lux, run.shaded = down.daylight;
    run.room = room, run.room_count = 2;
    assert_int_equal(rsv_daylight_run(open.daylight, &weather, &run, &report), RSV_OK);
    assert_true(lux[0] > 10000 && lux[2] > 0); // room 0
    assert_true(lux[1] == 0 && lux[3] == 0);   // room 1
    assert_close(report.room_shaded_hours[0], 0, 0);
    assert_close(report.room_shaded_hours[1], 1, 0);
    assert_close(report.shaded_hours, 49.0 / 99, 1e-9);
    rsv_daylight_report_free(open.daylight, &report);
    room[0] = 2;
    assert_int_equal(rsv_daylight_run(open.daylight, &weather, &run, &report), RSV_ERROR_ARGUMENT);
    release(&down);
    release(&open);
    world_end(closed);
    world_end(w);
}

/// Where nothing has a colour, three sensors share the channels of one field. The slightest tint separates them,
/// without changing the results.
static void gray_rooms_read_as_tinted_ones(void **state)
{
    (void)state;
    enum { count = 5 };
    rsv_weather_hour hour = record_at(3, 21, 10.5, 650, 140);
    rsv_weather weather = weather_of(&hour, 1);
    const rsv_probe sensor[count] = { up_at(1, 0.8f, -1), up_at(2, 0.8f, -1), up_at(3, 0.8f, -2),
        up_at(1, 0.8f, -3), { { 2, 1, -4 }, { 0, 0, -1 } } };
    float lux[2][count];
    for (int k = 0; k < 2; k++) {
        world *w = world_begin(2);
        rsv_material box = lambert_material(0.5f, 0);
        if (k) box.base_color.b = nextafterf(0.5f, 1);
        build_lit_room(w, false, true);
        world_box(w, world_material(w, box), v3(2, 0, -4), v3(2.5f, 0.4f, -3.5f));
        world_commit(w);
        rsv_daylight_desc desc = rsv_default_daylight_desc(RSV_QUALITY_DRAFT);
        desc.sensor_rays = 960;
        solved s = solve_with(w, &weather, sensor, count, &desc, 600);
        rsv_daylight_run_desc run = rsv_default_daylight_run_desc();
        rsv_daylight_report report;
        run.hourly = lux[k];
        assert_int_equal(rsv_daylight_run(s.daylight, &weather, &run, &report), RSV_OK);
        rsv_daylight_report_free(s.daylight, &report);
        release(&s);
        world_end(w);
    }
    for (int k = 0; k < count; k++)
        assert_close((double)lux[1][k], (double)lux[0][k], 2e-4 * (double)lux[0][k]);
}

// ---- errors, threads, input -------------------------------------------------------------------------

enum { seeds = 8, tried = 3 };

/// A few hours of summer and winter.
static rsv_weather some_weather(rsv_weather_hour hour[most_hours])
{
    for (int k = 0; k < most_hours; k++)
        hour[k] = record_at(k < 24 ? 3 : 11, 20, k % 24 + 0.5,
            k % 24 > 7 && k % 24 < 17 ? 300 + 9 * k : 0, k % 24 > 6 && k % 24 < 18 ? 120 : 0);
    return weather_of(hour, most_hours);
}

static void run_room(int threads, uint32_t seed, rsv_figure figure[tried])
{
    world *w = world_begin(threads);
    build_room(w, 0, RSV_NONE);
    rsv_weather_hour hour[most_hours];
    rsv_weather weather = some_weather(hour);
    rsv_probe sensor[tried] = { up_at(1, 0.8f, -1), up_at(3, 0.8f, -2.5f), up_at(2, 0.8f, -4.5f) };
    rsv_daylight_desc desc = rsv_default_daylight_desc(RSV_QUALITY_DRAFT);
    desc.seed = seed;
    desc.sensor_rays = 3840;
    solved s = solve_with(w, &weather, sensor, tried, &desc, 2000);
    rsv_daylight_run_desc run = rsv_default_daylight_run_desc();
    rsv_daylight_report report;
    assert_int_equal(rsv_daylight_run(s.daylight, &weather, &run, &report), RSV_OK);
    for (int k = 0; k < tried; k++)
        figure[k] = report.sensor[k][RSV_SENSOR_MEAN];
    rsv_daylight_report_free(s.daylight, &report);
    release(&s);
    world_end(w);
}

/// Reported standard errors, relative to the spread over seeds: above half, and, because they include the interpolation
/// error, below three times.
static void standard_errors_tell_the_spread(void **state)
{
    (void)state;
    rsv_figure figure[seeds][tried];
    double spread = 0, claimed = 0;
    for (uint32_t k = 0; k < seeds; k++)
        run_room(2, 11 * k + 1, figure[k]);
    for (int s = 0; s < tried; s++) {
        double mean = 0;
        for (int k = 0; k < seeds; k++)
            mean += figure[k][s].value / seeds;
        for (int k = 0; k < seeds; k++) {
            spread += pow(figure[k][s].value / mean - 1, 2) / (seeds - 1);
            claimed += pow(figure[k][s].standard_error / mean, 2) / seeds;
        }
    }
    double ratio = sqrt(claimed / spread);
    if (!(ratio > 0.6 && ratio < 3)) fail_msg("claimed errors are %g times the spread", ratio);
}

static void threads_change_nothing(void **state)
{
    (void)state;
    rsv_figure one[tried], three[tried];
    run_room(1, 5, one);
    run_room(3, 5, three);
    assert_memory_equal(one, three, sizeof one);
}

/// Two rooms with a doorway between them, and a row of sensors in each: the results of a room are those of its own
/// sensors.
static void rooms_are_told_apart(void **state)
{
    (void)state;
    enum { count = 12 };
    world *w = world_begin(2);
    uint32_t grey = world_lambert(w, 0.5f, 0);
    world_room(w, grey, v3(0, 0, -4), v3(6, 3, 0));
    world_box(w, grey, v3(2.92f, 0, -4), v3(3.08f, 3, -2.2f));
    world_box(w, grey, v3(2.92f, 0, -1.2f), v3(3.08f, 3, 0));
    world_commit(w);
    rsv_probe sensor[count];
    uint32_t room[count];
    size_t rooms;
    for (int k = 0; k < count; k++) // 0.6 m apart across the wall, through the doorway
        sensor[k] = up_at(k < 6 ? 2.7f - 0.5f * (float)k : 3.3f + 0.5f * (float)(k - 6), 0.8f,
            k == 3 ? -1.6f : -1.7f);
    sensor[0].position.x = sensor[6].position.x - 0.76f;
    assert_int_equal(rsv_daylight_rooms(w->scene, sensor, count, room, &rooms), RSV_OK);
    assert_int_equal(rooms, 2);
    for (int k = 0; k < count; k++)
        assert_int_equal(room[k], k >= 6);
    assert_int_equal(rsv_daylight_rooms(w->scene, sensor, 0, room, &rooms), RSV_OK);
    assert_int_equal(rooms, 0);
    world_end(w);
}

static void openings_are_told_apart(void **state)
{
    (void)state;
    rsv_probe sensor[] = { up_at(2, 0.8f, -2.5f), up_at(1, 0.8f, -1) };
    const uint32_t room[] = { 0, 0 };
    rsv_material clear = glass_material(), diffusing = lambert_material(0.8f, 0);
    clear.thickness = 0;
    diffusing.diffuse_transmission = 0.6f, diffusing.double_sided = true;
    for (int k = 0; k < 8; k++) { // none, roof, window, both; of glass, of a diffusing pane
        bool roof = k & 1, window = k & 2, rooflit = !roof;
        world *w = world_begin(1);
        uint32_t pane = world_material(w, k < 4 ? clear : diffusing);
        build_lit_room(w, roof, window);
        if (roof) add_pane(w, pane, false);
        if (window) add_pane(w, pane, true);
        world_commit(w);
        assert_int_equal(rsv_daylight_rooflit(w->scene, sensor, 2, room, 1, &rooflit), RSV_OK);
        assert_int_equal(rooflit, roof && !window);
        world_end(w);
    }
    assert_int_equal(rsv_daylight_class_rooflit(750), 3);
    assert_int_equal(rsv_daylight_class_rooflit(749), 2);
    assert_int_equal(rsv_daylight_class_rooflit(300), 1);
    assert_int_equal(rsv_daylight_class_rooflit(299), 0);
}

/// Rooms of an automatic grid in 4 x 3 x 8 m and `across` beyond a wall, with a doorway of 1 m.
/// @param count out, [8] sensors of each room
static size_t count_rooms(float wall, float across, double spacing, size_t count[8])
{
    world *w = world_begin(1);
    uint32_t grey = world_lambert(w, 0.5f, 0);
    world_room(w, grey, v3(0, 0, -8), v3(4 + wall + across, 3, 0));
    world_box(w, grey, v3(4, 0, -8), v3(4 + wall, 3, -2.25f));
    world_box(w, grey, v3(4, 0, -1.25f), v3(4 + wall, 3, 0));
    world_commit(w);
    rsv_probe *sensor;
    size_t sensors, rooms;
    assert_int_equal(rsv_daylight_sensors(w->scene, 0.8, spacing, &sensor, &sensors), RSV_OK);
    uint32_t *room = calloc(sensors, sizeof *room);
    assert_non_null(room);
    assert_int_equal(rsv_daylight_rooms(w->scene, sensor, sensors, room, &rooms), RSV_OK);
    for (size_t k = 0; k < sensors; k++)
        if (room[k] < 8) count[room[k]]++;
    free(room);
    rsv_daylight_free_sensors(w->scene, sensor);
    world_end(w);
    return rooms;
}

/// A doorway neither merges rooms nor is one, whatever the wall's thickness; a corridor is one room, a solid none.
static void doorways_part_rooms(void **state)
{
    (void)state;
    const struct {
        float wall, across;
        double spacing;
        size_t least[2];
    } plan[] = { { 0.15f, 4, 0.5, { 80, 80 } }, { 0.45f, 4, 0.5, { 80, 80 } },
        { 1, 4, 0.3, { 250, 250 } }, { 0.15f, 1.05f, 0.5, { 80, 12 } } };
    for (size_t k = 0; k < sizeof plan / sizeof *plan; k++) {
        size_t count[8] = { 0 };
        assert_int_equal(count_rooms(plan[k].wall, plan[k].across, plan[k].spacing, count), 2);
        assert_true(count[0] >= plan[k].least[0] && count[1] >= plan[k].least[1]);
    }
}

static void grids_stand_on_floors(void **state)
{
    (void)state;
    world *w = world_begin(1);
    uint32_t grey = world_lambert(w, 0.5f, 0);
    world_box(w, grey, v3(1.5f, 0, -3), v3(2.5f, 1.2f, -2)); // a cupboard, higher than the sensors
    build_room(w, 0, RSV_NONE);
    rsv_probe *sensor;
    size_t count;
    assert_int_equal(rsv_daylight_sensors(w->scene, 0.8, 0.5, &sensor, &count), RSV_OK);
    assert_int_equal(
        count, 42); // 6 by 9 but for the cupboard and its surroundings, 4 by 4 less corners
    for (size_t k = 0; k < count; k++) {
        rsv_vec3 p = sensor[k].position;
        assert_close((double)p.y, 0.8, 1e-5);
        assert_true(p.x > 0.29f && p.x < 3.71f && p.z < -0.24f && p.z > -4.71f);
        assert_false(p.x > 1.21f && p.x < 2.79f && p.z > -3 && p.z < -2);
    }
    rsv_daylight_free_sensors(w->scene, sensor);
    assert_int_equal(rsv_daylight_sensors(w->scene, 0, 0.5, &sensor, &count), RSV_ERROR_ARGUMENT);
    world_end(w);
    w = world_begin(1);
    build_open(w);
    assert_int_equal(rsv_daylight_sensors(w->scene, 0.8, 0.5, &sensor, &count), RSV_ERROR_SCENE);
    world_end(w);
}

static void failing_allocations_are_reported(void **state)
{
    (void)state;
    world *w = world_begin(1);
    build_room(w, 0, RSV_NONE);
    rsv_weather_hour hour = record_at(3, 21, 10.5, 650, 140);
    rsv_weather weather = weather_of(&hour, 1);
    rsv_probe sensor = up_at(1, 0.8f, -1);
    rsv_daylight_desc desc = rsv_default_daylight_desc(RSV_QUALITY_DRAFT);
    desc.sensor_rays = 240;
    solved s = solve_with(w, &weather, &sensor, 1, &desc, 300);
    rsv_daylight_destroy(s.daylight);
    rsv_status status = RSV_ERROR_MEMORY;
    for (long k = 0; status != RSV_OK; k += 1 + k / 16) {
        w->until_failure = k;
        status = rsv_daylight_create(s.light, &sensor, 1, &desc, &s.daylight);
        w->until_failure = -1;
        if (status != RSV_OK) assert_int_equal(status, RSV_ERROR_MEMORY);
    }
    status = RSV_ERROR_MEMORY;
    rsv_daylight_run_desc run = rsv_default_daylight_run_desc();
    for (long k = 0; status != RSV_OK; k++) {
        rsv_daylight_report report;
        w->until_failure = k;
        status = rsv_daylight_run(s.daylight, &weather, &run, &report);
        w->until_failure = -1;
        if (status != RSV_OK) assert_int_equal(status, RSV_ERROR_MEMORY);
        rsv_daylight_report_free(s.daylight, &report);
    }
    release(&s);
    world_end(w);
}

// ---- compared with Radiance ----------------------------------------------------------------------------------

enum { room_sensors = 24, file_limit = 512 };

static const char *in_reference(char path[file_limit], const char *name)
{
    const char *assets = getenv("RSV_ASSETS");
    snprintf(path, file_limit, "%s/../validation/daylight/%s", assets ? assets : "../shared/assets",
        name);
    return path;
}

static void lay_sensors(rsv_probe sensor[room_sensors])
{
    for (int k = 0; k < room_sensors; k++)
        sensor[k] = up_at(0.5f + (float)(k % 4), 0.8f, -0.5f - (float)(k / 4)); // pts.csv
}

/// Relative mean squared difference from the readings of the reference, and the ratio of the sums.
static void compare_hours(FILE *file, const float *hourly, double *rms, double *mean)
{
    char line[file_limit];
    double squares = 0, count = 0, sums[2] = { 0 };
    assert_non_null(fgets(line, sizeof line, file));
    while (fgets(line, sizeof line, file)) {
        char *cell = line;
        long row = strtol(cell, &cell, 10);
        for (int k = 0; k < room_sensors; k++) {
            double expected = strtod(cell + 1, &cell);
            double lux = (double)hourly[(row - 1) * room_sensors + k];
            squares += pow(lux / expected - 1, 2), count++;
            sums[0] += lux, sums[1] += expected;
        }
    }
    *rms = sqrt(squares / count), *mean = sums[0] / sums[1];
}

static void room_is_that_of_radiance(void **state)
{
    (void)state;
    char path[file_limit];
    FILE *file = fopen(in_reference(path, "sky_lux.csv"), "r");
    if (!file) {
        print_message("skipped: no %s\n", path);
        skip();
    }
    world *w = world_begin(2);
    rsv_scene_destroy(w->scene);
    assert_int_equal(rsv_scene_load(w->context, in_reference(path, "room.glb"), &w->scene), RSV_OK);
    rsv_weather weather;
    assert_int_equal(
        rsv_weather_read(w->context, in_reference(path, "chicago_ohare_tmy3.epw"), &weather),
        RSV_OK);
    rsv_probe sensor[room_sensors];
    lay_sensors(sensor);
    rsv_daylight_desc desc = rsv_default_daylight_desc(RSV_QUALITY_MEDIUM);
    solved s = solve_with(w, &weather, sensor, room_sensors, &desc, 5000);
    rsv_daylight_run_desc run = rsv_default_daylight_run_desc();
    rsv_daylight_report report;
    run.sky_only = true;
    run.hourly = calloc(weather.count * room_sensors, sizeof *run.hourly);
    assert_non_null(run.hourly);
    assert_int_equal(rsv_daylight_run(s.daylight, &weather, &run, &report), RSV_OK);
    double rms, mean;
    compare_hours(file, run.hourly, &rms, &mean);
    print_message("RMS %.4f, mean %.5f of the reference\n", rms, mean);
    assert_true(rms < 0.02 && fabs(mean - 1) < 0.005);
    for (int k = 0; k < room_sensors; k++)
        assert_true(report.sensor[k][RSV_SENSOR_MEAN].standard_error <
                    0.01 * report.sensor[k][RSV_SENSOR_MEAN].value);
    fclose(file);
    free(run.hourly);
    rsv_daylight_report_free(s.daylight, &report);
    release(&s);
    rsv_weather_free(w->context, &weather);
    world_end(w);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest quick[] = {
        cmocka_unit_test(open_ground_reads_what_the_sky_gives),
        cmocka_unit_test(windows_give_their_form_factor),
        cmocka_unit_test(rooms_without_windows_are_dark),
        cmocka_unit_test(errors_of_dark_rooms_are_small),
        cmocka_unit_test(figures_count_hours),
        cmocka_unit_test(grids_stand_on_floors),
        cmocka_unit_test(rooms_are_told_apart),
        cmocka_unit_test(openings_are_told_apart),
        cmocka_unit_test(failing_allocations_are_reported),
    };
    const struct CMUnitTest slow[] = {
        cmocka_unit_test(gray_rooms_read_as_tinted_ones),
        cmocka_unit_test(doorways_part_rooms),
        cmocka_unit_test(sun_passes_clear_panes),
        cmocka_unit_test(threads_change_nothing),
        cmocka_unit_test(shades_go_down_in_the_sun),
        cmocka_unit_test(shades_go_down_room_by_room),
        cmocka_unit_test(hours_are_those_of_the_path_tracer),
        cmocka_unit_test(room_is_that_of_radiance),
    };
    const struct CMUnitTest longest[] = {
        cmocka_unit_test(skies_behind_panes_are_those_of_the_path_tracer),
        cmocka_unit_test(scenes_may_be_turned),
        cmocka_unit_test(frosted_panes_spread_the_sky),
        cmocka_unit_test(diffusing_panes_spread_the_sky),
        cmocka_unit_test(standard_errors_tell_the_spread),
    };
    return RUN_THIRD(argc, argv, quick, slow, longest);
}
