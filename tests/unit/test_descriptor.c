/// Descriptors of programs that were built with an earlier or a later version of the library.
#include "core/descriptor.h"
#include "resolvent/device.h"
#include "resolvent/resolvent.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

typedef struct fixture {
    rsv_context *context;
    rsv_scene *scene;
    rsv_light *light;
} fixture;

static int set_up(void **state)
{
    fixture *f = calloc(1, sizeof *f);
    assert_non_null(f);
    rsv_solve_desc solve = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    solve.element_target = 60;
    solve.rays_per_element = 64;
    assert_int_equal(rsv_context_create(NULL, &f->context), RSV_OK);
    assert_int_equal(rsv_scene_builtin(f->context, "cornell-blocks", &f->scene), RSV_OK);
    assert_int_equal(rsv_light_create(f->scene, &solve, &f->light), RSV_OK);
    *state = f;
    return 0;
}

static int tear_down(void **state)
{
    fixture *f = *state;
    rsv_light_destroy(f->light);
    rsv_scene_destroy(f->scene);
    rsv_context_destroy(f->context);
    free(f);
    return 0;
}

static void assert_says(rsv_status status, const char *first, const char *second)
{
    assert_int_equal(status, RSV_ERROR_ARGUMENT);
    if (!strstr(rsv_last_error(), first) || !strstr(rsv_last_error(), second))
        fail_msg("'%s' lacks '%s' or '%s'", rsv_last_error(), first, second);
}

// ---- versions of a descriptor -------------------------------------------------------------------------

/// rsv_probe_desc before it had a seed, and a possible future version.
typedef struct earlier_probe_desc {
    size_t size;
    rsv_probe_mode mode;
    uint32_t samples;
} earlier_probe_desc;

typedef struct later_probe_desc {
    rsv_probe_desc known;
    double unknown;
} later_probe_desc;

static const rsv_probe probe = { .position = { 0, 0.5f, 0 }, .normal = { 0, 1, 0 } };

static rsv_probe_reading read_with(const fixture *f, const void *desc)
{
    rsv_probe_reading reading;
    assert_int_equal(rsv_probe_irradiance(f->light, desc, &probe, 1, &reading), RSV_OK);
    return reading;
}

static void earlier_descriptors_get_the_defaults_of_later_fields(void **state)
{
    fixture *f = *state;
    struct {
        earlier_probe_desc desc;
        uint32_t beyond[2]; ///< where the seed is today
    } old;
    memset(&old, 0xa5, sizeof old);
    rsv_probe_desc_init((rsv_probe_desc *)&old.desc, sizeof old.desc);
    assert_int_equal(old.desc.size, sizeof old.desc);
    assert_int_equal(old.beyond[0], 0xa5a5a5a5);
    rsv_probe_desc now = rsv_default_probe_desc();
    assert_true(old.desc.mode == now.mode && old.desc.samples == now.samples);
    old.desc.samples = now.samples = 64;
    const rsv_probe_reading a = read_with(f, &old.desc), b = read_with(f, &now);
    assert_memory_equal(&a, &b, sizeof a);
    now.seed = 0xa5a5a5a5;
    const rsv_probe_reading c = read_with(f, &now);
    assert_memory_not_equal(
        &a, &c, sizeof a); // the seed counts: it was not read from beyond the end
}

static void later_descriptors_count_as_far_as_they_are_known(void **state)
{
    fixture *f = *state;
    rsv_probe_desc now = rsv_default_probe_desc();
    later_probe_desc next;
    memset(&next, 0xa5, sizeof next);
    rsv_probe_desc_init(&next.known, sizeof next);
    assert_true(next.known.size == sizeof next && next.unknown == 0);
    next.known.samples = now.samples = 64;
    const rsv_probe_reading a = read_with(f, &next), b = read_with(f, &now);
    assert_memory_equal(&a, &b, sizeof a);
    next.unknown = 1;
    rsv_probe_reading reading;
    assert_says(rsv_probe_irradiance(f->light, &next.known, &probe, 1, &reading), "rsv_probe_desc",
        "use a later version");
}

static void sizes_that_are_none_are_refused(void **state)
{
    fixture *f = *state;
    rsv_probe_desc desc = rsv_default_probe_desc();
    rsv_probe_reading reading;
    const size_t bad[] = { 0, 1, sizeof(size_t), 4097, SIZE_MAX };
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        desc.size = bad[k];
        assert_says(rsv_probe_irradiance(f->light, &desc, &probe, 1, &reading),
            "rsv_probe_desc.size is ", "start from rsv_default_probe_desc()");
    }
}

