/// STL as programs write it, text and binary: read as intended, or rejected with a one-line message.
#include "resolvent/io.h"
#include "unit/file_fixture.h"

#define FACET                                                                                      \
    "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2 0 0\nvertex 0 3 "                      \
    "0\nendloop\nendfacet\n"

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
    return load_written(f, path_in(&files, "a.stl"), bytes, count);
}

/// Reads a text and checks the result.
static void check_text(fixture *f, const char *text, size_t triangles, const char *warning)
{
    rsv_scene *scene = load(f, text, strlen(text));
    if (!scene) fail_msg("'%s' is refused: %s", text, rsv_last_error());
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    assert_int_equal(view->triangle_count, triangles);
    assert_float_equal(view->bounds_max.x, 2, 0);
    assert_float_equal(view->bounds_max.y, 3, 0);
    if (warning)
        assert_mentions(f->log, warning);
    else if (strstr(f->log, "a.stl"))
        fail_msg("'%s' has a warning: %s", text, f->log);
    rsv_scene_destroy(scene);
}

static void texts_of_all_kinds_are_read(void **state)
{
    static const struct {
        const char *text;
        size_t triangles;
        const char *warning;
    } sound[] = {
        { "solid a b\n" FACET "endsolid a b\n", 1, NULL },
        { "solid\n" FACET "endsolid\n", 1, NULL },
        { "\xef\xbb\xbf \r\nsolid x\r\n" FACET "endsolid x\r\n", 1, NULL },
        { "SOLID CUBE\nFACET NORMAL 0 0 1\nOUTER LOOP\nVERTEX 0 0 0\nVERTEX 2.0E0 0 0\n"
          "VERTEX 0 +3.E+00 0\nENDLOOP\nENDFACET\nENDSOLID CUBE\n",
            1, NULL },
        { "Solid Mixed\nFacet Normal 0 0 1\nOuter Loop\nVertex 0 0 0\nVertex 2 0 0\nVertex 0 3 0\n"
          "EndLoop\nEndFacet\nEndSolid",
            1, NULL },
        { "solid a\n" FACET "endsolid a\nsolid b\n" FACET FACET "endsolid b\n", 3, NULL },
        { "solid a\n" FACET, 1, "endsolid" },
        { "solid a\nfacet normal nan nan nan\nouter loop\nvertex 0 0 0\nvertex 2 0 0\nvertex 0 3 "
          "0\nendloop\nendfacet\nendsolid\n",
            1, NULL },
        { "solid a\nfacet normal 0 0 1 outer loop vertex 0 0 0 vertex 2 0 0 vertex 0 3 0 endloop "
          "endfacet endsolid\n",
            1, NULL },
        { "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2 0 0\nvertex 2 3 0\n"
          "vertex 0 3 0\nendloop\nendfacet\nendsolid\n",
            2, NULL },
        { "solid two words facet normal 0 0 1 outer loop vertex 0 0 0 vertex 2 0 0 vertex 0 3 0 "
          "endloop "
          "endfacet endsolid two words SOLID b FACET normal 0 0 1 outer loop vertex 0 0 0 vertex 2 "
          "0 0 vertex 0 3 0 endloop endfacet endsolid b",
            2, NULL },
        { "solid a\ncolor 1 0 0\n" FACET "color 0 1 0\nendsolid\n", 1, "'color' in line 2" },
        { "solid empty\nendsolid\nsolid a\n" FACET "endsolid\n", 1, NULL },
    };
    for (size_t k = 0; k < sizeof sound / sizeof *sound; k++)
        check_text(*state, sound[k].text, sound[k].triangles, sound[k].warning);
}

static void solids_keep_their_names(void **state)
{
    static const char text[] =
        "solid left wing\n" FACET "endsolid\nSOLID Right\n" FACET "ENDSOLID\n";
    rsv_scene *scene = load(*state, text, sizeof text - 1);
    assert_non_null(scene);
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    assert_string_equal(object_of(view, 0), "left wing");
    assert_string_equal(object_of(view, 1), "Right");
    rsv_scene_destroy(scene);
}

