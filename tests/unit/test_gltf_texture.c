/// Images in glTF files: where they can be stored, how they are applied, and how bad ones are reported.
#include "file_fixture.h"

#include "resolvent/image.h"
#include "resolvent/io.h"
#include "scene/material_at.h"

/// A square with texture coordinates and colours, as base64 of: 4 positions, 4 texture coordinates (float), and
/// 6 indices (16-bit).
#define SQUARE_BUFFER                                                                              \
    "\"buffers\":[{\"byteLength\":92,\"uri\":\"data:application/octet-stream;base64,"              \
    "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAAAAAAAAAAgD8AAAAA"                             \
    "AAAAAAAAgD8AAIA/AACAPwAAgD8AAAAAAAAAAAAAAAAAAAEAAgAAAAIAAwA=\"}],"                            \
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},"                                           \
    "{\"buffer\":0,\"byteOffset\":48,\"byteLength\":32},"                                          \
    "{\"buffer\":0,\"byteOffset\":80,\"byteLength\":12}],"                                         \
    "\"accessors\":["                                                                              \
    "{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\","                      \
    "\"min\":[0,0,0],\"max\":[1,1,0]},"                                                            \
    "{\"bufferView\":1,\"componentType\":5126,\"count\":4,\"type\":\"VEC2\"},"                     \
    "{\"bufferView\":2,\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"}],"                  \
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1},"              \
    "\"indices\":2,\"material\":0}]}],\"nodes\":[{\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}],"      \
    "\"scene\":0,\"asset\":{\"version\":\"2.0\"}"

/// Writes "scene.gltf": the square with a material, and the members in `rest`.
static const char *write_scene(const folder *at, const char *material, const char *rest)
{
    static char text[4096];
    int length = snprintf(text, sizeof text, "{%s,\"materials\":[{\"name\":\"paint\",%s}],%s}",
        SQUARE_BUFFER, material, rest);
    const char *path = path_in(at, "scene.gltf");
    write_bytes(path, text, (size_t)length);
    return path;
}

#define TEXTURED "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}"
#define ONE_IMAGE(uri) "\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"" uri "\"}]"

/// Writes a PNG of one row, left black, right white.
static void write_picture(fixture *f, const folder *at, const char *name)
{
    rsv_image *image;
    assert_int_equal(rsv_image_create(f->context, 2, 1, 1, &image), RSV_OK);
    rsv_image_pixels(image, 0)[1] = rgb_gray(1);
    assert_int_equal(rsv_image_write(image, path_in(at, name), 0), RSV_OK);
    rsv_image_destroy(image);
}

static rsv_scene *load(fixture *f, const char *path)
{
    rsv_scene *scene = NULL;
    if (rsv_scene_load(f->context, path, &scene) != RSV_OK) fail_msg("%s", rsv_last_error());
    return scene;
}

/// Base colour in the middle of the left and of the right half of the square.
static void assert_halves(const rsv_scene *scene, float left, float right)
{
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    assert_float_equal(rsv_material_at(view, 1, 0.25f, 0.5f, 0).base_color.g, left, 1e-3);
    assert_float_equal(rsv_material_at(view, 0, 0.7f, 0.05f, 0).base_color.g, right, 1e-3);
}

static void picture_beside_the_file_is_laid_on(void **state)
{
    fixture *f = *state;
    folder at = new_folder();
    write_picture(f, &at, "stripes.png");
    rsv_scene *scene = load(f, write_scene(&at, TEXTURED, ONE_IMAGE("stripes.png")));
    assert_halves(scene, 0, 1);
    rsv_scene_destroy(scene);
    remove_folder(at.path);
}

static void texture_transform_moves_and_turns(void **state)
{
    fixture *f = *state;
    folder at = new_folder();
    write_picture(f, &at, "stripes.png");
    const char *mirrored = "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0,"
                           "\"extensions\":{\"KHR_texture_transform\":{\"offset\":[1,0],"
                           "\"scale\":[-1,1]}}}}";
    rsv_scene *scene = load(f, write_scene(&at, mirrored, ONE_IMAGE("stripes.png")));
    assert_halves(scene, 1, 0);
    rsv_scene_destroy(scene);
    // a quarter turn counter-clockwise: u is read where v was, v downwards
    const char *turned = "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0,"
                         "\"extensions\":{\"KHR_texture_transform\":{"
                         "\"rotation\":1.5707963267948966}}}}";
    scene = load(f, write_scene(&at, turned, ONE_IMAGE("stripes.png")));
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    // bottom of the square has v = 1, its top v = 0
    assert_float_equal(rsv_material_at(view, 0, 0.4f, 0.25f, 0).base_color.g, 1, 1e-3);
    assert_float_equal(rsv_material_at(view, 1, 0.4f, 0.35f, 0).base_color.g, 0, 1e-3);
    rsv_scene_destroy(scene);
    remove_folder(at.path);
}

