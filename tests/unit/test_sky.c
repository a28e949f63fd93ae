/// The sun's position, standard skies, that of Perez, patches and weather files.
#include "file_fixture.h"
#include "resolvent/sky.h"

#define DEGREES (M_PI / 180)

#define assert_near(value, expected, tolerance)                                                    \
    do {                                                                                           \
        double got = (value), wanted = (expected);                                                 \
        if (!(fabs(got - wanted) <= (tolerance)))                                                  \
            fail_msg(#value " is %.9g, expected %.9g", got, wanted);                               \
    } while (0)

// ---- the sun ------------------------------------------------------------------------------------

/// The example of Reda and Andreas (2008, table A5.1): topocentric, refraction of 0.016332 degrees taken out.
static void sun_is_where_the_published_example_has_it(void **state)
{
    (void)state;
    rsv_site golden = { 39.742476, -105.1786, -7, 1830.14 };
    rsv_moment moment = { 2003, 10, 17, 12 + 30 / 60.0 + 30 / 3600.0 };
    rsv_solar_position sun = rsv_sun_position(&golden, &moment);
    assert_near(sun.elevation / DEGREES, 39.872046, 0.0005);
    assert_near(sun.azimuth / DEGREES, 194.340241, 0.0005);
    assert_near(sun.distance, 0.9965422974, 5e-6);
}

/// Equinox and solstices of 2024 to the minute (Meeus 1998): declinations 0, 23.438, -23.438 degrees at the pole.
static void seasons_begin_when_almanacs_say(void **state)
{
    (void)state;
    rsv_site pole = { 90, 0, 0, 0 };
    rsv_moment equinox = { 2024, 3, 20, 3 + 6 / 60.0 }, summer = { 2024, 6, 20, 20.85 };
    rsv_moment winter = { 2024, 12, 21, 9.33 };
    const double parallax = 8.794 / 3600;
    assert_near(rsv_sun_position(&pole, &equinox).elevation / DEGREES, -parallax, 0.0005);
    assert_near(rsv_sun_position(&pole, &summer).elevation / DEGREES, 23.4385 - parallax, 0.001);
    assert_near(rsv_sun_position(&pole, &winter).elevation / DEGREES, -23.4385 - parallax, 0.001);
}

static void sun_stands_in_the_north_of_southern_places(void **state)
{
    (void)state;
    rsv_site sydney = { -33.87, 151.21, 10, 0 };
    rsv_moment noon = { 2023, 12, 22, 11.95 };
    rsv_solar_position sun = rsv_sun_position(&sydney, &noon);
    assert_true(sun.direction.z < 0 && sun.elevation > 79 * DEGREES);
    assert_near((double)sun.direction.y, sin(sun.elevation), 1e-6);
    assert_near((double)sun.direction.x, cos(sun.elevation) * sin(sun.azimuth), 1e-6);
}

static void days_are_counted_across_centuries(void **state)
{
    (void)state;
    assert_int_equal(rsv_day_number(2000, 1, 1), 0);
    assert_int_equal(rsv_day_number(1970, 1, 1), -10957);
    assert_int_equal(rsv_day_number(2100, 3, 1), 36584);
    assert_int_equal(rsv_day_number(1900, 1, 1), -36524);
    assert_int_equal(rsv_day_of_year(2024, 12, 31), 366);
    assert_false(rsv_is_leap_year(1900));
}

// ---- skies --------------------------------------------------------------------------------------

static rsv_vec3 direction_of(double elevation, double azimuth)
{
    return (rsv_vec3){ (float)(cos(elevation) * sin(azimuth)), (float)sin(elevation),
        (float)(-cos(elevation) * cos(azimuth)) };
}

/// Luminances relative to the zenith from the formulas of the standard, computed by hand for types 1, 5 and 12.
static void standard_skies_have_their_shapes(void **state)
{
    (void)state;
    rsv_vec3 sun = direction_of(45 * DEGREES, 0), up = { 0, 1, 0 };
    rsv_sky_shape overcast = rsv_cie_sky(1, sun), even = rsv_cie_sky(5, sun);
    rsv_vec3 low = direction_of(30 * DEGREES, 1);
    double gradation = (1 + 4 * exp(-0.7 / 0.5)) / (1 + 4 * exp(-0.7));
    assert_near(
        rsv_sky_shape_at(&overcast, low) / rsv_sky_shape_at(&overcast, up), gradation, 1e-6);
    assert_near(rsv_sky_shape_at(&even, low) / rsv_sky_shape_at(&even, up), 1, 1e-6);
    rsv_sky_shape clear = rsv_cie_sky(12, sun);
    double at_right_angles = 1 - exp(-0.32 / sin(45 * DEGREES));
    rsv_vec3 across = direction_of(45 * DEGREES, M_PI); // f(90 degrees) = 1 there
    assert_near(rsv_sky_shape_at(&clear, across), at_right_angles, 1e-6);
    assert_true(rsv_sky_shape_at(&clear, sun) > 5 * at_right_angles);
}

/// 1 + 2 sin is what type 16 is: the ground gets 7/9 pi of the zenith's luminance.
static void traditional_overcast_sky_gives_seven_ninths(void **state)
{
    (void)state;
    rsv_sky_patches patches = rsv_sky_patches_of(16);
    rsv_sky_shape shape = rsv_cie_sky(RSV_CIE_TRADITIONAL_OVERCAST, (rsv_vec3){ 0, 1, 0 });
    float *luminance = calloc(patches.count, sizeof *luminance);
    assert_non_null(luminance);
    rsv_sky_patch_luminances(&patches, &shape, 10000, luminance);
    assert_near((double)luminance[patches.count - 1], 10000 * 9 / (7 * M_PI), 10);
    rsv_vec3 low = direction_of(20 * DEGREES, 2);
    assert_near(rsv_sky_shape_at(&shape, low) / rsv_sky_shape_at(&shape, (rsv_vec3){ 0, 1, 0 }),
        (1 + 2 * sin(20 * DEGREES)) / 3, 1e-6);
    free(luminance);
}

static void skies_never_are_negative_or_undefined(void **state)
{
    (void)state;
    for (int k = 0; k < 4000; k++) {
        rsv_vec3 sun = direction_of((k % 19 - 4) * 5 * DEGREES, k * 0.7);
        rsv_irradiance_record r = { (k * 37) % 1100, (k * 53) % 700, k % 7 ? k % 30 - 10 : NAN,
            1 + k % 366 };
        rsv_perez_sky sky = rsv_perez_sky_of(&r, sun);
        assert_true(isfinite(sky.diffuse_illuminance) && sky.diffuse_illuminance >= 0);
        assert_true(isfinite(sky.direct_illuminance) && sky.direct_illuminance >= 0);
        for (int j = 0; j < 20; j++) {
            double value = rsv_sky_shape_at(&sky.shape, direction_of(j * 4.7 * DEGREES, j));
            assert_true(isfinite(value) && value >= 0);
        }
    }
}

static void illuminances_stand_for_the_irradiances_they_come_from(void **state)
{
    (void)state;
    rsv_vec3 sun = direction_of(40 * DEGREES, 2);
    rsv_irradiance_record r = { 600, 120, 12, 100 };
    rsv_perez_sky sky = rsv_perez_sky_of(&r, sun);
    rsv_perez_sky again =
        rsv_perez_sky_of_illuminance(sky.diffuse_illuminance, sky.direct_illuminance, &r, sun);
    assert_near(again.clearness, sky.clearness, 0.02 * sky.clearness);
    assert_near(again.brightness, sky.brightness, 0.02 * sky.brightness);
    assert_near(again.diffuse_illuminance, sky.diffuse_illuminance, 1e-9);
}

// ---- patches ------------------------------------------------------------------------------------

static void patches_cover_the_sky(void **state)
{
    (void)state;
    for (uint32_t m = 1; m <= 6; m++) {
        rsv_sky_patches p = rsv_sky_patches_of(m);
        double sum = 0;
        assert_int_equal(p.count, 144 * m * m + 2);
        for (uint32_t k = 1; k < p.count; k++) {
            sum += rsv_sky_patch_solid_angle(&p, k);
            assert_int_equal(rsv_sky_patch_at(&p, rsv_sky_patch_direction(&p, k)), k);
        }
        assert_near(sum, 2 * M_PI, 1e-9);
        assert_int_equal(rsv_sky_patch_at(&p, (rsv_vec3){ 0, -0.001f, 1 }), 0);
        assert_int_equal(rsv_sky_patch_at(&p, (rsv_vec3){ 0, 1, 0 }), p.count - 1);
    }
}

/// Directions spread evenly end in patches by their solid angles.
static void patches_take_their_share_of_directions(void **state)
{
    (void)state;
    enum { samples = 1000000 };
    rsv_sky_patches p = rsv_sky_patches_of(2);
    double *count = calloc(p.count, sizeof *count);
    assert_non_null(count);
    for (int k = 0; k < samples; k++) {
        double up = (k + 0.5) / samples, turn = 2 * M_PI * fmod(k * 0.6180339887498949, 1);
        count[rsv_sky_patch_at(&p, direction_of(asin(up), turn))]++;
    }
    for (uint32_t k = 1; k < p.count; k++) {
        double expected = samples * rsv_sky_patch_solid_angle(&p, k) / (2 * M_PI);
        assert_near(count[k], expected, 0.04 * expected + 5);
    }
    free(count);
}

static void patch_luminances_give_the_wanted_illuminance(void **state)
{
    (void)state;
    rsv_sky_patches p = rsv_sky_patches_of(4);
    float *luminance = calloc(p.count, sizeof *luminance);
    assert_non_null(luminance);
    rsv_sky_shape shapes[] = { rsv_cie_sky(13, direction_of(0.5, 1)),
        { .a = -1, .b = 0, .sun = { 0, 1, 0 } } };
    for (int k = 0; k < 2; k++) {
        double sum = 0;
        rsv_sky_patch_luminances(&p, &shapes[k], 8000, luminance);
        for (uint32_t i = 1; i < p.count; i++)
            sum += (double)luminance[i] * rsv_sky_patch_solid_angle(&p, i) *
                   (double)rsv_sky_patch_direction(&p, i).y;
        assert_near(sum, 8000, k ? 20 : 0.5);
    }
    free(luminance);
}

// ---- weather files ------------------------------------------------------------------------------

static rsv_status read_as(file_fixture *f, const char *text, rsv_weather *weather)
{
    const char *path = path_in(&f->folder, "weather.epw");
    write_bytes(path, text, strlen(text));
    return rsv_weather_read(f->context, path, weather);
}

#define HEADER(place, per_hour)                                                                    \
    "LOCATION,Here,-,-,-,1," place "\nDESIGN CONDITIONS,0\nTYPICAL/EXTREME PERIODS,0\nGROUND "     \
    "TEMPERATURES,0\nHOLIDAYS/DAYLIGHT SAVINGS,No,0,0,0\nCOMMENTS 1,\nCOMMENTS 2,\nDATA "          \
    "PERIODS,1," per_hour ",Data,Sunday, 1/ 1,12/31\n"
#define RECORD(date, values) date ",?9?9,1.0,4.0,73,99500,0,0,218," values ",0,0,0,0,270,2.6\n"

static void epw_records_are_read(void **state)
{
    file_fixture *f = *state;
    rsv_weather w;
    assert_int_equal(
        read_as(f,
            "\xef\xbb\xbf" HEADER("41.98,-87.92,-6.0,201.0", "1")
                RECORD("1986,6,1,12,60", "700,600,150") RECORD("1986,6,1,13,0", "720,610,155"),
            &w),
        RSV_OK);
    assert_string_equal(w.name, "Here");
    assert_int_equal(w.count, 2);
    assert_near(w.site.longitude, -87.92, 0);
    assert_near(w.hour[0].moment.hour, 11.5, 0);
    assert_near(w.hour[1].moment.hour, 12.5, 0);
    assert_near(w.hour[1].record.direct_normal, 610, 0);
    assert_near(w.hour[1].record.diffuse_horizontal, 155, 0);
    assert_near(w.hour[1].record.dew_point, 4, 0);
    assert_int_equal(w.missing, 8758);
    rsv_weather_free(f->context, &w);
}

/// An hour that occurs twice does not stand for one that is missing.
static void repeated_hours_cover_one(void **state)
{
    file_fixture *f = *state;
    rsv_weather w;
    assert_int_equal(read_as(f,
                         HEADER("41.98,-87.92,-6.0,201.0", "1") RECORD("1986,6,1,12,60",
                             "700,600,150") RECORD("1986,6,1,12,60", "700,600,150"),
                         &w),
        RSV_OK);
    assert_int_equal(w.count, 2);
    assert_int_equal(w.missing, 8759);
    rsv_weather_free(f->context, &w);
}

static void half_hours_and_leap_days_are_read(void **state)
{
    file_fixture *f = *state;
    rsv_weather w;
    assert_int_equal(
        read_as(f,
            HEADER("-41,174,12,5", "2") RECORD("2024,2,29,12,30", "700,600,150") "\r\n" RECORD(
                "2024,2,29,12,60", "700,600,150") RECORD("2023,2,29,13,0", "700,600,150"),
            &w),
        RSV_OK);
    assert_true(w.leap);
    assert_near(w.hour[0].moment.hour, 11.25, 0);
    assert_near(w.hour[1].moment.hour, 11.75, 0);
    assert_near(w.hour[2].moment.hour, 12.25, 0);
    assert_near(w.hour[0].hours, 0.5, 0);
    assert_int_equal(w.hour[0].record.day_of_year, 60);
    assert_int_equal(w.missing, 8783);
    rsv_weather_free(f->context, &w);
}

static void gaps_are_filled(void **state)
{
    file_fixture *f = *state;
    rsv_weather w;
    assert_int_equal(
        read_as(f,
            HEADER("41,-87,-6,2", "1") RECORD("2001,6,1,12,60", "700,600,150")
                RECORD("2001,6,1,13,60", "700,500,140") RECORD("2001,6,2,12,60", "9999,9999,9999")
                    RECORD("2001,6,2,13,60", "800,9999,150") RECORD("2001,6,2,1,60", "0,,9999"),
            &w),
        RSV_OK);
    assert_int_equal(w.filled, 1);
    assert_true(w.hour[2].filled);
    assert_near(w.hour[2].record.direct_normal, 600, 0);
    double up = sin(rsv_sun_position(&w.site, &w.hour[3].moment).elevation);
    assert_near(w.hour[3].record.direct_normal, 650 / up, 0.01);
    assert_near(w.hour[4].record.direct_normal, 0, 0);
    rsv_weather_free(f->context, &w);
}

static void wea_files_are_read(void **state)
{
    file_fixture *f = *state;
    rsv_weather w;
    assert_int_equal(
        read_as(f,
            "place Somewhere\nlatitude 41.98\nlongitude 87.92\ntime_zone 90\nsite_elevation 201\n"
            "weather_data_file_units 1\n1 1 0.500 0 0\n1 1 1.500 100 50\n",
            &w),
        RSV_OK);
    assert_string_equal(w.name, "Somewhere");
    assert_near(w.site.longitude, -87.92, 0);
    assert_near(w.site.time_zone, -6, 1e-12);
    assert_near(w.hour[1].record.direct_normal, 100, 0);
    assert_near(w.hour[1].hours, 1, 0);
    rsv_weather_free(f->context, &w);
    assert_int_equal(
        read_as(f,
            "place X\nlatitude 41.98\nlongitude 87.92\ntime_zone 90\nsite_elevation 201\n"
            "weather_data_file_units 2\n6 21 12.0 60000 20000\n",
            &w),
        RSV_OK);
    rsv_perez_sky sky = rsv_weather_sky(&w, 0, NULL);
    assert_near(sky.direct_illuminance, 60000, 0);
    assert_near(sky.diffuse_illuminance, 20000, 0);
    rsv_weather_free(f->context, &w);
}

static void polar_night_has_no_light(void **state)
{
    file_fixture *f = *state;
    rsv_weather w;
    assert_int_equal(
        read_as(f, HEADER("78.2,15.6,1,20", "1") RECORD("2001,12,21,12,60", "0,0,0"), &w), RSV_OK);
    rsv_solar_position sun;
    rsv_perez_sky sky = rsv_weather_sky(&w, 0, &sun);
    assert_true(sun.elevation < 0);
    assert_near(sky.diffuse_illuminance + sky.direct_illuminance, 0, 0);
    rsv_weather_free(f->context, &w);
}

static void bad_weather_files_are_refused(void **state)
{
    file_fixture *f = *state;
    static const char *const wrong[] = { "", "hello\n", "LOCATION,a,b\n", HEADER("95,0,0,0", "1"),
        HEADER("5,0,0,0", "1"), HEADER("5,0,0,0", "0") RECORD("2001,6,1,12,60", "7,6,1"),
        HEADER("5,0,0,0", "1") RECORD("2001,13,1,12,60", "7,6,1"),
        HEADER("5,0,0,0", "1") RECORD("2001,4,31,12,60", "7,6,1"),
        HEADER("5,0,0,0", "1") RECORD("2001,4,1,25,60", "7,6,1"),
        HEADER("5,0,0,0", "1") RECORD("2001,4,1,12,60", "7,x,1"),
        HEADER("5,0,0,0", "1") RECORD("2001,4,1,12,60", "9999,9999,9999"),
        HEADER("5,0,0,0", "1") "2001,4,1,12,60,?,1,2\n", "place A\nlatitude 5\n",
        "place A\nlatitude 5\nlongitude 5\ntime_zone 0\nweather_data_file_units 7\n1 1 1 1 1\n",
        "place A\nlatitude 5\nlongitude 5\ntime_zone 0\nweather_data_file_units 1\n1 1 1 1\n",
        "place A\nlatitude 5\nlongitude 5\ntime_zone 0\nweather_data_file_units 1\n1 1 nan 1 1\n" };
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
        rsv_weather w;
        if (read_as(f, wrong[k], &w) != RSV_ERROR_FORMAT) fail_msg("file %zu is read", k);
        assert_non_null(strstr(rsv_last_error(), "weather.epw"));
        rsv_weather_free(f->context, &w);
    }
    rsv_weather w;
    assert_int_equal(rsv_weather_read(f->context, "/nowhere/at.epw", &w), RSV_ERROR_IO);
}

