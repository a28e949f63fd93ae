/// Units of light strengths in files: by the program that wrote the file, and by the caller's choice.
#include "gltf_fixture.h"

typedef struct lamp {
    const char *type;
    double strength;
} lamp;

/// A square with lights and a material that shines. @param generator NULL = the file does not say
static const char *write_lamps(
    const folder *place, const char *generator, const lamp *source, int count)
{
    static const float corner[9] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 };
    char lights[2048] = "", nodes[2048] = "", who[128] = "", text[8192];
    for (int k = 0; k < count; k++) {
        char line[128];
        snprintf(line, sizeof line, "%s{\"type\":\"%s\",\"intensity\":%.17g}", k ? "," : "",
            source[k].type, source[k].strength);
        append_text(lights, sizeof lights, line);
        snprintf(
            line, sizeof line, ",{\"extensions\":{\"KHR_lights_punctual\":{\"light\":%d}}}", k);
        append_text(nodes, sizeof nodes, line);
    }
    if (generator) snprintf(who, sizeof who, ",\"generator\":\"%s\"", generator);
    write_bytes(path_in(place, "shape.bin"), corner, sizeof corner);
    int length = snprintf(text, sizeof text,
        "{\"asset\":{\"version\":\"2.0\"%s},\"buffers\":[{\"uri\":\"shape.bin\",\"byteLength\":36}]"
        ","
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"accessors\":[{\"bufferView\":0,"
        "\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],\"materials\":[{\"emissiveFactor\":"
        "[1,1,1]}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":0}]}]"
        ","
        "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[%s]}},\"nodes\":[{\"mesh\":0}%s]}",
        who, lights, nodes);
    const char *path = path_in(place, "lamps.gltf");
    write_bytes(path, text, (size_t)length);
    return path;
}

static rsv_scene *load_in(fixture *f, const char *path, rsv_light_units units)
{
    rsv_load_desc desc = rsv_default_load_desc();
    rsv_scene *scene = NULL;
    desc.light_units = units;
    f->log[0] = '\0';
    if (rsv_scene_load_with(f->context, path, &desc, &scene) != RSV_OK)
        fail_msg("%s", rsv_last_error());
    return scene;
}

static void assert_strength(const rsv_scene *scene, size_t light, double expected)
{
    double found = (double)rsv_scene_get_view(scene)->light[light].intensity.r;
    if (fabs(found - expected) > 1e-6 * expected)
        fail_msg("light %zu: %.9g, not %.9g", light, found, expected);
}

#define BLENDER "Khronos glTF Blender I/O v"
#define FOUR_PI 12.566370614359172

/// 40 W in each of the three ways that Blender's exporter offers, and in those of versions that offer one.
static void blender_means_the_same_lamp_in_whatever_way_it_is_written(void **state)
{
    static const struct {
        const char *generator;
        double written;
        const char *said;
    } cases[] = {
        { BLENDER "3.4.50", 40 * 683 / FOUR_PI, "candela" },
        { BLENDER "4.2.60", 40 * 683 / FOUR_PI, "candela" },
        { "Khronos glTF Blender I/O", 40 * 683 / FOUR_PI, "candela" },
        { BLENDER "3.4.50", 40 / FOUR_PI, "without units" },
        { BLENDER "4.0.40", 40 / FOUR_PI, "without units" },
        { BLENDER "3.4.50", 40, "raw" },
        { BLENDER "2.93.5", 40, "raw" },
    };
    folder place = new_folder();
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const lamp one = { "point", cases[k].written };
        fixture *f = *state;
        rsv_scene *scene =
            load_in(f, write_lamps(&place, cases[k].generator, &one, 1), RSV_LIGHT_UNITS_AUTO);
        assert_strength(scene, 0, 40 / FOUR_PI);
        assert_mentions(f->log, cases[k].said);
        assert_int_equal(rsv_scene_get_view(scene)->material[0].emission.r, 1);
        rsv_scene_destroy(scene);
    }
    remove_folder(place.path);
}

