/// Surroundings that the runtime turns, and probes that it relights, against the library's relighting.
#include "relight/turned_surroundings.h"
#include "resolvent/relight.h"
#include "resolvent_rt_file.h"

#include "bake_places.h"
#include "file_fixture.h"
#include "light_fixture.h"

enum { COLUMNS = 32, ROWS = 16, TURNS = 4, PLACES = 12 };
#define FIRST 20.0f
#define STEP (360.0f / TURNS)

/// The box with its lamp under a sky, open at one side, and what each of them does alone.
typedef struct open_box {
    folder place;
    rsv_context *context;
    rsv_scene *scene;
    rsv_light *solution;
    rsv_relighter *relighter;
    rsv_bake_receiver *receiver;
    size_t receiver_count;
    rsv_rt_file file; ///< the lamp, then the sky at TURNS angles
    rsv_rt_basis basis;
    float *light; ///< [receiver_count][3]
} open_box;

/// Brighter towards one side, and warmer there.
static void set_sky(rsv_scene *scene)
{
    static rsv_rgb pixel[ROWS * COLUMNS];
    for (uint32_t k = 0; k < ROWS * COLUMNS; k++) {
        float glow = 1 + cosf(2 * RSV_PI * ((float)(k % COLUMNS) + 0.5f) / COLUMNS);
        pixel[k] = rgb(glow, 0.5f + 0.5f * glow, 1);
    }
    const rsv_environment sky = {
        .pixels = pixel, .width = COLUMNS, .height = ROWS, .intensity = 1, .rotation = FIRST
    };
    assert_int_equal(rsv_scene_set_environment(scene, &sky), RSV_OK);
}

static void choose_receivers(open_box *b)
{
    size_t triangles = rsv_scene_get_view(b->scene)->triangle_count;
    b->receiver_count = PLACES * triangles;
    b->receiver = calloc(b->receiver_count, sizeof *b->receiver);
    b->light = calloc(b->receiver_count, 3 * sizeof *b->light);
    for (uint32_t k = 0; k < b->receiver_count; k++) {
        float x, y;
        rsv_sobol_2d(k % PLACES, 0, &x, &y);
        b->receiver[k] = (rsv_bake_receiver){ .triangle = k / PLACES };
        b->receiver[k].u = x + y < 1 ? x : 1 - x;
        b->receiver[k].v = x + y < 1 ? y : 1 - y;
    }
}

static void write_basis(open_box *b)
{
    rsv_bake_desc desc = rsv_default_bake_desc();
    rsv_bake_reader reader = reader_of_places("point", b->receiver, b->receiver_count);
    size_t lights;
    desc.turns = TURNS;
    if (rsv_bake_write_basis(rsv_light_get_view(b->solution), &reader, &desc,
            path_in(&b->place, "box.glb"), &lights))
        fail_msg("%s", rsv_last_error());
    assert_int_equal(lights, 1 + TURNS);
    if (rsv_rt_file_open(&b->file, path_in(&b->place, "box.light.safetensors")) ||
        rsv_rt_file_basis(&b->file, &b->basis))
        fail_msg("%s", b->file.message);
    assert_int_equal(b->basis.receiver_count, b->receiver_count);
}

static int solve_box(void **state)
{
    open_box *b = calloc(1, sizeof *b);
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = 500;
    desc.rays_per_element = 64;
    desc.refinements = 0;
    desc.light_samples = 16;
    desc.direct_levels = 1;
    b->place = new_folder();
    assert_int_equal(rsv_context_create(NULL, &b->context), RSV_OK);
    assert_int_equal(rsv_scene_builtin(b->context, "cornell-blocks", &b->scene), RSV_OK);
    set_sky(b->scene);
    if (rsv_light_create(b->scene, &desc, &b->solution)) fail_msg("%s", rsv_last_error());
    choose_receivers(b);
    write_basis(b);
    *state = b;
    return 0;
}

