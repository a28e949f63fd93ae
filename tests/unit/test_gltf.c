/// glTF: written files are read back; every encoding that the format allows; hostile and broken files.
#include "gltf_fixture.h"
#include "slow_tests.h"

// ---- write and read back --------------------------------------------------------------------------

static void assert_close(float a, float b)
{
    if (a == b) return; // also infinities
    assert_true(fabsf(a - b) <= 4e-7f * fmaxf(1e-3f, fmaxf(fabsf(a), fabsf(b))));
}

static void assert_close3(rsv_vec3 a, rsv_vec3 b)
{
    assert_true(v3_max_abs(v3_sub(a, b)) <= 4e-7f * fmaxf(1, v3_max_abs(a)));
}

static void assert_close_rgb(rsv_rgb a, rsv_rgb b)
{
    assert_close(a.r, b.r);
    assert_close(a.g, b.g);
    assert_close(a.b, b.b);
}

static void assert_same_material(const rsv_material *a, const rsv_material *b)
{
    assert_string_equal(a->name, b->name);
    assert_close_rgb(a->base_color, b->base_color);
    assert_close(a->metallic, b->metallic);
    assert_close(a->roughness, b->roughness);
    assert_int_equal(a->double_sided, b->double_sided);
    assert_int_equal(a->unlit, b->unlit);
    if (a->unlit) return; // the rest has no meaning
    assert_close(a->ior, b->ior);
    assert_close(a->specular, b->specular);
    assert_close_rgb(a->specular_color, b->specular_color);
    assert_close(a->transmission, b->transmission);
    assert_close(a->thickness, b->thickness);
    assert_close_rgb(a->attenuation_color, b->attenuation_color);
    assert_close(a->attenuation_distance, b->attenuation_distance);
    assert_close_rgb(a->emission, b->emission);
}

static void assert_same_light(const rsv_punctual_light *a, const rsv_punctual_light *b)
{
    assert_string_equal(a->name, b->name);
    assert_int_equal(a->kind, b->kind);
    assert_close_rgb(a->intensity, b->intensity);
    if (a->kind != RSV_PUNCTUAL_DIRECTIONAL) assert_close3(a->position, b->position);
    if (a->kind != RSV_PUNCTUAL_POINT) assert_close3(a->direction, b->direction);
    if (a->kind != RSV_PUNCTUAL_SPOT) return;
    assert_close(a->inner_cone_angle, b->inner_cone_angle);
    assert_close(a->outer_cone_angle, b->outer_cone_angle);
    assert_true(a->smooth_cone == b->smooth_cone);
    assert_close(a->exponent, b->exponent);
}

static void assert_same_camera(const rsv_camera *a, const rsv_camera *b)
{
    assert_string_equal(a->name, b->name);
    assert_close3(a->position, b->position);
    assert_close3(a->right, b->right);
    assert_close3(a->up, b->up);
    assert_close3(a->forward, b->forward);
    assert_close(a->vertical_fov, b->vertical_fov);
    assert_close(a->vertical_extent, b->vertical_extent);
    assert_close(a->aspect, b->aspect);
}

static void assert_same_view(const rsv_scene_view *a, const rsv_scene_view *b)
{
    assert_int_equal(a->vertex_count, b->vertex_count);
    assert_int_equal(a->triangle_count, b->triangle_count);
    assert_int_equal(a->object_count, b->object_count);
    assert_memory_equal(a->position, b->position, a->vertex_count * sizeof *a->position);
    assert_memory_equal(a->triangle, b->triangle, a->triangle_count * sizeof *a->triangle);
    assert_memory_equal(
        a->triangle_object, b->triangle_object, a->triangle_count * sizeof(uint32_t));
    assert_memory_equal(
        a->triangle_material, b->triangle_material, a->triangle_count * sizeof(uint32_t));
    for (size_t i = 0; i < a->vertex_count; i++)
        assert_close3(a->normal[i], b->normal[i]);
    for (size_t i = 0; i < a->object_count; i++)
        assert_string_equal(a->object_name[i], b->object_name[i]);
    assert_int_equal(a->material_count, b->material_count);
    for (size_t i = 0; i < a->material_count; i++)
        assert_same_material(&a->material[i], &b->material[i]);
    assert_int_equal(a->light_count, b->light_count);
    for (size_t i = 0; i < a->light_count; i++)
        assert_same_light(&a->light[i], &b->light[i]);
    assert_int_equal(a->camera_count, b->camera_count);
    for (size_t i = 0; i < a->camera_count; i++)
        assert_same_camera(&a->camera[i], &b->camera[i]);
}

static void assert_survives_the_file(fixture *f, const rsv_scene *scene)
{
    folder place = new_folder();
    const char *path = path_in(&place, "scene.glb");
    if (rsv_scene_save(scene, path) != RSV_OK) fail_msg("%s", rsv_last_error());
    rsv_scene *copy = load(f, path);
    assert_same_view(rsv_scene_get_view(scene), rsv_scene_get_view(copy));
    rsv_scene_destroy(copy);
    remove_folder(place.path);
}

