/// Light in baked texels and vertices compared with path tracing; noise and edges; borders where meshes meet.
#include "bake/bake_filter.h"
#include "bake/bake_judge.h"
#include "bake/bake_ktx2.h"
#include "bake/bake_smooth.h"
#include "file_fixture.h"
#include "light_fixture.h"
#include "light_view.h"
#include "relight/light_response.h"
#include "resolvent/bake.h"
#include "resolvent/trace.h"
#include "slow_tests.h"

#include <inttypes.h>

/// Texels or vertices that are looked at, about and at most.
#define WANTED 200
#define MOST_VALUES (2 * WANTED + 16)
#define MOST_PLACES (16 * MOST_VALUES)
/// Standard errors of path tracing that are left out of errors.
#define SURE 2

typedef struct values {
    float light[MOST_VALUES];
    uint32_t places_of[MOST_VALUES];
    rsv_surface_place place[MOST_PLACES];
    size_t count, places;
} values;

/// The values from which a bake reports its error.
static void take_judged(const rsv_bake_judge *judge, values *v)
{
    v->count = v->places = 0;
    for (size_t k = 0; k < judge->count && k < MOST_VALUES; k++) {
        const rsv_bake_judged *judged = &judge->value[k];
        v->light[v->count] = judged->light.g;
        v->places_of[v->count++] = judged->patch.count;
        memcpy(v->place + v->places, judged->patch.place,
            judged->patch.count * sizeof *judged->patch.place);
        v->places += judged->patch.count;
    }
}

static int compare(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/// Errors that the noise of path tracing does not explain, relative to the light, or to a twentieth of the mean if that
/// is larger; sorted.
/// @return their number
static size_t find_errors(const rsv_scene *scene, const values *v, uint32_t paths, float *error)
{
    static rsv_probe_reading reading[MOST_PLACES];
    static float truth[MOST_VALUES], deviation[MOST_VALUES];
    float mean = 0;
    assert_int_equal(rsv_surface_reference(scene, v->place, v->places, paths, 3, reading), RSV_OK);
    for (size_t k = 0, at = 0; k < v->count; k++) {
        float squares = 0;
        truth[k] = 0;
        for (uint32_t n = 0; n < v->places_of[k]; n++, at++) {
            truth[k] += reading[at].irradiance.g / (float)v->places_of[k];
            squares += reading[at].standard_error.g * reading[at].standard_error.g;
        }
        deviation[k] = sqrtf(squares) / (float)v->places_of[k];
        mean += truth[k] / (float)v->count;
    }
    for (size_t k = 0; k < v->count; k++)
        error[k] = f_max(fabsf(v->light[k] - truth[k]) - SURE * deviation[k], 0) /
                   f_max(truth[k], 0.05f * mean);
    qsort(error, v->count, sizeof *error, compare);
    return v->count;
}

static rsv_light *solve(const rsv_scene *scene, uint32_t rays)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_light *light;
    desc.element_target = 1500;
    desc.rays_per_element = rays;
    assert_int_equal(rsv_light_create(scene, &desc, &light), RSV_OK);
    return light;
}

/// A floor below a bulb of hundreds of triangles. A plate hides half of them from a part of the floor: elements are
/// larger than the penumbra. Two boxes stand on the floor, one of one-sided and one of two-sided faces, so that light
/// ends below them. Nearly all light is direct, so the errors are those of its estimate.
static void add_shaded_bulb(world *w)
{
    uint32_t dark = world_lambert(w, 0.02f, 0);
    world_quad(w, dark, v3(-1, 0, 1), v3(1, 0, 1), v3(1, 0, -1), v3(-1, 0, -1));
    world_box(w, dark, v3(0.1f, 0.3f, -0.5f), v3(0.7f, 0.31f, 0.5f));
    world_sphere(w, world_lambert(w, 0, 20), v3(0, 0.6f, 0), 0.06f, 2);
    rsv_material thin = lambert_material(0.02f, 0);
    thin.double_sided = true;
    uint32_t two_sided = world_material(w, thin);
    world_box(w, dark, v3(-0.83f, 0, 0.11f), v3(-0.37f, 0.2f, 0.57f));
    world_box(w, two_sided, v3(-0.83f, 0, -0.57f), v3(-0.37f, 0.2f, -0.11f));
    world_commit(w);
}