static int remove_box(void **state)
{
    open_box *b = *state;
    rsv_relighter_destroy(b->relighter);
    rsv_light_destroy(b->solution);
    rsv_scene_destroy(b->scene);
    rsv_context_destroy(b->context);
    rsv_rt_file_close(&b->file);
    remove_folder(b->place.path);
    free(b->receiver);
    free(b->light);
    free(b);
    return 0;
}

/// The runtime's light for the sky at an angle and the lamp at some strength.
static void turn_by_runtime(open_box *b, float degrees, float lamp)
{
    float scale[3 * (1 + TURNS)] = { lamp, lamp, lamp };
    const float sky[3] = { 1, 1, 1 };
    rsv_rt_file_turns turns = rsv_rt_file_find_turns(&b->file, &b->basis);
    assert_true(turns.first == 1 && turns.count == TURNS && turns.rotation == FIRST);
    rsv_rt_turn((degrees - turns.rotation) / 360, sky, turns.count, scale + 3 * turns.first);
    assert_int_equal(
        rsv_rt_relight(&b->basis, scale, 1 + TURNS, 0, b->basis.receiver_count, b->light),
        RSV_RT_OK);
}

static void turn_by_library(open_box *b, float degrees, float lamp)
{
    const rsv_light_scale scale = { "light", { lamp, lamp, lamp } };
    const rsv_relight_desc desc = {
        .size = sizeof desc, .light = &scale, .light_count = 1, .turn = true, .rotation = degrees
    };
    if (!b->relighter) assert_int_equal(rsv_relighter_create(b->solution, &b->relighter), RSV_OK);
    assert_int_equal(rsv_relighter_change(b->relighter, &desc), RSV_OK);
    assert_int_equal(rsv_relighter_settle(b->relighter), RSV_OK);
}

typedef struct difference {
    double largest, mean; ///< of the largest light, of the mean light
} difference;

/// The runtime's light at an angle, compared with the library's.
static difference compare(open_box *b, const rsv_light *s, float degrees, float lamp)
{
    turn_by_runtime(b, degrees, lamp);
    double most = 0, sum = 0;
    difference d = { 0, 0 };
    for (size_t k = 0; k < b->receiver_count; k++) {
        rsv_rgb truth = rsv_bake_irradiance(rsv_light_get_view(s), &b->receiver[k]);
        for (int c = 0; c < 3; c++) {
            double value = (double)(&truth.r)[c], off = fabs((double)b->light[3 * k + c] - value);
            most = fmax(most, value);
            sum += value;
            d.largest = fmax(d.largest, off);
            d.mean += off;
        }
    }
    print_message("%g degrees, lamp %g: largest difference %.3g, mean %.3g\n", (double)degrees,
        (double)lamp, d.largest / most, d.mean / sum);
    return (difference){ d.largest / most, d.mean / sum };
}

static void at_first_light_is_as_baked(void **state)
{
    open_box *b = *state;
    assert_true(compare(b, b->solution, FIRST, 1).largest < 1e-6);
}

static void the_sky_at_a_baked_angle_is_relit_exactly(void **state)
{
    open_box *b = *state;
    turn_by_library(b, FIRST + 3 * STEP, 0);
    assert_true(compare(b, b->solution, FIRST + 3 * STEP, 0).largest < 1e-4);
}

/// Sharpening looks at contrasts, which are not those of lights one by one.
static void lights_and_a_turned_sky_add_up(void **state)
{
    open_box *b = *state;
    turn_by_library(b, FIRST + 3 * STEP, 1);
    assert_true(compare(b, b->solution, FIRST + 3 * STEP, 1).mean < 2e-3);
}

/// A sky of cos(phi) is too dark by up to 1 - cos(STEP / 2) there, as a mean of two of its turns.
static void between_angles_light_changes_evenly(void **state)
{
    open_box *b = *state;
    rsv_light *sky;
    float degrees = FIRST + 1.5f * STEP;
    assert_int_equal(rsv_turned_surroundings_solve(b->solution, degrees, &sky), RSV_OK);
    assert_true(compare(b, sky, degrees, 0).mean < 1 - (double)cosf(RSV_PI / TURNS));
    rsv_light_destroy(sky);
}

