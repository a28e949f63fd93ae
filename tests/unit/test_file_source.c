/// Scenes and pictures from memory and through callbacks are those of the same files on disk.
#include "io/file_source.h"
#include "resolvent/image.h"
#include "resolvent/opfile.h"
#include "unit/file_fixture.h"

// ---- files that are nowhere ---------------------------------------------------------------------------

typedef struct virtual_file {
    const char *name;
    const void *bytes;
    size_t count;
} virtual_file;

typedef struct virtual_folder {
    const virtual_file *file; ///< up to one without a name
    size_t most;              ///< that one call reads
    const char *broken;       ///< a file that ends at half of its size; NULL = none
    int reads;
} virtual_folder;

static const virtual_file *find(const virtual_folder *in, const char *path)
{
    for (const virtual_file *f = in->file; f->name; f++)
        if (strcmp(f->name, path) == 0) return f;
    return NULL;
}

static int64_t size_of(void *user, const char *path)
{
    const virtual_file *f = find(user, path);
    return f ? (int64_t)f->count : -1;
}

static size_t read_some(void *user, const char *path, uint64_t offset, void *bytes, size_t count)
{
    virtual_folder *in = user;
    const virtual_file *f = find(in, path);
    assert_non_null(f);
    assert_true(offset + count <= f->count);
    in->reads++;
    bool is_broken = in->broken && strcmp(in->broken, path) == 0;
    if (count > in->most) count = in->most;
    if (is_broken && offset + count > f->count / 2) count = f->count / 2 - (size_t)offset;
    memcpy(bytes, (const char *)f->bytes + offset, count);
    return count;
}

static rsv_file_source source_of(virtual_folder *in)
{
    return (rsv_file_source){ size_of, read_some, in };
}

static rsv_status load_virtual(
    const fixture *f, virtual_folder *in, const char *name, rsv_scene **scene)
{
    const rsv_file_source files = source_of(in);
    rsv_load_desc desc = rsv_default_load_desc();
    desc.files = &files;
    return rsv_scene_load_with(f->context, name, &desc, scene);
}

// ---- scenes ---------------------------------------------------------------------------------------------

static const char obj[] = "mtllib parts/some colours.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
                          "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl red\nf 1/1 2/2 3/3 4/4\n";
static const char mtl[] = "newmtl red\nKd 0.8 0.1 0.1\nmap_Kd tile.png\n";
static const char ply[] = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                          "property float y\nproperty float z\nelement face 1\n"
                          "property list uchar int vertex_indices\nend_header\n"
                          "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
static const char stl[] = "solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
                          "vertex 0 1 0\nendloop\nendfacet\nendsolid t\n";
static const char gltf[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":0}]}],"
    "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}],"
    "\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"tile.png\"}],"
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\","
    "\"min\":[0,0,0],\"max\":[1,1,0]}],"
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
    "\"buffers\":[{\"uri\":\"points%20here.bin\",\"byteLength\":36}]}";
static const float points[9] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 };

/// The bytes of a picture of four texels.
static uint8_t *make_tile(const fixture *f, const folder *in, size_t *count)
{
    rsv_image *image;
    const rsv_rgb texel[] = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, { 1, 1, 1 } };
    assert_int_equal(rsv_image_create(f->context, 2, 2, 1, &image), RSV_OK);
    memcpy(rsv_image_pixels(image, 0), texel, sizeof texel);
    assert_int_equal(rsv_image_write(image, path_in(in, "tile.png"), 0), RSV_OK);
    rsv_image_destroy(image);
    return read_bytes(path_in(in, "tile.png"), count);
}

static void write_all(const folder *in, const virtual_file *file)
{
    char path[256];
    snprintf(path, sizeof path, "%s/parts", in->path);
    assert_int_equal(mkdir(path, 0777), 0);
    for (; file->name; file++)
        write_bytes(path_in(in, file->name + strlen("/nowhere/")), file->bytes, file->count);
}

static void digest(const rsv_scene *scene, char digits[RSV_FINGERPRINT_DIGITS + 1])
{
    assert_int_equal(rsv_scene_fingerprint(scene, digits), RSV_OK);
}