/// Watts that are not a round number, such as animated ones, do not reveal the unit. Other lights do; otherwise the
/// version of the exporter decides.
static void strengths_of_many_digits_follow_the_other_lights_or_the_version(void **state)
{
    static const struct {
        const char *generator;
        lamp lamp[3];
        int count;
        double expected; ///< of the first
    } cases[] = {
        { BLENDER "3.4.50", { { "point", 1234.56789 } }, 1, 1234.56789 / 683 },
        { BLENDER "2.93.5", { { "point", 1234.56789 } }, 1, 1234.56789 / FOUR_PI },
        { BLENDER "3.6.5", { { "point", 1.23456789 }, { "spot", 60 / FOUR_PI } }, 2, 1.23456789 },
        { BLENDER "3.6.5", { { "directional", 1000 * 683 } }, 1, 1000 },
        { BLENDER "3.6.5", { { "directional", 3.5 } }, 1, 3.5 },
        { BLENDER "2.90.1", { { "spot", 250 }, { "directional", 3 }, { "directional", 2 } }, 3,
            250 / FOUR_PI },
        { BLENDER "3.6.5", { { "spot", 60 / FOUR_PI }, { "directional", 3 } }, 2, 60 / FOUR_PI },
        { BLENDER "3.6.5", { { "point", 0 } }, 1, 0 },
    };
    folder place = new_folder();
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const char *path = write_lamps(&place, cases[k].generator, cases[k].lamp, cases[k].count);
        rsv_scene *scene = load_in(*state, path, RSV_LIGHT_UNITS_AUTO);
        assert_strength(scene, 0, cases[k].expected);
        rsv_scene_destroy(scene);
    }
    remove_folder(place.path);
}

static void other_programs_are_taken_at_their_numbers(void **state)
{
    static const char *const generators[] = { NULL, "Resolvent 1.0", "THREE.GLTFExporter r160" };
    const lamp lamps[] = { { "point", 2 }, { "directional", 3 } };
    folder place = new_folder();
    for (size_t k = 0; k < sizeof generators / sizeof *generators; k++) {
        fixture *f = *state;
        rsv_scene *scene =
            load_in(f, write_lamps(&place, generators[k], lamps, 2), RSV_LIGHT_UNITS_AUTO);
        assert_strength(scene, 0, 2);
        assert_strength(scene, 1, 3);
        assert_int_equal(strstr(f->log, "--light-units") == NULL, k == 1); // it is known
        rsv_scene_destroy(scene);
    }
    remove_folder(place.path);
}

static void the_caller_can_say_what_is_meant(void **state)
{
    static const struct {
        const char *generator;
        rsv_light_units units;
        double light, emission;
    } cases[] = {
        { NULL, RSV_LIGHT_UNITS_WATT, 1366, 1 },
        { NULL, RSV_LIGHT_UNITS_PHOTOMETRIC, 2, 1.0 / 683 },
        { BLENDER "3.4.50", RSV_LIGHT_UNITS_WATT, 1366, 1 },
        { BLENDER "3.4.50", RSV_LIGHT_UNITS_PHOTOMETRIC, 2, 1 }, // its emission has no units
    };
    const lamp lamps[] = { { "point", 1366 }, { "directional", 1366 } };
    folder place = new_folder();
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        fixture *f = *state;
        const char *path = write_lamps(&place, cases[k].generator, lamps, 2);
        rsv_scene *scene = load_in(f, path, cases[k].units);
        assert_strength(scene, 0, cases[k].light);
        assert_strength(scene, 1, cases[k].light);
        assert_float_equal(
            rsv_scene_get_view(scene)->material[0].emission.g, cases[k].emission, 1e-9);
        assert_null(strstr(f->log, "--light-units"));
        rsv_scene_destroy(scene);
    }
    remove_folder(place.path);
}

static void units_that_do_not_exist_are_refused(void **state)
{
    fixture *f = *state;
    folder place = new_folder();
    rsv_load_desc desc = rsv_default_load_desc();
    rsv_scene *scene = NULL;
    const lamp one = { "point", 1 };
    desc.light_units = (rsv_light_units)7;
    const char *path = write_lamps(&place, NULL, &one, 1);
    assert_int_equal(rsv_scene_load_with(f->context, path, &desc, &scene), RSV_ERROR_ARGUMENT);
    assert_mentions(rsv_last_error(), "units of light");
    remove_folder(place.path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(blender_means_the_same_lamp_in_whatever_way_it_is_written,
            fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            strengths_of_many_digits_follow_the_other_lights_or_the_version, fixture_setup,
            fixture_teardown),
        cmocka_unit_test_setup_teardown(
            other_programs_are_taken_at_their_numbers, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            the_caller_can_say_what_is_meant, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            units_that_do_not_exist_are_refused, fixture_setup, fixture_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
