/// Each part of a glTF file that is not read is named once, with what it affects.
#include "gltf_fixture.h"

/// One object of each kind of the format; % marks where something unknown is inserted.
static const char everything[] =
    "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"name\":\"lamp\",\"type\":\"spot\","
    "\"spot\":{%}%}]%}%}%,"
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48%}],"
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\","
    "\"sparse\":{\"count\":0,\"indices\":{\"bufferView\":0,\"componentType\":5121%},"
    "\"values\":{\"bufferView\":0%}%}%}],"
    "\"meshes\":[{\"name\":\"m\",\"primitives\":[{\"attributes\":{\"POSITION\":0},\"mode\":6,"
    "\"material\":0%}]%}],"
    "\"nodes\":[{\"name\":\"n\",\"mesh\":0,\"camera\":0,\"extensions\":{\"KHR_lights_punctual\":{"
    "\"light\":0%},\"KHR_node_visibility\":{\"visible\":true%}%}%}],"
    "\"scenes\":[{\"nodes\":[0]%}],"
    "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"znear\":1%}%}],"
    "\"skins\":[{\"joints\":[0]%}],"
    "\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"path\":\"scale\"%}%}],"
    "\"samplers\":[{\"input\":0,\"output\":0%}]%}],"
    "\"textures\":[{\"source\":0,\"sampler\":0%}],\"samplers\":[{\"magFilter\":9729%}],"
    "\"images\":[{\"bufferView\":0%}],"
    "\"materials\":[{\"name\":\"paint\",\"pbrMetallicRoughness\":{\"metallicFactor\":0%},"
    "\"normalTexture\":{\"index\":0,\"extensions\":{\"KHR_texture_transform\":{\"scale\":[1,1]%}%}%"
    "},"
    "\"extensions\":{\"KHR_materials_ior\":{\"ior\":1.4%},\"KHR_materials_clearcoat\":{"
    "\"clearcoatFactor\":0.5%}%}%}]";

static size_t count_marks(void)
{
    size_t marks = 0;
    for (const char *c = everything; *c; c++)
        marks += *c == '%';
    return marks;
}

/// Whether mark `k` stands within an object of extensions, where members are extensions.
static bool in_extensions(size_t mark)
{
    char kind[64];
    int depth = 0;
    size_t k = 0;
    for (const char *c = everything; *c; c++) {
        static const char key[] = "\"extensions\":";
        if (*c == '{') {
            kind[depth++] =
                c - everything >= (long)sizeof key - 1 && !strncmp(c - sizeof key + 1, key, 13);
        } else if (*c == '}') {
            depth--;
        } else if (*c == '%' && k++ == mark) {
            return depth > 0 && kind[depth - 1];
        }
    }
    return false;
}

/// Inserts `insert` at mark `which` and nothing at the others. SIZE_MAX = at none.
static void fill_in(char *text, size_t which, const char *insert)
{
    size_t mark = 0;
    for (const char *c = everything; *c; c++) {
        if (*c != '%')
            *text++ = *c;
        else if (mark++ == which)
            text += sprintf(text, "%s", insert + (c[-1] == '{')); // no comma before the first
    }
    *text = 0;
}

static void load_with(fixture *f, const folder *place, size_t mark, const char *insert)
{
    char text[8192];
    buffer b = square_buffer();
    f->log[0] = 0;
    fill_in(text, mark, insert);
    rsv_scene_destroy(load(f, write_gltf(place, &b, text)));
}

static void what_is_known_is_not_named(void **state)
{
    fixture *f = *state;
    folder place = new_folder();
    load_with(f, &place, SIZE_MAX, "");
    assert_null(strstr(f->log, "is ignored:"));
    assert_mentions(f->log, "1 animation is not played");
    remove_folder(place.path);
}

