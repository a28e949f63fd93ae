/// Textures of other formats than 8-bit PNG and JPEG, and meshes packed by EXT_meshopt_compression.
#include "gltf_fixture.h"

#include "resolvent/image.h"
#include "scene/material_at.h"

#include <meshoptimizer.h>
#include <webp/encode.h>
#include <zlib.h>

// ---- a textured square ------------------------------------------------------------------------------

/// The unit square with a texture. @param texture content of "textures" and "images" @param material members of it
static const char *write_textured(const folder *place, const char *material, const char *texture)
{
    const float uv[8] = { 0, 0, 1, 0, 1, 1, 0, 1 };
    char rest[2048];
    sketch s = square_sketch();
    add_vectors(&s, uv, 4, 2);
    snprintf(rest, sizeof rest,
        "\"materials\":[{\"name\":\"paint\",%s}],\"meshes\":[{\"primitives\":[{\"attributes\":{"
        "\"POSITION\":0,\"TEXCOORD_0\":2},\"indices\":1,\"material\":0}]}],\"nodes\":[{\"mesh\":0}]"
        ","
        "\"samplers\":[{\"magFilter\":9728}],%s",
        material, texture);
    return write_sketch(place, &s, rest);
}

#define PAINTED "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}"
#define SHINING "\"emissiveFactor\":[1,1,1],\"emissiveTexture\":{\"index\":0}"
#define IMAGE(uri) "\"textures\":[{\"source\":0,\"sampler\":0}],\"images\":[{\"uri\":\"" uri "\"}]"
#define WEBP_IMAGE                                                                                 \
    "\"textures\":[{\"sampler\":0,\"extensions\":{\"EXT_texture_webp\":{\"source\":0}}}],"         \
    "\"images\":[{\"uri\":\"a.webp\"}],\"extensionsRequired\":[\"EXT_texture_webp\"],"             \
    "\"extensionsUsed\":[\"EXT_texture_webp\"]"

/// The material in the middle of the left (0) or right (1) half.
static rsv_material half_of(const rsv_scene *scene, int half)
{
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    for (int k = 1; k < 100; k++) {
        float u = (float)(k % 10) / 10, v = (float)(k / 10) / 10;
        const uint32_t *c = view->triangle[0];
        float x = (1 - u - v) * view->position[c[0]].x + u * view->position[c[1]].x +
                  v * view->position[c[2]].x;
        if (u + v < 1 && fabsf(x - 0.25f - 0.5f * (float)half) < 0.06f)
            return rsv_material_at(view, 0, u, v, 0);
    }
    fail_msg("no such half");
    return rsv_default_material();
}

/// The material of the square.
static const rsv_material *paint_of(const rsv_scene *scene)
{
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    return &view->material[view->triangle_material[0]];
}

static void assert_color(rsv_rgb found, float r, float g, float b, float tolerance)
{
    if (fabsf(found.r - r) > tolerance || fabsf(found.g - g) > tolerance ||
        fabsf(found.b - b) > tolerance)
        fail_msg("(%g %g %g), not (%g %g %g)", (double)found.r, (double)found.g, (double)found.b,
            (double)r, (double)g, (double)b);
}

/// The texture is left out, and a warning says so.
static void assert_left_out(fixture *f, const char *path, const char *mentioned)
{
    f->log[0] = '\0';
    rsv_scene *scene = load(f, path);
    assert_int_equal(paint_of(scene)->texture_count, 0);
    assert_mentions(f->log, mentioned);
    rsv_scene_destroy(scene);
}

// ---- WebP ---------------------------------------------------------------------------------------------

/// Two pixels: red and opaque, green and half transparent.
static size_t write_webp(const folder *place, bool has_alpha, uint8_t **bytes)
{
    static const uint8_t rgba[8] = { 255, 0, 0, 255, 0, 255, 0, 128 };
    static const uint8_t rgb_only[6] = { 255, 0, 0, 0, 255, 0 };
    size_t count = has_alpha ? WebPEncodeLosslessRGBA(rgba, 2, 1, 8, bytes)
                             : WebPEncodeLosslessRGB(rgb_only, 2, 1, 6, bytes);
    assert_true(count > 0);
    write_bytes(path_in(place, "a.webp"), *bytes, count);
    return count;
}

