/// Lamps inside an opaque surface are reported; others are not.
#include "builtin/builtin.h"
#include "resolvent/scene.h"
#include "scene_fixture.h"

static rsv_material paint(const char *name, bool double_sided)
{
    rsv_material m = rsv_default_material();
    m.name = name;
    m.base_color = rgb_gray(0.7f);
    m.metallic = 0;
    m.double_sided = double_sided;
    return m;
}

static uint32_t add_material(rsv_scene *scene, rsv_material m)
{
    uint32_t id;
    assert_int_equal(rsv_scene_add_material(scene, &m, &id), RSV_OK);
    return id;
}

/// A room of 4 x 3 x 5 m, single-sided.
static rsv_scene *begin_room(fixture *f, bool camera)
{
    rsv_scene *scene;
    f->log[0] = 0;
    assert_int_equal(rsv_scene_create(f->context, &scene), RSV_OK);
    rsv_shape room = { scene, "room", add_material(scene, paint("plaster", false)), NULL };
    assert_int_equal(rsv_add_room(room, v3(0, 0, 0), v3(4, 3, 5)), RSV_OK);
    rsv_camera eye = rsv_camera_look_at("eye", v3(2, 1.5f, 4.5f), v3(2, 1, 0), 1, 1);
    if (camera) assert_int_equal(rsv_scene_add_camera(scene, &eye), RSV_OK);
    return scene;
}

static void add_point(
    rsv_scene *scene, const char *name, rsv_vec3 place, rsv_punctual_light_kind kind)
{
    rsv_punctual_light light = { .name = name,
        .kind = kind,
        .position = place,
        .direction = { 0, -1, 0 },
        .intensity = rgb_gray(10),
        .inner_cone_angle = 0.3f,
        .outer_cone_angle = 0.6f };
    assert_int_equal(rsv_scene_add_light(scene, &light), RSV_OK);
}

/// A box, whose faces may look inwards, and which may lack its bottom.
static void add_shade(rsv_scene *scene, const char *name, uint32_t material, rsv_vec3 low,
    rsv_vec3 high, bool inwards, bool open)
{
    static const uint32_t quad[6][4] = { { 0, 1, 5, 4 }, { 2, 6, 7, 3 }, { 0, 2, 3, 1 },
        { 4, 5, 7, 6 }, { 0, 4, 6, 2 }, { 1, 3, 7, 5 } };
    rsv_vec3 corner[8];
    uint32_t index[36], next = 0, mesh;
    for (int k = 0; k < 8; k++)
        corner[k] = v3(k & 1 ? high.x : low.x, k & 2 ? high.y : low.y, k & 4 ? high.z : low.z);
    for (int q = open ? 1 : 0; q < 6; q++)
        for (uint32_t k = 0; k < 6; k++) {
            static const uint32_t fan[6] = { 0, 1, 2, 0, 2, 3 };
            index[next++] = quad[q][fan[inwards ? 5 - k : k]];
        }
    rsv_mesh_desc desc = { .size = sizeof desc,
        .name = name,
        .positions = corner,
        .vertex_count = 8,
        .indices = index,
        .triangle_count = next / 3,
        .material = material };
    assert_int_equal(rsv_scene_add_mesh(scene, &desc, &mesh), RSV_OK);
    assert_int_equal(rsv_scene_add_instance(scene, mesh, NULL, NULL), RSV_OK);
}

static void add_sphere(rsv_scene *scene, const char *name, uint32_t material, float radius)
{
    rsv_shape shape = { scene, name, material, NULL };
    assert_int_equal(rsv_add_sphere(shape, v3(2, 2, 2), radius, 2), RSV_OK);
}

/// Commits. @return how many lamps were said to be enclosed
static size_t count_enclosed(fixture *f, rsv_scene *scene)
{
    assert_int_equal(rsv_scene_commit(scene), RSV_OK);
    rsv_scene_destroy(scene);
    return count_mentions(f->log, "encloses it");
}

static void an_opaque_bulb_is_named(void **state)
{
    fixture *f = *state;
    for (int kind = 0; kind < 4; kind++) {
        rsv_scene *scene = begin_room(f, kind % 2);
        uint32_t glass = add_material(scene, paint("milk glass", kind == 1));
        add_point(scene, "filament", v3(2.01f, 2, 2), RSV_PUNCTUAL_POINT);
        if (kind < 2) add_sphere(scene, "bulb", glass, 0.1f);
        // with walls of some thickness, and written twice
        rsv_vec3 low = v3(1.9f, 1.9f, 1.9f), high = v3(2.1f, 2.1f, 2.1f);
        if (kind >= 2) add_shade(scene, "bulb", glass, low, high, true, false);
        if (kind == 2) low = v3(1.88f, 1.88f, 1.88f), high = v3(2.12f, 2.12f, 2.12f);
        if (kind >= 2) add_shade(scene, "bulb", glass, low, high, false, false);
        assert_int_equal(count_enclosed(f, scene), 1);
        assert_mentions(f->log, "'filament'");
        assert_mentions(f->log, "'bulb'");
    }
}

