/// Scenes far from the origin: the common offset is subtracted when reading, and added when writing.
#include "gltf_fixture.h"

/// A room of 4 x 3 x 5 m with a lamp and a camera, all below one node; % is where that node is.
static const char room[] =
    "\"meshes\":[{\"name\":\"walls\",\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
    "\"cameras\":[{\"name\":\"eye\",\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"znear\":"
    "1}}],"
    "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"name\":\"bulb\",\"type\":\"point\"}]}}"
    ","
    "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"children\":[1,2,3],%s},"
    "{\"name\":\"walls\",\"mesh\":0,\"rotation\":[0,0.6,0,0.8]},"
    "{\"camera\":0,\"translation\":[0.25,1.5,2]},{\"translation\":[0,2.5,0],\"extensions\":{"
    "\"KHR_lights_punctual\":{\"light\":0}}}]";

static sketch room_sketch(void)
{
    const float lo[3] = { -2, 0, -2.5f }, hi[3] = { 2, 3, 2.5f };
    static const uint8_t face[6][6] = { { 0, 1, 5, 0, 5, 4 }, { 2, 6, 7, 2, 7, 3 },
        { 0, 4, 6, 0, 6, 2 }, { 1, 3, 7, 1, 7, 5 }, { 0, 2, 3, 0, 3, 1 }, { 4, 5, 7, 4, 7, 6 } };
    float corner[108];
    for (int k = 0; k < 36; k++)
        for (int axis = 0; axis < 3; axis++)
            corner[3 * k + axis] = face[k / 6][k % 6] >> axis & 1 ? hi[axis] : lo[axis];
    sketch s = { .count = 0 };
    add_vectors(&s, corner, 36, 3);
    return s;
}

static rsv_scene *room_at(fixture *f, const folder *place, const char *where)
{
    char text[4096];
    const sketch s = room_sketch();
    snprintf(text, sizeof text, room, where);
    return load(f, write_sketch(place, &s, text));
}

static void assert_origin(const rsv_scene *scene, double x, double y, double z)
{
    const double *origin = rsv_scene_get_view(scene)->origin;
    assert_true(origin[0] == x && origin[1] == y && origin[2] == z);
}

static void assert_same_places(const rsv_scene *a, const rsv_scene *b, float tolerance)
{
    const rsv_scene_view *p = rsv_scene_get_view(a), *q = rsv_scene_get_view(b);
    assert_int_equal(p->vertex_count, q->vertex_count);
    for (size_t k = 0; k < p->vertex_count; k++) {
        assert_true(v3_max_abs(v3_sub(p->position[k], q->position[k])) <= tolerance);
        assert_true(v3_max_abs(v3_sub(p->normal[k], q->normal[k])) <= 1e-6f);
    }
    assert_true(v3_max_abs(v3_sub(p->camera[0].position, q->camera[0].position)) <= tolerance);
    assert_true(v3_max_abs(v3_sub(p->light[0].position, q->light[0].position)) <= tolerance);
}

static void far_rooms_are_as_near_ones(void **state)
{
    static const struct {
        const char *where;
        double origin[3];
    } cases[] = {
        { "\"translation\":[22000,0,0]", { 22000, 0, 0 } },
        { "\"translation\":[-22000,0,7000]", { -22000, 0, 7000 } },
        { "\"translation\":[500000,0,5700000]", { 500000, 0, 5700000 } },
        { "\"translation\":[0,0,-4e10]", { 0, 0, -4e10 } },
        { "\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,5700000,0,-400,1]", { 5700000, 0, -400 } },
    };
    folder place = new_folder();
    rsv_scene *near = room_at(*state, &place, "\"translation\":[0,0,0]");
    assert_origin(near, 0, 0, 0);
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        rsv_scene *far = room_at(*state, &place, cases[k].where);
        const double *o = cases[k].origin;
        assert_origin(far, o[0], o[1], o[2]);
        assert_same_places(near, far, 1e-6f);
        rsv_scene_destroy(far);
    }
    rsv_scene_destroy(near);
    remove_folder(place.path);
}

/// Scaled, and by a number of metres that is not round: coordinates differ by a shift, which the origin tells.
static void what_is_taken_out_is_told(void **state)
{
    folder place = new_folder();
    rsv_scene *scene =
        room_at(*state, &place, "\"translation\":[448262.37,51.5,5411932.8],\"scale\":[2,2,2]");
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    assert_origin(scene, 448300, 100, 5411900);
    assert_true(fabs(view->origin[0] + (double)view->light[0].position.x - 448262.37) < 1e-5);
    assert_true(fabs(view->origin[1] + (double)view->light[0].position.y - 56.5) < 1e-5);
    assert_true(fabs(view->origin[2] + (double)view->camera[0].position.z - 5411936.8) < 1e-5);
    assert_mentions(((fixture *)*state)->log, "(448300, 100, 5411900) m is subtracted");
    rsv_scene_destroy(scene);
    remove_folder(place.path);
}