// ---- compared with Radiance ------------------------------------------------------------------------------

/// Patches of the reference: hours, and the luminance of each patch divided by 179.
enum { hour_limit = 8 };

static size_t read_reference(
    const char *path, int hour[hour_limit], double value[][hour_limit], size_t rows)
{
    FILE *file = fopen(path, "r");
    if (!file) return 0;
    size_t hours = 0, row = 0;
    char line[512];
    assert_non_null(fgets(line, sizeof line, file));
    for (char *cell = strtok(line, ",\n"); (cell = strtok(NULL, ",\n")) && hours < hour_limit;
         hours++)
        hour[hours] = atoi(cell + 1);
    for (; row < rows && fgets(line, sizeof line, file); row++) {
        strtok(line, ",");
        for (size_t k = 0; k < hours; k++)
            value[row][k] = strtod(strtok(NULL, ",\n"), NULL);
    }
    fclose(file);
    assert_int_equal(row, rows);
    return hours;
}

/// The sun as the reference has it: by the approximate formulas of the IES (Lighting Handbook, 8th edition, chapter 8), up to
/// half a degree off, by which patches next to the sun differ by more than what is tested here.
static rsv_vec3 reference_sun(const rsv_site *site, const rsv_weather_hour *hour)
{
    int day = hour->record.day_of_year;
    double declination = 0.4093 * sin(2 * M_PI / 365 * (day - 81)), phi = site->latitude * DEGREES;
    double solar = hour->moment.hour + 0.170 * sin(4 * M_PI / 373 * (day - 80)) -
                   0.129 * sin(2 * M_PI / 355 * (day - 8)) +
                   (site->longitude - 15 * site->time_zone) / 15;
    double turn = (solar - 12) * M_PI / 12;
    double up = sin(phi) * sin(declination) + cos(phi) * cos(declination) * cos(turn);
    double east = -cos(declination) * sin(turn);
    double north = cos(phi) * sin(declination) - sin(phi) * cos(declination) * cos(turn);
    return (rsv_vec3){ (float)east, (float)up, (float)-north };
}

