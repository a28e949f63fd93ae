/// The runtime for engines against the library, by way of the files that both read.
#include "resolvent/bake.h"
#include "resolvent/io.h"
#include "resolvent/opfile.h"
#include "resolvent/relight.h"
#include "resolvent_rt_file.h"

#include "bake/bake_operator.h"
#include "bake_places.h"
#include "file_fixture.h"
#include "light_fixture.h"
#include "light_view.h"
#include "slow_tests.h"

/// A lamp and spotlights, in rooms with glass and metal, and elements that hang.
typedef struct solved_file {
    folder place;
    char path[256];
    rsv_context *context;
} solved_file;

static int write_operator(void **state)
{
    solved_file *f = calloc(1, sizeof *f);
    rsv_scene *scene;
    rsv_light *s;
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = 300;
    desc.rays_per_element = 64;
    desc.photon_count = 0;
    desc.refinements = 1;
    desc.direct_levels = 0;
    desc.tolerance = 1e-6f;
    f->place = new_folder();
    snprintf(f->path, sizeof f->path, "%s", path_in(&f->place, "gallery.safetensors"));
    assert_int_equal(rsv_context_create(NULL, &f->context), RSV_OK);
    assert_int_equal(rsv_scene_builtin(f->context, "gallery:2", &scene), RSV_OK);
    if (rsv_light_create(scene, &desc, &s) != RSV_OK) fail_msg("%s", rsv_last_error());
    assert_int_equal(rsv_light_save(s, "gallery:2", f->path), RSV_OK);
    rsv_light_destroy(s);
    rsv_scene_destroy(scene);
    *state = f;
    return 0;
}

static int remove_operator(void **state)
{
    solved_file *f = *state;
    remove_folder(f->place.path);
    rsv_context_destroy(f->context);
    free(f);
    return 0;
}

/// Factors that differ from light to light; lights of one name share theirs. What rows gathered stays.
static void choose_scales(const rsv_rt_file *file, uint32_t count, float (*scale)[3])
{
    for (uint32_t l = 0; l < count; l++) {
        const char *name = rsv_rt_file_light(file, l);
        float strength = name ? 0.25f + (float)(strlen(name) % 5) : 1;
        scale[l][0] = strength;
        scale[l][1] = name ? 0.5f : 1;
        scale[l][2] = name ? 2 / strength : 1;
    }
}

/// The library's answer.
static void relight(const solved_file *f, const rsv_rt_file *file, uint32_t count,
    float (*scale)[3], rsv_scene **scene, rsv_light **s)
{
    rsv_light_scale light[64];
    uint32_t named = 0;
    for (uint32_t l = 0; l < count && rsv_rt_file_light(file, l); l++)
        light[named++] = (rsv_light_scale){ rsv_rt_file_light(file, l),
            { scale[l][0], scale[l][1], scale[l][2] } };
    const rsv_relight_desc desc = { .size = sizeof desc, .light = light, .light_count = named };
    assert_int_equal(rsv_light_load(f->context, f->path, scene, s), RSV_OK);
    if (rsv_light_relight(*s, &desc) != RSV_OK) fail_msg("%s", rsv_last_error());
}

static double largest_difference(const float *a, const rsv_rgb *b, size_t count)
{
    double difference = 0, size = 0;
    for (size_t k = 0; k < 3 * count; k++) {
        difference = fmax(difference, fabs((double)a[k] - (&b->r)[k]));
        size = fmax(size, (&b->r)[k]);
    }
    return difference / size;
}

static int always(void *user)
{
    (void)user;
    return 1;
}

typedef struct engine {
    rsv_rt_file file;
    rsv_rt_operator transport;
    rsv_rt_basis direct;
    float *irradiance, *exitance, *source;
} engine;

static void start(engine *e, const char *path)
{
    if (rsv_rt_file_open(&e->file, path) || rsv_rt_file_operator(&e->file, &e->transport) ||
        rsv_rt_file_direct(&e->file, &e->direct))
        fail_msg("%s", e->file.message);
    size_t count = e->transport.element_count;
    assert_int_equal(e->direct.receiver_count, count);
    e->irradiance = calloc(3 * count, sizeof *e->irradiance);
    e->source = calloc(3 * count, sizeof *e->source);
    e->exitance = aligned_alloc(16, 4 * count * sizeof *e->exitance);
}

