/// Likely mistakes in scenes: each is found where it was made, and nowhere else.
#include "scene_fixture.h"

#include "resolvent/check.h"

/// A room of six walls, 4 m wide, seen from within, and what was done to it.
typedef struct changes {
    int flipped; ///< this wall's triangles turn the other way; -1 = none
    int doubled; ///< this wall is there twice; -1 = none
    float rug;   ///< how wide the second time is, 1 = as the first
    float gap;   ///< metres that the last wall stands off the others
    float scale;
    bool dark;
} changes;

static const changes none = { -1, -1, 1, 0, 1, false };

/// Corners of a wall seen counter-clockwise from within.
static void wall(int side, float gap, float scale, rsv_vec3 corner[4])
{
    static const float at[6][4][3] = { { { -1, -1, -1 }, { 1, -1, -1 }, { 1, 1, -1 },
                                           { -1, 1, -1 } },
        { { 1, -1, 1 }, { -1, -1, 1 }, { -1, 1, 1 }, { 1, 1, 1 } },
        { { -1, -1, 1 }, { -1, -1, -1 }, { -1, 1, -1 }, { -1, 1, 1 } },
        { { 1, -1, -1 }, { 1, -1, 1 }, { 1, 1, 1 }, { 1, 1, -1 } },
        { { -1, -1, 1 }, { 1, -1, 1 }, { 1, -1, -1 }, { -1, -1, -1 } },
        { { -1, 1, -1 }, { 1, 1, -1 }, { 1, 1, 1 }, { -1, 1, 1 } } };
    for (int k = 0; k < 4; k++) {
        float lift = side == 5 ? gap : 0;
        corner[k] = v3(2 * scale * at[side][k][0], 2 * scale * at[side][k][1] + lift,
            2 * scale * at[side][k][2]);
    }
}

/// Towards the middle of a quadrilateral.
static void shrink(float factor, rsv_vec3 corner[4])
{
    rsv_vec3 middle = v3_scale(v3_add(corner[0], corner[2]), 0.5f);
    for (int k = 0; k < 4 && factor < 1; k++)
        corner[k] = v3_mad(middle, factor, v3_sub(corner[k], middle));
}

static rsv_scene *build_room(fixture *f, changes c)
{
    static const uint32_t usual[6] = { 0, 1, 2, 0, 2, 3 }, turned[6] = { 0, 2, 1, 0, 3, 2 };
    static const float at[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    rsv_scene *scene;
    rsv_vec3 position[28];
    uint32_t index[42], id, walls = 0;
    for (int side = 0; side < 6; side++)
        for (int copy = 0; copy < (side == c.doubled ? 2 : 1); copy++, walls++) {
            wall(side, c.gap, c.scale, position + 4 * walls);
            if (copy) shrink(c.rug, position + 4 * walls);
            for (int k = 0; k < 6; k++)
                index[6 * walls + (uint32_t)k] =
                    4 * walls + (side == c.flipped ? turned[k] : usual[k]);
        }
    const rsv_mesh_desc mesh = { .size = sizeof mesh,
        .positions = position,
        .vertex_count = 4 * walls,
        .indices = index,
        .triangle_count = 2 * walls };
    const rsv_material material = rsv_default_material();
    const rsv_camera camera =
        rsv_camera_look_at("eye", v3(0, 0, 0), v3(0.01f, 0.005f, -c.scale), 0.8f, 1);
    const rsv_punctual_light light = {
        .name = "lamp", .kind = RSV_PUNCTUAL_POINT, .intensity = { 1, 1, 1 }
    };
    assert_int_equal(rsv_scene_create(f->context, &scene), RSV_OK);
    assert_int_equal(rsv_scene_add_material(scene, &material, NULL), RSV_OK);
    assert_int_equal(rsv_scene_add_mesh(scene, &mesh, &id), RSV_OK);
    assert_int_equal(rsv_scene_add_instance(scene, id, at, "room"), RSV_OK);
    assert_int_equal(rsv_scene_add_camera(scene, &camera), RSV_OK);
    if (!c.dark) assert_int_equal(rsv_scene_add_light(scene, &light), RSV_OK);
    assert_int_equal(rsv_scene_commit(scene), RSV_OK);
    return scene;
}

/// Checks the mistakes found in a room: the test fails on any that `expected` does not list.
/// @param expected names, separated by commas
static void assert_found(fixture *f, changes c, const char *expected, size_t counted)
{
    rsv_scene *scene = build_room(f, c);
    rsv_finding *finding;
    size_t count;
    char names[256] = "";
    assert_int_equal(rsv_scene_check(scene, &finding, &count), RSV_OK);
    for (size_t k = 0; k < count; k++) {
        size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%s", k ? "," : "",
            rsv_mistake_name(finding[k].mistake));
        assert_null(strchr(finding[k].text, '\n'));
        if (counted && finding[k].count) assert_int_equal(finding[k].count, counted);
    }
    assert_string_equal(names, expected);
    rsv_findings_release(scene, finding);
    rsv_scene_destroy(scene);
}

static void a_sound_room_has_no_mistakes(void **state) { assert_found(*state, none, "", 0); }

static void a_wall_that_turns_the_other_way_is_found(void **state)
{
    changes c = none;
    c.flipped = 4; // the floor, which the camera does not see
    assert_found(*state, c, "flipped_faces", 4);
    c.flipped = 0; // what it looks at
    assert_found(*state, c, "backs,flipped_faces", 4);
}

static void a_wall_that_is_there_twice_is_found(void **state)
{
    changes c = none;
    c.doubled = 2;
    assert_found(*state, c, "doubled_faces", 2);
    c.rug = 0.5f; // in the plane of another face, without being its copy
    assert_found(*state, c, "", 0);
}

static void open_seams_and_gaps_are_found(void **state)
{
    changes c = none;
    c.gap = 2e-4f; // too narrow for a ray to find
    assert_found(*state, c, "open_seams", 4);
    c.gap = 0.05f; // too wide to be meant as one edge
    assert_found(*state, c, "leaks", 0);
}

static void odd_scales_are_found(void **state)
{
    changes c = none;
    c.scale = 1e-3f;
    assert_found(*state, c, "scale", 0);
    c.scale = 1e4f;
    assert_found(*state, c, "scale", 0);
}

static void darkness_is_found(void **state)
{
    changes c = none;
    c.dark = true;
    assert_found(*state, c, "no_light", 0);
}

/// However few allocations succeed, it ends in an error or a list.
static void running_out_of_memory_is_an_error(void **state)
{
    fixture *f = *state;
    changes c = none;
    c.flipped = 0;
    c.doubled = 2;
    rsv_scene *scene = build_room(f, c);
    rsv_status status = RSV_ERROR_MEMORY;
    for (size_t left = 0; status != RSV_OK && left < 1000; left++) {
        rsv_finding *finding;
        size_t count;
        f->allocations_left = left;
        status = rsv_scene_check(scene, &finding, &count);
        f->allocations_left = SIZE_MAX;
        if (status == RSV_OK)
            rsv_findings_release(scene, finding);
        else
            assert_null(finding);
    }
    assert_int_equal(status, RSV_OK);
    rsv_scene_destroy(scene);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, fixture_setup, fixture_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(a_sound_room_has_no_mistakes),
        TEST(a_wall_that_turns_the_other_way_is_found),
        TEST(a_wall_that_is_there_twice_is_found),
        TEST(open_seams_and_gaps_are_found),
        TEST(odd_scales_are_found),
        TEST(darkness_is_found),
        TEST(running_out_of_memory_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
