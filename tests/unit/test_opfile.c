/// Operator files: a file reads back as it was written, and every error in a file is reported.
#include "resolvent/opfile.h"
#include "resolvent/render.h"

#include "file_fixture.h"
#include "light_fixture.h"
#include "light_view.h"
#include "opfile/sha256.h"
#include "slow_tests.h"
#include "solve/light_internal.h"

#include <cjson/cJSON.h>

// ---- a scene with everything in it ----------------------------------------------------------------

static uint32_t add_checkers(rsv_scene *scene)
{
    static const uint8_t codes[2][2][4] = { { { 255, 60, 0, 255 }, { 20, 220, 90, 0 } },
        { { 40, 40, 250, 255 }, { 250, 250, 10, 255 } } };
    static const float values[3] = { 0.25f, 0.5f, 2.0f };
    uint32_t id;
    rsv_texture_desc checkers = { .size = sizeof checkers,
        .name = "checkers",
        .width = 2,
        .height = 2,
        .channel_count = 4,
        .codes = &codes[0][0][0],
        .srgb = true,
        .wrap_u = RSV_WRAP_MIRROR,
        .nearest = true };
    rsv_texture_desc ramp = { .size = sizeof ramp,
        .name = "ramp",
        .width = 3,
        .height = 1,
        .channel_count = 1,
        .values = values };
    assert_int_equal(rsv_scene_add_texture(scene, &ramp, NULL), RSV_OK);
    assert_int_equal(rsv_scene_add_texture(scene, &checkers, &id), RSV_OK);
    return id;
}

static uint32_t add_material(rsv_scene *scene, const char *name, rsv_rgb color, rsv_rgb emission)
{
    rsv_material m = rsv_default_material();
    uint32_t id;
    m.name = name;
    m.base_color = color;
    m.specular = 0;
    m.double_sided = true;
    m.emission = emission;
    assert_int_equal(rsv_scene_add_material(scene, &m, &id), RSV_OK);
    return id;
}

/// A square of half side `size` about `centre`, spanned by x and z or x and y.
static void add_square(rsv_scene *scene, const char *name, uint32_t material, rsv_vec3 centre,
    float size, bool upright)
{
    static const uint32_t indices[] = { 0, 1, 2, 0, 2, 3 };
    static const float uv[4][2] = { { 0, 0 }, { 3, 0 }, { 3, 3 }, { 0, 3 } };
    static const float color[4][4] = { { 1, 1, 1, 1 }, { 0.5f, 1, 1, 1 }, { 1, 1, 0.25f, 1 },
        { 1, 0.75f, 1, 1 } };
    rsv_vec3 p[4];
    for (int k = 0; k < 4; k++) {
        float x = k == 1 || k == 2 ? size : -size, y = k >= 2 ? size : -size;
        p[k] = v3_add(centre, upright ? v3(x, y, 0) : v3(x, 0, -y));
    }
    rsv_mesh_desc mesh = { .size = sizeof mesh,
        .name = name,
        .positions = p,
        .vertex_count = 4,
        .indices = indices,
        .triangle_count = 2,
        .material = material,
        .uvs = { uv, NULL },
        .colors = color };
    uint32_t id;
    assert_int_equal(rsv_scene_add_mesh(scene, &mesh, &id), RSV_OK);
    assert_int_equal(rsv_scene_add_instance(scene, id, NULL, name), RSV_OK);
}

static void add_lights(rsv_scene *scene)
{
    rsv_punctual_light light = { .name = "bulb",
        .kind = RSV_PUNCTUAL_POINT,
        .position = { 0.3f, 1.1f, 0.6f },
        .intensity = { 2, 1, 0.5f } };
    assert_int_equal(rsv_scene_add_light(scene, &light), RSV_OK);
    light.name = "spot";
    light.kind = RSV_PUNCTUAL_SPOT;
    light.direction = v3(0.1f, -1, -0.3f);
    light.inner_cone_angle = 0.3f;
    light.outer_cone_angle = 0.7f;
    light.exponent = 2;
    light.smooth_cone = true;
    assert_int_equal(rsv_scene_add_light(scene, &light), RSV_OK);
}