static void assert_same(const fixture *f, virtual_folder *in, const folder *disk, const char *name)
{
    char there[256], here[RSV_FINGERPRINT_DIGITS + 1], expected[RSV_FINGERPRINT_DIGITS + 1];
    rsv_scene *scene;
    snprintf(there, sizeof there, "/nowhere/%s", name);
    if (load_virtual(f, in, there, &scene) != RSV_OK) fail_msg("%s", rsv_last_error());
    digest(scene, here);
    rsv_scene_destroy(scene);
    if (rsv_scene_load(f->context, path_in(disk, name), &scene) != RSV_OK)
        fail_msg("%s", rsv_last_error());
    digest(scene, expected);
    rsv_scene_destroy(scene);
    assert_string_equal(here, expected);
}

#define TEXT_FILE(name, text)                                                                      \
    {                                                                                              \
        "/nowhere/" name, text, sizeof text - 1                                                    \
    }

static void scenes_through_callbacks_are_those_on_disk(void **state)
{
    fixture *f = *state;
    const folder disk = new_folder();
    size_t tile_bytes;
    uint8_t *tile = make_tile(f, &disk, &tile_bytes);
    const virtual_file files[] = { TEXT_FILE("s.obj", obj),
        TEXT_FILE("parts/some colours.mtl", mtl), TEXT_FILE("s.ply", ply), TEXT_FILE("s.stl", stl),
        TEXT_FILE("s.gltf", gltf), { "/nowhere/points here.bin", points, sizeof points },
        { "/nowhere/tile.png", tile, tile_bytes }, { NULL, NULL, 0 } };
    write_all(&disk, files);
    const char *const names[] = { "s.obj", "s.ply", "s.stl", "s.gltf" };
    for (size_t most = 7; most < 1000000; most *= 100)
        for (size_t k = 0; k < 4; k++) {
            virtual_folder in = { .file = files, .most = most };
            assert_same(f, &in, &disk, names[k]);
            assert_true(in.reads > 0);
        }
    if (strstr(f->log, "left out") || strstr(f->log, "cannot be read")) fail_msg("%s", f->log);
    free(tile);
    remove_folder(disk.path);
}

static void scenes_in_memory_are_those_on_disk(void **state)
{
    fixture *f = *state;
    const folder disk = new_folder();
    rsv_scene *scene;
    size_t count;
    char expected[RSV_FINGERPRINT_DIGITS + 1], here[RSV_FINGERPRINT_DIGITS + 1];
    assert_int_equal(rsv_scene_builtin(f->context, "cornell-blocks", &scene), RSV_OK);
    assert_int_equal(rsv_scene_save(scene, path_in(&disk, "box.glb")), RSV_OK);
    rsv_scene_destroy(scene);
    assert_int_equal(rsv_scene_load(f->context, path_in(&disk, "box.glb"), &scene), RSV_OK);
    digest(scene, expected);
    rsv_scene_destroy(scene);
    uint8_t *bytes = read_bytes(path_in(&disk, "box.glb"), &count);
    assert_int_equal(
        rsv_scene_load_memory(f->context, "box.glb", bytes, count, NULL, &scene), RSV_OK);
    memset(bytes, 0, count); // nothing of it is needed any more
    digest(scene, here);
    assert_string_equal(here, expected);
    rsv_scene_destroy(scene);
    free(bytes);
    remove_folder(disk.path);
}

static void pictures_in_memory_are_those_on_disk(void **state)
{
    fixture *f = *state;
    const folder disk = new_folder();
    size_t count;
    uint8_t *bytes = make_tile(f, &disk, &count);
    rsv_image *a = NULL, *b = NULL;
    assert_int_equal(rsv_image_read(f->context, path_in(&disk, "tile.png"), &a), RSV_OK);
    assert_int_equal(rsv_image_read_memory(f->context, "what", bytes, count, &b), RSV_OK);
    assert_memory_equal(
        rsv_image_const_pixels(a, 0), rsv_image_const_pixels(b, 0), 4 * sizeof(rsv_rgb));
    rsv_image_destroy(a);
    rsv_image_destroy(b);
    assert_int_equal(
        rsv_image_read_memory(f->context, "cut.png", bytes, count / 2, &b), RSV_ERROR_FORMAT);
    assert_mentions(rsv_last_error(), "cut.png");
    assert_int_equal(rsv_image_read_memory(f->context, "empty.png", "", 0, &b), RSV_ERROR_FORMAT);
    assert_int_equal(
        rsv_image_read_memory(f->context, "none", "text", 4, &b), RSV_ERROR_UNSUPPORTED);
    free(bytes);
    remove_folder(disk.path);
}