static void light_of_a_shaded_bulb_is_what_is_path_traced(void **state)
{
    (void)state;
    static const char *const target[] = { "lightmap", "vertex" };
    const float most[] = { UNLESS_SANITIZED(0.05f, 0.3f), UNLESS_SANITIZED(0.1f, 0.3f) };
    static values v;
    static float error[MOST_VALUES];
    world *w = world_begin(2);
    add_shaded_bulb(w);
    rsv_light *light = solve(w->scene, 64);
    folder files = new_folder();
    for (int k = 0; k < 2; k++) {
        rsv_bake_judge judge;
        rsv_bake_desc desc = rsv_default_bake_desc();
        assert_int_equal(rsv_bake_judge_create(inside(light), WANTED, &judge), RSV_OK);
        desc.map_size = 96;
        desc.visitor = &judge.visitor;
        desc.judged = WANTED;
        rsv_bake_report report = { 0 };
        assert_int_equal(
            rsv_bake(light, target[k], path_in(&files, "a.glb"), &desc, &report), RSV_OK);
        take_judged(&judge, &v);
        rsv_bake_judge_destroy(&judge);
        size_t count = find_errors(w->scene, &v, UNLESS_SANITIZED(1024, 64), error);
        print_message("%s: %zu values, median error %.4f, 90th percentile %.4f, 99th %.4f\n",
            target[k], count, (double)error[count / 2], (double)error[count * 9 / 10],
            (double)error[count * 99 / 100]);
        print_message(
            "as the bake says: %zu values, median error %.4f, 99th percentile %.4f, noise %.4f\n",
            report.judged, report.error_median, report.error_99, report.error_noise);
        assert_int_equal(report.judged, count);
        assert_true(
            fabs(report.error_99 - (double)error[count * 99 / 100]) < UNLESS_SANITIZED(0.03, 0.3));
        if (k == 0) assert_true(report.error_noise < 0.001 && report.error_median < 0.01);
        assert_true(report.error_99 > report.error_median);
        assert_true(count > WANTED / 2);
        assert_true(error[count / 2] < 0.01f);
        assert_true(error[count * 9 / 10] < UNLESS_SANITIZED(0.02f, 0.05f));
        assert_true(error[count * 99 / 100] < most[k]);
    }
    remove_folder(files.path);
    rsv_light_destroy(light);
    world_end(w);
}

static void bakes_do_not_depend_on_threads(void **state)
{
    (void)state;
    static const char *const target[] = { "lightmap", "vertex" };
    folder files = new_folder();
    for (int k = 0; k < 2; k++) {
        uint8_t *bytes[2];
        size_t count[2];
        for (int threads = 0; threads < 2; threads++) {
            world *w = world_begin(1 + 2 * threads);
            add_shaded_bulb(w);
            rsv_light *light = solve(w->scene, 64);
            rsv_bake_desc desc = rsv_default_bake_desc();
            desc.map_size = 64;
            desc.basis = true;
            assert_int_equal(
                rsv_bake(light, target[k], path_in(&files, "a.glb"), &desc, NULL), RSV_OK);
            bytes[threads] = read_bytes(path_in(&files, "a.glb"), &count[threads]);
            rsv_light_destroy(light);
            world_end(w);
        }
        assert_int_equal(count[0], count[1]);
        assert_memory_equal(bytes[0], bytes[1], count[0]);
        free(bytes[0]);
        free(bytes[1]);
    }
    remove_folder(files.path);
}

// ---- many lamps -----------------------------------------------------------------------------------

/// More lamps than get their full number of photons each, over a floor that reflects them.
#define LAMPS 20