static void add_sky(rsv_scene *scene)
{
    rsv_rgb pixels[8 * 4];
    for (int k = 0; k < 32; k++)
        pixels[k] = rgb(0.1f + 0.01f * (float)k, 0.2f, 0.3f);
    pixels[11] = rgb(90, 80, 70);
    rsv_environment sky = { .name = "sky \"quoted\"",
        .pixels = pixels,
        .width = 8,
        .height = 4,
        .intensity = 0.7f,
        .rotation = 33 };
    assert_int_equal(rsv_scene_set_environment(scene, &sky), RSV_OK);
}

/// @param sky left out where a scene is loaded over and over: preparing it takes most of the time
static world *world_of_everything(int threads, bool sky)
{
    world *w = world_begin(threads);
    rsv_material m = rsv_default_material();
    rsv_texture_ref refs[2];
    uint32_t id, checkers = add_checkers(w->scene);
    refs[0] = rsv_default_texture_ref(RSV_TEXTURE_BASE_COLOR, checkers);
    refs[1] = rsv_default_texture_ref(RSV_TEXTURE_METALLIC_ROUGHNESS, 0);
    refs[1].transform[0][2] = 0.25f;
    m.name = "tiles";
    m.roughness = 0.5f;
    m.textures = refs;
    m.texture_count = 2;
    assert_int_equal(rsv_scene_add_material(w->scene, &m, &id), RSV_OK);
    add_square(w->scene, "floor", id, v3(0, 0, 0), 1, false);
    id = add_material(w->scene, "chalk", rgb(0.7f, 0.5f, 0.4f), rgb(0, 0, 0));
    add_square(w->scene, "wall", id, v3(0, 1, -1), 1, true);
    id = add_material(w->scene, "lamp", rgb(0, 0, 0), rgb(3, 4, 5));
    add_square(w->scene, "shade", id, v3(0.4f, 1.5f, 0), 0.2f, false);
    m = rsv_default_material();
    m.name = "pane";
    m.transmission = 1;
    m.roughness = 0;
    m.attenuation_color = rgb(1, 0.5f, 0.5f);
    assert_int_equal(rsv_scene_add_material(w->scene, &m, &id), RSV_OK);
    add_square(w->scene, "window", id, v3(-0.4f, 0.5f, 0.2f), 0.3f, true);
    assert_true(rsv_material_preset("marble", &m));
    m.name = "marble";
    assert_int_equal(rsv_scene_add_material(w->scene, &m, &id), RSV_OK);
    add_square(w->scene, "slab", id, v3(0.5f, 0.3f, 0.2f), 0.2f, true);
    add_lights(w->scene);
    if (sky) add_sky(w->scene);
    rsv_camera camera = rsv_camera_look_at("front", v3(0.2f, 1, 3), v3(0, 0.6f, 0), 0.8f, 1.5f);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    camera.vertical_fov = 0;
    camera.vertical_extent = 1.25f;
    camera.name = "plan";
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    if (rsv_scene_commit(w->scene) != RSV_OK) fail_msg("%s", rsv_last_error());
    return w;
}

static rsv_light *solve(const world *w)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = 60;
    desc.rays_per_element = 64;
    desc.photon_count = UNLESS_SANITIZED(4000, 1000);
    desc.direct_levels = 1;
    rsv_light *solution;
    if (rsv_light_create(w->scene, &desc, &solution) != RSV_OK) fail_msg("%s", rsv_last_error());
    return solution;
}

// ---- round trips ----------------------------------------------------------------------------------

/// @param shared_pattern spares the light that is shot for rough lobes
static rsv_image *render(
    const rsv_light *solution, rsv_render_mode mode, uint32_t camera, bool shared_pattern)
{
    rsv_render_desc desc = rsv_default_render_desc();
    desc.mode = mode;
    desc.camera = camera;
    desc.width = 24;
    desc.height = 16;
    desc.samples = 2;
    desc.layers = true;
    desc.shared_pattern = shared_pattern;
    rsv_image *image;
    if (rsv_render(solution, &desc, &image) != RSV_OK) fail_msg("%s", rsv_last_error());
    return image;
}