static void builtin_scenes_survive_the_file(void **state)
{
    fixture *f = *state;
    for (const char *const *name = rsv_scene_builtin_names(); *name; name++) {
        rsv_scene *scene = NULL;
        assert_int_equal(rsv_scene_builtin(f->context, *name, &scene), RSV_OK);
        assert_survives_the_file(f, scene);
        if (rsv_scene_get_view(scene)->fog) {
            assert_mentions(f->log, "fog is not written");
            f->log[0] = 0;
        }
        rsv_scene_destroy(scene);
        // its light is the environment, which the caller chooses
        if (strcmp(*name, "character") == 0) f->log[0] = 0;
    }
    assert_string_equal(f->log, "");
}

static void add_odd_materials(rsv_scene *scene)
{
    rsv_material m = rsv_default_material();
    m.name = "glass \"and\" \\ more: \xc3\xa9";
    m.base_color = rgb(0.1f, 0.2f, 0.3f);
    m.roughness = 0;
    m.ior = 1.33f;
    m.transmission = 0.9f;
    m.thickness = 0.25f;
    m.attenuation_color = rgb(0.9f, 0.5f, 0.1f);
    m.attenuation_distance = 0.7f;
    m.double_sided = true;
    assert_int_equal(rsv_scene_add_material(scene, &m, NULL), RSV_OK);
    m = rsv_default_material();
    m.name = "lamp";
    m.specular = 0.3f;
    m.specular_color = rgb(1, 0.5f, 0.25f);
    m.emission = rgb(17, 12, 4);
    assert_int_equal(rsv_scene_add_material(scene, &m, NULL), RSV_OK);
    m.name = "dim lamp";
    m.emission = rgb(0.3f, 0.2f, 0);
    assert_int_equal(rsv_scene_add_material(scene, &m, NULL), RSV_OK);
    m.name = "sign";
    m.unlit = true;
    assert_int_equal(rsv_scene_add_material(scene, &m, NULL), RSV_OK);
    m = rsv_default_material();
    m.name = "gold";
    m.metallic = 1;
    m.attenuation_color = rgb(0.5f, 0.5f, 0.5f);
    assert_int_equal(rsv_scene_add_material(scene, &m, NULL), RSV_OK);
}

static void add_lights_and_cameras(rsv_scene *scene)
{
    const rsv_punctual_light lights[] = {
        { .name = "point",
            .kind = RSV_PUNCTUAL_POINT,
            .position = { 1, 2, 3 },
            .intensity = { 3, 2, 1 } },
        { .name = "spot",
            .kind = RSV_PUNCTUAL_SPOT,
            .position = { 0.1f, 2, 3 },
            .direction = { 0.6f, -0.8f, 0 },
            .intensity = { 0.5f, 0.5f, 2 },
            .inner_cone_angle = 0.3f,
            .outer_cone_angle = RSV_PI / 2,
            .exponent = 2.5f },
        { .name = "smooth",
            .kind = RSV_PUNCTUAL_SPOT,
            .position = { 1, 2, 3 },
            .direction = { 0, -1, 0 },
            .intensity = { 1, 2, 3 },
            .inner_cone_angle = 0.2f,
            .outer_cone_angle = 0.9f,
            .smooth_cone = true },
        { .name = "sun",
            .kind = RSV_PUNCTUAL_DIRECTIONAL,
            .direction = { 0, -1, 0 },
            .intensity = { 1e5f, 9e4f, 8e4f } },
        { .name = "off", .kind = RSV_PUNCTUAL_POINT },
    };
    for (size_t i = 0; i < sizeof lights / sizeof *lights; i++)
        assert_int_equal(rsv_scene_add_light(scene, &lights[i]), RSV_OK);
    rsv_camera camera = rsv_camera_look_at("free", v3(1, 2, 3), v3(0, 0.3f, 0), 0.7f, 0);
    assert_int_equal(rsv_scene_add_camera(scene, &camera), RSV_OK);
    camera = rsv_camera_look_at("plan", v3(0, 9, 0), v3(0, 0, 0), 0, 1.5f);
    camera.vertical_extent = 3;
    assert_int_equal(rsv_scene_add_camera(scene, &camera), RSV_OK);
}