static void unknown_extensions_and_properties_are_named_on_every_object(void **state)
{
    fixture *f = *state;
    folder place = new_folder();
    for (size_t mark = 0; mark < count_marks(); mark++) {
        bool among = in_extensions(mark);
        load_with(f, &place, mark, ",\"ACME_thing\":{\"a\":[1,{\"b\":2}]}");
        const char *expected = among ? "warning: extension 'ACME_thing' is ignored: "
                                     : "warning: property 'ACME_thing' is ignored: ";
        if (count_mentions(f->log, expected) != 1 || count_mentions(f->log, "ACME_thing") != 1)
            fail_msg("mark %zu: '%s' is not said once in: %s", mark, expected, f->log);
    }
    remove_folder(place.path);
}

/// "extensions" of its own for each object that has none yet.
static void extensions_are_named_with_their_objects(void **state)
{
    static const struct {
        const char *before, *described;
    } cases[] = {
        { "\"mesh\":0", "node 'n'" },
        { "\"metallicFactor\":0", "a pbrMetallicRoughness of material 'paint'" },
        { "\"mode\":6", "a primitive of mesh 'm'" },
        { "\"type\":\"spot\"", "light 'lamp'" },
        { "\"magFilter\":9729", "sampler 0" },
        { "\"version\":\"2.0\"", "the asset" },
        { "\"yfov\":1", "a lens of camera 0" },
        { "\"path\":\"scale\"", "a target of animation 0" },
        { "\"ior\":1.4", "an index of refraction of material 'paint'" },
    };
    fixture *f = *state;
    folder place = new_folder();
    buffer b = square_buffer();
    char text[8192], changed[16384];
    fill_in(text, SIZE_MAX, "");
    write_gltf(&place, &b, text);
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        size_t bytes;
        char *whole = (char *)read_bytes(path_in(&place, "shape.gltf"), &bytes);
        whole[bytes] = 0;
        char *at = strstr(whole, cases[k].before);
        assert_non_null(at);
        bool is_node = k == 0; // it has extensions already
        if (is_node) at = strstr(at, "\"extensions\":{") + strlen("\"extensions\":{");
        snprintf(changed, sizeof changed, "%.*s%s%s", (int)(at - whole), whole,
            is_node ? "\"ACME_x\":{}," : "\"extensions\":{\"ACME_x\":{}},", at);
        free(whole);
        const char *path = path_in(&place, "changed.gltf");
        write_bytes(path, changed, strlen(changed));
        f->log[0] = 0;
        rsv_scene_destroy(load(f, path));
        char expected[256];
        snprintf(expected, sizeof expected, "warning: extension 'ACME_x' is ignored: %s\n",
            cases[k].described);
        assert_mentions(f->log, expected);
    }
    remove_folder(place.path);
}

static const char *extended_nodes(const folder *place)
{
    const sketch s = square_sketch();
    return write_sketch(place, &s,
        "\"extensionsUsed\":[\"MSFT_lod\",\"EXT_lights_area\",\"EXT_lights_image_based\","
        "\"ACME_nowhere\",\"KHR_mesh_quantization\"],"
        "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"name\":\"a\",\"type\":\"point\","
        "\"range\":5},{\"type\":\"point\",\"range\":6}]},\"EXT_lights_image_based\":{\"lights\":[]}"
        ","
        "\"EXT_lights_area\":{\"lights\":[]}},"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_2\":9,\"_ID\":9},"
        "\"indices\":1}]}],\"scenes\":[{\"nodes\":[0,1],\"extensions\":{\"EXT_lights_image_based\":"
        "{"
        "\"light\":0}}}],\"nodes\":[{\"name\":\"near\",\"mesh\":0,\"foo\":1,\"extensions\":{"
        "\"MSFT_lod\":{\"ids\":[1]},\"EXT_lights_area\":{\"light\":0}}},{\"mesh\":0,\"foo\":2,"
        "\"skin\":-1,\"extensions\":{\"MSFT_lod\":{\"ids\":[0]}}}]");
}