static void webp_textures_are_laid_on(void **state)
{
    folder place = new_folder();
    for (int has_alpha = 0; has_alpha < 2; has_alpha++) {
        uint8_t *bytes;
        write_webp(&place, has_alpha, &bytes);
        rsv_scene *scene =
            load(*state, write_textured(&place, PAINTED ",\"alphaMode\":\"BLEND\"", WEBP_IMAGE));
        assert_color(half_of(scene, 0).base_color, 1, 0, 0, 1e-4f);
        assert_color(half_of(scene, 1).base_color, 0, 1, 0, 1e-4f);
        assert_float_equal(half_of(scene, 1).opacity, has_alpha ? 128 / 255.0 : 1, 1e-4);
        rsv_scene_destroy(scene);
        WebPFree(bytes);
    }
    remove_folder(place.path);
}

static void a_picture_beside_webp_is_for_others(void **state)
{
    folder place = new_folder();
    uint8_t *bytes;
    write_webp(&place, false, &bytes);
    fixture *f = *state;
    const char *path = write_textured(&place, PAINTED,
        "\"textures\":[{\"source\":1,\"sampler\":0,\"extensions\":{\"EXT_texture_webp\":{"
        "\"source\":"
        "0}}}],\"images\":[{\"uri\":\"a.webp\"},{\"uri\":\"none.png\"}],\"extensionsUsed\":["
        "\"EXT_texture_webp\"]");
    f->log[0] = '\0';
    rsv_scene *scene = load(f, path);
    assert_color(half_of(scene, 0).base_color, 1, 0, 0, 1e-4f);
    assert_null(strstr(f->log, "warning"));
    rsv_scene_destroy(scene);
    WebPFree(bytes);
    remove_folder(place.path);
}

static void broken_webp_leaves_the_factor(void **state)
{
    folder place = new_folder();
    uint8_t *bytes;
    size_t count = write_webp(&place, true, &bytes);
    const char *path = write_textured(&place, PAINTED, WEBP_IMAGE);
    char kept[256];
    snprintf(kept, sizeof kept, "%s", path);
    for (size_t length = 0; length + 4 < count; length++) {
        write_bytes(path_in(&place, "a.webp"), bytes, length);
        assert_left_out(*state, kept, length ? "cannot read 'a.webp'" : "a.webp");
    }
    // 16383 x 16383 pixels of 40 bytes: the 14 bits after the signature, in each of the places where the head has them
    for (size_t at = 12; at + 4 < count; at++) {
        uint8_t saved[4];
        memcpy(saved, bytes + at, 4);
        memset(bytes + at, 0xff, 4);
        write_bytes(path_in(&place, "a.webp"), bytes, count);
        rsv_scene *scene = load(*state, kept); // whatever it shows, it loads
        rsv_scene_destroy(scene);
        memcpy(bytes + at, saved, 4);
    }
    WebPFree(bytes);
    remove_folder(place.path);
}

// ---- 16 bits ------------------------------------------------------------------------------------------

static void put32(uint8_t *to, uint32_t value)
{
    for (int k = 0; k < 4; k++)
        to[k] = (uint8_t)(value >> (24 - 8 * k));
}

static size_t put_chunk(uint8_t *to, const char *type, const uint8_t *data, uint32_t bytes)
{
    put32(to, bytes);
    memcpy(to + 4, type, 4);
    if (bytes) memcpy(to + 8, data, bytes);
    put32(to + 8 + bytes, (uint32_t)crc32(0, to + 4, 4 + bytes));
    return 12 + bytes;
}