static void add_lamps(world *w, char name[LAMPS][24])
{
    rsv_material metal = lambert_material(0.8f, 0);
    metal.metallic = 1;
    metal.roughness = 0.05f;
    world_quad(w, world_material(w, metal), v3(-1, 0, 1), v3(1, 0, 1), v3(1, 0, -1), v3(-1, 0, -1));
    uint32_t ceiling = world_lambert(w, 0.5f, 0);
    world_quad(w, ceiling, v3(-1, 1, -1), v3(1, 1, -1), v3(1, 1, 1), v3(-1, 1, 1));
    for (int k = 0; k < LAMPS; k++) {
        float x = -0.9f + 0.4f * (float)(k % 5), z = -0.8f + 0.4f * (float)(k / 5);
        rsv_material lamp = lambert_material(0, 5);
        snprintf(name[k], sizeof name[k], "lamp %d", k);
        lamp.name = name[k];
        world_quad(w, world_material(w, lamp), v3(x, 0.5f, z), v3(x + 0.1f, 0.5f, z),
            v3(x + 0.1f, 0.5f, z + 0.1f), v3(x, 0.5f, z + 0.1f));
    }
    world_commit(w);
}

static void many_lamps_add_up_to_the_whole(void **state)
{
    (void)state;
    char name[LAMPS][24];
    world *w = world_begin(2);
    add_lamps(w, name);
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_light *light;
    desc.element_target = 200;
    desc.rays_per_element = 64;
    desc.photon_count = 20000;
    assert_int_equal(rsv_light_create(w->scene, &desc, &light), RSV_OK);
    const rsv_light_view *s = inside(light);
    rsv_light_responses *parts;
    size_t count = 0;
    double most = 0, off = 0;
    assert_int_equal(rsv_light_responses_count(light, &count), RSV_OK);
    assert_int_equal(count, LAMPS);
    assert_int_equal(rsv_light_responses_create(light, &parts), RSV_OK);
    assert_int_equal(parts->count, count);
    assert_non_null(s->caustics.caustic);
    for (size_t n = 0; n < s->caustics.elements->node_count; n++) {
        double sum = 0, whole = (double)s->caustics.caustic[n].g;
        for (size_t k = 0; k < count; k++)
            sum += (double)parts->view[k]->caustics.caustic[n].g;
        most = fmax(most, whole);
        off = fmax(off, fabs(sum - whole));
    }
    print_message("largest %.3g, sums of parts are off by %.3g\n", most, off);
    assert_true(most > 0);
    assert_true(off < 1e-4 * most);
    rsv_light_responses_destroy(parts);
    rsv_light_destroy(light);
    world_end(w);
}

// ---- a weak lamp beside a strong one ----------------------------------------------------------------

/// A plate that throws the shadows of both on the floor.
static world *two_lamps(void)
{
    world *w = world_begin(2);
    uint32_t gray = world_lambert(w, 0.5f, 0), weak, strong;
    rsv_material lamp = lambert_material(0, 5);
    lamp.name = "strong";
    strong = world_material(w, lamp);
    lamp = lambert_material(0, 0.25f);
    lamp.name = "weak";
    weak = world_material(w, lamp);
    world_quad(w, gray, v3(-1, 0, 1), v3(1, 0, 1), v3(1, 0, -1), v3(-1, 0, -1));
    world_quad(w, gray, v3(-0.3f, 0.3f, 0.3f), v3(0.3f, 0.3f, 0.3f), v3(0.3f, 0.3f, -0.3f),
        v3(-0.3f, 0.3f, -0.3f));
    world_quad(w, strong, v3(-0.8f, 1, -0.2f), v3(-0.4f, 1, -0.2f), v3(-0.4f, 1, 0.2f),
        v3(-0.8f, 1, 0.2f));
    world_quad(
        w, weak, v3(0.4f, 1, -0.2f), v3(0.8f, 1, -0.2f), v3(0.8f, 1, 0.2f), v3(0.4f, 1, 0.2f));
    world_commit(w);
    return w;
}