/// Of any size and at any place, whose faces look inwards: rays that are reflected next to an edge do not leave through it.
static void a_bulb_that_faces_inwards_is_named(void **state)
{
    fixture *f = *state;
    for (int kind = 0; kind < 24; kind++) {
        rsv_scene *scene = begin_room(f, true);
        uint32_t glass = add_material(scene, paint("milk glass", kind % 2));
        float size = 0.05f + 0.015f * (float)kind, x = 1.1f + 0.07f * (float)kind;
        add_point(scene, "filament", v3(x, 1.7f, 2), RSV_PUNCTUAL_POINT);
        add_shade(scene, "bulb", glass, v3(x - size, 1.7f - size, 2 - size),
            v3(x + size, 1.7f + size, 2 + size), true, false);
        if (count_enclosed(f, scene) != 1) fail_msg("a box of %g m is no bulb", 2 * (double)size);
        assert_mentions(f->log, "'filament'");
        assert_mentions(f->log, "'bulb'");
    }
}

/// A large one counts if nothing else shines.
static void a_large_bulb_is_named_where_all_is_dark(void **state)
{
    fixture *f = *state;
    for (int other = 0; other < 2; other++) {
        rsv_scene *scene = begin_room(f, true);
        uint32_t glass = add_material(scene, paint("milk glass", false));
        add_point(scene, "filament", v3(2, 1.5f, 1.5f), RSV_PUNCTUAL_POINT);
        if (other) add_point(scene, "free", v3(2, 2.8f, 4), RSV_PUNCTUAL_POINT);
        add_shade(scene, "bulb", glass, v3(1.3f, 1, 0.8f), v3(2.7f, 1.8f, 2.2f), true, false);
        assert_int_equal(count_enclosed(f, scene), !other);
        if (!other) assert_mentions(f->log, "'filament'");
    }
}

static void each_of_several_lamps_is_named(void **state)
{
    fixture *f = *state;
    rsv_scene *scene = begin_room(f, true);
    uint32_t tin = add_material(scene, paint("tin", false));
    rsv_material glow = paint("glow", false);
    glow.emission = rgb_gray(10);
    add_point(scene, "first", v3(1, 2, 1), RSV_PUNCTUAL_SPOT);
    add_point(scene, "free", v3(2, 2, 1), RSV_PUNCTUAL_SPOT);
    add_shade(scene, "can", tin, v3(0.9f, 1.8f, 0.9f), v3(1.1f, 2.1f, 1.1f), false, false);
    add_shade(scene, "tube", add_material(scene, glow), v3(2.9f, 1, 2), v3(3.1f, 1.1f, 2.1f), false,
        false);
    add_shade(scene, "case", tin, v3(2.8f, 0.9f, 1.9f), v3(3.2f, 1.2f, 2.2f), false, false);
    assert_int_equal(count_enclosed(f, scene), 2);
    assert_mentions(f->log, "light 'first': the opaque object 'can'");
    assert_mentions(f->log, "lamp 'tube': the opaque object 'case'");
}

static void lamps_that_shed_light_are_not(void **state)
{
    fixture *f = *state;
    for (int kind = 0; kind < 7; kind++) {
        rsv_scene *scene = begin_room(f, kind != 4);
        bool open = kind == 1 || kind == 5;
        rsv_material m = paint("shade", kind == 1);
        if (kind == 0) m.transmission = 1;
        if (kind == 2) m.opacity = 0.5f;
        if (kind == 3) m.diffuse_transmission = 0.5f;
        add_point(scene, "lamp", v3(2, 2, 2), kind == 6 ? RSV_PUNCTUAL_SPOT : RSV_PUNCTUAL_POINT);
        // 4: a room that no camera is in; 6: a spot that shines out of its housing
        if (kind != 4)
            add_shade(scene, "shade", add_material(scene, m),
                v3(1.8f, kind == 6 ? 1.99f : 1.8f, 1.8f), v3(2.2f, 2.2f, 2.2f), false,
                open || kind == 6);
        size_t count = count_enclosed(f, scene);
        if (count) fail_msg("%d: %s", kind, f->log);
    }
}

static void rooms_are_no_bulbs(void **state)
{
    fixture *f = *state;
    static const char *const name[] = { "cornell-blocks", "cornell-glass", "furnace", "two-rooms",
        "gallery:2" };
    for (size_t k = 0; k < sizeof name / sizeof name[0]; k++) {
        rsv_scene *scene;
        f->log[0] = 0;
        assert_int_equal(rsv_scene_builtin(f->context, name[k], &scene), RSV_OK);
        rsv_scene_destroy(scene);
        if (strstr(f->log, "enclosed")) fail_msg("%s: %s", name[k], f->log);
    }
    // a doll house without a floor, lit from within
    rsv_scene *scene = begin_room(f, true);
    uint32_t wood = add_material(scene, paint("wood", true));
    add_point(scene, "candle", v3(2, 1.1f, 2), RSV_PUNCTUAL_POINT);
    add_shade(scene, "house", wood, v3(1.6f, 0.8f, 1.6f), v3(2.4f, 1.4f, 2.4f), false, true);
    assert_int_equal(count_enclosed(f, scene), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(an_opaque_bulb_is_named, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            a_bulb_that_faces_inwards_is_named, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            a_large_bulb_is_named_where_all_is_dark, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            each_of_several_lamps_is_named, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            lamps_that_shed_light_are_not, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(rooms_are_no_bulbs, fixture_setup, fixture_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