static void check_same_picture(
    const rsv_light *a, const rsv_light *b, rsv_render_mode mode, uint32_t camera)
{
    rsv_image *left = render(a, mode, camera, false), *right = render(b, mode, camera, false);
    uint32_t layers = rsv_image_layer_count(left);
    assert_int_equal(rsv_image_layer_count(right), layers);
    for (uint32_t k = 0; k < layers; k++)
        assert_memory_equal(rsv_image_const_pixels(left, k), rsv_image_const_pixels(right, k),
            24 * 16 * sizeof(rsv_rgb));
    rsv_image_destroy(left);
    rsv_image_destroy(right);
}

static void check_same_probes(const rsv_light *a, const rsv_light *b)
{
    const rsv_probe probe[2] = { { { 0.1f, 0, 0.2f }, { 0, 1, 0 } },
        { { 0.4f, 0.7f, 0.3f }, { 0, 0.6f, 0.8f } } };
    rsv_probe_reading left[2], right[2];
    for (int mode = RSV_PROBE_LOOKUP; mode <= RSV_PROBE_OPERATOR; mode++) {
        assert_int_equal(
            rsv_probe_irradiance(
                a, &(rsv_probe_desc){ sizeof(rsv_probe_desc), mode, 256, 5 }, probe, 2, left),
            RSV_OK);
        assert_int_equal(
            rsv_probe_irradiance(
                b, &(rsv_probe_desc){ sizeof(rsv_probe_desc), mode, 256, 5 }, probe, 2, right),
            RSV_OK);
        assert_memory_equal(left, right, sizeof left);
    }
}

/// Saves, loads and compares pictures, probes and a file written once more.
static void check_round_trip(world *w)
{
    folder f = new_folder();
    char first[256], second[256];
    snprintf(first, sizeof first, "%s", path_in(&f, "a.safetensors"));
    snprintf(second, sizeof second, "%s", path_in(&f, "b.safetensors"));
    rsv_light *s = solve(w), *loaded;
    rsv_scene *scene;
    assert_int_equal(rsv_light_save(s, "everything", first), RSV_OK);
    assert_true(rsv_is_operator_file(first));
    if (rsv_light_load(w->context, first, &scene, &loaded) != RSV_OK)
        fail_msg("%s", rsv_last_error());
    for (uint32_t camera = 0; camera < rsv_scene_get_view(scene)->camera_count; camera++) {
        check_same_picture(s, loaded, RSV_RENDER_OPERATOR, camera);
        check_same_picture(s, loaded, RSV_RENDER_FINAL, camera);
    }
    check_same_probes(s, loaded);
    assert_string_equal(
        rsv_light_report(s)->solver_reason, rsv_light_report(loaded)->solver_reason);
    assert_true(rsv_light_report(s)->norm_inf == rsv_light_report(loaded)->norm_inf);
    assert_int_equal(rsv_light_save(loaded, "everything", second), RSV_OK);
    size_t bytes[2];
    uint8_t *a = read_bytes(first, &bytes[0]), *b = read_bytes(second, &bytes[1]);
    assert_int_equal(bytes[0], bytes[1]);
    assert_memory_equal(a, b, bytes[0]);
    free(a);
    free(b);
    rsv_light_destroy(loaded);
    rsv_scene_destroy(scene);
    rsv_light_destroy(s);
    remove_folder(f.path);
    world_end(w);
}

static void a_scene_with_everything_comes_back_bit_by_bit(void **state)
{
    (void)state;
    check_round_trip(world_of_everything(2, true));
}

static void caustics_come_back(void **state)
{
    (void)state;
    check_round_trip(world_builtin(2, "cornell-spheres"));
}

static void a_scene_that_only_shines_comes_back(void **state)
{
    (void)state;
    world *w = world_begin(1);
    rsv_material m = rsv_default_material();
    uint32_t id;
    m.unlit = true;
    assert_int_equal(rsv_scene_add_material(w->scene, &m, &id), RSV_OK);
    add_square(w->scene, "sign", id, v3(0, 0, 0), 1, true);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    check_round_trip(w);
}

