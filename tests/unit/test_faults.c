/// Out of memory: whichever allocation fails, the work ends with an error and nothing leaks.
#include "resolvent/bake.h"
#include "resolvent/certify.h"
#include "resolvent/frame.h"
#include "resolvent/io.h"
#include "resolvent/opfile.h"
#include "resolvent/relight.h"
#include "resolvent/render.h"

#include "file_fixture.h"
#include "slow_tests.h"

/// One run in so many allocations: by day, and with the argument `long`. RSV_FAULTS=1 in the environment tries every one.
enum { BY_DAY = 97, BY_NIGHT = 7 };
static size_t stride = BY_DAY;

/// What a run makes; all of it may be missing after a failure.
typedef struct products {
    rsv_scene *scene;
    rsv_light *solution;
    rsv_image *image;
} products;

static void destroy(products *p)
{
    rsv_image_destroy(p->image);
    rsv_light_destroy(p->solution);
    rsv_scene_destroy(p->scene);
}

/// Settings that make every part of a solution, as small as can be.
static rsv_solve_desc smallest(void)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = 60;
    desc.rays_per_element = 64;
    desc.refinements = 1;
    desc.direct_levels = 1;
    desc.light_samples = 16;
    desc.photon_count = 500;
    return desc;
}

static rsv_status solve(fixture *f, const char *scene, products *p)
{
    rsv_builtin_desc builtin = rsv_default_builtin_desc();
    builtin.body_triangles = 100;
    rsv_solve_desc desc = smallest();
    rsv_status status = rsv_scene_builtin_with(f->context, scene, &builtin, &p->scene);
    return status == RSV_OK ? rsv_light_create(p->scene, &desc, &p->solution) : status;
}

static rsv_status render(products *p, rsv_render_mode mode)
{
    rsv_render_desc desc = rsv_default_render_desc();
    desc.mode = mode;
    desc.width = desc.height = 8;
    desc.samples = 1;
    rsv_image_destroy(p->image);
    p->image = NULL;
    if (mode == RSV_RENDER_REFERENCE) return rsv_render_reference(p->scene, &desc, &p->image, NULL);
    return rsv_render(p->solution, &desc, &p->image);
}

static rsv_status run_pictures(fixture *f, const char *scene, products *p)
{
    rsv_status status = solve(f, scene, p);
    if (status == RSV_OK) status = render(p, RSV_RENDER_OPERATOR);
    if (status == RSV_OK) status = render(p, RSV_RENDER_FINAL);
    return status == RSV_OK ? render(p, RSV_RENDER_REFERENCE) : status;
}

/// Fails the allocations of a run one by one.
static void fail_each(
    fixture *f, rsv_status (*run)(fixture *, const char *, products *), const char *scene)
{
    size_t alive = f->allocations_alive;
    f->allocations_left = SIZE_MAX - 1;
    products all = { 0 };
    if (run(f, scene, &all) != RSV_OK) fail_msg("%s: %s", scene, rsv_last_error());
    size_t count = SIZE_MAX - 1 - f->allocations_left;
    destroy(&all);
    for (size_t k = 0; k < count; k += stride) {
        products made = { 0 };
        f->log[0] = 0;
        f->allocations_left = k;
        f->fails_once = true;
        rsv_status status = run(f, scene, &made);
        bool failed = !f->fails_once;
        f->fails_once = false;
        f->allocations_left = SIZE_MAX;
        destroy(&made);
        if (failed && status != RSV_ERROR_MEMORY)
            fail_msg("%s: allocation %zu of %zu failed, the run ended with %d", scene, k, count,
                (int)status);
        if (!failed && status != RSV_OK) // a failure before this one was not forgotten
            fail_msg("%s: no allocation failed, the run ended with %d: %s", scene, (int)status,
                rsv_last_error());
        if (f->allocations_alive != alive)
            fail_msg("%s: allocation %zu of %zu failed, %zd were left", scene, k, count,
                (ssize_t)(f->allocations_alive - alive));
    }
    products after = { 0 };
    if (run(f, scene, &after) != RSV_OK)
        fail_msg("%s: after all those failures: %s", scene, rsv_last_error());
    destroy(&after);
}

static rsv_status run_file(fixture *f, const char *scene, products *p)
{
    folder made = new_folder();
    char path[160];
    snprintf(path, sizeof path, "%s/operator.safetensors", made.path);
    rsv_status status = solve(f, scene, p);
    if (status == RSV_OK) status = rsv_light_save(p->solution, scene, path);
    if (status == RSV_OK) {
        destroy(p);
        *p = (products){ 0 };
        status = rsv_light_load(f->context, path, &p->scene, &p->solution);
    }
    if (status == RSV_OK) {
        rsv_relight_desc desc = { .size = sizeof desc };
        status = rsv_light_relight(p->solution, &desc);
    }
    remove_folder(made.path);
    return status;
}

