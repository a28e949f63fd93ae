/// Files as they occur in practice: buffers too long and too short, names with odd characters, other versions, extreme
/// depths.
#include "gltf_fixture.h"
#include "slow_tests.h"

#define SQUARE_MESH                                                                                \
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48}],\"accessors\":[{\"bufferView\":0,"         \
    "\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"}],\"meshes\":[{\"primitives\":[{"        \
    "\"attributes\":{\"POSITION\":0},\"mode\":6}]}],\"nodes\":[{\"mesh\":0}]"
#define VERSION "\"asset\":{\"version\":\"2.0\"}"

static const char *write_text(const folder *place, const char *name, const char *text)
{
    const char *path = path_in(place, name);
    write_bytes(path, text, strlen(text));
    return path;
}

/// Writes the first `bytes` bytes of a buffer that begins with the square.
static void write_square(const folder *place, const char *name, size_t bytes)
{
    buffer b = square_buffer();
    assert_true(bytes <= sizeof b.data);
    write_bytes(path_in(place, name), b.data, bytes);
}

static void assert_shows_square(fixture *f, const char *path, float height)
{
    rsv_scene *scene = load(f, path);
    assert_int_equal(rsv_scene_get_view(scene)->triangle_count, 2);
    assert_bounds(scene, v3(0, 0, 0), v3(1, height, 0));
    rsv_scene_destroy(scene);
}

// ---- lengths --------------------------------------------------------------------------------------

static void buffers_may_be_longer_than_they_say(void **state)
{
    fixture *f = *state;
    folder place = new_folder();
    write_square(&place, "long.bin", 48 + 7);
    assert_shows_square(f,
        write_text(&place, "a.gltf",
            "{" VERSION ",\"buffers\":[{\"uri\":\"long.bin\",\"byteLength\":48}]," SQUARE_MESH "}"),
        1);
    // the same 48 bytes and 7 more, as base64
    assert_shows_square(f,
        write_text(&place, "b.gltf",
            "{" VERSION ",\"buffers\":[{\"uri\":\"data:application/octet-stream;base64,"
            "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAAAAAAAAAAgD8AAAAAAAAAAAAAAA==\","
            "\"byteLength\":48}]," SQUARE_MESH "}"),
        1);
    assert_null(strstr(f->log, "warning"));
    remove_folder(place.path);
}

/// Reads no more of a huge file than requested.
static void a_huge_buffer_file_is_read_as_far_as_it_is_needed(void **state)
{
    folder place = new_folder();
    write_square(&place, "huge.bin", 48);
    if (truncate(path_in(&place, "huge.bin"), (off_t)1 << 40) != 0) skip();
    assert_shows_square(*state,
        write_text(&place, "a.gltf",
            "{" VERSION ",\"buffers\":[{\"uri\":\"huge.bin\",\"byteLength\":48}]," SQUARE_MESH "}"),
        1);
    remove_folder(place.path);
}

static void put_word(uint8_t *at, size_t value)
{
    for (int k = 0; k < 4; k++)
        at[k] = (uint8_t)(value >> 8 * k);
}

/// A .glb whose JSON says `said` bytes and whose binary chunk has `there`. @param extra bytes behind its end
static const char *write_glb(const folder *place, size_t said, size_t there, size_t extra)
{
    static uint8_t file[8192];
    buffer b = square_buffer();
    char text[2048];
    int length = snprintf(text, sizeof text,
        "{" VERSION ",\"buffers\":[{\"byteLength\":%zu}]," SQUARE_MESH "}", said);
    size_t json = ((size_t)length + 3) & ~(size_t)3, at = 20 + json;
    memset(file, 0, sizeof file);
    memset(file + 20, ' ', json);
    memcpy(file, "glTF", 4);
    put_word(file + 4, 2);
    put_word(file + 8, at + 8 + there);
    put_word(file + 12, json);
    memcpy(file + 16, "JSON", 4);
    memcpy(file + 20, text, (size_t)length);
    put_word(file + at, there);
    memcpy(file + at + 4, "BIN", 4);
    memcpy(file + at + 8, b.data, there < b.bytes ? there : b.bytes);
    const char *path = path_in(place, "a.glb");
    write_bytes(path, file, at + 8 + there + extra);
    return path;
}