/// A PNG of 2 x 1 grey pixels of 16 bits.
static void write_png16(const folder *place, uint16_t left, uint16_t right)
{
    uint8_t row[5] = { 0, (uint8_t)(left >> 8), (uint8_t)left, (uint8_t)(right >> 8),
        (uint8_t)right };
    uint8_t head[13] = { 0, 0, 0, 2, 0, 0, 0, 1, 16, 0, 0, 0, 0 }, packed[64], png[256];
    uLongf packed_bytes = sizeof packed;
    assert_int_equal(compress(packed, &packed_bytes, row, sizeof row), Z_OK);
    memcpy(png, "\x89PNG\r\n\x1a\n", 8);
    size_t at = 8;
    at += put_chunk(png + at, "IHDR", head, sizeof head);
    at += put_chunk(png + at, "IDAT", packed, (uint32_t)packed_bytes);
    at += put_chunk(png + at, "IEND", NULL, 0);
    write_bytes(path_in(place, "deep.png"), png, at);
}

/// Coats use their own map, or that of the surface below if the file says so, or none.
static void coats_have_the_normals_that_files_say(void **state)
{
    static const struct {
        const char *coat;
        size_t textures;
        bool own;
    } cases[] = { { "\"clearcoatFactor\":1", 1, true },
        { "\"clearcoatFactor\":1,\"clearcoatNormalTexture\":{\"index\":0}", 2, false },
        { "\"clearcoatFactor\":1,\"clearcoatNormalTexture\":{\"index\":0,\"scale\":0.5}", 2, true },
        { "\"clearcoatFactor\":0,\"clearcoatNormalTexture\":{\"index\":0}", 1, false } };
    fixture *f = *state;
    folder place = new_folder();
    write_png16(&place, 0x8000, 0x8000);
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        char material[512];
        snprintf(material, sizeof material,
            "\"normalTexture\":{\"index\":0},\"extensions\":{\"KHR_materials_clearcoat\":{%s}}",
            cases[k].coat);
        f->log[0] = '\0';
        rsv_scene *scene = load(f, write_textured(&place, material, IMAGE("deep.png")));
        assert_int_equal(paint_of(scene)->texture_count, cases[k].textures);
        assert_int_equal(rsv_coat_has_own_normals(paint_of(scene)), cases[k].own);
        assert_null(strstr(f->log, "coat"));
        rsv_scene_destroy(scene);
    }
    remove_folder(place.path);
}

static double srgb(double code)
{
    return code <= 0.04045 ? code / 12.92 : pow((code + 0.055) / 1.055, 2.4);
}

/// 16-bit values between two 8-bit values are not rounded to either of them.
static void sixteen_bits_are_not_rounded_to_eight(void **state)
{
    folder place = new_folder();
    write_png16(&place, 300, 40000);
    rsv_scene *scene = load(*state, write_textured(&place, PAINTED, IMAGE("deep.png")));
    float left = (float)srgb(300 / 65535.0), right = (float)srgb(40000 / 65535.0);
    assert_color(half_of(scene, 0).base_color, left, left, left, 1e-6f);
    assert_color(half_of(scene, 1).base_color, right, right, right, 1e-6f);
    rsv_scene_destroy(scene);
    scene =
        load(*state, write_textured(&place,
                         "\"pbrMetallicRoughness\":{\"metallicRoughnessTexture\":{\"index\":0}}",
                         IMAGE("deep.png")));
    assert_float_equal(half_of(scene, 1).roughness, 40000 / 65535.0, 1e-6); // no colour, no curve
    rsv_scene_destroy(scene);
    remove_folder(place.path);
}

// ---- radiance -----------------------------------------------------------------------------------------