static void each_is_named_once_with_how_many_it_affects(void **state)
{
    fixture *f = *state;
    folder place = new_folder();
    rsv_scene_destroy(load(f, extended_nodes(&place)));
    static const char *const expected[] = {
        "warning: extension 'MSFT_lod' is ignored: 2 nodes (first: node 'near')\n",
        "warning: extension 'EXT_lights_area' is ignored: the file itself, node 'near'\n",
        "warning: extension 'EXT_lights_image_based' is ignored: the file itself, scene 0\n",
        "extension 'ACME_nowhere' is listed as used, but nothing uses it\n",
        "warning: property 'foo' is ignored: 2 nodes (first: node 'near')\n",
        "attribute 'TEXCOORD_2' is ignored: a primitive of mesh 0\n",
        "attribute '_ID' is ignored: a primitive of mesh 0\n",
        "warning: property 'skin' has a value that is not in the format, and is ignored: node 1\n",
        "warning: 2 lights (first: light 'a'): the range is ignored",
    };
    for (size_t k = 0; k < sizeof expected / sizeof *expected; k++)
        assert_mentions(f->log, expected[k]);
    assert_int_equal(count_mentions(f->log, "MSFT_lod"), 1);
    assert_null(strstr(f->log, "KHR_mesh_quantization"));
    remove_folder(place.path);
}

#define PLAIN_MESH                                                                                 \
    "\"meshes\":[{\"name\":\"m\",\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1%"  \
    "s}]}],"
#define LAMP(light)                                                                                \
    "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"name\":\"l\"," light                  \
    "}]}},\"nodes\":[{"                                                                            \
    "\"name\":\"n\",\"mesh\":0,\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}]"
#define CAMERA(camera, node)                                                                       \
    "\"cameras\":[{" camera "}],\"nodes\":[{\"mesh\":0},{\"name\":\"n\",\"camera\":0" node "}]"

/// Unsupported features are reported, and the rest is shown.
static void oddities_are_told_and_the_rest_is_shown(void **state)
{
    static const struct {
        const char *primitive, *rest, *told;
        size_t lights;
    } cases[] = {
        { "", LAMP("\"type\":\"point\",\"intensity\":-5"),
            "light 'l': its intensity is "
            "negative",
            0 },
        { "", LAMP("\"type\":\"spot\",\"spot\":{\"innerConeAngle\":1,\"outerConeAngle\":0.5}"),
            "light 'l': its cone is outside the format's range", 1 },
        { "", LAMP("\"type\":\"spot\",\"spot\":{\"outerConeAngle\":2}"),
            "light 'l': its cone is outside the format's range", 1 },
        { "", LAMP("\"type\":\"spot\",\"spot\":{\"innerConeAngle\":0.5,\"outerConeAngle\":0.5}"),
            "", 1 },
        { "", LAMP("\"intensity\":5"), "light 'l': its type '' is not in the format", 0 },
        { "",
            "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"spot\"}]}},\"nodes\":"
            "[{"
            "\"mesh\":0},{\"name\":\"n\",\"scale\":[0,0,0],\"extensions\":{\"KHR_lights_punctual\":"
            "{"
            "\"light\":0}}}]",
            "node 'n': its light is left out: its transform makes its direction zero", 0 },
        { "", CAMERA("\"type\":\"perspective\",\"perspective\":{\"yfov\":0}", ""),
            "node 'n': its camera is left out: its lens", 0 },
        { "", CAMERA("\"type\":\"orthographic\",\"orthographic\":{\"xmag\":1,\"ymag\":0}", ""),
            "node 'n': its camera is left out: its lens", 0 },
        { "", CAMERA("\"type\":\"perspective\",\"perspective\":{\"yfov\":1}", ",\"scale\":[0,0,0]"),
            "node 'n': its camera is left out: its transform", 0 },
        { "", "\"skins\":[{\"joints\":[0]}],\"nodes\":[{\"name\":\"n\",\"mesh\":0,\"skin\":0}]",
            "1 nodes (first: 'n') have a skin, but their mesh has no joints", 0 },
        { "",
            "\"nodes\":[{\"name\":\"n\",\"mesh\":0,\"translation\":[1,2,3],\"matrix\":[1,0,0,0,0,1,"
            "0,0,"
            "0,0,1,0,0,0,0,1]}]",
            "node 'n': translation, rotation and scale are ignored next to a matrix", 0 },
        { "",
            "\"nodes\":[{\"name\":\"n\",\"mesh\":0,\"matrix\":[1,0,0,0.5,0,1,0,0,0,0,1,0,0,0,0,2]}"
            "]",
            "node 'n': the last row of the matrix", 0 },
        { ",\"material\":0", "\"materials\":[{\"alphaMode\":\"CLIP\"}],\"nodes\":[{\"mesh\":0}]",
            "its alphaMode 'CLIP' is not in the format", 0 },
        { ",\"material\":0",
            "\"materials\":[{\"name\":\"p\",\"emissiveTexture\":{\"index\":7,\"texCoord\":1}}],"
            "\"nodes\":"
            "[{\"mesh\":0}]",
            "material 'p' has textures that use TEXCOORD_1, which the mesh lacks", 0 },
        { ",\"material\":null",
            "\"nodes\":[{\"mesh\":0,\"camera\":null,\"name\":null,\"children\":null}]", "", 0 },
        { "", "\"extensionsRequired\":[7],\"nodes\":[{\"mesh\":0}]",
            "property 'extensionsRequired' has a value that is not in the format", 0 },
        { "",
            "\"scenes\":[{\"nodes\":[0]},{\"name\":\"b\",\"nodes\":[0]}],\"scene\":1,\"nodes\":[{"
            "\"mesh\":0}]",
            "it holds 2 scenes: scene 'b' is shown", 0 },
    };
    fixture *f = *state;
    folder place = new_folder();
    const sketch s = square_sketch();
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        char rest[2048];
        int head = snprintf(rest, sizeof rest, PLAIN_MESH, cases[k].primitive);
        snprintf(rest + head, sizeof rest - (size_t)head, "%s", cases[k].rest);
        f->log[0] = 0;
        rsv_scene *scene = load(f, write_sketch(&place, &s, rest));
        assert_mentions(f->log, cases[k].told);
        if (!*cases[k].told) assert_null(strstr(f->log, "warning"));
        assert_bounds(scene, v3(0, 0, 0), v3(1, 1, 0));
        assert_int_equal(rsv_scene_get_view(scene)->light_count, cases[k].lights);
        rsv_scene_destroy(scene);
    }
    remove_folder(place.path);
}

