/// What a program that embeds the library may get wrong or want to know: scenes that are not committed, ...
#include "resolvent/resolvent.h"
#include "unit/scene_fixture.h"

// ---- scenes that are not committed ------------------------------------------------------------------

/// A square that could be lit, not committed.
static rsv_scene *unfinished(fixture *f)
{
    const rsv_vec3 corner[] = { { 0, 0, 0 }, { 0, 0, 1 }, { 1, 0, 1 } };
    const rsv_material material = rsv_default_material();
    rsv_scene *scene;
    uint32_t id;
    assert_int_equal(rsv_scene_create(f->context, &scene), RSV_OK);
    assert_int_equal(rsv_scene_add_material(scene, &material, &id), RSV_OK);
    const rsv_mesh_desc mesh = {
        .positions = corner, .vertex_count = 3, .triangle_count = 1, .material = id
    };
    assert_int_equal(rsv_scene_add_mesh(scene, &mesh, &id), RSV_OK);
    assert_int_equal(rsv_scene_add_instance(scene, id, NULL, NULL), RSV_OK);
    return scene;
}

static void assert_refused(rsv_status status)
{
    assert_int_equal(status, RSV_ERROR_ARGUMENT);
    assert_mentions(rsv_last_error(), "call rsv_scene_commit() first");
}

static void uncommitted_scenes_are_not_solved(void **state)
{
    fixture *f = *state;
    rsv_scene *scene = unfinished(f);
    rsv_light *light = NULL;
    rsv_update_store *store;
    rsv_certificate certificate;
    rsv_error_stop stop;
    const rsv_error_target target = rsv_default_error_target(0.05);
    char digits[RSV_FINGERPRINT_DIGITS + 1];
    assert_refused(rsv_light_create(scene, NULL, &light));
    assert_refused(rsv_solve_to_error(scene, NULL, &target, &light, &certificate, &stop));
    assert_int_equal(rsv_update_store_create(f->context, &store), RSV_OK);
    assert_refused(rsv_operator_update(scene, NULL, store, &light, NULL));
    assert_refused(rsv_scene_fingerprint(scene, digits));
    assert_null(light);
    rsv_update_store_destroy(store);
    rsv_scene_destroy(scene);
}

static void uncommitted_scenes_are_not_shown(void **state)
{
    fixture *f = *state;
    rsv_scene *scene = unfinished(f);
    rsv_render_desc desc = rsv_default_render_desc();
    const rsv_plan_desc plan = rsv_default_plan_desc();
    const rsv_probe probe = { { 0, 1, 0 }, { 0, 1, 0 } };
    rsv_probe_reading reading;
    rsv_image *image = NULL;
    rsv_light *light = NULL;
    rsv_tracer *tracer = NULL;
    assert_refused(rsv_render_planned(scene, &plan, &desc, &light, &image, NULL));
    assert_refused(rsv_render_reference(scene, &desc, &image, NULL));
    assert_refused(rsv_probe_reference(scene, &probe, 1, 16, 0, &reading));
    desc.mode = RSV_RENDER_OCCLUSION;
    assert_refused(rsv_render_occlusion(scene, &desc, &image));
    assert_refused(rsv_tracer_create(scene, &tracer));
    assert_null(image);
    rsv_scene_destroy(scene);
}

static void uncommitted_scenes_are_not_checked_or_written(void **state)
{
    fixture *f = *state;
    rsv_scene *scene = unfinished(f);
    rsv_finding *findings;
    size_t count;
    rsv_probe *sensors;
    rsv_fog fog = rsv_default_fog();
    assert_refused(rsv_scene_check(scene, &findings, &count));
    assert_refused(rsv_scene_save(scene, "uncommitted.glb"));
    assert_refused(rsv_scene_set_fog(scene, &fog));
    assert_refused(rsv_daylight_sensors(scene, 0.8, 0.5, &sensors, &count));
    rsv_scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(
            uncommitted_scenes_are_not_solved, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            uncommitted_scenes_are_not_shown, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            uncommitted_scenes_are_not_checked_or_written, fixture_setup, fixture_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