static void files_do_not_depend_on_the_number_of_threads(void **state)
{
    (void)state;
    folder f = new_folder();
    uint8_t *content[2];
    size_t bytes[2];
    for (int k = 0; k < 2; k++) {
        world *w = world_of_everything(k + 1, false);
        rsv_light *s = solve(w);
        assert_int_equal(rsv_light_save(s, NULL, path_in(&f, "a.safetensors")), RSV_OK);
        content[k] = read_bytes(path_in(&f, "a.safetensors"), &bytes[k]);
        rsv_light_destroy(s);
        world_end(w);
    }
    assert_int_equal(bytes[0], bytes[1]);
    assert_memory_equal(content[0], content[1], bytes[0]);
    free(content[0]);
    free(content[1]);
    remove_folder(f.path);
}

// ---- files that are wrong -------------------------------------------------------------------------

/// A sound file in memory, and the place of its copies.
typedef struct specimen {
    world *w;
    folder f;
    char path[256];
    uint8_t *content;
    size_t bytes, header; ///< length of the JSON
} specimen;

/// What specimens are copies of: solved once for all tests, as their state.
typedef struct original {
    uint8_t *content;
    size_t bytes;
} original;

static int make_original(void **state)
{
    original *o = calloc(1, sizeof *o);
    assert_non_null(o);
    folder f = new_folder();
    const char *path = path_in(&f, "original.safetensors");
    world *w = world_of_everything(2, false);
    rsv_light *solution = solve(w);
    assert_int_equal(rsv_light_save(solution, "specimen", path), RSV_OK);
    rsv_light_destroy(solution);
    world_end(w);
    o->content = read_bytes(path, &o->bytes);
    remove_folder(f.path);
    *state = o;
    return 0;
}

static int free_original(void **state)
{
    original *o = *state;
    free(o->content);
    free(o);
    return 0;
}

static specimen new_specimen(void **state)
{
    const original *o = *state;
    specimen s = {
        .w = world_begin(2), .f = new_folder(), .content = malloc(o->bytes), .bytes = o->bytes
    };
    snprintf(s.path, sizeof s.path, "%s", path_in(&s.f, "specimen.safetensors"));
    assert_non_null(s.content);
    memcpy(s.content, o->content, o->bytes);
    write_bytes(s.path, s.content, s.bytes);
    uint64_t length;
    memcpy(&length, s.content, sizeof length);
    s.header = length;
    return s;
}

static void end_specimen(specimen *s)
{
    free(s->content);
    remove_folder(s->f.path);
    world_end(s->w);
}

static rsv_status load(const specimen *s, rsv_scene **scene, rsv_light **solution)
{
    *scene = NULL;
    *solution = NULL;
    return rsv_light_load(s->w->context, s->path, scene, solution);
}

/// Writes `content` in place of the specimen, and expects one line with the file's name and `why`.
static void check_refused(specimen *s, const void *content, size_t bytes, const char *why)
{
    rsv_scene *scene;
    rsv_light *solution;
    write_bytes(s->path, content, bytes);
    assert_int_not_equal(load(s, &scene, &solution), RSV_OK);
    assert_mentions(rsv_last_error(), s->path);
    assert_mentions(rsv_last_error(), why);
    assert_null(strchr(rsv_last_error(), '\n'));
}

/// Makes the checksum fit again.
static void sign(uint8_t *content, size_t bytes)
{
    char digits[RSV_SHA256_DIGITS + 1];
    uint8_t *place = memmem(content, bytes, "\"sha256\":\"", 10);
    assert_non_null(place);
    memset(place + 10, '0', RSV_SHA256_DIGITS);
    rsv_sha256 hash = rsv_sha256_begin();
    rsv_sha256_add(&hash, content, bytes);
    rsv_sha256_end(&hash, digits);
    memcpy(place + 10, digits, RSV_SHA256_DIGITS);
}