/// Loads a scene whose picture is bad, and expects a warning and the factor alone.
static void check_left_out(fixture *f, const folder *at, const char *rest, const char *complaint)
{
    f->log[0] = 0;
    rsv_scene *scene = load(f, write_scene(at,
                                   "\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,0.25,0.5,1],"
                                   "\"baseColorTexture\":{\"index\":0}}",
                                   rest));
    assert_mentions(f->log, "warning: material 'paint': texture 0");
    assert_mentions(f->log, complaint);
    assert_mentions(f->log, "the factor alone is used");
    assert_int_equal(rsv_scene_get_view(scene)->texture_count, 0);
    assert_halves(scene, 0.25f, 0.25f);
    rsv_scene_destroy(scene);
}

static void pictures_that_cannot_be_read_leave_the_factor(void **state)
{
    fixture *f = *state;
    folder at = new_folder();
    static const char text[] = "this is no picture";
    write_bytes(path_in(&at, "text.png"), text, sizeof text);
    check_left_out(f, &at, ONE_IMAGE("absent.png"), "'absent.png': it is missing");
    check_left_out(f, &at, ONE_IMAGE("../../../etc/hostname"), "it is missing");
    check_left_out(f, &at, ONE_IMAGE("text.png"), "cannot read 'text.png'");
    check_left_out(f, &at, "\"textures\":[{\"source\":7}]", "no PNG or JPEG image");
    check_left_out(f, &at, "\"textures\":[{}]", "no PNG or JPEG image");
    check_left_out(f, &at, "\"images\":[]", "texture 0 does not exist");
    remove_folder(at.path);
}

static void pictures_in_buffers_must_lie_inside_them(void **state)
{
    fixture *f = *state;
    folder at = new_folder();
    check_left_out(f, &at,
        "\"textures\":[{\"source\":0}],\"images\":[{\"bufferView\":0,\"mimeType\":\"image/png\"}]",
        "cannot read 'image 0'");
    remove_folder(at.path);
}

/// A PNG's checksum (ISO 3309).
static uint32_t crc(const uint8_t *bytes, size_t count)
{
    uint32_t c = UINT32_MAX;
    for (size_t i = 0; i < count; i++) {
        c ^= bytes[i];
        for (int bit = 0; bit < 8; bit++)
            c = c >> 1 ^ (c & 1 ? 0xedb88320u : 0);
    }
    return ~c;
}

static void put_word(uint8_t *to, uint32_t value)
{
    for (int k = 0; k < 4; k++)
        to[k] = (uint8_t)(value >> (24 - 8 * k));
}

/// Changes the size that a PNG says it has.
static void resize_png(const char *path, uint32_t width, uint32_t height)
{
    size_t bytes;
    uint8_t *png = read_bytes(path, &bytes);
    put_word(png + 16, width);
    put_word(png + 20, height);
    put_word(png + 29, crc(png + 12, 17));
    write_bytes(path, png, bytes);
    free(png);
}

static void implausible_sizes_are_refused_before_memory_is_taken(void **state)
{
    fixture *f = *state;
    folder at = new_folder();
    write_picture(f, &at, "bomb.png");
    resize_png(path_in(&at, "bomb.png"), 16000, 16000);
    check_left_out(f, &at, ONE_IMAGE("bomb.png"), "16000 x 16000 pixels do not fit in");
    resize_png(path_in(&at, "bomb.png"), 100000, 1);
    check_left_out(f, &at, ONE_IMAGE("bomb.png"), "100000 x 1 pixels are not in 1 .. 16384");
    remove_folder(at.path);
}

static void cut_pictures_are_left_out(void **state)
{
    fixture *f = *state;
    folder at = new_folder();
    write_picture(f, &at, "whole.png");
    size_t bytes;
    uint8_t *png = read_bytes(path_in(&at, "whole.png"), &bytes);
    for (size_t length = 1; length < bytes - 16; length += 5) {
        write_bytes(path_in(&at, "cut.png"), png, length);
        check_left_out(f, &at, ONE_IMAGE("cut.png"), "cannot read 'cut.png'");
    }
    free(png);
    remove_folder(at.path);
}

