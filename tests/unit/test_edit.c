/// Scenes without some of their objects, with others twice, and with other materials.
#include "scene_fixture.h"

#include "resolvent/edit.h"
#include "resolvent/update.h"

static rsv_scene *open_room(rsv_context *context)
{
    rsv_scene *room = NULL;
    assert_int_equal(rsv_scene_builtin(context, "cornell-blocks", &room), RSV_OK);
    return room;
}

static rsv_scene *apply(const rsv_scene *scene, const rsv_scene_edit *edit)
{
    rsv_scene *edited = NULL;
    if (rsv_scene_apply_edit(scene, edit, &edited) != RSV_OK) fail_msg("%s", rsv_last_error());
    return edited;
}

/// Triangle k of one object, as corners.
static void corners_of(const rsv_scene_view *v, uint32_t object, uint32_t k, rsv_vec3 corner[3])
{
    uint32_t t = 0;
    while (v->triangle_object[t] != object)
        t++;
    for (int c = 0; c < 3; c++)
        corner[c] = v->position[v->triangle[t + k][c]];
}

static void assert_same_object(
    const rsv_scene_view *v, uint32_t object, const rsv_scene_view *w, uint32_t other)
{
    rsv_vec3 a[3], b[3];
    assert_string_equal(v->object_name[object], w->object_name[other]);
    for (uint32_t k = 0; k < 2; k++) {
        corners_of(v, object, k, a);
        corners_of(w, other, k, b);
        assert_memory_equal(a, b, sizeof a);
    }
}

static void objects_go_and_come_bit_for_bit(void **state)
{
    rsv_context *context = ((fixture *)*state)->context;
    rsv_scene *room = open_room(context);
    const uint32_t kept[] = { 7, 0, 1, 6, 6 };
    const rsv_material_edit blue = { 1, { 0.1f, 0.2f, 0.9f }, 0.3f, 0.5f };
    rsv_scene_edit edit = rsv_default_scene_edit();
    rsv_scene *same = apply(room, &edit);
    edit.object = kept;
    edit.object_count = 5;
    edit.material = &blue;
    edit.material_count = 1;
    rsv_scene *edited = apply(room, &edit);
    const rsv_scene_view *v = rsv_scene_get_view(room), *w = rsv_scene_get_view(edited),
                         *s = rsv_scene_get_view(same);
    assert_int_equal(w->object_count, 5);
    for (uint32_t k = 0; k < 5; k++)
        assert_same_object(v, kept[k], w, k);
    assert_true(w->material[1].roughness == 0.3f && w->material[1].metallic == 0.5f);
    assert_true(w->material[1].base_color.b == 0.9f && v->material[1].base_color.b != 0.9f);
    assert_int_equal(s->vertex_count, v->vertex_count);
    assert_memory_equal(s->position, v->position, v->vertex_count * sizeof *v->position);
    assert_memory_equal(s->normal, v->normal, v->vertex_count * sizeof *v->normal);
    assert_memory_equal(&w->camera[0].position, &v->camera[0].position, sizeof(rsv_vec3));
    rsv_scene_destroy(same);
    rsv_scene_destroy(edited);
    rsv_scene_destroy(room);
}

/// One of two blocks goes on, the other one waits.
static void versions_are_mixed(void **state)
{
    rsv_scene *room = open_room(((fixture *)*state)->context);
    const rsv_motion up[2] = {
        { 5, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0.1f, 0, 1 } },
        { 6, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0.1f, 0, 1 } },
    };
    const bool moved[8] = { [5] = true };
    const uint32_t few[] = { 0, 1 };
    rsv_scene *late = NULL, *mixed = NULL, *other = NULL;
    rsv_scene_edit edit = rsv_default_scene_edit();
    edit.object = few;
    edit.object_count = 2;
    assert_int_equal(rsv_scene_move(room, up, 2, &late), RSV_OK);
    assert_int_equal(rsv_scene_mix(room, late, moved, &mixed), RSV_OK);
    assert_same_object(rsv_scene_get_view(late), 5, rsv_scene_get_view(mixed), 5);
    assert_same_object(rsv_scene_get_view(room), 6, rsv_scene_get_view(mixed), 6);
    rsv_scene_destroy(mixed);
    other = apply(room, &edit);
    assert_int_equal(rsv_scene_mix(other, late, moved, &mixed), RSV_ERROR_ARGUMENT);
    rsv_scene_destroy(other);
    rsv_scene_destroy(late);
    rsv_scene_destroy(room);
}