static void every_material_light_and_camera_survives_the_file(void **state)
{
    fixture *f = *state;
    rsv_scene *scene = NULL;
    assert_int_equal(rsv_scene_create(f->context, &scene), RSV_OK);
    add_odd_materials(scene);
    add_lights_and_cameras(scene);
    const rsv_vec3 position[4] = { { 0, 0, 0 }, { 0.1f, 0, 0 }, { 0, 0.7f, 0 },
        { 0, 0, 1.0f / 3 } };
    const rsv_vec3 normal[4] = { { -1, -1, -1 }, { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } };
    const uint32_t index[12] = { 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3 };
    const float mirror[16] = { -1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 0, 3, 0, 0, 1 };
    for (uint32_t material = 0; material < 5; material++) {
        rsv_mesh_desc mesh = { .size = sizeof mesh,
            .name = "body",
            .positions = position,
            .normals = material % 2 ? normal : NULL,
            .vertex_count = 4,
            .indices = index,
            .triangle_count = 4,
            .material = material };
        uint32_t id;
        assert_int_equal(rsv_scene_add_mesh(scene, &mesh, &id), RSV_OK);
        assert_int_equal(rsv_scene_add_instance(scene, id, NULL, NULL), RSV_OK);
        assert_int_equal(rsv_scene_add_instance(scene, id, mirror, "twin"), RSV_OK);
    }
    assert_int_equal(rsv_scene_commit(scene), RSV_OK);
    assert_survives_the_file(f, scene);
    rsv_scene_destroy(scene);
}

static void the_writer_leaves_nothing_half_written(void **state)
{
    fixture *f = *state;
    rsv_scene *scene = NULL;
    assert_int_equal(rsv_scene_create(f->context, &scene), RSV_OK);
    assert_int_equal(rsv_scene_save(scene, "/tmp/never.glb"), RSV_ERROR_ARGUMENT);
    rsv_scene_destroy(scene);
    assert_int_equal(rsv_scene_builtin(f->context, "furnace", &scene), RSV_OK);
    assert_int_equal(rsv_scene_save(scene, "/nonexistent/folder/x.glb"), RSV_ERROR_IO);
    assert_mentions(rsv_last_error(), "/nonexistent/folder");
    folder place = new_folder();
    f->allocations_left = 0;
    assert_int_equal(rsv_scene_save(scene, path_in(&place, "x.glb")), RSV_ERROR_MEMORY);
    f->allocations_left = SIZE_MAX;
    assert_int_equal(access(path_in(&place, "x.glb"), F_OK), -1);
    remove_folder(place.path);
    rsv_scene_destroy(scene);
}

static uint32_t word_at(const uint8_t *p)
{
    return p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static void chunks_are_aligned_and_add_up(void **state)
{
    fixture *f = *state;
    rsv_scene *scene = NULL;
    folder place = new_folder();
    const char *path = path_in(&place, "scene.glb");
    assert_int_equal(rsv_scene_builtin(f->context, "two-rooms", &scene), RSV_OK);
    assert_int_equal(rsv_scene_save(scene, path), RSV_OK);
    size_t bytes;
    uint8_t *data = read_bytes(path, &bytes);
    uint32_t json_bytes = word_at(data + 12);
    assert_memory_equal(data, "glTF\2\0\0\0", 8);
    assert_int_equal(word_at(data + 8), bytes);
    assert_int_equal(json_bytes % 4, 0);
    assert_memory_equal(data + 16, "JSON{", 5);
    assert_memory_equal(data + 20 + json_bytes + 4, "BIN\0", 4);
    assert_int_equal(20 + json_bytes + 8 + word_at(data + 20 + json_bytes), bytes);
    free(data);
    remove_folder(place.path);
    rsv_scene_destroy(scene);
}

/// glTF knows media inside bodies alone, and no light from all around.
static void fog_and_environments_are_said_to_be_left_out(void **state)
{
    fixture *f = *state;
    rsv_scene *scene = NULL;
    folder place = new_folder();
    rsv_fog fog = rsv_default_fog();
    fog.extinction = rgb_gray(1);
    assert_int_equal(rsv_scene_builtin(f->context, "furnace", &scene), RSV_OK);
    assert_int_equal(rsv_scene_set_fog(scene, &fog), RSV_OK);
    assert_int_equal(rsv_scene_set_builtin_environment(scene, "white", 1, 0), RSV_OK);
    assert_int_equal(rsv_scene_save(scene, path_in(&place, "scene.glb")), RSV_OK);
    assert_mentions(f->log, "scene.glb: the scene's fog is not written");
    assert_mentions(f->log, "scene.glb: the scene's environment is not written");
    remove_folder(place.path);
    rsv_scene_destroy(scene);
}

// ---- encodings ------------------------------------------------------------------------------------

/// One buffer view over everything, accessor 0 the square, and one mesh in one node.
static void one_mesh(
    char *text, size_t capacity, const buffer *b, const char *accessors, const char *primitive)
{
    snprintf(text, capacity,
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":%zu}],\"accessors\":[{\"bufferView\":0,"
        "\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"}%s],\"meshes\":[{\"name\":\"square\","
        "\"primitives\":[{\"attributes\":{\"POSITION\":0}%s}]}],\"nodes\":[{\"mesh\":0}]",
        b->bytes, accessors, primitive);
}