static rsv_status run_certificate(fixture *f, const char *scene, products *p)
{
    rsv_certify_desc desc = rsv_brief_certify_desc();
    desc.samples = 64;
    desc.gather_rays = 16;
    desc.light_samples = 8;
    rsv_certificate certificate;
    rsv_status status = solve(f, scene, p);
    if (status == RSV_OK) status = rsv_certify(p->solution, &desc, &certificate);
    rsv_error_split split;
    if (status == RSV_OK) status = rsv_split_error(p->solution, &certificate, &split);
    rsv_goal_certificate goal;
    return status == RSV_OK ? rsv_certify_goal(p->solution, &desc, 0, &goal) : status;
}

static rsv_status run_bakes(fixture *f, const char *scene, products *p)
{
    folder made = new_folder();
    char input[160], output[160];
    snprintf(input, sizeof input, "%s/input.glb", made.path);
    snprintf(output, sizeof output, "%s/output.glb", made.path);
    rsv_status status = rsv_scene_builtin(f->context, scene, &p->scene);
    if (status == RSV_OK) status = rsv_scene_save(p->scene, input);
    rsv_scene_destroy(p->scene);
    p->scene = NULL;
    if (status == RSV_OK) status = rsv_scene_load(f->context, input, &p->scene);
    rsv_solve_desc solve_desc = smallest();
    if (status == RSV_OK) status = rsv_light_create(p->scene, &solve_desc, &p->solution);
    rsv_bake_desc desc = rsv_default_bake_desc();
    desc.map_size = 64;
    desc.probe_samples = 32;
    desc.probe_spacing = 0.5F;
    desc.tolerance = 0.5F;
    rsv_bake_report report;
    if (status == RSV_OK) status = rsv_bake_vertices(p->solution, output, &desc, &report);
    // from an operator file, and without the document that it holds
    char kept[160];
    snprintf(kept, sizeof kept, "%s/kept.safetensors", made.path);
    if (status == RSV_OK) status = rsv_light_save(p->solution, scene, kept);
    if (status == RSV_OK) {
        destroy(p);
        *p = (products){ 0 };
        status = rsv_light_load(f->context, kept, &p->scene, &p->solution);
    }
    if (status == RSV_OK) status = rsv_bake_lightmap(p->solution, output, &desc, &report);
    if (status == RSV_OK) rsv_scene_drop_document(p->scene);
    if (status == RSV_OK) status = rsv_bake_vertices(p->solution, output, &desc, NULL);
    snprintf(output, sizeof output, "%s/output.json", made.path);
    if (status == RSV_OK) status = rsv_bake_probes(p->solution, output, &desc, &report);
    remove_folder(made.path);
    return status;
}

static rsv_status run_frames(fixture *f, const char *scene, products *p)
{
    rsv_frame_renderer *renderer = NULL;
    rsv_frame_desc desc = rsv_default_frame_desc();
    desc.width = desc.height = 16;
    rsv_status status = solve(f, scene, p);
    if (status == RSV_OK) status = rsv_frame_renderer_create(p->solution, &desc, &renderer);
    rsv_frame_renderer_destroy(renderer);
    return status;
}

static void pictures_survive_failing_memory(void **state)
{
    fail_each(*state, run_pictures, "cornell-spheres");
    fail_each(*state, run_pictures, "cornell-showcase");
}

static void operator_files_survive_failing_memory(void **state)
{
    fail_each(*state, run_file, "cornell-spheres");
}

static void certificates_survive_failing_memory(void **state)
{
    fail_each(*state, run_certificate, "cornell-blocks");
}

static void bakes_survive_failing_memory(void **state)
{
    fail_each(*state, run_bakes, "cornell-blocks");
}

static void frames_survive_failing_memory(void **state)
{
    fail_each(*state, run_frames, "cornell-spheres");
}

int main(int argc, char **argv)
{
    if (asks_for_more(argc, argv)) stride = BY_NIGHT;
    if (getenv("RSV_FAULTS")) stride = 1;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(
            pictures_survive_failing_memory, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            operator_files_survive_failing_memory, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            certificates_survive_failing_memory, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            bakes_survive_failing_memory, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            frames_survive_failing_memory, fixture_setup, fixture_teardown),
    };
    return cmocka_run_group_tests_name("faults", tests, NULL, NULL);
}
