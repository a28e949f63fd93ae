/// PLY files as programs write them, text and binary: read as intended, or rejected with one line of error.
#include "resolvent/io.h"
#include "unit/file_fixture.h"

static folder files;

static int enter(void **state)
{
    files = new_folder();
    return fixture_setup(state);
}

static int leave(void **state)
{
    remove_folder(files.path);
    return fixture_teardown(state);
}

static rsv_scene *load(fixture *f, const void *bytes, size_t count)
{
    return load_written(f, path_in(&files, "a.ply"), bytes, count);
}

/// Checks the scene from a file whose points reach (2, 3).
static void check(
    fixture *f, const void *bytes, size_t count, size_t triangles, const char *warning)
{
    rsv_scene *scene = load(f, bytes, count);
    if (!scene) fail_msg("%s", rsv_last_error());
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    assert_int_equal(view->triangle_count, triangles);
    assert_float_equal(view->bounds_max.x, 2, 0);
    assert_float_equal(view->bounds_max.y, 3, 0);
    if (warning)
        assert_mentions(f->log, warning);
    else if (strstr(f->log, "a.ply"))
        fail_msg("a warning: %s", f->log);
    rsv_scene_destroy(scene);
}

#define VERTEX "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
#define FACE "element face 1\nproperty list uchar int vertex_indices\n"
#define START "ply\nformat ascii 1.0\n"
#define POINTS "0 0 0\n2 0 0\n0 3 0\n"

static void texts_of_all_kinds_are_read(void **state)
{
    static const struct {
        const char *text;
        size_t triangles;
        const char *warning;
    } sound[] = {
        { START VERTEX FACE "end_header\n" POINTS "3 0 1 2\n", 1, NULL },
        { START VERTEX FACE "end_header\n" POINTS "3 0 1 2", 1, NULL },
        { "\xef\xbb\xbf" START VERTEX FACE "end_header\n" POINTS "3 0 1 2\n", 1, NULL },
        { START VERTEX FACE "end_header\n" POINTS "\n\n3 0 1 2\n", 1, NULL },
        { START VERTEX FACE "end_header\n0 0 0 2 0 0 0 3 0 3 0 1 2", 1, NULL },
        { START FACE VERTEX "end_header\n3 0 1 2\n" POINTS, 1, NULL },
        { "PLY\r\nformat ascii 1.0\r\ncomment a\r\nobj_info b\r\nelement vertex 3\r\nproperty "
          "double "
          "x\r\nproperty double y\r\nproperty double z\r\nelement face 1\r\nproperty list uint8 "
          "int32 "
          "vertex_index\r\nend_header\r\n0 0 0\r\n2 0 0\r\n0 3 0\r\n3 0 1 2\r\n",
            1, NULL },
        { "ply\rformat\tascii 1.0\relement  vertex  3 \rproperty float x\rproperty float "
          "y\rproperty "
          "float z\r" FACE "end_header\r0 0 0\r2 0 0\r0 3 0\r3 0 1 2\r",
            1, NULL },
        { START "element vertex 3\nproperty int z\nproperty int y\nproperty int x\n" FACE
                "end_header\n0 0 0\n0 0 2\n0 3 0\n3 0 1 2\n",
            1, NULL },
        { START VERTEX "element edge 1\nproperty int a\nproperty list int int b\n" FACE
                       "property uchar red\nend_header\n" POINTS "7 2 1 1\n3 0 1 2 9\n",
            1, "not used: edge, red" },
        { START
            "comment by hand\ncomment TextureFile wood.png\nobj_info a\nobj_info b\n" VERTEX FACE
            "end_header\n" POINTS "3 0 1 2\n",
            1, "not used: TextureFile wood.png" },
        { START VERTEX "element face 3\nproperty uchar k\nproperty list uchar int vertex_indices\n"
                       "end_header\n" POINTS "1 0\n1 2 0 1\n1 3 0 1 2\n",
            1, "2 faces of fewer than three corners" },
        { START VERTEX FACE "end_header\n" POINTS "3 0 1 2\nand more\n", 1, "9 bytes" },
        { START "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                "element tristrips 1\nproperty list int int vertex_indices\nend_header\n" POINTS
                "2 3 0\n8 0 1 2 3 -1 0 1 2\n",
            3, NULL },
    };
    for (size_t k = 0; k < sizeof sound / sizeof *sound; k++)
        check(*state, sound[k].text, strlen(sound[k].text), sound[k].triangles, sound[k].warning);
}

static size_t put(uint8_t *to, const void *value, size_t size, bool big)
{
    const uint8_t *bytes = value; // this test runs where the low byte comes first
    for (size_t k = 0; k < size; k++)
        to[k] = bytes[big ? size - 1 - k : k];
    return size;
}