static float total_area(const rsv_scene_view *view)
{
    float area = 0;
    for (size_t t = 0; t < view->triangle_count; t++) {
        const uint32_t *c = view->triangle[t];
        rsv_vec3 a = view->position[c[0]];
        area += 0.5f * v3_length(v3_cross(
                           v3_sub(view->position[c[1]], a), v3_sub(view->position[c[2]], a)));
        assert_true(geometric_normal(view, t).z > 0.99f); // counter-clockwise throughout
    }
    return area;
}

static void assert_shows_square(fixture *f, const char *path)
{
    rsv_scene *scene = load(f, path);
    assert_int_equal(rsv_scene_get_view(scene)->triangle_count, 2);
    assert_float_equal(total_area(rsv_scene_get_view(scene)), 1, 1e-6f);
    rsv_scene_destroy(scene);
}

static void every_index_type_is_read(void **state)
{
    folder place = new_folder();
    const uint8_t narrow[6] = { 0, 1, 2, 0, 2, 3 };
    for (int component = 5121; component <= 5125; component += 2) {
        buffer b = square_buffer();
        size_t size = component == 5121 ? 1 : component == 5123 ? 2 : 4, offset = b.bytes;
        for (int i = 0; i < 6; i++)
            append_bytes(&b, (const uint8_t[4]){ narrow[i] }, size);
        char accessor[256], rest[2048];
        snprintf(accessor, sizeof accessor,
            ",{\"bufferView\":0,\"byteOffset\":%zu,\"componentType\":%d,\"count\":6,\"type\":"
            "\"SCALAR\"}",
            offset, component);
        one_mesh(rest, sizeof rest, &b, accessor, ",\"indices\":1");
        assert_shows_square(*state, write_gltf(&place, &b, rest));
    }
    remove_folder(place.path);
}

static void strips_and_fans_become_triangles(void **state)
{
    folder place = new_folder();
    const uint8_t strip[4] = { 0, 1, 3, 2 };
    for (int mode = 5; mode <= 6; mode++) {
        buffer b = square_buffer();
        size_t offset = append_bytes(&b, strip, 4);
        char accessor[256], rest[2048], primitive[64];
        snprintf(accessor, sizeof accessor,
            ",{\"bufferView\":0,\"byteOffset\":%zu,\"componentType\":5121,\"count\":4,\"type\":"
            "\"SCALAR\"}",
            offset);
        snprintf(
            primitive, sizeof primitive, ",\"mode\":%d%s", mode, mode == 5 ? ",\"indices\":1" : "");
        one_mesh(rest, sizeof rest, &b, accessor, primitive);
        assert_shows_square(*state, write_gltf(&place, &b, rest));
    }
    remove_folder(place.path);
}

static void points_and_lines_are_skipped(void **state)
{
    fixture *f = *state;
    folder place = new_folder();
    buffer b = square_buffer();
    char rest[2048];
    one_mesh(rest, sizeof rest, &b, "", ",\"mode\":1");
    assert_refused(f, write_gltf(&place, &b, rest), RSV_ERROR_SCENE, "no triangles");
    assert_mentions(f->log, "mesh 'square': points and lines are skipped");
    remove_folder(place.path);
}

static void quantized_strided_and_sparse_positions_are_read(void **state)
{
    folder place = new_folder();
    buffer b = { .bytes = 0 };
    // three corners of the square as normalised bytes, 4 apart; the second comes from the sparse part
    const int8_t corner[12] = { 0, 0, 0, 0, 0, 0, 0, 0, 127, 127, 0, 0 };
    const int8_t replacement[4] = { 127, 0, 0, 0 };
    const uint16_t replaced[2] = { 1, 0 };
    append_bytes(&b, corner, sizeof corner);
    append_bytes(&b, replacement, sizeof replacement);
    append_bytes(&b, replaced, sizeof replaced);
    const char *path = write_gltf(&place, &b,
        "\"extensionsRequired\":[\"KHR_mesh_quantization\"],\"bufferViews\":["
        "{\"buffer\":0,\"byteLength\":12,\"byteStride\":4},"
        "{\"buffer\":0,\"byteOffset\":12,\"byteLength\":4},"
        "{\"buffer\":0,\"byteOffset\":16,\"byteLength\":4}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5120,\"normalized\":true,\"count\":3,"
        "\"type\":\"VEC3\",\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":2,\"componentType\":"
        "5123},"
        "\"values\":{\"bufferView\":1}}}],\"meshes\":[{\"primitives\":[{\"attributes\":{"
        "\"POSITION\":0}}]}],"
        "\"nodes\":[{\"mesh\":0}]");
    rsv_scene *scene = load(*state, path);
    assert_float_equal(total_area(rsv_scene_get_view(scene)), 0.5f, 1e-6f);
    rsv_scene_destroy(scene);
    remove_folder(place.path);
}