static void stop(engine *e)
{
    free(e->irradiance);
    free(e->source);
    free(e->exitance);
    rsv_rt_file_close(&e->file);
}

static void solve(engine *e)
{
    rsv_rt_solver solver;
    rsv_rt_solver_begin(&solver, &e->transport, e->irradiance, e->exitance);
    assert_int_equal(
        rsv_rt_solver_update_while(&solver, e->source, 1e-6f, 100000, always, NULL), 1);
}

static void the_operator_route_is_relight(void **state)
{
    engine e;
    rsv_scene *scene;
    rsv_light *s;
    float scale[64][3];
    start(&e, ((solved_file *)*state)->path);
    assert_true(e.transport.hanging_count > 0 && e.direct.light_count > 2);
    choose_scales(&e.file, e.direct.light_count, scale);
    relight(*state, &e.file, e.direct.light_count, scale, &scene, &s);
    assert_int_equal(rsv_rt_relight(&e.direct, &scale[0][0], e.direct.light_count, 0,
                         e.direct.receiver_count, e.source),
        RSV_RT_OK);
    solve(&e);
    assert_true(largest_difference(
                    e.irradiance, inside(s)->irradiance, inside(s)->elements->node_count) < 1e-4);
    rsv_light_destroy(s);
    rsv_scene_destroy(scene);
    stop(&e);
}

static void the_basis_route_is_relight(void **state)
{
    engine e;
    rsv_scene *scene;
    rsv_light *s;
    float scale[64][3];
    start(&e, ((solved_file *)*state)->path);
    uint32_t lights = e.direct.light_count, count = e.transport.element_count;
    choose_scales(&e.file, lights, scale);
    relight(*state, &e.file, lights, scale, &scene, &s);
    float *value = malloc((size_t)lights * count * 3 * sizeof *value);
    for (uint32_t l = 0; l < lights; l++) { // what each light does by itself
        memcpy(e.source, e.direct.value + (size_t)l * count * 3, count * 3 * sizeof *value);
        memset(e.irradiance, 0, count * 3 * sizeof *value);
        solve(&e);
        memcpy(value + (size_t)l * count * 3, e.irradiance, count * 3 * sizeof *value);
    }
    const rsv_rt_basis basis = { lights, count, 1, value };
    rsv_rt_relight(&basis, &scale[0][0], lights, 0, count, e.irradiance);
    assert_true(largest_difference(e.irradiance, inside(s)->irradiance, count) < 1e-4);
    free(value);
    rsv_light_destroy(s);
    rsv_scene_destroy(scene);
    stop(&e);
}

// ---- receivers ------------------------------------------------------------------------------------

typedef rsv_status (*bake_function)(const rsv_light *solution, const char *output,
    const rsv_bake_desc *desc, rsv_bake_report *report);

/// The stored light at four points of each triangle.
static rsv_status bake_places(const rsv_light *solution, const char *output,
    const rsv_bake_desc *desc, rsv_bake_report *report)
{
    const rsv_light_view *s = rsv_light_get_view(solution);
    size_t count = 4 * s->scene.view->triangle_count, lights;
    rsv_bake_receiver *receiver = calloc(count, sizeof *receiver);
    for (uint32_t k = 0; k < count; k++)
        receiver[k] = (rsv_bake_receiver){
            .triangle = k / 4, .u = k % 4 & 1 ? 0.6f : 0.2f, .v = k % 4 & 2 ? 0.3f : 0.1f
        };
    rsv_bake_reader reader = reader_of_places("vertex", receiver, count);
    rsv_status status = rsv_bake_write_basis(s, &reader, desc, output, &lights);
    if (status == RSV_OK) status = rsv_bake_write_operator(s, "vertex", receiver, count, output);
    report->lights = lights;
    free(receiver);
    return status;
}