static void descriptors_within_descriptors_have_versions_too(void **state)
{
    fixture *f = *state;
    rsv_plan_desc plan = rsv_default_plan_desc();
    rsv_render_desc picture = rsv_default_render_desc();
    rsv_solve_desc solve = { 0 };
    rsv_light *light = NULL;
    rsv_image *image = NULL;
    plan.solve = &solve;
    assert_says(rsv_render_planned(f->scene, &plan, &picture, &light, &image, NULL),
        "rsv_solve_desc.size", "rsv_default_solve_desc()");
    assert_null(light);
    assert_null(image);
}

// ---- all of them ------------------------------------------------------------------------------------------

#define ASSERT_NEEDS_SIZE(call, type) assert_says(call, #type ".size is 0", "sizeof(" #type ")")

static void descriptors_of_pictures_need_a_size(void **state)
{
    fixture *f = *state;
    const rsv_render_desc render = { 0 };
    const rsv_frame_desc frame = { 0 };
    const rsv_mover_desc mover = { 0 };
    const rsv_plan_desc plan = { 0 };
    rsv_light *light = NULL;
    rsv_image *image = NULL;
    rsv_occlusion *occlusion = NULL;
    rsv_frame_renderer *renderer = NULL;
    rsv_mover *moved = NULL;
    ASSERT_NEEDS_SIZE(rsv_render(f->light, &render, &image), rsv_render_desc);
    ASSERT_NEEDS_SIZE(rsv_render_reference(f->scene, &render, &image, NULL), rsv_render_desc);
    ASSERT_NEEDS_SIZE(rsv_render_occlusion(f->scene, &render, &image), rsv_render_desc);
    ASSERT_NEEDS_SIZE(rsv_occlusion_create(f->scene, &render, &occlusion), rsv_render_desc);
    ASSERT_NEEDS_SIZE(
        rsv_render_operator(f->light, &render, RSV_GLOSS_PATHS, &image), rsv_render_desc);
    ASSERT_NEEDS_SIZE(
        rsv_render_planned(f->scene, NULL, &render, &light, &image, NULL), rsv_render_desc);
    ASSERT_NEEDS_SIZE(
        rsv_render_planned(f->scene, &plan, NULL, &light, &image, NULL), rsv_plan_desc);
    ASSERT_NEEDS_SIZE(rsv_frame_renderer_create(f->light, &frame, &renderer), rsv_frame_desc);
    ASSERT_NEEDS_SIZE(rsv_mover_create(f->light, f->scene, &mover, &moved), rsv_mover_desc);
    assert_true(!light && !image && !occlusion && !renderer && !moved);
}

static void descriptors_of_solutions_need_a_size(void **state)
{
    fixture *f = *state;
    const rsv_solve_desc solve = { 0 };
    const rsv_relight_desc relight = { 0 };
    const rsv_error_target target = { 0 };
    const rsv_fit_desc fit = { 0 };
    const rsv_fit_wanted wanted = { .probe = probe, .reading = { 1, 1, 1 }, .weight = 1 };
    rsv_light *light = NULL;
    rsv_update_store *store = NULL;
    rsv_certificate certificate;
    rsv_error_stop stop;
    rsv_fit *fitted = NULL;
    ASSERT_NEEDS_SIZE(rsv_light_create(f->scene, &solve, &light), rsv_solve_desc);
    assert_int_equal(rsv_update_store_create(f->context, &store), RSV_OK);
    ASSERT_NEEDS_SIZE(rsv_operator_update(f->scene, &solve, store, &light, NULL), rsv_solve_desc);
    rsv_update_store_destroy(store);
    ASSERT_NEEDS_SIZE(rsv_light_relight(f->light, &relight), rsv_relight_desc);
    ASSERT_NEEDS_SIZE(
        rsv_solve_to_error(f->scene, &solve, NULL, &light, &certificate, &stop), rsv_solve_desc);
    ASSERT_NEEDS_SIZE(
        rsv_solve_to_error(f->scene, NULL, &target, &light, &certificate, &stop), rsv_error_target);
    ASSERT_NEEDS_SIZE(rsv_fit_create(f->light, &wanted, 1, &fit, &fitted), rsv_fit_desc);
    assert_true(!light && !fitted);
}