static void binary_chunks_may_be_longer_than_they_say(void **state)
{
    folder place = new_folder();
    assert_shows_square(*state, write_glb(&place, 48, 48, 0), 1);
    assert_shows_square(*state, write_glb(&place, 48, 60, 0), 1);
    assert_shows_square(*state, write_glb(&place, 48, 48, 5), 1);
    assert_refused(*state, write_glb(&place, 48, 40, 0), RSV_ERROR_FORMAT,
        "buffer 0 needs 48 bytes (byteLength), but 40 are there");
    remove_folder(place.path);
}

static void buffers_that_are_too_short_are_refused_in_our_words(void **state)
{
    static const char *const uri[] = { "short.bin",
        "data:application/octet-stream;base64,"
        "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAAAAAAAA==" };
    folder place = new_folder();
    write_square(&place, "short.bin", 40);
    for (int k = 0; k < 2; k++) {
        char text[2048];
        snprintf(text, sizeof text,
            "{" VERSION ",\"buffers\":[{\"uri\":\"%s\",\"byteLength\":48}]," SQUARE_MESH "}",
            uri[k]);
        assert_refused(*state, write_text(&place, "a.gltf", text), RSV_ERROR_FORMAT,
            "buffer 0 needs 48 bytes (byteLength), but 40 are there");
        assert_null(strstr(rsv_last_error(), "AAAA"));
    }
    assert_refused(*state,
        write_text(&place, "a.gltf",
            "{" VERSION ",\"buffers\":[{\"uri\":\"short.bin\",\"byteLength\":1e13}]," SQUARE_MESH
            "}"),
        RSV_ERROR_FORMAT, "needs 10000000000000 bytes (byteLength), but 40 are there");
    remove_folder(place.path);
}

static void broken_data_uris_are_refused_in_our_words(void **state)
{
    static const struct {
        const char *uri, *message;
    } cases[] = {
        { "data:application/octet-stream;base64,AAAA!AAA",
            "buffer 0: its data URI is not valid base64" },
        { "data:application/octet-stream;base64", "buffer 0: its data URI has no comma" },
        { "https://example.org/AAAAAAAAAAAA.bin",
            "buffer 0: there is no file 'https://example.org" },
        { "C:/Users/me/scene.bin", "buffers must lie in the asset's folder or below" },
        { "/etc/hostname", "buffers must lie in the asset's folder or below" },
    };
    folder place = new_folder();
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        char text[2048];
        snprintf(text, sizeof text,
            "{" VERSION ",\"buffers\":[{\"uri\":\"%s\",\"byteLength\":48}]," SQUARE_MESH "}",
            cases[k].uri);
        rsv_scene *scene = NULL;
        assert_int_not_equal(rsv_scene_load(((fixture *)*state)->context,
                                 write_text(&place, "a.gltf", text), &scene),
            RSV_OK);
        assert_mentions(rsv_last_error(), cases[k].message);
        assert_null(strstr(rsv_last_error(), "AAAA!"));
    }
    remove_folder(place.path);
}

/// Any media type is accepted, and base64 in all usual forms: in lines, URL-safe, with its padding escaped or left out.
static void data_uris_of_all_kinds_are_read(void **state)
{
    static const char *const uri[] = {
        "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAAAAAAAAAAgD8AAAAA",
        "data:application/gltf-buffer;charset=x;base64,"
        "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAAAAAAAAAAgD8AAAAAAA%3D%3D",
        "data:text/plain;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAA\\nAACAPwAAgD8AAAAAAAAAAAAAgD8A"
        "AAAA",
        "data:text/plain,%00%00%00%00%00%00%00%00%00%00%00%00%00%00%80%3f%00%00%00%00%00%00%00%00"
        "%00%00%80%3f%00%00%80%3f%00%00%00%00%00%00%00%00%00%00%80%3f%00%00%00%00",
    };
    folder place = new_folder();
    for (size_t k = 0; k < sizeof uri / sizeof *uri; k++) {
        char text[2048];
        snprintf(text, sizeof text,
            "{" VERSION ",\"buffers\":[{\"uri\":\"%s\",\"byteLength\":48}]," SQUARE_MESH "}",
            uri[k]);
        assert_shows_square(*state, write_text(&place, "a.gltf", text), 1);
    }
    remove_folder(place.path);
}