static void pictures_of_radiance_are_linear(void **state)
{
    static const char *const names[] = { "light.exr", "light.hdr" };
    static const char *const textures[] = { IMAGE("light.exr"), IMAGE("light.hdr") };
    fixture *f = *state;
    folder place = new_folder();
    rsv_image *image;
    assert_int_equal(rsv_image_create(f->context, 2, 1, 1, &image), RSV_OK);
    rsv_image_pixels(image, 0)[0] = rgb(0.25f, 0.5f, 0.125f);
    rsv_image_pixels(image, 0)[1] = rgb(8, 4, 16);
    for (size_t k = 0; k < 2; k++) {
        assert_int_equal(rsv_image_write(image, path_in(&place, names[k]), 0), RSV_OK);
        rsv_scene *scene = load(f, write_textured(&place, SHINING, textures[k]));
        assert_color(half_of(scene, 0).emission, 0.25f, 0.5f, 0.125f, 2e-3f);
        assert_color(half_of(scene, 1).emission, 8, 4, 16, 0.1f);
        rsv_scene_destroy(scene);
        scene = load(f, write_textured(&place, PAINTED, textures[k]));
        assert_color(half_of(scene, 0).base_color, 0.25f, 0.5f, 0.125f, 2e-3f);
        assert_color(half_of(scene, 1).base_color, 1, 1, 1, 1e-5f); // nothing reflects more
        rsv_scene_destroy(scene);
    }
    rsv_image_destroy(image);
    remove_folder(place.path);
}

// ---- textures of other scene formats --------------------------------------------------------------

/// "marks.png": left red, right green; "grey.png": left black, right half.
static void write_marks(fixture *f, const folder *place)
{
    rsv_image *image;
    assert_int_equal(rsv_image_create(f->context, 8, 1, 1, &image), RSV_OK);
    rsv_rgb *pixel = rsv_image_pixels(image, 0);
    for (int k = 0; k < 8; k++)
        pixel[k] = k < 4 ? rgb(1, 0, 0) : rgb(0, 1, 0);
    assert_int_equal(rsv_image_write(image, path_in(place, "marks.png"), 0), RSV_OK);
    for (int k = 0; k < 8; k++)
        pixel[k] = rgb_gray(k < 4 ? 0 : 0.2158605f); // code 128 of 255
    assert_int_equal(rsv_image_write(image, path_in(place, "grey.png"), 0), RSV_OK);
    rsv_image_destroy(image);
}

/// The unit square as .obj under a library of one material, "paint".
static const char *write_obj(const folder *place, const char *material)
{
    static const char square[] =
        "mtllib m.mtl\nusemtl paint\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 "
        "1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n";
    char library[512];
    int length = snprintf(library, sizeof library, "newmtl paint\n%s", material);
    write_bytes(path_in(place, "m.mtl"), library, (size_t)length);
    write_bytes(path_in(place, "square.obj"), square, sizeof square - 1);
    return path_in(place, "square.obj");
}

static void textures_of_obj_multiply_its_colours(void **state)
{
    fixture *f = *state;
    folder place = new_folder();
    write_marks(f, &place);
    rsv_scene *scene = load(f, write_obj(&place, "Kd 0.5 0.25 1\nmap_Kd marks.png\n"));
    assert_color(half_of(scene, 0).base_color, 0.5f, 0, 0, 1e-3f);
    assert_color(half_of(scene, 1).base_color, 0, 0.25f, 0, 1e-3f);
    rsv_scene_destroy(scene);
    scene = load(f, write_obj(&place, "Kd 1 1 1\nmap_d grey.png\n"));
    assert_float_equal(half_of(scene, 0).opacity, 0, 1e-3);
    assert_float_equal(half_of(scene, 1).opacity, 128 / 255.0, 1e-3);
    rsv_scene_destroy(scene);
    scene = load(f, write_obj(&place, "Kd 0 0 0\nKe 0 0 0\nmap_Ke marks.png\n"));
    assert_color(half_of(scene, 0).emission, 1, 0, 0, 1e-3f);
    assert_false(paint_of(scene)->double_sided);
    rsv_scene_destroy(scene);
    remove_folder(place.path);
}