static void compare_hour(const rsv_weather *w, int row, size_t column, double value[][hour_limit])
{
    static float luminance[146];
    rsv_sky_patches patches = rsv_sky_patches_of(1);
    rsv_weather_hour hour = w->hour[row - 1];
    rsv_vec3 sun = reference_sun(&w->site, &hour);
    rsv_perez_sky sky = rsv_perez_sky_of(&hour.record, sun);
    rsv_sky_patch_luminances(&patches, &sky.shape, sky.diffuse_illuminance, luminance);
    luminance[0] =
        (float)(0.2 / M_PI *
                (sky.diffuse_illuminance + fmax((double)sun.y, 0) * sky.direct_illuminance));
    for (size_t k = 0; k < patches.count; k++) {
        double expected = 179 * value[k][column]; // three digits
        if (fabs((double)luminance[k] - expected) > 0.01 * expected)
            fail_msg("hour %d, patch %zu: %g, expected %g", row, k, (double)luminance[k], expected);
    }
}

static void patches_are_those_of_the_reference(void **state)
{
    file_fixture *f = *state;
    const char *assets = getenv("RSV_ASSETS");
    char path[512];
    static double value[146][hour_limit];
    int hour[hour_limit];
    snprintf(path, sizeof path, "%s/../validation/daylight/sky_patches.csv",
        assets ? assets : "../shared/assets");
    size_t hours = read_reference(path, hour, value, 146);
    if (hours == 0) {
        print_message("skipped: no %s\n", path);
        skip();
    }
    snprintf(path, sizeof path, "%s/../validation/daylight/chicago_ohare_tmy3.epw",
        assets ? assets : "../shared/assets");
    rsv_weather w;
    assert_int_equal(rsv_weather_read(f->context, path, &w), RSV_OK);
    assert_int_equal(w.count, 8760);
    assert_int_equal(w.missing + w.filled, 0);
    for (size_t k = 0; k < hours; k++)
        compare_hour(&w, hour[k], k, value);
    rsv_weather_free(f->context, &w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sun_is_where_the_published_example_has_it),
        cmocka_unit_test(seasons_begin_when_almanacs_say),
        cmocka_unit_test(sun_stands_in_the_north_of_southern_places),
        cmocka_unit_test(days_are_counted_across_centuries),
        cmocka_unit_test(standard_skies_have_their_shapes),
        cmocka_unit_test(traditional_overcast_sky_gives_seven_ninths),
        cmocka_unit_test(skies_never_are_negative_or_undefined),
        cmocka_unit_test(illuminances_stand_for_the_irradiances_they_come_from),
        cmocka_unit_test(patches_cover_the_sky),
        cmocka_unit_test(patches_take_their_share_of_directions),
        cmocka_unit_test(patch_luminances_give_the_wanted_illuminance),
        cmocka_unit_test_setup_teardown(epw_records_are_read, file_set_up, file_tear_down),
        cmocka_unit_test_setup_teardown(repeated_hours_cover_one, file_set_up, file_tear_down),
        cmocka_unit_test_setup_teardown(
            half_hours_and_leap_days_are_read, file_set_up, file_tear_down),
        cmocka_unit_test_setup_teardown(gaps_are_filled, file_set_up, file_tear_down),
        cmocka_unit_test_setup_teardown(wea_files_are_read, file_set_up, file_tear_down),
        cmocka_unit_test_setup_teardown(polar_night_has_no_light, file_set_up, file_tear_down),
        cmocka_unit_test_setup_teardown(bad_weather_files_are_refused, file_set_up, file_tear_down),
        cmocka_unit_test_setup_teardown(
            patches_are_those_of_the_reference, file_set_up, file_tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