/// A hundred thousand different properties do not give a hundred thousand lines.
static void hostile_variety_is_cut_short(void **state)
{
    enum { VARIETY = 100000 };
    fixture *f = *state;
    folder place = new_folder();
    buffer b = square_buffer();
    char *text = malloc((size_t)VARIETY * 16 + 2048);
    assert_non_null(text);
    write_bytes(path_in(&place, "a.bin"), b.data, b.bytes);
    size_t used = (size_t)sprintf(text,
        "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"uri\":\"a.bin\",\"byteLength\":48}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48}],\"accessors\":[{\"bufferView\":0,"
        "\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"}],\"meshes\":[{\"primitives\":[{"
        "\"attributes\":{\"POSITION\":0},\"mode\":6}]}],\"nodes\":[{\"mesh\":0");
    for (int k = 0; k < VARIETY; k++)
        used += (size_t)sprintf(text + used, ",\"p%d\":1", k);
    used += (size_t)sprintf(text + used, "}]}");
    const char *path = path_in(&place, "many.gltf");
    write_bytes(path, text, used);
    free(text);
    rsv_scene_destroy(load(f, path));
    assert_in_range(count_mentions(f->log, "\n"), 2, 100);
    assert_mentions(f->log, "99936 more uses of extensions and properties that are not known");
    remove_folder(place.path);
}

#define UNREAD_TEST(function)                                                                      \
    cmocka_unit_test_setup_teardown(function, fixture_setup, fixture_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        UNREAD_TEST(what_is_known_is_not_named),
        UNREAD_TEST(unknown_extensions_and_properties_are_named_on_every_object),
        UNREAD_TEST(extensions_are_named_with_their_objects),
        UNREAD_TEST(each_is_named_once_with_how_many_it_affects),
        UNREAD_TEST(oddities_are_told_and_the_rest_is_shown),
        UNREAD_TEST(hostile_variety_is_cut_short),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