// ---- callbacks that fail ----------------------------------------------------------------------------------

static void what_cannot_be_read_is_an_error(void **state)
{
    fixture *f = *state;
    const virtual_file files[] = { TEXT_FILE("s.obj", obj), TEXT_FILE("s.ply", ply),
        TEXT_FILE("s.stl", stl), TEXT_FILE("s.gltf", gltf), { NULL, NULL, 0 } };
    rsv_scene *scene = NULL;
    for (size_t k = 0; k < 4; k++) {
        virtual_folder in = { .file = files, .most = SIZE_MAX, .broken = files[k].name };
        assert_int_equal(load_virtual(f, &in, files[k].name, &scene), RSV_ERROR_IO);
        assert_mentions(rsv_last_error(), files[k].name);
        assert_null(scene);
    }
    virtual_folder in = { .file = files, .most = SIZE_MAX };
    assert_int_equal(load_virtual(f, &in, "/nowhere/absent.glb", &scene), RSV_ERROR_IO);
    assert_int_equal(load_virtual(f, &in, "/nowhere/s.gltf", &scene), RSV_ERROR_IO);
    assert_mentions(rsv_last_error(), "points%20here.bin");
}

static void sources_without_callbacks_are_refused(void **state)
{
    fixture *f = *state;
    const rsv_file_source files = { size_of, NULL, NULL };
    rsv_load_desc desc = rsv_default_load_desc();
    rsv_scene *scene = NULL;
    desc.files = &files;
    assert_int_equal(rsv_scene_load_with(f->context, "s.obj", &desc, &scene), RSV_ERROR_ARGUMENT);
    assert_mentions(rsv_last_error(), "lacks a callback");
}

/// A callback that loads a scene itself, as one that unpacks a library of parts might.
typedef struct nested {
    const fixture *f;
    virtual_folder in;
    int depth;
} nested;

static int64_t nested_size(void *user, const char *path)
{
    return size_of(&((nested *)user)->in, path);
}

static size_t nested_read(void *user, const char *path, uint64_t offset, void *bytes, size_t count)
{
    nested *n = user;
    if (n->depth++ == 0) {
        rsv_scene *scene;
        assert_int_equal(load_virtual(n->f, &n->in, "/nowhere/s.stl", &scene), RSV_OK);
        rsv_scene_destroy(scene);
    }
    return read_some(&n->in, path, offset, bytes, count);
}

static void callbacks_may_call_the_library(void **state)
{
    const virtual_file files[] = { TEXT_FILE("s.ply", ply), TEXT_FILE("s.stl", stl),
        { NULL, NULL, 0 } };
    nested n = { .f = *state, .in = { .file = files, .most = SIZE_MAX } };
    const rsv_file_source source = { nested_size, nested_read, &n };
    rsv_load_desc desc = rsv_default_load_desc();
    rsv_scene *scene;
    desc.files = &source;
    assert_int_equal(rsv_scene_load_with(n.f->context, "/nowhere/s.ply", &desc, &scene), RSV_OK);
    assert_true(n.depth > 0);
    rsv_scene_destroy(scene);
}

/// Every allocation of a load fails once.
static void memory_may_run_out_at_any_moment(void **state)
{
    fixture *f = *state;
    const virtual_file files[] = { TEXT_FILE("s.obj", obj),
        TEXT_FILE("parts/some colours.mtl", mtl), { NULL, NULL, 0 } };
    for (size_t left = 0;; left++) {
        virtual_folder in = { .file = files, .most = SIZE_MAX };
        rsv_scene *scene = NULL;
        f->allocations_left = left;
        rsv_status status = load_virtual(f, &in, "/nowhere/s.obj", &scene);
        f->allocations_left = SIZE_MAX;
        rsv_scene_destroy(scene);
        if (status == RSV_OK) break;
        assert_int_equal(status, RSV_ERROR_MEMORY);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(
            scenes_through_callbacks_are_those_on_disk, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            scenes_in_memory_are_those_on_disk, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            pictures_in_memory_are_those_on_disk, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            what_cannot_be_read_is_an_error, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            sources_without_callbacks_are_refused, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            callbacks_may_call_the_library, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            memory_may_run_out_at_any_moment, fixture_setup, fixture_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
