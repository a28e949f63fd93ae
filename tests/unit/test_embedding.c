/// Programs that embed the library: typical mistakes, and queries.
#include "core/sampling.h"
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
    const rsv_mesh_desc mesh = { .size = sizeof mesh,
        .positions = corner,
        .vertex_count = 3,
        .triangle_count = 1,
        .material = id };
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

// ---- objects ------------------------------------------------------------------------------------------

static void objects_have_their_triangles(void **state)
{
    fixture *f = *state;
    rsv_scene *scene;
    size_t all = 0;
    assert_int_equal(rsv_scene_builtin(f->context, "cornell-blocks", &scene), RSV_OK);
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    for (uint32_t object = 0; object < view->object_count; object++) {
        uint32_t first;
        size_t count = rsv_scene_object_triangles(scene, object, &first);
        for (size_t k = 0; k < count; k++)
            assert_int_equal(view->triangle_object[first + k], object);
        assert_true(rsv_scene_find_object(scene, view->object_name[object]) <= object);
        all += count;
    }
    uint32_t first;
    assert_int_equal(all, view->triangle_count);
    assert_int_equal(rsv_scene_find_object(scene, "nothing of that name"), RSV_NONE);
    assert_int_equal(rsv_scene_object_triangles(scene, RSV_NONE, &first), 0);
    rsv_scene_destroy(scene);
}

// ---- many points at once ----------------------------------------------------------------------------

static rsv_light *solve_spheres(fixture *f, rsv_scene **scene)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_light *light;
    desc.element_target = 2000;
    desc.rays_per_element = 64;
    desc.refinements = 0;
    desc.photon_count = 10000;
    assert_int_equal(rsv_scene_builtin(f->context, "cornell-spheres", scene), RSV_OK);
    assert_int_equal(rsv_light_create(*scene, &desc, &light), RSV_OK);
    return light;
}

static rsv_triangle_point random_point(rsv_random *random, size_t triangles)
{
    float u = rsv_random_float(random), v = rsv_random_float(random);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    uint32_t triangle = (uint32_t)(rsv_random_float(random) * (float)triangles);
    return (rsv_triangle_point){ triangle, u, v, rsv_random_float(random) < 0.3f };
}

static void many_points_read_as_one_by_one(void **state)
{
    enum { COUNT = 1000 };
    rsv_scene *scene;
    rsv_light *light = solve_spheres(*state, &scene);
    size_t triangles = rsv_scene_get_view(scene)->triangle_count;
    rsv_triangle_point point[COUNT];
    rsv_rgb read[COUNT];
    rsv_random random = rsv_random_from(1, 2, 3);
    for (int k = 0; k < COUNT; k++)
        point[k] = random_point(&random, triangles);
    const uint32_t orders[] = { RSV_NONE, 0, 1, 2, 100 };
    for (int n = 0; n < 5; n++) {
        assert_int_equal(rsv_light_irradiance_points(light, point, COUNT, orders[n], read), RSV_OK);
        for (int k = 0; k < COUNT; k++) {
            const rsv_triangle_point *p = &point[k];
            rsv_rgb one =
                rsv_light_irradiance(light, p->triangle, p->u, p->v, p->back_side, orders[n]);
            assert_memory_equal(&read[k], &one, sizeof one);
        }
    }
    rsv_light_destroy(light);
    rsv_scene_destroy(scene);
}

static void points_off_the_scene_are_refused(void **state)
{
    rsv_scene *scene;
    rsv_light *light = solve_spheres(*state, &scene);
    rsv_triangle_point point[] = { { 0, 0.2f, 0.2f, false }, { 1u << 30, 0.2f, 0.2f, false } };
    rsv_rgb read[2];
    assert_int_equal(
        rsv_light_irradiance_points(light, point, 2, RSV_NONE, read), RSV_ERROR_ARGUMENT);
    assert_mentions(rsv_last_error(), "point 1 is on triangle 1073741824");
    point[1] = (rsv_triangle_point){ 0, NAN, 0, false };
    assert_int_equal(
        rsv_light_irradiance_points(light, point, 2, RSV_NONE, read), RSV_ERROR_ARGUMENT);
    assert_mentions(rsv_last_error(), "u and v of point 1");
    assert_int_equal(rsv_light_irradiance_points(light, NULL, 0, RSV_NONE, NULL), RSV_OK);
    rsv_light_destroy(light);
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
        cmocka_unit_test_setup_teardown(
            objects_have_their_triangles, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            many_points_read_as_one_by_one, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            points_off_the_scene_are_refused, fixture_setup, fixture_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