static void transforms_compose_down_the_tree(void **state)
{
    fixture *f = *state;
    folder place = new_folder();
    buffer b = square_buffer();
    char rest[4096], head[2048];
    one_mesh(head, sizeof head, &b, "", "");
    *strstr(head, ",\"nodes\"") = 0;
    // a quarter turn about z, then a shift; the mesh is used by two nodes, mirrored in one of them
    snprintf(rest, sizeof rest,
        "%s,\"nodes\":[{\"name\":\"root\",\"translation\":[10,0,0],\"rotation\":[0,0,0.70710678,"
        "0.70710678],\"children\":[1,2,3]},{\"name\":\"a\",\"mesh\":0,\"scale\":[2,2,2]},"
        "{\"name\":\"b\",\"mesh\":0,\"matrix\":[-1,0,0,0,0,1,0,0,0,0,1,0,0,0,5,1]},"
        "{\"name\":\"eye\",\"camera\":0,\"scale\":[3,3,3]},{\"name\":\"elsewhere\",\"mesh\":0}],"
        "\"scenes\":[{\"nodes\":[4]},{\"nodes\":[0]}],\"scene\":1,"
        "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.5,\"znear\":1}}],"
        "\"extensionsUsed\":[\"KHR_lights_punctual\"]",
        head);
    rsv_scene *scene = load(f, write_gltf(&place, &b, rest));
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    assert_int_equal(view->object_count, 2);
    assert_string_equal(view->object_name[0], "a");
    assert_string_equal(view->object_name[1], "b");
    assert_close3(view->bounds_min, v3(8, -1, 0));
    assert_close3(view->bounds_max, v3(10, 2, 5));
    assert_float_equal(view->normal[view->vertex_count - 1].z, 1, 1e-6f);
    assert_string_equal(view->camera[0].name, "eye"); // the camera itself has no name
    assert_close3(view->camera[0].right, v3(0, 1, 0));
    assert_close3(view->camera[0].forward, v3(0, 0, -1));
    rsv_scene_destroy(scene);
    remove_folder(place.path);
}

static void percent_encoded_names_are_decoded(void **state)
{
    fixture *f = *state;
    folder place = new_folder();
    buffer b = square_buffer();
    char rest[2048];
    one_mesh(rest, sizeof rest, &b, "", ",\"mode\":6");
    const char *path = write_gltf(&place, &b, rest);
    size_t bytes;
    char *text = (char *)read_bytes(path, &bytes), changed[4096];
    text[bytes] = 0;
    char *name = strstr(text, "shape.bin");
    snprintf(changed, sizeof changed, "%.*ssub/a%%20b.bin%s", (int)(name - text), text, name + 9);
    free(text);
    assert_int_equal(mkdir(path_in(&place, "sub"), 0700), 0);
    write_bytes(path_in(&place, "sub/a b.bin"), b.data, b.bytes);
    path = path_in(&place, "encoded.gltf");
    write_bytes(path, changed, strlen(changed));
    assert_shows_square(f, path);
    remove_folder(place.path);
}

static void data_uris_are_read(void **state)
{
    folder place = new_folder();
    // one float triangle: (0,0,0) (1,0,0) (0,1,0)
    const char *text =
        "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":36,\"uri\":"
        "\"data:application/"
        "octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"accessors\":[{\"bufferView\":0,"
        "\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],\"meshes\":[{\"primitives\":[{"
        "\"attributes\":{\"POSITION\":0}}]}],\"nodes\":[{\"mesh\":0}]}";
    const char *path = path_in(&place, "data.gltf");
    write_bytes(path, text, strlen(text));
    rsv_scene *scene = load(*state, path);
    assert_float_equal(total_area(rsv_scene_get_view(scene)), 0.5f, 1e-6f);
    rsv_scene_destroy(scene);
    remove_folder(place.path);
}