/// Grey pictures of roughness and metal say nothing of each other; the exponent's is that of its largest value.
static void maps_of_obj_tell_roughness_metal_and_highlights(void **state)
{
    fixture *f = *state;
    folder place = new_folder();
    write_marks(f, &place);
    const float grey = 128 / 255.0f;
    rsv_scene *scene =
        load(f, write_obj(&place, "Kd 1 1 1\nPr 0.5\nPm 1\nmap_Pr grey.png\nmap_Pm grey.png\n"));
    assert_float_equal(half_of(scene, 0).roughness, 0, 1e-3);
    assert_float_equal(half_of(scene, 1).roughness, 0.5f * grey, 1e-3);
    assert_float_equal(half_of(scene, 1).metallic, grey, 1e-3);
    rsv_scene_destroy(scene);
    scene = load(f, write_obj(&place, "Kd 1 1 1\nKs 1 1 1\nNs 200\nmap_Ns grey.png\n"));
    assert_float_equal(half_of(scene, 0).roughness, 1, 1e-3);
    assert_float_equal(half_of(scene, 1).roughness, pow(2 / (200 * (double)grey + 2), 0.25), 2e-3);
    rsv_scene_destroy(scene);
    scene = load(f, write_obj(&place, "Kd 1 1 1\nNs 10\nmap_Ks marks.png\n"));
    assert_color(half_of(scene, 1).specular_color, 0, 1, 0, 1e-3f);
    assert_float_equal(half_of(scene, 1).specular, 1, 1e-6);
    rsv_scene_destroy(scene);
    remove_folder(place.path);
}

/// What Blender calls a bump map is a normal map; that of other programs holds heights.
static void bump_maps_that_hold_normals_are_normal_maps(void **state)
{
    fixture *f = *state;
    folder place = new_folder();
    rsv_image *image;
    write_marks(f, &place);
    assert_int_equal(rsv_image_create(f->context, 1, 1, 1, &image), RSV_OK);
    rsv_image_pixels(image, 0)[0] = rgb(0.2158605f, 0.2158605f, 1);
    assert_int_equal(rsv_image_write(image, path_in(&place, "up.png"), 0), RSV_OK);
    rsv_image_destroy(image);
    rsv_scene *scene = load(f, write_obj(&place, "Kd 1 1 1\nmap_Bump -bm 0.5 up.png\n"));
    assert_int_equal(paint_of(scene)->textures[0].role, RSV_TEXTURE_NORMAL);
    assert_float_equal(paint_of(scene)->textures[0].scale, 0.5, 1e-6);
    rsv_scene_destroy(scene);
    assert_left_out(f, write_obj(&place, "Kd 1 1 1\nmap_Bump grey.png\n"),
        "'grey.png' is left out: it holds heights, not normals");
    remove_folder(place.path);
}

/// The sockets of a Principled BSDF, as the exporter turns them into Phong's terms: roughness 0.3, metallic 1 and 0.75,
/// specular 0.5, which is an index of refraction of 1.5.
static void obj_of_blender_is_read_as_blender_means_it(void **state)
{
    fixture *f = *state;
    folder place = new_folder();
    write_marks(f, &place);
    static const char rest[] = "mtllib m.mtl\nusemtl paint\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
                               "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n";
    static const char *const head[] = { "# Blender 3.4.1\n", "# Blender v2.93.0 OBJ File: ''\n" };
    static const char *const shininess[] = { "Ns 490\n", "Ns 441\n" };
    for (int k = 0; k < 2; k++) {
        char text[1024];
        snprintf(text, sizeof text,
            "%sKa 0.75 0.75 0.75\nKd 0.5 0.5 0.5\nKs 0.5 0.5 0.5\nillum 3\n", shininess[k]);
        const char *path = write_obj(&place, text);
        int length = snprintf(text, sizeof text, "%s%s", head[k], rest);
        write_bytes(path, text, (size_t)length);
        rsv_scene *scene = load(f, path);
        assert_float_equal(paint_of(scene)->roughness, 0.3, 1e-5);
        assert_float_equal(paint_of(scene)->metallic, 0.75, 1e-6);
        assert_float_equal(paint_of(scene)->ior, 1.5, 1e-6);
        assert_color(paint_of(scene)->base_color, 0.5f, 0.5f, 0.5f, 0);
        rsv_scene_destroy(scene);
        write_obj(&place, "illum 9\nNi 1.45\nd 0.5\nmap_Ns grey.png\nmap_refl grey.png\n"
                          "map_Kd marks.png\n");
        write_bytes(path, text, (size_t)length);
        scene = load(f, path);
        assert_float_equal(half_of(scene, 1).roughness, 128 / 255.0, 1e-3);
        assert_float_equal(half_of(scene, 1).metallic, 128 / 255.0, 1e-3);
        assert_color(half_of(scene, 1).base_color, 0, 1, 0, 1e-3f);
        assert_float_equal(paint_of(scene)->opacity, 0.5, 0);
        assert_float_equal(paint_of(scene)->transmission, 0, 0);
        rsv_scene_destroy(scene);
    }
    remove_folder(place.path);
}

