/// Files of luminaires: intensities, symmetries, flux, and what is wrong with files.
#include "file_fixture.h"
#include "resolvent/luminaire.h"

#define DEGREES (M_PI / 180)

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

/// A made-up distribution of type C with the symmetry asked for: 1 = in C and -C, 2 = in C and 180 - C besides.
static double wanted_intensity(double gamma, double c, int symmetry)
{
    double around = symmetry == 3   ? 1
                    : symmetry == 2 ? 1 + 0.4 * cos(2 * c)
                    : symmetry == 1 ? 1 + 0.3 * cos(c) + 0.2 * cos(2 * c)
                                    : 1 + 0.3 * cos(c) + 0.2 * sin(c);
    return 1000 * exp(-gamma) * around * (0.3 + cos(gamma) * cos(gamma));
}

/// Range of C planes that a symmetry needs.
static double last_plane(int symmetry)
{
    return symmetry == 3 ? 0 : symmetry == 2 ? 90 : symmetry == 1 ? 180 : 360;
}

static char *write_ies(int version, int symmetry, int step)
{
    static const char *const heads[] = { "", "IESNA91\n", "IESNA:LM-63-1995\n",
        "IESNA:LM-63-2002\n[LUMINAIRE] a lamp\n" };
    char *text = NULL;
    size_t length = 0;
    FILE *s = open_memstream(&text, &length);
    assert_non_null(s);
    int planes = (int)(last_plane(symmetry) / 15) + 1, angles = 180 / step + 1;
    fprintf(s, "%s[TEST] x\r\nTILT=%s\r\n", heads[version],
        version == 1 ? "INCLUDE\n1\n2\n0 90\n1 .9" : "NONE");
    fprintf(s, "2 1500 2 %d %d 1 2 0.3 0.6 0\n0.9 1 40\n", angles, planes);
    for (int k = 0; k < angles; k++)
        fprintf(s, "%d%s", k * step, k % 10 == 9 ? "\r\n" : " ");
    for (int k = 0; k < planes; k++)
        fprintf(s, "\n%d", 15 * k);
    for (int j = 0; j < planes; j++)
        for (int k = 0; k < angles; k++)
            fprintf(s, "%s%.8g", k % 8 ? " " : "\n",
                wanted_intensity(k * step * DEGREES, 15 * j * DEGREES, symmetry) / 1.8);
    fputs("\n", s);
    assert_int_equal(fclose(s), 0);
    return text;
}

static char *write_eulumdat(int symmetry, int step)
{
    char *text = NULL;
    size_t length = 0;
    FILE *s = open_memstream(&text, &length);
    assert_non_null(s);
    static const int kinds[] = { 0, 2, 4, 1 };
    int planes = 24, angles = 180 / step + 1,
        stored = (int)(last_plane(symmetry) / 15) + (symmetry > 0);
    fprintf(s, "maker\r\n1\r\n%d\r\n%d\r\n15\r\n%d\r\n%d\r\nreport\r\na lamp\r\nn\r\nf\r\nd\r\n",
        kinds[symmetry], planes, angles, step);
    fprintf(s, "600\r\n300\r\n80\r\n0\r\n0\r\n0\r\n0\r\n0\r\n0\r\n100\r\n80\r\n1,"
               "0\r\n0\r\n1\r\n2\r\nLED\r\n3000\r\nwarm\r\n80\r\n40\r\n");
    for (int k = 0; k < 10; k++)
        fputs("0.5\r\n", s);
    for (int k = 0; k < planes; k++)
        fprintf(s, "%d\r\n", 15 * k);
    for (int k = 0; k < angles; k++)
        fprintf(s, "%d\r\n", k * step);
    for (int j = 0; j < stored; j++)
        for (int k = 0; k < angles; k++)
            fprintf(s, "%.8g\r\n",
                wanted_intensity(k * step * DEGREES, 15 * j * DEGREES, symmetry) / 3);
    assert_int_equal(fclose(s), 0);
    return text;
}

/// Towards gamma from straight down and C about the vertical axis.
static rsv_vec3 towards(double gamma, double c)
{
    return (
        rsv_vec3){ (float)(sin(gamma) * cos(c)), (float)-cos(gamma), (float)(sin(gamma) * sin(c)) };
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

static void check_luminaire(file_fixture *f, char *text, int symmetry)
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
    assert_near(l.width, 0.3, 1e-9);
    rsv_luminaire_free(f->context, &l);
    free(text);
}

static void ies_files_of_all_versions_and_symmetries_are_read(void **state)
{
    for (int version = 0; version < 4; version++)
        for (int symmetry = 0; symmetry < 4; symmetry++)
            check_luminaire(*state, write_ies(version, symmetry, 3), symmetry);
}

static void eulumdat_files_of_all_symmetries_are_read(void **state)
{
    for (int symmetry = 0; symmetry < 4; symmetry++)
        check_luminaire(*state, write_eulumdat(symmetry, 3), symmetry);
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
    assert_near(rsv_luminaire_intensity(&l, (rsv_vec3){ 0, 1, 0 }), 0, 0);
    assert_near(l.width, 0.3048, 1e-9);
    assert_near(l.lamp_lumens, 0, 0);
    rsv_luminaire_free(f->context, &l);
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
        rsv_vec3 a = { (float)(cos(v) * sin(h)), (float)sin(v), (float)(cos(v) * cos(h)) };
        rsv_vec3 b = { (float)sin(h), (float)(cos(h) * sin(v)), (float)(cos(h) * cos(v)) };
        rsv_vec3 d = type == 2 ? b : a;
        assert_near(rsv_luminaire_intensity(&l, d), 40, 0.01);
        assert_near(rsv_luminaire_intensity(&l, (rsv_vec3){ -d.x, -d.y, d.z }), 40, 0.01);
        assert_near(rsv_luminaire_intensity(&l, (rsv_vec3){ 0, 0, -1 }), 0, 0.01);
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
        "TILT=NONE\n1 1000 1 2 1 1 1 0 0 0 1 1 10\n0 90\n0\n100\n",
        "TILT=NONE\n1 1000 1 2 1 1 1 0 0 0 1 1 10\n90 0\n0\n100 1\n",
        "TILT=NONE\n1 1000 1 2 1 7 1 0 0 0 1 1 10\n0 90\n0\n100 1\n",
        "TILT=NONE\n1 1000 1 1000000 1000000 1 1 0 0 0 1 1 10\n0 90\n0\n100 1\n",
        "TILT=NONE\n1 1000 1 -2 1 1 1 0 0 0 1 1 10\n0 90\n0\n100 1\n",
        "TILT=NONE\n1 1000 1 2 1 1 1 0 0 0 1 1 10\n0 x\n0\n100 1\n", "maker\n1\n9\n24\n15\n",
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
        cmocka_unit_test_setup_teardown(bad_files_are_refused, file_set_up, file_tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