/// A box with its lamp, with a basis and an operator. Direct light is given at the elements that have rows.
static void bake_box(const solved_file *f, bake_function bake)
{
    char input[256], output[256];
    snprintf(input, sizeof input, "%s", path_in(&f->place, "box.glb"));
    snprintf(output, sizeof output, "%s", path_in(&f->place, "lit.glb"));
    rsv_scene *scene;
    rsv_light *s;
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = 600;
    desc.direct_level = false;
    desc.photon_count = 0;
    desc.tolerance = 1e-6f;
    rsv_bake_desc how = rsv_default_bake_desc();
    how.map_size = 128;
    how.basis = how.operator_file = true;
    rsv_bake_report report = { 0 };
    assert_int_equal(rsv_scene_builtin(f->context, "cornell-blocks", &scene), RSV_OK);
    assert_int_equal(rsv_scene_save(scene, input), RSV_OK);
    rsv_scene_destroy(scene);
    assert_int_equal(rsv_scene_load(f->context, input, &scene), RSV_OK);
    assert_int_equal(rsv_light_create(scene, &desc, &s), RSV_OK);
    if (bake(s, output, &how, &report)) fail_msg("%s", rsv_last_error());
    rsv_light_destroy(s);
    rsv_scene_destroy(scene);
}

/// What was baked: all lights of the basis together. @return [basis.receiver_count][3]
static float *read_baked(const char *path, uint32_t *count)
{
    rsv_rt_file file;
    rsv_rt_basis basis;
    float scale[3 * 64];
    for (int k = 0; k < 3 * 64; k++)
        scale[k] = 1;
    if (rsv_rt_file_open(&file, path) || rsv_rt_file_basis(&file, &basis))
        fail_msg("%s", file.message);
    float *baked = calloc(basis.receiver_count, 3 * sizeof *baked);
    assert_int_equal(
        rsv_rt_relight(&basis, scale, basis.light_count, 0, basis.receiver_count, baked), 0);
    *count = basis.receiver_count;
    rsv_rt_file_close(&file);
    return baked;
}

/// Mean over all receivers of the difference, relative to the mean.
static double mean_difference(const float *a, const float *b, size_t count)
{
    double difference = 0, sum = 0;
    for (size_t k = 0; k < 3 * count; k++) {
        difference += fabs((double)a[k] - (double)b[k]);
        sum += (double)b[k];
    }
    return difference / sum;
}

/// @param shown out: difference from what `bake` shows, with its sharpened indirect light @param solved out: of the runtime's
/// own solution
static void judge_receivers(const solved_file *f, double *shown, double *solved)
{
    engine e;
    rsv_rt_receivers receivers;
    uint32_t count;
    float *baked = read_baked(path_in(&f->place, "lit.light.safetensors"), &count);
    start(&e, path_in(&f->place, "lit.operator.safetensors"));
    if (rsv_rt_file_receivers(&e.file, &e.transport, &receivers)) fail_msg("%s", e.file.message);
    assert_int_equal(receivers.count, count);
    size_t floats = 3 * (size_t)e.transport.element_count;
    float *out = calloc(count, 3 * sizeof *out), *field = calloc(floats, sizeof *field);
    const float *source = rsv_rt_file_array(&e.file, "source", "F32", NULL);
    const float *indirect = rsv_rt_file_array(&e.file, "shown.indirect", "F32", NULL);
    assert_true(source && indirect);
    for (size_t k = 0; k < floats; k++) {
        field[k] = source[k] + indirect[k];
        e.source[k] = source[k];
    }
    assert_int_equal(rsv_rt_receive(&receivers, field, 0, count, out), RSV_RT_OK);
    *shown = mean_difference(out, baked, count);
    solve(&e);
    assert_int_equal(rsv_rt_receive(&receivers, e.irradiance, 0, count, out), RSV_RT_OK);
    *solved = mean_difference(out, baked, count);
    free(field);
    free(out);
    free(baked);
    stop(&e);
}