/// A unit square packed by Draco, as base64: what stands between the two may break it.
#define PACKED_SQUARE(first, rest)                                                                 \
    "{\"asset\":{\"version\":\"2.0\"},\"extensionsRequired\":[\"KHR_draco_mesh_compression\"],"    \
    "\"buffers\":[{\"byteLength\":114,\"uri\":\"data:application/octet-stream;base64," first       \
    "Q08CAgEBAAAABAIBAgAAAR//ARH/AREC/wAAAAAAAQAJAwAAAgEBCQMAAQMBAQEAAwMBMAEQAwAogpgA"             \
    "AAAAAP8AAAAAAAAAAAAAAAAAAAAAAIA/CAADAQEBgAEBOP/3AQgDAJiE/"                                    \
    "wAAAH8AAAAI\"}],\"bufferViews\":[{\"buffer\":0,"                                              \
    "\"byteLength\":114}],\"accessors\":[{\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"}" \
    ","                                                                                            \
    "{\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},{\"componentType\":5126,\"count\":4,"  \
    "\"type\":\"VEC3\"}],\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"indices\":0,"    \
    "\"attributes\":{\"POSITION\":1,\"NORMAL\":2},\"extensions\":{\"KHR_draco_mesh_compression\":" \
    "{" rest "}}}]}]}"

static void packed_meshes_are_unpacked(void **state)
{
    folder place = new_folder();
    const char *text =
        PACKED_SQUARE("RFJB", "\"bufferView\":0,\"attributes\":{\"POSITION\":0,\"NORMAL\":1}");
    const char *path = path_in(&place, "packed.gltf");
    write_bytes(path, text, strlen(text));
    rsv_scene *scene = load(*state, path);
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    assert_int_equal(view->vertex_count, 4);
    assert_float_equal(total_area(view), 1, 1e-6f);
    for (int k = 0; k < 4; k++)
        assert_close3(view->normal[k], v3(0, 0, 1));
    rsv_scene_destroy(scene);
    remove_folder(place.path);
}

static void broken_packed_meshes_are_refused(void **state)
{
    static const struct {
        const char *text, *mentioned;
    } broken[] = {
        { PACKED_SQUARE("AAAA", "\"bufferView\":0,\"attributes\":{\"POSITION\":0}"),
            "cannot be unpacked" },
        { PACKED_SQUARE("RFJB", "\"bufferView\":7,\"attributes\":{\"POSITION\":0}"),
            "names no buffer view" },
        { PACKED_SQUARE("RFJB", "\"bufferView\":0,\"attributes\":{\"POSITION\":5}"),
            "not among its packed data" },
        { PACKED_SQUARE("RFJB", "\"bufferView\":0"), "names no attributes" },
    };
    folder place = new_folder();
    const char *path = path_in(&place, "broken.gltf");
    for (size_t k = 0; k < sizeof broken / sizeof *broken; k++) {
        write_bytes(path, broken[k].text, strlen(broken[k].text));
        assert_refused(*state, path, RSV_ERROR_FORMAT, broken[k].mentioned);
    }
    remove_folder(place.path);
}

// ---- hostile files --------------------------------------------------------------------------------

static void buffers_outside_the_folder_are_refused(void **state)
{
    folder place = new_folder();
    char outside[256];
    snprintf(outside, sizeof outside, "%s-outside.bin", place.path);
    buffer b = square_buffer();
    write_bytes(outside, b.data, b.bytes);
    const char *const uri[3] = { "../%s", "%%2e%%2e/%s", "x/../../%s" };
    for (int i = 0; i < 3; i++) {
        char name[256], text[1024];
        snprintf(name, sizeof name, uri[i], strrchr(outside, '/') + 1);
        snprintf(text, sizeof text,
            "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"uri\":\"%s\",\"byteLength\":%zu}]}",
            name, b.bytes);
        const char *path = path_in(&place, "escape.gltf");
        write_bytes(path, text, strlen(text));
        assert_refused(*state, path, RSV_ERROR_IO, "asset's folder");
    }
    unlink(outside);
    remove_folder(place.path);
}

static void bad_references_are_named(void **state)
{
    fixture *f = *state;
    const struct {
        const char *accessors, *primitive, *message;
        rsv_status status;
    } cases[] = {
        { "", ",\"material\":7", "mesh 'square': material 7", RSV_ERROR_FORMAT },
        { "", ",\"indices\":9", "mesh 'square': accessor 9 does not exist", RSV_ERROR_FORMAT },
        { ",{\"bufferView\":0,\"componentType\":5121,\"count\":400,\"type\":\"SCALAR\"}",
            ",\"indices\":1", "mesh 'square': accessor 1 reaches past the end", RSV_ERROR_FORMAT },
        { ",{\"bufferView\":0,\"componentType\":5125,\"count\":4611686018427387904,\"type\":"
          "\"SCALAR\"}",
            ",\"indices\":1", "accessor 1 reaches past the end", RSV_ERROR_FORMAT },
        { ",{\"bufferView\":0,\"byteOffset\":14,\"componentType\":5121,\"count\":3,\"type\":"
          "\"SCALAR\"}",
            ",\"indices\":1", "mesh 'square': accessor 1: index 0 refers to vertex 128",
            RSV_ERROR_FORMAT },
        { ",{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"SCALAR\"}",
            ",\"indices\":1", "mesh 'square': accessor 1 must hold", RSV_ERROR_FORMAT },
    };
    folder place = new_folder();
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        buffer b = square_buffer();
        char rest[2048];
        one_mesh(rest, sizeof rest, &b, cases[i].accessors, cases[i].primitive);
        assert_refused(f, write_gltf(&place, &b, rest), cases[i].status, cases[i].message);
    }
    remove_folder(place.path);
}