/// A prepared relighter includes the sky at its current angle.
static void a_prepared_sky_dims_at_once(void **state)
{
    open_box *b = *state;
    const rsv_light_scale dim[] = { { "light", { 2, 2, 2 } },
        { "environment", { 0.25f, 0.25f, 0.25f } } };
    const rsv_relight_desc desc = { .size = sizeof desc,
        .light = dim,
        .light_count = 2,
        .turn = true,
        .rotation = FIRST + 3 * STEP };
    rsv_relight_progress progress;
    double sum = 0, off = 0;
    turn_by_library(b, FIRST + 3 * STEP, 1);
    assert_int_equal(rsv_relighter_prepare(b->relighter), RSV_OK);
    assert_int_equal(rsv_relighter_change(b->relighter, &desc), RSV_OK);
    assert_int_equal(rsv_relighter_step(b->relighter, 0, &progress), RSV_OK);
    assert_true(progress.converged && progress.orders == 0);
    for (size_t k = 0; k < b->receiver_count; k++)
        b->light[k] = rsv_bake_irradiance(rsv_light_get_view(b->solution), &b->receiver[k]).g;
    assert_int_equal(rsv_relighter_settle(b->relighter), RSV_OK);
    for (size_t k = 0; k < b->receiver_count; k++) {
        double rested =
            (double)rsv_bake_irradiance(rsv_light_get_view(b->solution), &b->receiver[k]).g;
        off += fabs((double)b->light[k] - rested);
        sum += rested;
    }
    assert_true(off < 2e-3 * sum);
}

// ---- probes ---------------------------------------------------------------------------------------

/// Bakes probes under the present light. @return their coefficients, to be freed
static float *bake_probes(const open_box *b, bool basis, size_t *floats)
{
    rsv_bake_desc desc = rsv_default_bake_desc();
    rsv_bake_report report;
    size_t bytes;
    desc.probe_spacing = 0.4f;
    desc.basis = basis;
    desc.turns = TURNS;
    if (rsv_bake_probes(b->solution, path_in(&b->place, "probes.json"), &desc, &report))
        fail_msg("%s", rsv_last_error());
    size_t probes = (size_t)report.probe_count[0] * report.probe_count[1] * report.probe_count[2];
    *floats = 3 * RSV_RT_SH_COUNT * probes;
    float *coefficient = (float *)read_bytes(path_in(&b->place, "probes.probes.bin"), &bytes);
    assert_int_equal(bytes, *floats * sizeof(float) + probes);
    return coefficient;
}

/// Sum of differences relative to the sum of what should be.
static double probes_differ(const float *is, const float *should_be, size_t floats)
{
    double sum = 0, differences = 0;
    for (size_t k = 0; k < floats; k++) {
        sum += fabs((double)should_be[k]);
        differences += fabs((double)is[k] - (double)should_be[k]);
    }
    print_message("probes differ by %.3g\n", differences / sum);
    return differences / sum;
}

/// The probes of a basis under the lamp and the sky at an angle. @return to be freed
static float *relight_probes(rsv_rt_file *file, float lamp, float turn, size_t floats)
{
    rsv_rt_basis basis;
    rsv_rt_probe_grid grid;
    const float sky[3] = { 1, 1, 1 };
    float scale[3 * (1 + TURNS)] = { lamp, lamp, lamp };
    float *lit = malloc(floats * sizeof *lit);
    if (rsv_rt_file_basis(file, &basis) || rsv_rt_file_probes(file, &basis, &grid))
        fail_msg("%s", file->message);
    assert_int_equal(3 * (size_t)basis.receiver_count * basis.value_count, floats);
    rsv_rt_turn(turn, sky, TURNS, scale + 3);
    assert_int_equal(
        rsv_rt_relight(&basis, scale, 1 + TURNS, 0, basis.receiver_count, lit), RSV_RT_OK);
    return lit;
}