static void extensions_set_what_they_name(void **state)
{
    fixture *f = *state;
    folder at = new_folder();
    rsv_scene *scene = load(f,
        write_scene(&at,
            "\"alphaMode\":\"BLEND\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,1,0.25]},"
            "\"extensions\":{"
            "\"KHR_materials_clearcoat\":{\"clearcoatFactor\":0.5,\"clearcoatRoughnessFactor\":0.1}"
            ","
            "\"KHR_materials_sheen\":{\"sheenColorFactor\":[0.1,0.2,0.3],"
            "\"sheenRoughnessFactor\":0.4},"
            "\"KHR_materials_diffuse_transmission\":{\"diffuseTransmissionFactor\":0.6,"
            "\"diffuseTransmissionColorFactor\":[0.7,0.8,0.9]},"
            "\"KHR_materials_coat\":{}},"
            "\"extras\":{\"resolvent\":{\"scatter_distance\":[0.001,0.002,0.003],"
            "\"camera_emission\":0.25}}",
            "\"textures\":[]"));
    const rsv_material *m = &rsv_scene_get_view(scene)->material[0];
    assert_float_equal(m->opacity, 0.25f, 0);
    assert_float_equal(m->clearcoat, 0.5f, 0);
    assert_float_equal(m->clearcoat_roughness, 0.1f, 0);
    assert_float_equal(m->sheen_color.b, 0.3f, 0);
    assert_float_equal(m->sheen_roughness, 0.4f, 0);
    assert_float_equal(m->diffuse_transmission, 0.6f, 0);
    assert_float_equal(m->diffuse_transmission_color.g, 0.8f, 0);
    assert_float_equal(m->scatter_distance.g, 0.002f, 0);
    assert_float_equal(m->camera_emission, 0.25f, 0);
    assert_mentions(f->log, "extension 'KHR_materials_coat' is ignored: material 'paint'");

    // what is written is read back
    assert_int_equal(rsv_scene_save(scene, path_in(&at, "again.glb")), RSV_OK);
    rsv_scene *again = load(f, path_in(&at, "again.glb"));
    const rsv_material *n = &rsv_scene_get_view(again)->material[0];
    assert_float_equal(n->opacity, 0.25f, 0);
    assert_float_equal(n->clearcoat, 0.5f, 0);
    assert_float_equal(n->sheen_color.b, 0.3f, 0);
    assert_float_equal(n->diffuse_transmission, 0.6f, 0);
    assert_float_equal(n->scatter_distance.g, 0.002f, 0);
    assert_float_equal(n->camera_emission, 0.25f, 0);
    rsv_scene_destroy(again);
    rsv_scene_destroy(scene);
    remove_folder(at.path);
}

static void alpha_counts_where_the_mode_says_so(void **state)
{
    fixture *f = *state;
    folder at = new_folder();
    const struct {
        const char *mode;
        float opacity, cutoff;
    } expected[] = {
        { "\"OPAQUE\"", 1, 0 },
        { "\"MASK\"", 0.25f, 0.5f },
        { "\"MASK\",\"alphaCutoff\":0.125", 1, 0.125f }, // what is there is opaque
        { "\"MASK\",\"alphaCutoff\":0", 1, 0 },          // nothing is below 0
        { "\"BLEND\"", 0.25f, 0 },
    };
    for (size_t k = 0; k < sizeof expected / sizeof *expected; k++) {
        char material[256];
        snprintf(material, sizeof material,
            "\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,1,0.25]},\"alphaMode\":%s",
            expected[k].mode);
        rsv_scene *scene = load(f, write_scene(&at, material, "\"textures\":[]"));
        const rsv_material *m = &rsv_scene_get_view(scene)->material[0];
        assert_float_equal(m->opacity, expected[k].opacity, 0);
        assert_float_equal(m->alpha_cutoff, expected[k].cutoff, 0);
        rsv_scene_destroy(scene);
    }
    remove_folder(at.path);
}

static void sample_assets_load(void **state)
{
    fixture *f = *state;
    static const char *const names[] = { "AlphaBlendModeTest.glb", "BoxTextured.glb",
        "Duck_draco/Duck.gltf", "Duck_quantized/Duck.gltf",
        "SimpleSparseAccessor/SimpleSparseAccessor.gltf", "TextureSettingsTest.glb",
        "TriangleWithoutIndices/TriangleWithoutIndices.gltf", "VertexColorTest.glb" };
    char path[512];
    const char *assets = getenv("RSV_ASSETS");
    snprintf(path, sizeof path, "%s/gltf", assets ? assets : "");
    if (!assets || access(path, R_OK) != 0) {
        print_message("skipped: no sample assets in RSV_ASSETS\n");
        skip();
    }
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        snprintf(path, sizeof path, "%s/gltf/%s", assets, names[k]);
        rsv_scene_destroy(load(f, path));
    }
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, fixture_setup, fixture_teardown)
    const struct CMUnitTest tests[] = {
        TEST(picture_beside_the_file_is_laid_on),
        TEST(texture_transform_moves_and_turns),
        TEST(pictures_that_cannot_be_read_leave_the_factor),
        TEST(pictures_in_buffers_must_lie_inside_them),
        TEST(implausible_sizes_are_refused_before_memory_is_taken),
        TEST(cut_pictures_are_left_out),
        TEST(extensions_set_what_they_name),
        TEST(alpha_counts_where_the_mode_says_so),
        TEST(sample_assets_load),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