static void broken_documents_are_refused(void **state)
{
    const struct {
        const char *text, *message;
        rsv_status status;
    } cases[] = {
        { "", "holds no JSON: it is empty", RSV_ERROR_FORMAT },
        { "{\"asset\":", "its JSON ends in the middle", RSV_ERROR_FORMAT },
        { "{\"asset\":\n {\"version\" \"2.0\"}}", "its JSON is broken near line 2, column 17",
            RSV_ERROR_FORMAT },
        { "[1,2,3,4]", "no JSON object", RSV_ERROR_FORMAT },
        { "glTF\2\0\0\0", "", RSV_ERROR_FORMAT },
        { "{\"asset\":{\"version\":\"2.0\"},\"extensionsRequired\":[\"EXT_lights_image_based\"]}",
            "'EXT_lights_image_based'", RSV_ERROR_UNSUPPORTED },
        { "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[3]}]}", "node 3 does not exist",
            RSV_ERROR_FORMAT },
        { "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{}],\"scene\":-7}", "default scene -7",
            RSV_ERROR_FORMAT },
        { "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"mesh\":-2}]}", "mesh -2 does not exist",
            RSV_ERROR_FORMAT },
        { "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"camera\":1}]}", "camera 1 does not exist",
            RSV_ERROR_FORMAT },
        { "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"name\":\"n\",\"matrix\":[1,2]}]}",
            "matrix of node 'n'", RSV_ERROR_FORMAT },
        { "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"children\":["
          "1]},"
          "{\"children\":[0]}]}",
            "without cycles", RSV_ERROR_FORMAT },
        { "{\"asset\":{\"version\":\"2.0\"}}", "no triangles", RSV_ERROR_SCENE },
    };
    folder place = new_folder();
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const char *path = path_in(&place, "broken.gltf");
        write_bytes(path, cases[i].text, i == 4 ? 8 : strlen(cases[i].text));
        assert_refused(*state, path, cases[i].status, cases[i].message);
    }
    assert_refused(*state, path_in(&place, "missing.glb"), RSV_ERROR_IO, "cannot be opened");
    assert_refused(*state, place.path, RSV_ERROR_IO, "not a regular file");
    remove_folder(place.path);
}

static void deep_nesting_is_refused(void **state)
{
    folder place = new_folder();
    enum { DEPTH = 200000 };
    char *text = malloc(2 * DEPTH + 64);
    assert_non_null(text);
    int length = sprintf(text, "{\"asset\":{\"version\":\"2.0\"},\"extras\":");
    memset(text + length, '[', DEPTH);
    memset(text + length + DEPTH, ']', DEPTH);
    text[length + 2 * DEPTH] = '}';
    const char *path = path_in(&place, "deep.gltf");
    write_bytes(path, text, (size_t)length + 2 * DEPTH + 1);
    free(text);
    assert_refused(*state, path, RSV_ERROR_FORMAT, "nested too deeply");
    remove_folder(place.path);
}

/// A long chain of nodes needs no deep recursion.
static void deep_node_trees_are_walked(void **state)
{
    enum { DEPTH = 20000 };
    folder place = new_folder();
    buffer b = square_buffer();
    char head[2048];
    one_mesh(head, sizeof head, &b, "", ",\"mode\":6");
    *strstr(head, "{\"mesh\":0}") = 0;
    char *text = malloc(DEPTH * 32 + 4096);
    assert_non_null(text);
    int length = sprintf(text,
        "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"uri\":\"shape.bin\",\"byteLength\":%zu}],"
        "%s",
        b.bytes, head);
    for (int i = 1; i < DEPTH; i++)
        length += sprintf(text + length, "{\"children\":[%d]},", i);
    length += sprintf(text + length, "{\"mesh\":0}]}");
    write_bytes(path_in(&place, "shape.bin"), b.data, b.bytes);
    const char *path = path_in(&place, "chain.gltf");
    write_bytes(path, text, (size_t)length);
    free(text);
    assert_shows_square(*state, path);
    remove_folder(place.path);
}

/// Truncated at every length and with random bytes changed: an error or a scene, never a crash.
static void damaged_files_do_no_harm(void **state)
{
    fixture *f = *state;
    folder place = new_folder();
    char path[256];
    snprintf(path, sizeof path, "%s", path_in(&place, "damaged.glb"));
    rsv_scene *scene = NULL;
    assert_int_equal(rsv_scene_builtin(f->context, "furnace", &scene), RSV_OK);
    assert_int_equal(rsv_scene_save(scene, path), RSV_OK);
    rsv_scene_destroy(scene);
    size_t bytes;
    uint8_t *data = read_bytes(path, &bytes);
    for (size_t length = 0; length < bytes; length += 1 + length / 16) {
        write_bytes(path, data, length);
        assert_int_equal(rsv_scene_load(f->context, path, &scene), RSV_ERROR_FORMAT);
    }
    unsigned random = 1;
    for (int trial = 0; trial < 600; trial++) {
        size_t at = (random = random * 1664525u + 1013904223u) % bytes;
        uint8_t kept = data[at];
        data[at] = (uint8_t)(random >> 24);
        write_bytes(path, data, bytes);
        data[at] = kept;
        f->log[0] = 0;
        if (rsv_scene_load(f->context, path, &scene) == RSV_OK) rsv_scene_destroy(scene);
    }
    free(data);
    remove_folder(place.path);
}