/// A lamp with only its share of the rays gives the light of one with all rays, up to noise in penumbrae.
static void weak_lamps_get_fewer_rays_and_the_same_light(void **state)
{
    (void)state;
    world *w = two_lamps();
    rsv_light *light = solve(w->scene, 64);
    const rsv_light_view *s = inside(light);
    const rsv_lights *lights = rsv_light_get_sources(light)->lights;
    rsv_light_basis *basis;
    uint16_t *valid;
    uint64_t rays[2][2] = { { 0 } };
    assert_int_equal(rsv_light_basis_create_empty(light, &basis), RSV_OK);
    assert_int_equal(rsv_find_fine_valid(light, &valid), RSV_OK);
    assert_int_equal(basis->source_count, 2);
    for (size_t k = 0; k < 2; k++) {
        rsv_light_part part[2] = { { 0 } };
        double sum = 0, off = 0, bias = 0;
        for (int shared = 0; shared < 2; shared++) {
            rsv_light_effort effort = rsv_full_light_effort(light, valid);
            effort.fine_whole = shared ? s->fine.direct : NULL;
            assert_int_equal(rsv_light_part_estimate(light, lights, &basis->source[k], &effort,
                                 &part[shared], &rays[k][shared]),
                RSV_OK);
        }
        for (size_t n = 0; n < s->fine.elements->node_count; n++) {
            if (rgb_is_black(s->fine.direct[n])) continue; // there is nothing to divide
            double difference = (double)part[1].fine[n].g - (double)part[0].fine[n].g;
            sum += (double)part[0].fine[n].g;
            off += fabs(difference);
            bias += difference;
        }
        print_message("%s: %" PRIu64 " rays instead of %" PRIu64
                      ", off by %.3g, in the mean %.3g\n",
            basis->source[k].name, rays[k][1], rays[k][0], off / sum, bias / sum);
        assert_true(off < 0.03 * sum);
        assert_true(fabs(bias) < 0.003 * sum);
        rsv_light_part_free(w->context, &part[0]);
        rsv_light_part_free(w->context, &part[1]);
    }
    for (size_t k = 0; k < 2; k++)
        if (strcmp(basis->source[k].name, "weak") == 0)
            assert_true((double)rays[k][1] < 0.6 * (double)rays[k][0]);
    rsv_free(w->context, valid);
    rsv_light_basis_destroy(basis);
    rsv_light_destroy(light);
    world_end(w);
}

// ---- noise ----------------------------------------------------------------------------------------

#define SIDE 48
#define EDGE 20

static float noise(uint32_t k, uint32_t half)
{
    uint32_t x = (k * 2 + half) * 2654435761u;
    x ^= x >> 15;
    x *= 2246822519u;
    return (float)(x >> 8) / 16777216.0f - 0.5f;
}

/// Light 1 left of an edge and 3 right of it, noisy but in a few dark rows, whose halves agree.
static void noise_is_filtered_and_edges_stay(void **state)
{
    const fixture *f = *state;
    static rsv_rgb half[2][SIDE * SIDE];
    static uint32_t group[SIDE * SIDE];
    for (uint32_t k = 0; k < SIDE * SIDE; k++)
        for (uint32_t h = 0; h < 2; h++) {
            bool dark = k / SIDE < 4;
            float level = k % SIDE < EDGE ? 1 : 3;
            half[h][k] = rgb_gray(dark ? 0 : level * (1 + 0.2f * noise(k, h)));
        }
    static rsv_rgb filtered[2][SIDE * SIDE];
    const rsv_bake_noisy_map map = { SIDE, SIDE, group, { half[0], half[1] },
        { filtered[0], filtered[1] } };
    assert_int_equal(rsv_bake_filter(f->context, &map), RSV_OK);
    double squares = 0, count = 0;
    for (uint32_t k = 0; k < SIDE * SIDE; k++) {
        float light = 0.5f * (filtered[0][k].g + filtered[1][k].g), level = k % SIDE < EDGE ? 1 : 3;
        if (k / SIDE < 4) {
            assert_true(light == 0);
            continue;
        }
        double off = (double)(light / level) - 1;
        squares += off * off;
        count++;
        assert_true(fabs(off) < 0.2); // a texel of the other side would be off by two thirds
    }
    double before = 0.2 / sqrt(12.0 * 2);
    print_message("deviation %.4f, before %.4f\n", sqrt(squares / count), before);
    assert_true(sqrt(squares / count) < 0.4 * before);
}