/// A room far away is recognised as such even if the file also has a cube at the origin.
static void what_is_left_at_the_origin_does_no_harm(void **state)
{
    fixture *f = *state;
    folder place = new_folder();
    char text[4096];
    sketch s = room_sketch();
    rsv_scene *near = room_at(f, &place, "\"translation\":[0,0,0]");
    snprintf(text, sizeof text, room, "\"translation\":[448262,51,5411932]");
    char *nodes = strstr(text, "{\"nodes\":[0]}");
    char more[4096];
    snprintf(more, sizeof more,
        "%.*s{\"nodes\":[0,4]}%.*s,{\"name\":\"cube\",\"mesh\":0,\"scale\":[-0.5,0.5,0.5]}]",
        (int)(nodes - text), text, (int)(strlen(nodes) - strlen("{\"nodes\":[0]}") - 1),
        nodes + strlen("{\"nodes\":[0]}"));
    rsv_scene *scene = load(f, write_sketch(&place, &s, more));
    assert_origin(scene, 448260, 50, 5411930);
    assert_mentions(f->log, "object 'cube' lies 5.41e+06 m away from the rest of the scene");
    const rsv_scene_view *p = rsv_scene_get_view(near), *q = rsv_scene_get_view(scene);
    for (size_t k = 0; k < p->vertex_count; k++)
        assert_true(
            v3_max_abs(v3_sub(v3_sub(q->position[k], p->position[k]), v3(2, 1, 2))) <= 2e-6f);
    rsv_scene_destroy(scene);
    rsv_scene_destroy(near);
    remove_folder(place.path);
}

/// Large scenes, and scenes a few times their size away from the origin, stay as they are. So does a scene close to the
/// origin with one object far away: no common offset can be subtracted, and the shape of that object becomes inexact.
static void single_objects_far_away_are_told(void **state)
{
    static const struct {
        const char *where;
        bool coarse;
    } place[] = { { "4000000.3,0,0", true }, { "0,0,-700000", true }, { "9000,0,0", false },
        { "3,0,0", false } };
    fixture *f = *state;
    folder files = new_folder();
    for (size_t k = 0; k < sizeof place / sizeof *place; k++) {
        char text[1024];
        const sketch s = room_sketch();
        snprintf(text, sizeof text,
            "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"scenes\":[{"
            "\"nodes\":[0,1,2,3]}],\"nodes\":[{\"mesh\":0},{\"mesh\":0,\"translation\":[9,0,0]},"
            "{\"mesh\":0,\"translation\":[0,0,9]},{\"name\":\"stray\",\"mesh\":0,"
            "\"translation\":[%s]}]",
            place[k].where);
        f->log[0] = 0;
        rsv_scene_destroy(load(f, write_sketch(&files, &s, text)));
        assert_int_equal(count_mentions(f->log, "(first: 'stray'"), place[k].coarse);
        assert_int_equal(count_mentions(f->log, "single precision"), place[k].coarse);
    }
    remove_folder(files.path);
}

static void near_scenes_are_left_alone(void **state)
{
    static const char *const where[] = { "\"translation\":[300,0,0]",
        "\"translation\":[9000,0,0],\"scale\":[100,100,100]", "\"scale\":[1e6,1e6,1e6]" };
    folder place = new_folder();
    for (size_t k = 0; k < sizeof where / sizeof *where; k++) {
        rsv_scene *scene = room_at(*state, &place, where[k]);
        assert_origin(scene, 0, 0, 0);
        rsv_scene_destroy(scene);
    }
    remove_folder(place.path);
}

static void what_is_written_is_where_it_was(void **state)
{
    folder place = new_folder();
    rsv_scene *scene = room_at(*state, &place, "\"translation\":[22000,40,5700000.25]");
    const char *path = path_in(&place, "again.glb");
    assert_int_equal(rsv_scene_save(scene, path), RSV_OK);
    rsv_scene *again = load(*state, path);
    const double *o = rsv_scene_get_view(scene)->origin;
    assert_origin(again, o[0], o[1], o[2]);
    assert_same_places(scene, again, 0);
    rsv_scene_destroy(again);
    rsv_scene_destroy(scene);
    remove_folder(place.path);
}