static void receivers_show_what_is_baked(void **state)
{
    const solved_file *f = *state;
    static const char *const what[] = { "places", "vertices", "texels" };
    const bake_function bake[] = { bake_places, rsv_bake_vertices, rsv_bake_lightmap };
    // bakes sample direct light at each receiver; elements smear it at the edges of shadows and in corners, where the vertices
    // of a box are
    const double most[] = { 1e-6, 0.2, 0.1 }, most_solved[] = { 0.02, 0.2, 0.1 };
    for (int k = 0; k < 3; k++) {
        double shown, solved;
        bake_box(f, bake[k]);
        judge_receivers(f, &shown, &solved);
        print_message("%s: off by %.2g, unsharpened by %.2g\n", what[k], shown, solved);
        assert_true(shown < most[k]);
        assert_true(solved < most_solved[k]);
    }
}

/// Light without E0, whatever E0 was at the time of the visit.
static void bounced_light_is_kept_by_itself(void **state)
{
    engine e;
    rsv_rt_solver solver;
    start(&e, ((solved_file *)*state)->path);
    size_t floats = 3 * (size_t)e.transport.element_count;
    float *bounced = malloc(floats * sizeof *bounced);
    memcpy(e.source, e.direct.value, floats * sizeof *e.source);
    rsv_rt_solver_begin(&solver, &e.transport, e.irradiance, e.exitance);
    rsv_rt_solver_keep_bounced(&solver, bounced);
    assert_int_equal(rsv_rt_solver_update_while(&solver, e.source, 1e-6f, 100000, always, NULL), 1);
    for (uint32_t k = 0; k < e.transport.hanging_count; k++) // E0 there is that of the parents
        for (size_t c = 0; c < 3; c++) {
            float *own = &e.source[3 * (size_t)e.transport.hanging_node[k] + c];
            *own = 0;
            for (size_t p = 4 * (size_t)k; p < 4 * (size_t)k + 4; p++)
                *own += e.transport.hanging_weight[p] *
                        e.source[3 * (size_t)e.transport.hanging_parent[p] + c];
        }
    float largest = 0;
    for (size_t k = 0; k < floats; k++)
        largest = fmaxf(largest, e.irradiance[k]);
    for (size_t k = 0; k < floats; k++)
        assert_true(fabsf(e.source[k] + bounced[k] - e.irradiance[k]) <= 1e-5f * largest);
    free(bounced);
    stop(&e);
}

static void damaged_files_are_refused(void **state)
{
    const solved_file *f = *state;
    size_t bytes;
    rsv_rt_file file;
    rsv_rt_operator transport;
    uint8_t *all = read_bytes(f->path, &bytes);
    const char *path = path_in(&f->place, "damaged.safetensors");
    const size_t length[] = { 0, 7, 100, bytes / 8 };
    for (size_t k = 0; k < sizeof length / sizeof length[0]; k++) {
        write_bytes(path, all, length[k]);
        assert_false(
            rsv_rt_file_open(&file, path) == 0 && rsv_rt_file_operator(&file, &transport) == 0);
        assert_true(file.message[0]);
        rsv_rt_file_close(&file);
    }
    for (size_t k = 0; k + 20 < bytes; k++) // of another version
        if (memcmp(all + k, "format_version\":\"2\"", 19) == 0) all[k + 17] = '7';
    write_bytes(path, all, bytes);
    assert_int_equal(rsv_rt_file_open(&file, path), 0);
    assert_int_equal(rsv_rt_file_operator(&file, &transport), -1);
    assert_non_null(strstr(file.message, "version is '7'"));
    rsv_rt_basis basis;
    assert_int_equal(rsv_rt_file_basis(&file, &basis), -1);
    assert_int_equal(strncmp(file.message, path, strlen(path)), 0);
    rsv_rt_file_close(&file);
    assert_int_equal(rsv_rt_file_open(&file, path_in(&f->place, "nowhere")), -1);
    assert_non_null(strstr(file.message, "nowhere"));
    rsv_rt_file_close(&file);
    free(all);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest quick[] = {
        cmocka_unit_test(the_operator_route_is_relight),
        cmocka_unit_test(the_basis_route_is_relight),
        cmocka_unit_test(bounced_light_is_kept_by_itself),
        cmocka_unit_test(damaged_files_are_refused),
    };
    const struct CMUnitTest slow[] = {
        cmocka_unit_test(receivers_show_what_is_baked),
    };
    return RUN_HALF_WITH(argc, argv, quick, slow, write_operator, remove_operator);
}