static void truncated_files_are_refused(void **state)
{
    specimen s = new_specimen(state);
    const size_t cuts[] = { 0, 1, 7, 8, 9, 100, s.header, s.header + 7, s.header + 8, s.header + 9,
        s.bytes / 2, s.bytes - 4, s.bytes - 1 };
    for (size_t k = 0; k < sizeof cuts / sizeof *cuts; k++)
        check_refused(&s, s.content, cuts[k], "");
    end_specimen(&s);
}

static void every_changed_byte_is_noticed(void **state)
{
    specimen s = new_specimen(state);
    for (size_t k = 0; k < 60; k++) {
        size_t at = k < 30 ? 8 + k * s.header / 30 : k * (s.bytes - 1) / 59;
        s.content[at] ^= 4;
        check_refused(&s, s.content, s.bytes, "");
        s.content[at] ^= 4;
    }
    s.content[s.bytes - 1] ^= 1;
    check_refused(&s, s.content, s.bytes, "checksum");
    end_specimen(&s);
}

/// Replaces a text of the header by one of the same length.
static void replace(specimen *s, const char *text, const char *by)
{
    uint8_t *place = memmem(s->content, s->bytes, text, strlen(text));
    assert_non_null(place);
    assert_int_equal(strlen(text), strlen(by));
    memcpy(place, by, strlen(by));
}

static void other_versions_and_formats_are_named(void **state)
{
    specimen s = new_specimen(state);
    replace(&s, "\"format_version\":\"2\"", "\"format_version\":\"9\"");
    check_refused(&s, s.content, s.bytes, "newer");
    replace(&s, "\"format_version\":\"9\"", "\"format_version\":\"0\"");
    check_refused(&s, s.content, s.bytes, "version is 0");
    replace(&s, "resolvent-operator", "resolvent-orchestr");
    check_refused(&s, s.content, s.bytes, "not an operator");
    end_specimen(&s);
}

static void check_header_refused(specimen *s, const char *header, const char *why)
{
    uint8_t content[512] = { 0 };
    uint64_t length = strlen(header);
    memcpy(content, &length, sizeof length);
    memcpy(content + 8, header, length);
    check_refused(s, content, 8 + length + 16, why); // sixteen bytes of data
}

static void foreign_files_are_refused(void **state)
{
    specimen s = new_specimen(state);
    check_header_refused(&s, "{\"w\":{\"dtype\":\"F32\",\"shape\":[2,2],\"data_offsets\":[0,16]}}",
        "not an operator");
    check_header_refused(&s, "{}", "16 follow");
    check_header_refused(&s, "[1, 2]", "not a JSON object");
    check_header_refused(&s, "{\"w\":", "not a JSON object");
    check_header_refused(
        &s, "{\"w\":{\"dtype\":\"F64\",\"shape\":[2],\"data_offsets\":[0,16]}}", "'w'");
    check_header_refused(
        &s, "{\"w\":{\"dtype\":\"F32\",\"shape\":[5],\"data_offsets\":[0,16]}}", "'w'");
    check_header_refused(
        &s, "{\"w\":{\"dtype\":\"F32\",\"shape\":[4],\"data_offsets\":[16,32]}}", "'w'");
    check_header_refused(
        &s, "{\"w\":{\"dtype\":\"F32\",\"shape\":[-4],\"data_offsets\":[0,16]}}", "'w'");
    check_header_refused(&s,
        "{\"w\":{\"dtype\":\"U8\",\"shape\":[4294967296,4294967296,16],"
        "\"data_offsets\":[0,16]}}",
        "'w'");
    check_header_refused(&s, "{\"w\":7}", "'w'");
    memset(s.content, 0xff, 8);
    check_refused(&s, s.content, s.bytes, "header");
    end_specimen(&s);
}

/// Bytes of a tensor within the specimen.
static uint8_t *tensor_bytes(const specimen *s, const cJSON *entry, size_t *bytes)
{
    const cJSON *offsets = cJSON_GetObjectItem(entry, "data_offsets");
    size_t begin = (size_t)cJSON_GetArrayItem(offsets, 0)->valuedouble;
    *bytes = (size_t)cJSON_GetArrayItem(offsets, 1)->valuedouble - begin;
    return s->content + 8 + s->header + begin;
}