/// Windows paths, and paths of another computer, lead to the file of that name next to the scene.
static void textures_are_found_beside_the_scene(void **state)
{
    static const char *const names[] = { "marks.png", "./marks.png", "C:\\my work\\tex\\marks.png",
        "/home/somebody/marks.png", "sub\\marks.png" };
    fixture *f = *state;
    folder place = new_folder();
    write_marks(f, &place);
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        char material[256];
        snprintf(material, sizeof material, "Kd 1 1 1\nmap_Kd %s\n", names[k]);
        rsv_scene *scene = load(f, write_obj(&place, material));
        assert_color(half_of(scene, 0).base_color, 1, 0, 0, 1e-3f);
        rsv_scene_destroy(scene);
    }
    remove_folder(place.path);
}

static void textures_that_cannot_be_read_are_named(void **state)
{
    fixture *f = *state;
    folder place = new_folder();
    write_bytes(path_in(&place, "torn.png"), "\x89PNG\r\n\x1a\n", 8);
    const char *path = write_obj(&place, "Kd 1 1 1\nmap_Kd torn.png\nmap_Ke none.png\n");
    assert_left_out(f, path, "material 'paint': its texture 'torn.png' is left out: cannot read");
    assert_mentions(f->log, "'none.png' is left out: there is no such file");
    path = write_obj(&place, "Kd 1 1 1\ndisp torn.png\nrefl torn.png\n");
    assert_left_out(f, path, "textures that are not used: displacement");
    assert_mentions(f->log, "statements that are not used: 'refl'");
    remove_folder(place.path);
}

// ---- meshopt ------------------------------------------------------------------------------------------

/// Writes a square with compressed positions and indices.
/// @param views JSON of the buffer views; %zu twice: offset and length of the indices' data
typedef struct packed_square {
    uint8_t data[1024];
    size_t vertex_bytes, bytes;
} packed_square;

static packed_square pack_square(bool as_sequence)
{
    static const float corner[12] = { 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0 };
    static const unsigned index[6] = { 0, 1, 2, 0, 2, 3 };
    packed_square p;
    p.vertex_bytes = meshopt_encodeVertexBuffer(p.data, sizeof p.data, corner, 4, 12);
    uint8_t *rest = p.data + p.vertex_bytes;
    size_t left = sizeof p.data - p.vertex_bytes;
    p.bytes = p.vertex_bytes + (as_sequence ? meshopt_encodeIndexSequence(rest, left, index, 6)
                                            : meshopt_encodeIndexBuffer(rest, left, index, 6));
    assert_true(p.bytes > p.vertex_bytes);
    return p;
}

/// What a file says of its packed parts.
typedef struct claims {
    int vertex_count, vertex_stride, index_count, index_stride;
    const char *mode, *index_mode, *filter;
    size_t index_length; ///< 0 = as it is
} claims;

static const claims true_claims = { 4, 12, 6, 2, "ATTRIBUTES", "TRIANGLES", "NONE", 0 };