/// A move that makes a scene invalid is rejected with the same error as an invalid file.
static void objects_do_not_grow_beyond_all_bounds(void **state)
{
    rsv_scene *room = open_room(((fixture *)*state)->context), *moved = NULL;
    const rsv_motion huge = { 5, { 1e10f, 0, 0, 0, 0, 1e10f, 0, 0, 0, 0, 1e10f, 0, 0, 0, 0, 1 } };
    assert_int_equal(rsv_scene_move(room, &huge, 1, &moved), RSV_ERROR_SCENE);
    assert_non_null(strstr(rsv_last_error(), "'short block' reaches to a coordinate"));
    rsv_scene_destroy(room);
}

static void assert_refused(
    const rsv_scene *room, rsv_scene_edit edit, rsv_status wanted, const char *why)
{
    rsv_scene *edited = NULL;
    assert_int_equal(rsv_scene_apply_edit(room, &edit, &edited), wanted);
    if (!strstr(rsv_last_error(), why)) fail_msg("%s", rsv_last_error());
}

static void bad_edits_are_refused(void **state)
{
    rsv_scene *room = open_room(((fixture *)*state)->context);
    const uint32_t beyond = 8;
    const rsv_material_edit none = { 99, { 0, 0, 0 }, 0, 0 }, bright = { 0, { 2, 0, 0 }, 0, 0 };
    const rsv_scene_edit plain = rsv_default_scene_edit();
    rsv_scene_edit edit = plain;
    edit.object = &beyond;
    assert_refused(room, edit, RSV_ERROR_SCENE, "no triangles");
    edit.object_count = 1;
    assert_refused(room, edit, RSV_ERROR_ARGUMENT, "object 8 does not exist");
    edit = plain;
    edit.material = &none;
    edit.material_count = 1;
    assert_refused(room, edit, RSV_ERROR_ARGUMENT, "material 99 does not exist");
    edit.material = &bright;
    assert_refused(room, edit, RSV_ERROR_ARGUMENT, "from 0 to 1");
    rsv_scene_destroy(room);
}

/// What an edit leaves unchanged is recognised.
static void updates_reuse_what_stayed(void **state)
{
    rsv_context *context = ((fixture *)*state)->context;
    rsv_scene *room = open_room(context);
    const uint32_t kept[] = { 0, 1, 2, 3, 4, 6, 7 }; // without the short block
    rsv_scene_edit edit = rsv_default_scene_edit();
    edit.object = kept;
    edit.object_count = 7;
    rsv_scene *edited = apply(room, &edit);
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.max_elements = 300;
    rsv_update_store *store = NULL;
    rsv_light *light = NULL, *next = NULL;
    rsv_update_report report;
    assert_int_equal(rsv_update_store_create(context, &store), RSV_OK);
    assert_int_equal(rsv_operator_update(room, &desc, store, &light, NULL), RSV_OK);
    assert_int_equal(rsv_operator_update(edited, &desc, store, &next, &report), RSV_OK);
    assert_true(report.kept_row_rays > 0 && report.kept_row_rays < report.row_rays);
    rsv_light_destroy(next);
    rsv_light_destroy(light);
    rsv_update_store_destroy(store);
    rsv_scene_destroy(edited);
    rsv_scene_destroy(room);
}

#define CASE(name) cmocka_unit_test_setup_teardown(name, fixture_setup, fixture_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        CASE(objects_go_and_come_bit_for_bit),
        CASE(versions_are_mixed),
        CASE(objects_do_not_grow_beyond_all_bounds),
        CASE(bad_edits_are_refused),
        CASE(updates_reuse_what_stayed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