static void check_poisoned(specimen *s, const char *name, size_t at, const void *by, size_t bytes)
{
    cJSON *root = cJSON_ParseWithLength((const char *)s->content + 8, s->header);
    const cJSON *entry = cJSON_GetObjectItemCaseSensitive(root, name);
    size_t length;
    uint8_t *data = tensor_bytes(s, entry, &length), kept[64];
    assert_true(length >= at + bytes && bytes <= sizeof kept);
    memcpy(kept, data + at, bytes);
    memcpy(data + at, by, bytes);
    sign(s->content, s->bytes);
    check_refused(s, s->content, s->bytes, "");
    memcpy(data + at, kept, bytes);
    cJSON_Delete(root);
}

static void indices_out_of_range_are_refused(void **state)
{
    static const char *const tensors[] = { "transport.column", "transport.tinted.column",
        "transport.row_start", "escape.row_start", "subsurface.column", "subsurface.row_start",
        "scene.triangle.vertex", "scene.triangle.material", "scene.triangle.object",
        "scene.texture_use.texture", "scene.texture_use.role", "scene.texture.wrap_u",
        "scene.light.kind", "element.cell.node", "element.face", "element.face.level",
        "element.cell.split", "element.support.start", "element.support.corner",
        "direct.hanging.parent", "direct.hanging.node", "direct.cell.node", "caustic.cell.node",
        "diffused.cell.node" };
    static const uint8_t ones[8] = { 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff };
    specimen s = new_specimen(state);
    for (size_t k = 0; k < sizeof tensors / sizeof *tensors; k++)
        check_poisoned(&s, tensors[k], 0, ones, strstr(tensors[k], "split") ? 1 : 2);
    end_specimen(&s);
}

static void numbers_that_are_none_are_refused(void **state)
{
    static const char *const tensors[] = { "transport.scale", "transport.tinted.weight",
        "transport.gathered", "subsurface.weight", "albedo", "source", "irradiance",
        "shown.indirect", "shown.order3", "direct.irradiance", "caustic.irradiance",
        "diffused.entered", "element.area", "direct.hanging.weight", "scene.vertex.position",
        "scene.vertex.normal", "scene.vertex.uv0", "scene.vertex.color", "scene.light.position",
        "scene.camera.position" };
    const float nan = NAN;
    specimen s = new_specimen(state);
    for (size_t k = 0; k < sizeof tensors / sizeof *tensors; k++)
        check_poisoned(&s, tensors[k], 0, &nan, sizeof nan);
    end_specimen(&s);
}

/// A tensor overwritten with anything: the file is refused, or gives a valid scene.
static void no_signed_content_leads_astray(void **state)
{
    specimen s = new_specimen(state);
    cJSON *root = cJSON_ParseWithLength((const char *)s.content + 8, s.header), *entry;
    rsv_random random = rsv_random_from(1, 2, 3);
    cJSON_ArrayForEach(entry, root)
    {
        if (strcmp(entry->string, "__metadata__") == 0) continue;
        size_t length;
        uint8_t *data = tensor_bytes(&s, entry, &length), kept;
        if (length == 0) continue;
        rsv_scene *scene;
        rsv_light *solution;
        size_t at = rsv_random_bits(&random) % length;
        kept = data[at];
        data[at] ^= (uint8_t)(1u << rsv_random_bits(&random) % 8);
        sign(s.content, s.bytes);
        write_bytes(s.path, s.content, s.bytes);
        if (load(&s, &scene, &solution) == RSV_OK) {
            bool of_scene = strncmp(entry->string, "scene.", 6) == 0; // all that photons know
            rsv_image_destroy(render(solution, RSV_RENDER_OPERATOR, 0, !of_scene));
            rsv_light_destroy(solution);
            rsv_scene_destroy(scene);
        }
        data[at] = kept;
    }
    cJSON_Delete(root);
    end_specimen(&s);
}