static const char *write_packed(const folder *place, const packed_square *p, claims c)
{
    static char text[4096];
    size_t length = c.index_length ? c.index_length : p->bytes - p->vertex_bytes;
    write_bytes(path_in(place, "packed.bin"), p->data, p->bytes);
    int count = snprintf(text, sizeof text,
        "{\"asset\":{\"version\":\"2.0\"},\"extensionsRequired\":[\"EXT_meshopt_compression\"],"
        "\"extensionsUsed\":[\"EXT_meshopt_compression\"],"
        "\"buffers\":[{\"uri\":\"packed.bin\",\"byteLength\":%zu},{\"byteLength\":60,"
        "\"extensions\":{"
        "\"EXT_meshopt_compression\":{\"fallback\":true}}}],\"bufferViews\":["
        "{\"buffer\":1,\"byteLength\":48,\"byteStride\":12,\"extensions\":{\"EXT_meshopt_"
        "compression\":"
        "{\"buffer\":0,\"byteLength\":%zu,\"byteStride\":%d,\"count\":%d,\"mode\":\"%s\","
        "\"filter\":"
        "\"%s\"}}},"
        "{\"buffer\":1,\"byteOffset\":48,\"byteLength\":12,\"extensions\":{\"EXT_meshopt_"
        "compression\":"
        "{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu,\"byteStride\":%d,\"count\":%d,"
        "\"mode\":"
        "\"%s\"}}}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"
        "{\"bufferView\":1,\"componentType\":%d,\"count\":6,\"type\":\"SCALAR\"}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}],"
        "\"nodes\":[{\"mesh\":0}]}",
        p->bytes, p->vertex_bytes, c.vertex_stride, c.vertex_count, c.mode, c.filter,
        p->vertex_bytes, length, c.index_stride, c.index_count, c.index_mode,
        c.index_stride == 4 ? 5125 : 5123);
    const char *path = path_in(place, "packed.gltf");
    write_bytes(path, text, (size_t)count);
    return path;
}

static void packed_views_are_unpacked(void **state)
{
    folder place = new_folder();
    for (int sequence = 0; sequence < 2; sequence++)
        for (int stride = 2; stride <= 4; stride += 2) {
            const packed_square p = pack_square(sequence);
            claims c = true_claims;
            c.index_stride = stride;
            if (sequence) c.index_mode = "INDICES";
            fixture *f = *state;
            f->log[0] = '\0';
            rsv_scene *scene = load(f, write_packed(&place, &p, c));
            assert_bounds(scene, v3(0, 0, 0), v3(1, 1, 0));
            assert_int_equal(rsv_scene_get_view(scene)->triangle_count, 2);
            assert_null(strstr(f->log, "meshopt"));
            rsv_scene_destroy(scene);
        }
    remove_folder(place.path);
}

/// Filters change places in a way that another reader would, too: a float of 24 bits of mantissa and 8 of exponent.
static void filters_are_applied(void **state)
{
    static const float corner[12] = { 0, 0, 0, 2, 0, 0, 2, 0.5f, 0, 0, 0.5f, 0 };
    folder place = new_folder();
    packed_square p = pack_square(false);
    uint8_t coded[48], indices[256];
    size_t index_bytes = p.bytes - p.vertex_bytes;
    memcpy(indices, p.data + p.vertex_bytes, index_bytes);
    meshopt_encodeFilterExp(coded, 4, 12, 15, corner);
    p.vertex_bytes = meshopt_encodeVertexBuffer(p.data, 512, coded, 4, 12);
    memcpy(p.data + p.vertex_bytes, indices, index_bytes);
    p.bytes = p.vertex_bytes + index_bytes;
    claims c = true_claims;
    c.filter = "EXPONENTIAL";
    rsv_scene *scene = load(*state, write_packed(&place, &p, c));
    assert_bounds(scene, v3(0, 0, 0), v3(2, 0.5f, 0));
    rsv_scene_destroy(scene);
    remove_folder(place.path);
}