static void binaries_of_both_ends_are_read(void **state)
{
    static const float corner[9] = { 0, 0, 0, 2, 0, 0, 0, 3, 0 };
    for (int big = 0; big < 2; big++) {
        for (int more = -1; more < 3; more++) {
            uint8_t bytes[512];
            size_t length = (size_t)sprintf((char *)bytes,
                "ply\nformat binary_%s_endian 1.0\n" VERTEX
                "element box 1\nproperty double size\nproperty list ushort short parts\n"
                "element face 1\nproperty list int uint vertex_indices\nend_header\n",
                big ? "big" : "little");
            for (int k = 0; k < 9; k++)
                length += put(bytes + length, &corner[k], 4, big);
            const double size = 5;
            const uint16_t parts[3] = { 2, 7, 8 };
            length += put(bytes + length, &size, 8, big);
            for (int k = 0; k < 3; k++)
                length += put(bytes + length, &parts[k], 2, big);
            for (uint32_t k = 0; k < 4; k++)
                length += put(bytes + length, &(uint32_t){ k ? k - 1 : 3 }, 4, big);
            bytes[length] = bytes[length + 1] = 9;
            if (more < 0) {
                assert_null(load(*state, bytes, length - 1));
                assert_mentions(rsv_last_error(), "cut off");
            } else {
                char extra[16];
                snprintf(extra, sizeof extra, "%d bytes", more);
                check(*state, bytes, length + (size_t)more, 1, more ? extra : "not used: box");
            }
        }
    }
}

/// A polygon that turns inwards covers its own area, whichever corner comes first and whichever way it faces.
static void polygons_need_not_be_convex(void **state)
{
    static const float arrow[5][2] = { { 0, 0 }, { 2, 0 }, { 2, 3 }, { 1, 1 }, { 0, 3 } };
    for (int first = 0; first < 5; first++) {
        for (int way = -1; way < 2; way += 2) {
            char text[1024];
            int length = sprintf(text, START
                "element vertex 5\nproperty float x\nproperty float y\nproperty float z\n" FACE
                "end_header\n");
            for (int k = 0; k < 5; k++)
                length +=
                    sprintf(text + length, "%g %g 0\n", (double)arrow[k][0], (double)arrow[k][1]);
            length += sprintf(text + length, "5");
            for (int k = 0; k < 5; k++)
                length += sprintf(text + length, " %d", (first + way * k + 5) % 5);
            rsv_scene *scene = load(*state, text, (size_t)length);
            if (!scene) fail_msg("%s", rsv_last_error());
            const rsv_scene_view *view = rsv_scene_get_view(scene);
            double area = 0;
            assert_int_equal(view->triangle_count, 3);
            for (size_t t = 0; t < 3; t++) {
                const uint32_t *c = view->triangle[t];
                rsv_vec3 n = v3_cross(v3_sub(view->position[c[1]], view->position[c[0]]),
                    v3_sub(view->position[c[2]], view->position[c[0]]));
                assert_true(n.z * (float)way > 0);
                area += 0.5 * (double)v3_length(n);
            }
            assert_float_equal(area, 4, 1e-6);
            rsv_scene_destroy(scene);
        }
    }
}

static void normals_are_taken(void **state)
{
    static const char text[] = START
        "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty float "
        "nx\nproperty float ny\nproperty float nz\n" FACE
        "end_header\n0 0 0 0 0.6 0.8\n2 0 0 0 0.6 0.8\n0 3 0 0 0.6 0.8\n3 0 1 2\n";
    rsv_scene *scene = load(*state, text, sizeof text - 1);
    assert_non_null(scene);
    assert_float_equal(rsv_scene_get_view(scene)->normal[0].y, 0.6f, 1e-6);
    rsv_scene_destroy(scene);
}

static void what_is_broken_is_refused_with_its_place(void **state)
{
    static const struct {
        const char *text, *reason;
    } broken[] = {
        { START VERTEX "element face 2\nproperty list uchar int vertex_indices\nend_header\n" POINTS
                       "3 0 1 2\n3 0 1\n",
            "the file is cut off" },
        { START VERTEX FACE "end_header\n0 0 0\n2,5 0 0\n0 3 0\n3 0 1 2\n", "line 11: a number" },
        { START VERTEX FACE "end_header\n0 0 0\nnan 0 0\n0 3 0\n3 0 1 2\n",
            "vertex 1 is not finite" },
        { START VERTEX FACE "end_header\n" POINTS "3 0 1 -1\n", "line 13" },
        { START VERTEX FACE "end_header\n" POINTS "3 0 1 2.5\n", "line 13" },
        { START VERTEX FACE "end_header\n" POINTS "3 0 1 3\n", "vertex 3 (index out of range)" },
        { START VERTEX FACE "end_header\n" POINTS "4000000000 0 1 2\n", "length of a list" },
        { START VERTEX "end_header\n" POINTS, "no triangle" },
        { START "element vertex 3\nproperty float x\nproperty float y\n" FACE
                "end_header\n0 0\n2 0\n0 3\n3 0 1 2\n",
            "x, y and z" },
        { START VERTEX VERTEX FACE "end_header\n" POINTS POINTS "3 0 1 2\n", "line 7" },
        { START VERTEX
            "element face 1\nproperty list float int vertex_indices\nend_header\n" POINTS,
            "line 8" },
    };
    for (size_t k = 0; k < sizeof broken / sizeof *broken; k++) {
        rsv_scene *scene = load(*state, broken[k].text, strlen(broken[k].text));
        if (scene) fail_msg("%zu is accepted", k);
        assert_mentions(rsv_last_error(), broken[k].reason);
    }
}

int main(void)
{
#define CASE(name) cmocka_unit_test_setup_teardown(name, enter, leave)
    const struct CMUnitTest tests[] = {
        CASE(texts_of_all_kinds_are_read),
        CASE(binaries_of_both_ends_are_read),
        CASE(polygons_need_not_be_convex),
        CASE(normals_are_taken),
        CASE(what_is_broken_is_refused_with_its_place),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
