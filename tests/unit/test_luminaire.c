/// Luminaire files: intensities, symmetries, flux, and errors in files.
#include "file_fixture.h"
#include "luminaire_fixture.h"

#define assert_near(value, expected, tolerance)                                                    \
    do {                                                                                           \
        double got = (value), wanted = (expected);                                                 \
        if (!(fabs(got - wanted) <= (tolerance)))                                                  \
            fail_msg(#value " is %.9g, expected %.9g", got, wanted);                               \
    } while (0)

static rsv_status read_as(file_fixture *f, const char *text, rsv_luminaire *l)
{
    const char *path = path_in(&f->folder, "lamp.ies");
    write_bytes(path, text, strlen(text));
    return rsv_luminaire_read(f->context, path, l);
}

/// Towards gamma from straight down and C about the vertical axis.
static rsv_vec3 towards(double gamma, double c)
{
    return (
        rsv_vec3){ (float)(sin(gamma) * cos(c)), (float)(sin(gamma) * sin(c)), (float)-cos(gamma) };
}

/// The integral of the light over the sphere, by so many directions spread evenly.
static double sphere_integral(const rsv_luminaire *l)
{
    enum { directions = 400000 };
    double sum = 0;
    for (int k = 0; k < directions; k++) {
        double up = 2 * (k + 0.5) / directions - 1,
               turn = 2 * M_PI * fmod(k * 0.6180339887498949, 1);
        double across = sqrt(1 - up * up);
        sum += rsv_luminaire_intensity(
            l, (rsv_vec3){ (float)(across * cos(turn)), (float)up, (float)(across * sin(turn)) });
    }
    return 4 * M_PI * sum / directions;
}

/// Written as LM-63 and read again it is the same.
static void check_printed(file_fixture *f, const rsv_luminaire *l)
{
    rsv_luminaire again;
    char *text = NULL;
    assert_int_equal(rsv_luminaire_print(f->context, l, &text), RSV_OK);
    if (rsv_luminaire_parse(f->context, "again", text, strlen(text), &again) != RSV_OK)
        fail_msg("%s", rsv_last_error());
    size_t count = (size_t)l->vertical_count * l->horizontal_count;
    assert_int_equal(again.vertical_count * again.horizontal_count, count);
    assert_memory_equal(again.intensity, l->intensity, count * sizeof *l->intensity);
    assert_memory_equal(
        again.horizontal, l->horizontal, l->horizontal_count * sizeof *l->horizontal);
    rsv_luminaire_free(f->context, &again);
    rsv_free(f->context, text);
}

static void check_luminaire(file_fixture *f, char *text, int symmetry, rsv_vec3 opening)
{
    rsv_luminaire l;
    if (read_as(f, text, &l) != RSV_OK) fail_msg("%s", rsv_last_error());
    for (int k = 0; k < 200; k++) { // between planes, cos 2 C departs by 1.4 % from a line
        double gamma = k * 0.9 * DEGREES, c = k * 37.7 * DEGREES,
               expected = wanted_intensity(gamma, c, symmetry);
        assert_near(rsv_luminaire_intensity(&l, towards(gamma, c)), expected, 0.02 * expected + 1);
    }
    double flux = rsv_luminaire_flux(&l);
    assert_near(sphere_integral(&l), flux, 0.002 * flux);
    assert_near(l.lamp_lumens, 3000, 1e-6);
    assert_near(l.watts, 40, 1e-9);
    rsv_vec3 found = rsv_luminaire_opening(&l);
    assert_near(found.x, opening.x, 1e-6);
    assert_near(found.y, opening.y, 1e-6);
    assert_near(found.z, opening.z, 1e-6);
    check_printed(f, &l);
    rsv_luminaire_free(f->context, &l);
    free(text);
}

static void ies_files_of_all_versions_and_symmetries_are_read(void **state)
{
    for (int version = 0; version < 4; version++)
        for (int symmetry = 0; symmetry < 4; symmetry++)
            check_luminaire(
                *state, write_ies(version, symmetry, 3), symmetry, (rsv_vec3){ 0.6f, 0.3f, 0 });
}

static void eulumdat_files_of_all_symmetries_are_read(void **state)
{
    for (int symmetry = 0; symmetry < 4; symmetry++)
        check_luminaire(
            *state, write_eulumdat(symmetry, 3), symmetry, (rsv_vec3){ -0.5f, -0.5f, 0.02f });
}

/// I = 100 cos gamma: pi times 100 lm, and 2 pi times 100 lm of a lamp that shines alike to one side.
static void flux_is_exact_where_intensities_are_known(void **state)
{
    file_fixture *f = *state;
    rsv_luminaire l;
    assert_int_equal(
        read_as(f, "TILT=NONE\n1 -1 1 2 1 1 1 1 0 0\n1 1 10\n0 90\n0\n100 100\n", &l), RSV_OK);
    assert_near(rsv_luminaire_flux(&l), 200 * M_PI, 0.01);
    assert_near(rsv_luminaire_peak(&l), 100, 0);
    assert_near(rsv_luminaire_intensity(&l, (rsv_vec3){ 0, 0, 1 }), 0, 0);
    assert_near(l.width, 0.3048, 1e-9);
    assert_near(l.lamp_lumens, 0, 0);
    rsv_luminaire_free(f->context, &l);
}

/// The factor of TILT for a luminaire that points straight down multiplies all intensities.
static void tilts_factor_straight_down_is_applied(void **state)
{
    file_fixture *f = *state;
    rsv_luminaire l;
    assert_int_equal(read_as(f,
                         "TILT=INCLUDE\n1\n3\n0 45 90\n0.9 0.8 0.7\n"
                         "1 -1 1 2 1 1 1 1 0 0\n1 1 10\n0 90\n0\n100 100\n",
                         &l),
        RSV_OK);
    assert_near(rsv_luminaire_flux(&l), 0.9 * 200 * M_PI, 0.01);
    rsv_luminaire_free(f->context, &l);
    assert_int_equal(
        read_as(f, "TILT=INCLUDE\n1\n0\n1 -1 1 2 1 1 1 1 0 0\n1 1 10\n0 90\n0\n100 100\n", &l),
        RSV_OK);
    assert_near(rsv_luminaire_flux(&l), 200 * M_PI, 0.01);
    rsv_luminaire_free(f->context, &l);
}

static void forms_of_the_same_file_are_read(void **state)
{
    file_fixture *f = *state;
    static const char *const form[] = {
        "TILT=NONE\r1 -1 1 2 1 1 1 1 0 0\r1 1 10\r0 90\r0\r100 100\r",
        "IESNA:LM-63-2002\r\nTILT = none \r\n1,-1,1,2,1,1,1,1,0,0\r\n1 1 10 0 90 0 100 100",
        "[TEST] x\nTILT=None\n1 -1 1 2\n1 1 1 1 0 0 1 1 10 0\n90 0 100\n100\n\x1a",
    };
    for (size_t k = 0; k < sizeof form / sizeof *form; k++) {
        rsv_luminaire l;
        assert_int_equal(read_as(f, form[k], &l), RSV_OK);
        assert_near(rsv_luminaire_flux(&l), 200 * M_PI, 0.01);
        rsv_luminaire_free(f->context, &l);
    }
}

/// Types A and B, one half stated: latitudes and turns change places.
static void floodlights_and_headlights_are_told_apart(void **state)
{
    file_fixture *f = *state;
    for (int type = 2; type <= 3; type++) {
        char text[512];
        rsv_luminaire l;
        snprintf(text, sizeof text,
            "IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 3 3 %d 2 0 0 0\n1 1.1 10\n0 30 90\n0 45 90\n"
            "100 80 0\n60 40 0\n0 0 0\n",
            type);
        assert_int_equal(read_as(f, text, &l), RSV_OK);
        double v = 30 * DEGREES, h = 45 * DEGREES;
        rsv_vec3 a = { (float)(cos(v) * sin(h)), (float)sin(v), (float)(-cos(v) * cos(h)) };
        rsv_vec3 b = { (float)sin(h), (float)(cos(h) * sin(v)), (float)(-cos(h) * cos(v)) };
        rsv_vec3 d = type == 2 ? b : a;
        assert_near(rsv_luminaire_intensity(&l, d), 40, 0.01);
        assert_near(rsv_luminaire_intensity(&l, (rsv_vec3){ -d.x, -d.y, d.z }), 40, 0.01);
        assert_near(rsv_luminaire_intensity(&l, (rsv_vec3){ 0, 0, 1 }), 0, 0.01);
        double flux = rsv_luminaire_flux(&l);
        assert_near(sphere_integral(&l), flux, 0.002 * flux);
        rsv_luminaire_free(f->context, &l);
    }
}

static void bad_files_are_refused(void **state)
{
    file_fixture *f = *state;
    static const char *const wrong[] = { "", "hello\n", "TILT=NONE\n",
        "TILT=lamp.tlt\n1 1 1 1 1 1 1 1 1 1 1 1 1 0 0 5\n", "TILT=INCLUDE\n1 1e9\n",
        "TILT=INCLUDE\n1 2\n0 0\n1 1\n1 -1 1 2 1 1 1 1 0 0\n1 1 10\n0 90\n0\n100 100\n",
        "TILT=INCLUDE\n1 2\n0 90\n1 -1\n1 -1 1 2 1 1 1 1 0 0\n1 1 10\n0 90\n0\n100 100\n",
        "TILT=NONE\n1 1000 1 2 1 1 1 0 0 0 1 1 10\n0 90\n0\n100\n",
        "TILT=NONE\n1 1000 1 2 1 1 1 0 0 0 1 1 10\n90 0\n0\n100 1\n",
        "TILT=NONE\n1 1000 1 2 1 7 1 0 0 0 1 1 10\n0 90\n0\n100 1\n",
        "TILT=NONE\n1 1000 1 1000000 1000000 1 1 0 0 0 1 1 10\n0 90\n0\n100 1\n",
        "TILT=NONE\n1 1000 1 -2 1 1 1 0 0 0 1 1 10\n0 90\n0\n100 1\n",
        "TILT=NONE\n1 1000 1 2 1 1 1 0 0 0 1 1 10\n0 x\n0\n100 1\n",
        "TILT=NONE\n1 1000 1 2 1 1 1 0 0 0 1 1 10\n45 300\n0\n100 1\n",
        "TILT=NONE\n1 1000 1 2 1 1 1 0 0 0 1 1 10\n-90 90\n0\n100 1\n",
        "TILT=NONE\n1 1000 1 2 2 1 1 0 0 0 1 1 10\n0 90\n-90 300\n100 1 100 1\n",
        "TILT=NONE\n1 1000 1 2 1 3 1 0 0 0 1 1 10\n0 120\n0\n100 1\n", "maker\n1\n9\n24\n15\n",
        "maker\n1\n4\nx\n15\n" };
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
        rsv_luminaire l;
        rsv_status status = read_as(f, wrong[k], &l);
        if (status != RSV_ERROR_FORMAT) fail_msg("file %zu: status %d", k, (int)status);
        assert_non_null(strstr(rsv_last_error(), "lamp.ies"));
        rsv_luminaire_free(f->context, &l);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(
            ies_files_of_all_versions_and_symmetries_are_read, file_set_up, file_tear_down),
        cmocka_unit_test_setup_teardown(
            eulumdat_files_of_all_symmetries_are_read, file_set_up, file_tear_down),
        cmocka_unit_test_setup_teardown(
            flux_is_exact_where_intensities_are_known, file_set_up, file_tear_down),
        cmocka_unit_test_setup_teardown(
            floodlights_and_headlights_are_told_apart, file_set_up, file_tear_down),
        cmocka_unit_test_setup_teardown(
            forms_of_the_same_file_are_read, file_set_up, file_tear_down),
        cmocka_unit_test_setup_teardown(
            tilts_factor_straight_down_is_applied, file_set_up, file_tear_down),
        cmocka_unit_test_setup_teardown(bad_files_are_refused, file_set_up, file_tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