static void lying_claims_are_refused(void **state)
{
    static const struct {
        claims claims;
        const char *mentioned;
    } cases[] = {
        { { 2000000000, 12, 6, 2, "ATTRIBUTES", "TRIANGLES", "NONE", 0 }, "do not fit in" },
        { { 4, 12, 2000000001, 2, "ATTRIBUTES", "TRIANGLES", "NONE", 0 }, "do not fit in" },
        { { 4, 13, 6, 2, "ATTRIBUTES", "TRIANGLES", "NONE", 0 }, "byteStride" },
        { { 4, 0, 6, 2, "ATTRIBUTES", "TRIANGLES", "NONE", 0 }, "byteStride" },
        { { 4, 260, 6, 2, "ATTRIBUTES", "TRIANGLES", "NONE", 0 }, "byteStride" },
        { { 4, 12, 6, 3, "ATTRIBUTES", "TRIANGLES", "NONE", 0 }, "byteStride" },
        { { 4, 12, 5, 2, "ATTRIBUTES", "TRIANGLES", "NONE", 0 }, "count" },
        { { 4, 12, 9, 2, "ATTRIBUTES", "TRIANGLES", "NONE", 0 }, "damaged" },
        { { 4, 12, 6, 2, "POINTS", "TRIANGLES", "NONE", 0 }, "mode" },
        { { 4, 12, 6, 2, "ATTRIBUTES", "TRIANGLES", "SINE", 0 }, "filter" },
        { { 4, 12, 6, 2, "ATTRIBUTES", "TRIANGLES", "OCTAHEDRAL", 0 }, "filter" },
        { { 4, 12, 6, 2, "ATTRIBUTES", "TRIANGLES", "QUATERNION", 0 }, "filter" },
        { { 4, 12, 6, 2, "ATTRIBUTES", "TRIANGLES", "NONE", 100000 }, "past the end" },
        { { 4, 12, 6, 2, "ATTRIBUTES", "INDICES", "NONE", 0 }, "damaged" },
        { { 3, 12, 6, 2, "ATTRIBUTES", "TRIANGLES", "NONE", 0 }, "past" },
    };
    folder place = new_folder();
    const packed_square p = pack_square(false);
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        rsv_scene *scene = NULL;
        fixture *f = *state;
        const char *path = write_packed(&place, &p, cases[k].claims);
        if (rsv_scene_load(f->context, path, &scene) == RSV_OK) fail_msg("case %zu is read", k);
        assert_null(strchr(rsv_last_error(), '\n'));
        if (k + 1 < sizeof cases / sizeof *cases)
            assert_mentions(rsv_last_error(), cases[k].mentioned);
    }
    remove_folder(place.path);
}

/// Truncated or changed anywhere, it is rejected or read, and does no harm.
static void damaged_packed_data_do_no_harm(void **state)
{
    folder place = new_folder();
    fixture *f = *state;
    const packed_square whole = pack_square(false);
    for (size_t k = 0; k < whole.bytes; k++) {
        packed_square p = whole;
        rsv_scene *scene = NULL;
        p.data[k] ^= (uint8_t)(0x5a + k);
        if (rsv_scene_load(f->context, write_packed(&place, &p, true_claims), &scene) == RSV_OK)
            rsv_scene_destroy(scene);
    }
    for (size_t cut = 1; cut < whole.bytes - whole.vertex_bytes; cut++) {
        claims c = true_claims;
        rsv_scene *scene = NULL;
        c.index_length = cut;
        if (rsv_scene_load(f->context, write_packed(&place, &whole, c), &scene) == RSV_OK)
            rsv_scene_destroy(scene);
    }
    remove_folder(place.path);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, fixture_setup, fixture_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(webp_textures_are_laid_on),
        TEST(a_picture_beside_webp_is_for_others),
        TEST(broken_webp_leaves_the_factor),
        TEST(sixteen_bits_are_not_rounded_to_eight),
        TEST(pictures_of_radiance_are_linear),
        TEST(textures_of_obj_multiply_its_colours),
        TEST(coats_have_the_normals_that_files_say),
        TEST(maps_of_obj_tell_roughness_metal_and_highlights),
        TEST(bump_maps_that_hold_normals_are_normal_maps),
        TEST(obj_of_blender_is_read_as_blender_means_it),
        TEST(textures_are_found_beside_the_scene),
        TEST(textures_that_cannot_be_read_are_named),
        TEST(packed_views_are_unpacked),
        TEST(filters_are_applied),
        TEST(lying_claims_are_refused),
        TEST(damaged_packed_data_do_no_harm),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