/// Stored light of few rays, smoothed, is nearer to that of many.
static void smoothing_takes_noise_of_rows_away(void **state)
{
    (void)state;
    world *w = world_builtin(2, "cornell-blocks");
    world_commit(w);
    rsv_light *few = solve(w->scene, 64), *many = solve(w->scene, UNLESS_SANITIZED(4096, 1024));
    const rsv_light_view *a = inside(few), *b = inside(many);
    rsv_bake_smooth smooth;
    double before = 0, after = 0;
    assert_int_equal(a->elements->node_count, b->elements->node_count);
    assert_int_equal(rsv_bake_smooth_create(a, &smooth), RSV_OK);
    for (size_t n = 0; n < a->elements->node_count; n++) {
        double area = (double)a->elements->node_area[n];
        double truth = (double)(b->indirect[n].g + b->gathered[n].g);
        double noisy = (double)(a->indirect[n].g + a->gathered[n].g) - truth;
        double quiet = (double)smooth.view.indirect[n].g - truth;
        before += area * noisy * noisy;
        after += area * quiet * quiet;
    }
    print_message("deviation from many rays: %.2f of what it was\n", sqrt(after / before));
    // what is left is noise that all nodes share, of light that was reflected before, and bends of the light itself
    assert_true(sqrt(after / before) < 0.85);
    rsv_bake_smooth_destroy(&smooth);
    rsv_light_destroy(few);
    rsv_light_destroy(many);
    world_end(w);
}

static void shared_exponents_hold_colours_within_half_a_percent(void **state)
{
    (void)state;
    assert_int_equal(rsv_rgb9e5(rgb_gray(0)), 0);
    assert_int_equal(rsv_rgb9e5(rgb(NAN, -1, 0)), 0);
    assert_int_equal(rsv_rgb9e5(rgb_gray(1e30f)), rsv_rgb9e5(rgb_gray(RSV_RGB9E5_MOST)));
    for (float brightest = 1e-3f; brightest < 6e4f; brightest *= 1.37f) {
        const rsv_rgb color = rgb(brightest, 0.5f * brightest, 0.01f * brightest);
        uint32_t code = rsv_rgb9e5(color);
        for (int c = 0; c < 3; c++) {
            float back = ldexpf((float)(code >> 9 * c & 511), (int)(code >> 27) - 24);
            assert_true(fabsf(back - (&color.r)[c]) <= 0.004f * brightest);
        }
    }
}

// ---- borders --------------------------------------------------------------------------------------

/// Metres around the border that rays are sent to.
#define CLOSE 1e-3f

static float along_border(const rsv_scene_view *view, size_t k)
{
    rsv_vec3 p = view->position[k];
    return fabsf(p.y) < 1e-5f && fabsf(p.z) < 1e-5f ? p.x : NAN;
}

/// Different places of an object's vertices on the border. @return how many
static size_t list_border(const rsv_scene_view *view, const char *object, float *place)
{
    size_t count = 0, unique = 0;
    for (size_t t = 0; t < view->triangle_count; t++)
        for (int k = 0; k < 3; k++) {
            float x = along_border(view, view->triangle[t][k]);
            if (strcmp(object_of(view, t), object) == 0 && isfinite(x)) place[count++] = x;
        }
    qsort(place, count, sizeof *place, compare);
    for (size_t k = 0; k < count; k++)
        if (unique == 0 || place[k] - place[unique - 1] > 1e-5f) place[unique++] = place[k];
    return unique;
}

