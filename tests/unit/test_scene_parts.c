/// Parts of a scene sent from one process to another: all arrive, and damaged ones do no harm.
#include "io/scene_parts.h"

#include "core/core.h"

#include "scene_fixture.h"

typedef struct parts {
    rsv_context *context;
    char *bytes;
    size_t count;
    int warnings;
} parts;

static void count_warnings(void *user, rsv_log_level level, const char *message)
{
    parts *p = user;
    p->warnings += level == RSV_LOG_WARNING && strcmp(message, "beware") == 0;
}

static void send_all(FILE *to)
{
    static const rsv_vec3 position[3] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } };
    static const rsv_vec3 normal[3] = { { 0, 0, 1 }, { 0, 0, 1 }, { 0, 0.6f, 0.8f } };
    static const uint32_t index[3] = { 0, 1, 2 };
    static const double moved[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1 };
    rsv_material material = rsv_default_material();
    material.name = "clay";
    material.base_color = (rsv_rgb){ 0.25f, 0.5f, 0.75f };
    material.double_sided = true;
    const rsv_mesh_desc mesh = { .size = sizeof mesh,
        .name = "leaf",
        .positions = position,
        .normals = normal,
        .vertex_count = 3,
        .indices = index,
        .triangle_count = 1,
        .material = 0 };
    const rsv_punctual_light light = { .name = "lamp",
        .kind = RSV_PUNCTUAL_POINT,
        .position = { 1, 2, 3 },
        .direction = { 0, -1, 0 },
        .intensity = { 4, 5, 6 } };
    const rsv_camera camera =
        rsv_camera_look_at("eye", (rsv_vec3){ 0, 0, 5 }, (rsv_vec3){ 0, 0, 0 }, 1, 1.5f);
    rsv_send_log(to, RSV_LOG_WARNING, "beware");
    rsv_send_material(to, &material);
    rsv_send_mesh(to, &mesh);
    rsv_send_instance(to, 0, moved, NULL);
    rsv_send_instance(to, 0, moved, "a leaf's twin");
    rsv_send_light(to, &light);
    rsv_send_camera(to, &camera);
}

static int begin(void **state)
{
    static parts p;
    p = (parts){ 0 };
    rsv_context_desc desc = rsv_default_context_desc();
    desc.log = count_warnings;
    desc.user = &p;
    assert_int_equal(rsv_context_create(&desc, &p.context), RSV_OK);
    FILE *to = open_memstream(&p.bytes, &p.count);
    assert_non_null(to);
    send_all(to);
    assert_int_equal(fclose(to), 0);
    *state = &p;
    return 0;
}

static int end(void **state)
{
    parts *p = *state;
    rsv_context_destroy(p->context);
    free(p->bytes);
    return 0;
}

static rsv_status receive(parts *p, size_t count, rsv_scene **scene)
{
    assert_int_equal(rsv_scene_create(p->context, scene), RSV_OK);
    return rsv_receive_parts((const uint8_t *)p->bytes, count, NULL, "parts.obj", *scene);
}

static void all_parts_arrive(void **state)
{
    parts *p = *state;
    rsv_scene *scene;
    assert_int_equal(receive(p, p->count, &scene), RSV_OK);
    assert_int_equal(p->warnings, 1);
    assert_int_equal(rsv_scene_commit(scene), RSV_OK);
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    assert_int_equal(view->triangle_count, 2);
    assert_float_equal(view->position[view->triangle[0][1]].x, 6, 0);
    assert_float_equal(view->normal[view->triangle[0][2]].y, 0.6, 1e-6);
    assert_string_equal(view->object_name[0], "leaf");
    assert_string_equal(view->object_name[1], "a leaf's twin");
    assert_string_equal(view->material[0].name, "clay");
    assert_float_equal(view->material[0].base_color.g, 0.5, 0);
    assert_true(view->material[0].double_sided && !view->material[0].unlit);
    assert_string_equal(view->light[0].name, "lamp");
    assert_float_equal(view->light[0].intensity.b, 6, 0);
    assert_string_equal(view->camera[0].name, "eye");
    assert_float_equal(view->camera[0].aspect, 1.5, 0);
    rsv_scene_destroy(scene);
}

/// Only ends of records will do.
static void cut_answers_are_refused(void **state)
{
    parts *p = *state;
    int whole = 0;
    for (size_t count = 0; count < p->count; count++) {
        rsv_scene *scene;
        rsv_status status = receive(p, count, &scene);
        if (status == RSV_OK)
            whole++;
        else
            assert_int_equal(status, RSV_ERROR_FORMAT);
        rsv_scene_destroy(scene);
    }
    assert_int_equal(whole, 7);
}

static void damaged_answers_do_no_harm(void **state)
{
    parts *p = *state;
    uint32_t random = 1;
    for (int round = 0; round < 20000; round++) {
        random = random * 1664525 + 1013904223;
        size_t at = (random >> 8) % p->count;
        char kept = p->bytes[at];
        p->bytes[at] ^= (char)(1 << random % 7);
        rsv_scene *scene;
        if (receive(p, p->count, &scene) == RSV_OK) rsv_scene_commit(scene);
        rsv_scene_destroy(scene);
        p->bytes[at] = kept;
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(all_parts_arrive, begin, end),
        cmocka_unit_test_setup_teardown(cut_answers_are_refused, begin, end),
        cmocka_unit_test_setup_teardown(damaged_answers_do_no_harm, begin, end),
    };
    return cmocka_run_group_tests_name("scene parts", tests, NULL, NULL);
}