/// A missing buffer is an error only if it is needed; the message names what needs it.
static void buffers_without_data_are_named_where_they_are_needed(void **state)
{
    folder place = new_folder();
    write_square(&place, "a.bin", 48);
    assert_shows_square(*state,
        write_text(&place, "a.gltf",
            "{" VERSION
            ",\"buffers\":[{\"uri\":\"a.bin\",\"byteLength\":48},{\"byteLength\":9}]," SQUARE_MESH
            "}"),
        1);
    assert_refused(*state,
        write_text(
            &place, "a.gltf", "{" VERSION ",\"buffers\":[{\"byteLength\":48}]," SQUARE_MESH "}"),
        RSV_ERROR_FORMAT, "mesh 'mesh 0': accessor 0 lies in a buffer without data");
    remove_folder(place.path);
}

// ---- names ----------------------------------------------------------------------------------------

/// Squares whose height says which file they are from.
static void write_tall(const folder *place, const char *name, float height)
{
    const float corner[12] = { 0, 0, 0, 1, 0, 0, 1, height, 0, 0, height, 0 };
    write_bytes(path_in(place, name), corner, sizeof corner);
}

static void names_mean_what_the_uri_says(void **state)
{
    static const struct {
        const char *uri;
        float height;
    } cases[] = { { "a+b.bin", 1 }, { "a%2Bb.bin", 1 }, { "a%20b.bin", 2 }, { "a b.bin", 2 },
        { "100%.bin", 3 }, { "100%25.bin", 3 }, { "%c3%a9.bin", 4 }, { "\xc3\xa9.bin", 4 },
        { "sub\\\\c.bin", 5 }, { "./sub/../sub/c.bin", 5 }, { "d%20e.bin", 6 } };
    folder place = new_folder();
    write_tall(&place, "a+b.bin", 1);
    write_tall(&place, "a b.bin", 2);
    write_tall(&place, "100%.bin", 3);
    write_tall(&place, "\xc3\xa9.bin", 4);
    assert_int_equal(mkdir(path_in(&place, "sub"), 0700), 0);
    write_tall(&place, "sub/c.bin", 5);
    write_tall(&place, "d%20e.bin", 6); // named as it is written, by who does not know of escapes
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        char text[2048];
        snprintf(text, sizeof text,
            "{" VERSION ",\"buffers\":[{\"uri\":\"%s\",\"byteLength\":48}]," SQUARE_MESH "}",
            cases[k].uri);
        assert_shows_square(*state, write_text(&place, "a.gltf", text), cases[k].height);
    }
    remove_folder(place.path);
}

// ---- versions -------------------------------------------------------------------------------------

static void other_versions_are_named(void **state)
{
    static const struct {
        const char *asset, *message;
        rsv_status status;
    } cases[] = {
        { "\"asset\":{\"version\":\"1.0\"}", "is glTF 1.0, which is not supported; convert it",
            RSV_ERROR_UNSUPPORTED },
        { "\"asset\":{\"version\":\"3.1\"}", "is glTF 3.1", RSV_ERROR_UNSUPPORTED },
        { "\"asset\":{\"version\":\"2.9\",\"minVersion\":\"2.1\"}", "needs a reader of glTF 2.1",
            RSV_ERROR_UNSUPPORTED },
        { "\"asset\":{\"version\":\"3.0\",\"minVersion\":\"2.0\"}", NULL, RSV_OK },
        { "\"asset\":{}", "has no asset.version", RSV_ERROR_FORMAT },
        { "\"meshes\":{\"m\":{}}", "has no asset.version", RSV_ERROR_FORMAT },
        { "\"asset\":{\"version\":\"2.1\"}", NULL, RSV_OK },
        { "\"asset\":{\"version\":\"2.1\",\"minVersion\":\"2.0\"}", NULL, RSV_OK },
        { "\"asset\":{\"version\":2.0}", NULL, RSV_OK },
    };
    folder place = new_folder();
    write_square(&place, "a.bin", 48);
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        char text[2048];
        snprintf(text, sizeof text,
            "{%s,\"buffers\":[{\"uri\":\"a.bin\",\"byteLength\":48}]," SQUARE_MESH "}",
            cases[k].asset);
        const char *path = write_text(&place, "a.gltf", text);
        if (cases[k].message)
            assert_refused(*state, path, cases[k].status, cases[k].message);
        else
            assert_shows_square(*state, path, 1);
    }
    remove_folder(place.path);
}