/// Rays from many viewpoints past the border, as close to it as pixels are. @return how many hit neither surface
static size_t count_pinholes(const rsv_scene *scene, size_t rays)
{
    rsv_tracer *tracer;
    size_t holes = 0;
    assert_int_equal(rsv_tracer_create(scene, &tracer), RSV_OK);
    for (uint32_t k = 0; k < rays; k++) {
        rsv_vec3 target = v3(1.9f * noise(k, 0), CLOSE * noise(k, 2), CLOSE * noise(k, 3));
        rsv_vec3 from =
            v3(2 * noise(k, 1), 0.2f + 0.1f * (float)(k % 13), 0.2f + 0.1f * (float)(k % 11));
        const rsv_ray ray = { from, v3_sub(target, from), INFINITY };
        rsv_hit hit;
        holes += !rsv_tracer_closest(tracer, &ray, &hit);
    }
    rsv_tracer_destroy(tracer);
    return holes;
}

static void add_named_quad(world *w, const char *name, const rsv_vec3 corner[4], uint32_t paint)
{
    const rsv_shape shape = { w->scene, name, paint, NULL };
    assert_int_equal(rsv_add_quad(shape, corner), RSV_OK);
}

/// A floor and a wall of two pieces that meet at the back edge of the floor. The floor has no vertex in the middle of
/// the wall.
static void meshes_that_meet_have_the_same_vertices_there(void **state)
{
    (void)state;
    world *w = world_begin(2);
    uint32_t paint = world_lambert(w, 0.5f, 0);
    add_named_quad(
        w, "floor", (rsv_vec3[]){ { -1, 0, 1 }, { 1, 0, 1 }, { 1, 0, 0 }, { -1, 0, 0 } }, paint);
    add_named_quad(w, "left",
        (rsv_vec3[]){ { -1, 0, 0 }, { 0.37f, 0, 0 }, { 0.37f, 1, 0 }, { -1, 1, 0 } }, paint);
    add_named_quad(w, "right",
        (rsv_vec3[]){ { 0.37f, 0, 0 }, { 1, 0, 0 }, { 1, 1, 0 }, { 0.37f, 1, 0 } }, paint);
    world_sphere(w, world_lambert(w, 0, 20), v3(-0.3f, 0.2f, 0.15f), 0.03f, 1);
    world_commit(w);
    rsv_light *light = solve(w->scene, 64);
    folder files = new_folder();
    rsv_scene *baked;
    assert_int_equal(rsv_bake(light, "vertex", path_in(&files, "a.glb"), NULL, NULL), RSV_OK);
    assert_int_equal(rsv_scene_load(w->context, path_in(&files, "a.glb"), &baked), RSV_OK);
    static float place[3][65536];
    const rsv_scene_view *view = rsv_scene_get_view(baked);
    size_t floor = list_border(view, "floor", place[0]), left = list_border(view, "left", place[1]),
           right = list_border(view, "right", place[2]);
    print_message("points on the border: floor %zu, wall %zu + %zu\n", floor, left, right);
    assert_true(floor > 4);
    assert_int_equal(floor, left + right - 1); // the middle is in both
    for (size_t k = 0; k < left; k++)
        assert_true(fabsf(place[0][k] - place[1][k]) < 1e-6f);
    for (size_t k = 0; k < right; k++)
        assert_true(fabsf(place[0][left - 1 + k] - place[2][k]) < 1e-6f);
    assert_int_equal(count_pinholes(baked, 200000), 0);
    rsv_scene_destroy(baked);
    remove_folder(files.path);
    rsv_light_destroy(light);
    world_end(w);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest quick[] = {
        cmocka_unit_test_setup_teardown(
            noise_is_filtered_and_edges_stay, fixture_setup, fixture_teardown),
        cmocka_unit_test(shared_exponents_hold_colours_within_half_a_percent),
        cmocka_unit_test(meshes_that_meet_have_the_same_vertices_there),
    };
    const struct CMUnitTest slow[] = {
        cmocka_unit_test(light_of_a_shaded_bulb_is_what_is_path_traced),
        cmocka_unit_test(bakes_do_not_depend_on_threads),
        cmocka_unit_test(many_lamps_add_up_to_the_whole),
        cmocka_unit_test(weak_lamps_get_fewer_rays_and_the_same_light),
        cmocka_unit_test(smoothing_takes_noise_of_rows_away),
    };
    return RUN_HALF(argc, argv, quick, slow);
}