/// Skins and instances are far away, too.
static void skins_and_instances_keep_their_digits(void **state)
{
    folder place = new_folder();
    sketch s = square_sketch();
    const uint8_t joints[16] = { 0 };
    const float weights[16] = { 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0 };
    const float shift[6] = { 0, 0, 0, 0.125f, 0, 0 };
    add_accessor(&s, joints, sizeof joints, 5121, 4, "VEC4", "");
    add_vectors(&s, weights, 4, 4);
    add_vectors(&s, shift, 2, 3);
    rsv_scene *scene = load(*state,
        write_sketch(&place, &s,
            "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"JOINTS_0\":2,"
            "\"WEIGHTS_0\":3},\"indices\":1}]}],\"skins\":[{\"joints\":[1]}],\"scenes\":[{"
            "\"nodes\":"
            "[2]}],\"nodes\":[{\"mesh\":0,\"skin\":0},{\"translation\":[0,0,0.0625]},"
            "{\"translation\":[5700000,0,0],\"children\":[0,1,3]},{\"mesh\":0,\"extensions\":{"
            "\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":4}}}}]"));
    assert_origin(scene, 5700000, 0, 0);
    assert_bounds(scene, v3(0, 0, 0), v3(1.125f, 1, 0.0625f));
    rsv_scene_destroy(scene);
    remove_folder(place.path);
}

/// Text and doubles have all digits of a place. Loads a triangle 5,700 km away, of 0.25 m, with millimetres.
static void check_far_file(fixture *f, const char *name, const void *bytes, size_t count)
{
    folder place = new_folder();
    rsv_scene *scene = load_written(f, path_in(&place, name), bytes, count);
    if (!scene) fail_msg("%s: %s", name, rsv_last_error());
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    const double corner[3] = { 500000.123, 100.25, 5700000.373 };
    for (int axis = 0; axis < 3; axis++) {
        double high = view->origin[axis] + (double)(&view->bounds_max.x)[axis];
        if (fabs(high - corner[axis]) > 1e-7) fail_msg("%s: axis %d at %.9f", name, axis, high);
    }
    if (strstr(f->log, "single precision")) fail_msg("%s: %s", name, f->log);
    rsv_scene_destroy(scene);
    remove_folder(place.path);
}

static void other_formats_keep_their_digits(void **state)
{
    static const char head[] = "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty "
                               "double x\nproperty double y\nproperty double z\nelement face 1\n"
                               "property list uchar uchar vertex_indices\nend_header\n";
    static const char ply[] =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
        "float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "499999.873 100 5700000.123\n500000.123 100 5700000.373\n499999.873 100.25 "
        "5700000.123\n3 0 1 2\n";
    static const char stl[] =
        "solid a\nfacet normal 0 0 0\nouter loop\nvertex 499999.873 100 5700000.123\nvertex "
        "500000.123 100 5700000.373\nvertex 499999.873 100.25 5700000.123\nendloop\nendfacet\n"
        "endsolid\n";
    static const char obj[] = "# a map\nv 499999.873 100 5700000.123\nv  500000.123\t100 "
                              "5700000.373 1 0 0\nv 499999.873 100.25 5700000.123\nf 1 2 3\n";
    const double place[9] = { 499999.873, 100, 5700000.123, 500000.123, 100, 5700000.373,
        499999.873, 100.25, 5700000.123 };
    char binary[sizeof head + sizeof place + 4];
    memcpy(binary, head, sizeof head - 1);
    memcpy(binary + sizeof head - 1, place, sizeof place);
    memcpy(binary + sizeof head - 1 + sizeof place, "\3\0\1\2", 4);
    check_far_file(*state, "a.ply", ply, sizeof ply - 1);
    check_far_file(*state, "b.ply", binary, sizeof binary - 1);
    check_far_file(*state, "a.stl", stl, sizeof stl - 1);
    check_far_file(*state, "a.obj", obj, sizeof obj - 1);
}

/// Vertices of glTF are floats: a warning says that they are too coarse.
static void coarse_vertices_are_told(void **state)
{
    const float corner[9] = { 5700000, 0, 0, 5700001, 0, 0, 5700000, 1, 0 };
    folder place = new_folder();
    sketch s = { .count = 0 };
    add_vectors(&s, corner, 3, 3);
    rsv_scene *scene = load(*state,
        write_sketch(&place, &s,
            "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"scenes\":[{"
            "\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}]"));
    assert_mentions(((fixture *)*state)->log, "in single precision, which resolves");
    rsv_scene_destroy(scene);
    remove_folder(place.path);
}

#define ORIGIN_TEST(function)                                                                      \
    cmocka_unit_test_setup_teardown(function, fixture_setup, fixture_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        ORIGIN_TEST(far_rooms_are_as_near_ones),
        ORIGIN_TEST(what_is_taken_out_is_told),
        ORIGIN_TEST(what_is_left_at_the_origin_does_no_harm),
        ORIGIN_TEST(single_objects_far_away_are_told),
        ORIGIN_TEST(near_scenes_are_left_alone),
        ORIGIN_TEST(what_is_written_is_where_it_was),
        ORIGIN_TEST(skins_and_instances_keep_their_digits),
        ORIGIN_TEST(other_formats_keep_their_digits),
        ORIGIN_TEST(coarse_vertices_are_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