static void a_byte_order_mark_is_no_harm(void **state)
{
    folder place = new_folder();
    write_square(&place, "a.bin", 48);
    const char text[] = "\xef\xbb\xbf{" VERSION
                        ",\"buffers\":[{\"uri\":\"a.bin\",\"byteLength\":48.0}]," SQUARE_MESH "}";
    assert_shows_square(*state, write_text(&place, "a.gltf", text), 1);
    const char wide[] = "{\0\"\0a\0s\0s\0e\0t\0\"\0:\0{\0}\0}";
    write_bytes(path_in(&place, "b.gltf"), wide, sizeof wide);
    assert_refused(*state, path_in(&place, "b.gltf"), RSV_ERROR_FORMAT, "is not in UTF-8");
    remove_folder(place.path);
}

// ---- depths ---------------------------------------------------------------------------------------

static void extensions_nested_a_thousand_deep_are_refused(void **state)
{
    enum { DEPTH = 1000 };
    static const char level[] = "{\"extensions\":{\"X\":";
    folder place = new_folder();
    char *text = malloc((sizeof level + 2) * DEPTH + 256);
    assert_non_null(text);
    size_t used = (size_t)sprintf(text, "{" VERSION ",\"nodes\":[");
    for (int k = 0; k < DEPTH; k++)
        used += (size_t)sprintf(text + used, "%s", level);
    used += (size_t)sprintf(text + used, "{}");
    for (int k = 0; k < DEPTH; k++)
        used += (size_t)sprintf(text + used, "}}");
    used += (size_t)sprintf(text + used, "]}");
    const char *path = path_in(&place, "deep.gltf");
    write_bytes(path, text, used);
    free(text);
    assert_refused(*state, path, RSV_ERROR_FORMAT, "its JSON is nested too deeply at line 1");
    remove_folder(place.path);
}

/// A chain of a million nodes, each a thousandth of a millimetre on.
static void chains_of_a_million_nodes_are_walked(void **state)
{
    enum { DEPTH = UNLESS_SANITIZED(1000000, 50000) };
    folder place = new_folder();
    char *text = malloc((size_t)DEPTH * 48 + 4096);
    assert_non_null(text);
    write_square(&place, "a.bin", 48);
    size_t used = (size_t)sprintf(
        text, "{" VERSION ",\"buffers\":[{\"uri\":\"a.bin\",\"byteLength\":48}]," SQUARE_MESH);
    used = (size_t)(strstr(text, ",\"nodes\"") - text);
    used += (size_t)sprintf(text + used, ",\"nodes\":[");
    for (int i = 1; i < DEPTH; i++)
        used += (size_t)sprintf(text + used, "{\"translation\":[0,0,1e-6],\"children\":[%d]},", i);
    used += (size_t)sprintf(text + used, "{\"mesh\":0}]}");
    const char *path = path_in(&place, "chain.gltf");
    write_bytes(path, text, used);
    free(text);
    rsv_scene *scene = load(*state, path);
    assert_bounds(scene, v3(0, 0, (DEPTH - 1) * 1e-6f), v3(1, 1, (DEPTH - 1) * 1e-6f));
    rsv_scene_destroy(scene);
    remove_folder(place.path);
}

#define FILE_TEST(function)                                                                        \
    cmocka_unit_test_setup_teardown(function, fixture_setup, fixture_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        FILE_TEST(buffers_may_be_longer_than_they_say),
        FILE_TEST(a_huge_buffer_file_is_read_as_far_as_it_is_needed),
        FILE_TEST(binary_chunks_may_be_longer_than_they_say),
        FILE_TEST(buffers_that_are_too_short_are_refused_in_our_words),
        FILE_TEST(broken_data_uris_are_refused_in_our_words),
        FILE_TEST(data_uris_of_all_kinds_are_read),
        FILE_TEST(buffers_without_data_are_named_where_they_are_needed),
        FILE_TEST(names_mean_what_the_uri_says),
        FILE_TEST(other_versions_are_named),
        FILE_TEST(a_byte_order_mark_is_no_harm),
        FILE_TEST(extensions_nested_a_thousand_deep_are_refused),
        FILE_TEST(chains_of_a_million_nodes_are_walked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