static void descriptors_of_errors_and_bakes_need_a_size(void **state)
{
    fixture *f = *state;
    const rsv_certify_desc certify = { 0 };
    const rsv_heat_map_desc map = { 0 };
    const rsv_bake_desc bake = { 0 };
    rsv_certificate certificate;
    rsv_goal_certificate goal;
    rsv_image *image = NULL;
    ASSERT_NEEDS_SIZE(rsv_certify(f->light, &certify, &certificate), rsv_certify_desc);
    ASSERT_NEEDS_SIZE(rsv_certify_goal(f->light, &certify, 0, &goal), rsv_certify_desc);
    ASSERT_NEEDS_SIZE(rsv_certify_points(f->light, &certify, &probe, 1, &goal), rsv_certify_desc);
    ASSERT_NEEDS_SIZE(
        rsv_certify_picture(f->light, &certify, NULL, &certificate, &image), rsv_certify_desc);
    ASSERT_NEEDS_SIZE(
        rsv_certify_picture(f->light, NULL, &map, &certificate, &image), rsv_heat_map_desc);
    ASSERT_NEEDS_SIZE(rsv_bake(f->light, "vertex", "none.glb", &bake, NULL), rsv_bake_desc);
    ASSERT_NEEDS_SIZE(rsv_bake_vertices(f->light, "none.glb", &bake, NULL), rsv_bake_desc);
    ASSERT_NEEDS_SIZE(rsv_bake_lightmap(f->light, "none.glb", &bake, NULL), rsv_bake_desc);
    ASSERT_NEEDS_SIZE(rsv_bake_probes(f->light, "none.json", &bake, NULL), rsv_bake_desc);
    assert_null(image);
}

static void descriptors_of_daylight_need_a_size(void **state)
{
    fixture *f = *state;
    const rsv_daylight_desc desc = { 0 };
    const rsv_daylight_run_desc run = { 0 };
    const rsv_weather weather = { 0 };
    rsv_daylight *daylight = NULL;
    rsv_daylight_report report;
    rsv_daylight_desc quick = rsv_default_daylight_desc(RSV_QUALITY_DRAFT);
    quick.subdivision = 1;
    quick.sensor_rays = quick.node_rays = 240;
    ASSERT_NEEDS_SIZE(rsv_daylight_surround(f->scene, &weather, &desc), rsv_daylight_desc);
    ASSERT_NEEDS_SIZE(
        rsv_daylight_create(f->light, &probe, 1, &desc, &daylight), rsv_daylight_desc);
    assert_null(daylight);
    assert_int_equal(rsv_daylight_create(f->light, &probe, 1, &quick, &daylight), RSV_OK);
    ASSERT_NEEDS_SIZE(rsv_daylight_run(daylight, &weather, &run, &report), rsv_daylight_run_desc);
    rsv_daylight_destroy(daylight);
}

static void descriptors_of_scenes_need_a_size(void **state)
{
    fixture *f = *state;
    const rsv_context_desc context = { 0 };
    const rsv_load_desc load = { 0 };
    const rsv_builtin_desc builtin = { 0 };
    const rsv_mesh_desc mesh = { 0 };
    const rsv_texture_desc texture = { 0 };
    const rsv_device_desc device = { 0 };
    rsv_context *other = NULL;
    rsv_scene *scene = NULL, *empty = NULL;
    rsv_animation *animation = NULL;
    rsv_device *opened = NULL;
    uint32_t id;
    ASSERT_NEEDS_SIZE(rsv_context_create(&context, &other), rsv_context_desc);
    ASSERT_NEEDS_SIZE(rsv_scene_load_with(f->context, "none.glb", &load, &scene), rsv_load_desc);
    ASSERT_NEEDS_SIZE(
        rsv_scene_load_memory(f->context, "none.glb", "", 0, &load, &scene), rsv_load_desc);
    ASSERT_NEEDS_SIZE(rsv_animation_open(f->context, "none.glb", &load, &animation), rsv_load_desc);
    ASSERT_NEEDS_SIZE(
        rsv_scene_builtin_with(f->context, "furnace", &builtin, &scene), rsv_builtin_desc);
    ASSERT_NEEDS_SIZE(rsv_device_open(&device, &opened), rsv_device_desc);
    assert_int_equal(rsv_scene_create(f->context, &empty), RSV_OK);
    ASSERT_NEEDS_SIZE(rsv_scene_add_mesh(empty, &mesh, &id), rsv_mesh_desc);
    ASSERT_NEEDS_SIZE(rsv_scene_add_texture(empty, &texture, &id), rsv_texture_desc);
    rsv_scene_destroy(empty);
    assert_true(!other && !scene && !animation && !opened);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(earlier_descriptors_get_the_defaults_of_later_fields),
        cmocka_unit_test(later_descriptors_count_as_far_as_they_are_known),
        cmocka_unit_test(sizes_that_are_none_are_refused),
        cmocka_unit_test(descriptors_within_descriptors_have_versions_too),
        cmocka_unit_test(descriptors_of_pictures_need_a_size),
        cmocka_unit_test(descriptors_of_solutions_need_a_size),
        cmocka_unit_test(descriptors_of_errors_and_bakes_need_a_size),
        cmocka_unit_test(descriptors_of_daylight_need_a_size),
        cmocka_unit_test(descriptors_of_scenes_need_a_size),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