static void probes_are_relit(void **state)
{
    open_box *b = *state;
    rsv_rt_file file;
    size_t floats;
    float *whole = bake_probes(b, true, &floats);
    if (rsv_rt_file_open(&file, path_in(&b->place, "probes.light.safetensors")))
        fail_msg("%s", file.message);
    float *lit = relight_probes(&file, 1, 0, floats);
    assert_true(probes_differ(lit, whole, floats) < 1e-5);
    free(whole);
    free(lit);
    turn_by_library(b, FIRST + 3 * STEP, 0);
    whole = bake_probes(b, false, &floats);
    lit = relight_probes(&file, 0, 3.0f / TURNS, floats);
    assert_true(probes_differ(lit, whole, floats) < 1e-4);
    free(whole);
    free(lit);
    rsv_rt_file_close(&file);
}

static float *read_probes(const open_box *b, bool packed, rsv_rt_file *file, rsv_rt_basis *basis)
{
    rsv_bake_desc desc = rsv_default_bake_desc();
    desc.probe_spacing = 0.4f;
    desc.basis = true;
    desc.packed = packed;
    desc.turns = TURNS;
    if (rsv_bake_probes(b->solution, path_in(&b->place, "packed.json"), &desc, NULL))
        fail_msg("%s", rsv_last_error());
    if (rsv_rt_file_open(file, path_in(&b->place, "packed.light.safetensors")) ||
        rsv_rt_file_basis(file, basis))
        fail_msg("%s", file->message);
    size_t bytes =
        3 * (size_t)basis->light_count * basis->receiver_count * basis->value_count * sizeof(float);
    return memcpy(malloc(bytes), basis->value, bytes);
}

/// Halves err by 2^-11 of a number at most; values of a basis of probes have both signs.
static void a_packed_basis_is_the_same_but_for_rounding(void **state)
{
    open_box *b = *state;
    rsv_rt_file file;
    rsv_rt_basis plain, packed;
    float *exact = read_probes(b, false, &file, &plain);
    size_t size = file.size;
    rsv_rt_file_close(&file);
    float *rounded = read_probes(b, true, &file, &packed);
    print_message("%zu bytes, packed %zu\n", size, file.size);
    assert_true(file.size < size);
    assert_int_equal(rsv_rt_file_find_turns(&file, &packed).count, TURNS);
    size_t one = 3 * (size_t)plain.receiver_count * plain.value_count;
    for (uint32_t l = 0; l < plain.light_count; l++) {
        float most = 0;
        for (size_t k = l * one; k < (l + 1) * one; k++)
            most = f_max(most, fabsf(exact[k]));
        for (size_t k = l * one; k < (l + 1) * one; k++)
            assert_true(
                fabsf(rounded[k] - exact[k]) <= 0x1p-11f * fabsf(exact[k]) + 0x1p-38f * most);
    }
    file.bytes[file.size - 40] ^= 0x55; // within the last light
    assert_int_equal(rsv_rt_file_basis(&file, &packed), -1);
    assert_non_null(strstr(file.message, "is damaged"));
    rsv_rt_file_close(&file);
    free(exact);
    free(rounded);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(at_first_light_is_as_baked),
        cmocka_unit_test(probes_are_relit),
        cmocka_unit_test(a_packed_basis_is_the_same_but_for_rounding),
        cmocka_unit_test(the_sky_at_a_baked_angle_is_relit_exactly),
        cmocka_unit_test(lights_and_a_turned_sky_add_up),
        cmocka_unit_test(between_angles_light_changes_evenly),
        cmocka_unit_test(a_prepared_sky_dims_at_once),
    };
    return cmocka_run_group_tests(tests, solve_box, remove_box);
}