/// A header, a count and two triangles that reach (2, 3), with this many bytes removed or appended.
static rsv_scene *load_binary(fixture *f, const char *head, uint32_t count, int more, int attribute)
{
    uint8_t bytes[84 + 100 + 600] = { 0 };
    static const float corner[6][3] = { { 0, 0, 0 }, { 2, 0, 0 }, { 0, 3, 0 }, { 0, 0, 1 },
        { 2, 0, 1 }, { 0, 3, 1 } };
    memcpy(bytes, head, strlen(head));
    memcpy(bytes + 80, &count, 4);
    for (int t = 0; t < 2; t++) {
        memcpy(bytes + 84 + 50 * t + 12, corner[3 * t], 36);
        bytes[84 + 50 * t + 48] = (uint8_t)attribute;
    }
    return load(f, bytes, (size_t)(184 + more));
}

static void binaries_of_all_kinds_are_read(void **state)
{
    static const struct {
        const char *head;
        uint32_t count;
        int more, attribute;
        size_t triangles;
        const char *warning;
    } sound[] = {
        { "made by hand", 2, 0, 0, 2, NULL },
        { "solid made by hand", 2, 0, 0, 2, NULL },
        { "SOLID", 2, 0, 0, 2, NULL },
        { "any", 2, 1, 0, 2, "1 bytes" },
        { "any", 2, 512, 0, 2, "512 bytes" },
        { "solid any", 2, 512, 0, 2, "512 bytes" },
        { "any", 1, 0, 0, 1, "50 bytes" },
        { "any", 0, 0, 0, 2, NULL },
        { "any", UINT32_MAX, 0, 0, 2, NULL },
        { "COLOR=\xff", 2, 0, 7, 2, "colours" },
    };
    for (size_t k = 0; k < sizeof sound / sizeof *sound; k++) {
        fixture *f = *state;
        rsv_scene *scene =
            load_binary(f, sound[k].head, sound[k].count, sound[k].more, sound[k].attribute);
        if (!scene) fail_msg("%zu is refused: %s", k, rsv_last_error());
        assert_int_equal(rsv_scene_get_view(scene)->triangle_count, sound[k].triangles);
        assert_float_equal(rsv_scene_get_view(scene)->bounds_max.y, 3, 0);
        if (sound[k].warning)
            assert_mentions(f->log, sound[k].warning);
        else
            assert_null(strstr(f->log, "a.stl"));
        rsv_scene_destroy(scene);
    }
}

static void what_is_broken_is_refused_with_its_place(void **state)
{
    static const struct {
        const char *text, *reason;
    } broken[] = {
        { "", "empty" },
        { "solid a\nendsolid\n", "no triangle" },
        { "not an STL file at all", "not an STL file" },
        { "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2 0\n", "cut off" },
        { "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2,5 0 0\n", "line 5" },
        { "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex inf 0 0\n", "line 5" },
        { "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\n",
            "line 6: a loop of 2 corners" },
        { "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nedge 1 0 0\n", "'edge'" },
        { "solid a\nfacet normal 0 0 1\nouter ring\nvertex 0 0 0\n", "'loop'" },
    };
    for (size_t k = 0; k < sizeof broken / sizeof *broken; k++) {
        rsv_scene *scene = load(*state, broken[k].text, strlen(broken[k].text));
        if (scene) fail_msg("'%s' is accepted", broken[k].text);
        assert_mentions(rsv_last_error(), broken[k].reason);
    }
    assert_null(load_binary(*state, "any", 3, 0, 0));
    assert_mentions(rsv_last_error(), "announces 3 triangles, but holds 2");
    assert_null(load_binary(*state, "any", 2, -1, 0));
    assert_null(load_binary(*state, "any", 4000000000u, 0, 0));
}

int main(void)
{
#define CASE(name) cmocka_unit_test_setup_teardown(name, enter, leave)
    const struct CMUnitTest tests[] = {
        CASE(texts_of_all_kinds_are_read),
        CASE(solids_keep_their_names),
        CASE(binaries_of_all_kinds_are_read),
        CASE(what_is_broken_is_refused_with_its_place),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