static void elements_of_another_scene_are_refused(void **state)
{
    specimen s = new_specimen(state);
    world *other = world_builtin(1, "cornell-blocks");
    rsv_scene *scene;
    rsv_light *solution, *unused;
    assert_int_equal(load(&s, &scene, &solution), RSV_OK);
    rsv_light mixed = *solution;
    mixed.view.scene.scene = other->scene;
    assert_int_equal(rsv_light_save(&mixed, "mixed", s.path), RSV_OK);
    rsv_light_destroy(solution);
    rsv_scene_destroy(scene);
    assert_int_equal(load(&s, &scene, &unused), RSV_ERROR_FORMAT);
    assert_mentions(rsv_last_error(), s.path);
    world_end(other);
    end_specimen(&s);
}

static void exhausted_memory_is_an_error(void **state)
{
    specimen s = new_specimen(state);
    rsv_scene *scene;
    rsv_light *solution = NULL;
    for (long k = 0; !solution; k += 1 + k / 10) {
        s.w->until_failure = k;
        rsv_status status = load(&s, &scene, &solution);
        s.w->until_failure = -1;
        if (status != RSV_OK) assert_null(solution);
    }
    for (long k = 0, saved = 0; !saved; k += 1 + k / 10) {
        s.w->until_failure = k;
        saved = rsv_light_save(solution, "specimen", s.path) == RSV_OK;
        s.w->until_failure = -1;
    }
    rsv_light_destroy(solution);
    rsv_scene_destroy(scene);
    end_specimen(&s);
}

static void checksums_are_sha256(void **state)
{
    (void)state;
    static const struct {
        const char *text, *digits;
    } known[] = { // FIPS 180-4, examples
        { "", "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855" },
        { "abc", "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad" },
        { "abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq",
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1" }
    };
    for (size_t k = 0; k < 6; k++) {
        char digits[RSV_SHA256_DIGITS + 1];
        rsv_sha256 hash = k < 3 ? rsv_sha256_begin() : rsv_sha256_begin_portable();
        for (const char *c = known[k % 3].text; *c; c++)
            rsv_sha256_add(&hash, c, 1);
        rsv_sha256_end(&hash, digits);
        assert_string_equal(digits, known[k % 3].digits);
    }
}

static void checksums_do_not_depend_on_the_processor(void **state)
{
    (void)state;
    uint8_t content[1000];
    for (size_t k = 0; k < sizeof content; k++)
        content[k] = (uint8_t)(k * k + 13 * k);
    for (size_t bytes = 0; bytes < sizeof content; bytes += 37) {
        char digits[2][RSV_SHA256_DIGITS + 1];
        rsv_sha256 hash[2] = { rsv_sha256_begin(), rsv_sha256_begin_portable() };
        for (int k = 0; k < 2; k++) {
            rsv_sha256_add(&hash[k], content, bytes);
            rsv_sha256_end(&hash[k], digits[k]);
        }
        assert_string_equal(digits[0], digits[1]);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest quick[] = {
        cmocka_unit_test(checksums_are_sha256),
        cmocka_unit_test(checksums_do_not_depend_on_the_processor),
        cmocka_unit_test(a_scene_with_everything_comes_back_bit_by_bit),
        cmocka_unit_test(caustics_come_back),
        cmocka_unit_test(a_scene_that_only_shines_comes_back),
        cmocka_unit_test(files_do_not_depend_on_the_number_of_threads),
        cmocka_unit_test(truncated_files_are_refused),
        cmocka_unit_test(every_changed_byte_is_noticed),
        cmocka_unit_test(other_versions_and_formats_are_named),
        cmocka_unit_test(foreign_files_are_refused),
        cmocka_unit_test(indices_out_of_range_are_refused),
        cmocka_unit_test(numbers_that_are_none_are_refused),
        cmocka_unit_test(elements_of_another_scene_are_refused),
        cmocka_unit_test(exhausted_memory_is_an_error),
    };
    const struct CMUnitTest slow[] = {
        cmocka_unit_test(no_signed_content_leads_astray),
    };
    return RUN_HALF_WITH(argc, argv, quick, slow, make_original, free_original);
}