// ---- assets ---------------------------------------------------------------------------------------

static bool ends_with(const char *text, const char *end)
{
    size_t length = strlen(text), end_length = strlen(end);
    return length >= end_length && !strcmp(text + length - end_length, end);
}

/// Calls `visit` for every .gltf and .glb file below a folder.
static void visit_files(fixture *f, const char *path, void (*visit)(fixture *, const char *))
{
    DIR *directory = opendir(path);
    assert_non_null(directory);
    for (struct dirent *entry; (entry = readdir(directory));) {
        char name[1024];
        struct stat info;
        if (entry->d_name[0] == '.') continue;
        snprintf(name, sizeof name, "%s/%s", path, entry->d_name);
        if (stat(name, &info) == 0 && S_ISDIR(info.st_mode))
            visit_files(f, name, visit);
        else if (ends_with(name, ".gltf") || ends_with(name, ".glb"))
            visit(f, name);
    }
    closedir(directory);
}

static void visit_assets(fixture *f, const char *part, void (*visit)(fixture *, const char *))
{
    const char *assets = getenv("RSV_ASSETS");
    char path[1024];
    snprintf(path, sizeof path, "%s/%s", assets ? assets : "", part);
    if (!assets || access(path, R_OK) != 0) {
        print_message("skipped: no assets at RSV_ASSETS/%s\n", part);
        skip();
    }
    visit_files(f, path, visit);
}

static void expect_good(fixture *f, const char *path)
{
    rsv_scene *scene = NULL;
    struct stat info;
    assert_int_equal(stat(path, &info), 0);
    if (info.st_size > UNLESS_SANITIZED(INT64_MAX, 250000)) return;
    rsv_status status = rsv_scene_load(f->context, path, &scene);
    if (status != RSV_OK) fail_msg("%s", rsv_last_error());
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    for (size_t t = 0; t < view->triangle_count; t++)
        for (int k = 0; k < 3; k++)
            assert_true(
                v3_dot(view->normal[view->triangle[t][k]], geometric_normal(view, t)) > -1e-3f);
    rsv_scene_destroy(scene);
}

/// Expects one line that names the file. If the broken part is not needed (a name that is a number, an index of -1 as a
/// texture), expects a scene of finite size.
static void expect_error_or_recovery(fixture *f, const char *path)
{
    rsv_scene *scene = NULL;
    if (rsv_scene_load(f->context, path, &scene) == RSV_OK) {
        const rsv_scene_view *view = rsv_scene_get_view(scene);
        assert_true(view->triangle_count > 0);
        for (size_t v = 0; v < view->vertex_count; v++)
            assert_true(isfinite(v3_max_abs(view->position[v])));
    } else {
        assert_mentions(rsv_last_error(), path);
    }
    rsv_scene_destroy(scene);
}

static void good_assets_load(void **state) { visit_assets(*state, "gltf", expect_good); }

static void interiors_load(void **state) { visit_assets(*state, "interiors", expect_good); }

static void broken_assets_fail_cleanly(void **state)
{
    visit_assets(*state, "broken", expect_error_or_recovery);
}

#define GLTF_TEST(function)                                                                        \
    cmocka_unit_test_setup_teardown(function, fixture_setup, fixture_teardown)

int main(int argc, char **argv)
{
    const struct CMUnitTest quick[] = {
        GLTF_TEST(every_material_light_and_camera_survives_the_file),
        GLTF_TEST(the_writer_leaves_nothing_half_written),
        GLTF_TEST(chunks_are_aligned_and_add_up),
        GLTF_TEST(fog_and_environments_are_said_to_be_left_out),
        GLTF_TEST(every_index_type_is_read),
        GLTF_TEST(strips_and_fans_become_triangles),
        GLTF_TEST(points_and_lines_are_skipped),
        GLTF_TEST(quantized_strided_and_sparse_positions_are_read),
        GLTF_TEST(transforms_compose_down_the_tree),
        GLTF_TEST(percent_encoded_names_are_decoded),
        GLTF_TEST(data_uris_are_read),
        GLTF_TEST(packed_meshes_are_unpacked),
        GLTF_TEST(broken_packed_meshes_are_refused),
        GLTF_TEST(buffers_outside_the_folder_are_refused),
        GLTF_TEST(bad_references_are_named),
        GLTF_TEST(broken_documents_are_refused),
        GLTF_TEST(deep_nesting_is_refused),
        GLTF_TEST(deep_node_trees_are_walked),
        GLTF_TEST(damaged_files_do_no_harm),
        GLTF_TEST(good_assets_load),
        GLTF_TEST(broken_assets_fail_cleanly),
    };
    const struct CMUnitTest slow[] = {
        GLTF_TEST(builtin_scenes_survive_the_file),
        GLTF_TEST(interiors_load),
    };
    return RUN_HALF(argc, argv, quick, slow);
}
