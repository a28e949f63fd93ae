/// The file that a scene came from: kept in memory, packed and unpacked, written back with light.
#include "io/gltf_archive.h"
#include "resolvent/bake.h"
#include "resolvent/io.h"
#include "resolvent/opfile.h"
#include "resolvent/relight.h"
#include "scene/document.h"
#include "unit/file_fixture.h"
#include "unit/scene_fixture.h"
#include "unit/slow_tests.h"

// ---- archives -------------------------------------------------------------------------------------

static const char text[] = "{\"asset\":{\"version\":\"2.0\"},\"buffers\":["
                           "{\"byteLength\":5,\"uri\":\"a%20b.bin\"},{\"byteLength\":3,\"uri\":"
                           "\"data:application/octet-stream;base64,AQID\"}],\"images\":[{\"uri\":"
                           "\"c.png\"},{\"uri\":\"missing.png\"}]}";

/// A document as the parser makes it.
static rsv_gltf_document document_of(const rsv_gltf_buffer *buffer, const rsv_gltf_image *image)
{
    return (rsv_gltf_document){ .text = text,
        .text_bytes = sizeof text - 1,
        .buffer = buffer,
        .buffer_count = 2,
        .image = image,
        .image_count = 2 };
}

static uint8_t *pack(const fixture *f, size_t *count)
{
    static const uint8_t a[5] = { 1, 2, 3, 4, 5 }, b[3] = { 1, 2, 3 }, c[2] = { 9, 8 };
    const rsv_gltf_buffer buffer[2] = { { a, 5, "a%20b.bin" },
        { b, 3, "data:application/octet-stream;base64,AQID" } };
    const rsv_gltf_image image[2] = { { .bytes = c, .size = 2, .buffer_view = -1, .uri = "c.png" },
        { .buffer_view = -1, .uri = "missing.png" } };
    const rsv_gltf_document document = document_of(buffer, image);
    uint8_t *bytes;
    assert_int_equal(rsv_gltf_archive_pack(f->context, &document, &bytes, count), RSV_OK);
    return bytes;
}

static void archives_hold_the_text_and_the_files_beside_it(void **state)
{
    const fixture *f = *state;
    size_t count, at = 0;
    uint8_t *bytes = pack(f, &count);
    rsv_gltf_chunk chunk;
    assert_true(rsv_gltf_archive_next(bytes, count, &at, &chunk));
    assert_int_equal(chunk.type, RSV_GLB_JSON);
    assert_memory_equal(chunk.data, text, sizeof text - 1);
    assert_true(rsv_gltf_archive_next(bytes, count, &at, &chunk));
    assert_string_equal(chunk.uri, "a%20b.bin");
    assert_int_equal(chunk.size, 5);
    assert_true(rsv_gltf_archive_next(bytes, count, &at, &chunk));
    assert_string_equal(chunk.uri, "c.png");
    assert_int_equal(chunk.size, 2);
    assert_false(rsv_gltf_archive_next(bytes, count, &at, &chunk));
    assert_int_equal(at, count);
    rsv_free(f->context, bytes);
}

static void archives_are_opened_as_the_file_was(void **state)
{
    const fixture *f = *state;
    size_t count;
    uint8_t *bytes = pack(f, &count);
    const rsv_gltf_document *document;
    if (rsv_gltf_open_archive(bytes, count, &document)) fail_msg("%s", rsv_last_error());
    rsv_free(f->context, bytes);
    assert_int_equal(document->buffer_count, 2);
    assert_int_equal(document->buffer[0].size, 5);
    assert_int_equal(document->buffer[0].data[4], 5);
    assert_int_equal(document->buffer[1].data[2], 3);
    assert_int_equal(document->image[0].size, 2);
    assert_null(document->image[1].bytes);
    assert_memory_equal(document->text, text, sizeof text - 1);
    rsv_gltf_close(document);
}

/// Every byte of the containers' numbers, and every length.
static void damaged_archives_are_refused_or_read(void **state)
{
    const fixture *f = *state;
    size_t count;
    uint8_t *bytes = pack(f, &count);
    const rsv_gltf_document *document;
    for (size_t k = 0; k < count; k++) {
        uint8_t was = bytes[k];
        if (k >= 20 && k < 20 + sizeof text - 1) continue; // other tests spoil JSON
        bytes[k] = (uint8_t)~was;
        if (rsv_gltf_open_archive(bytes, count, &document) == RSV_OK) rsv_gltf_close(document);
        bytes[k] = was;
    }
    for (size_t k = 0; k < count; k++)
        assert_int_not_equal(rsv_gltf_open_archive(bytes, k, &document), RSV_OK);
    rsv_free(f->context, bytes);
}

// ---- bakes ----------------------------------------------------------------------------------------

typedef struct solved {
    folder place;
    rsv_scene *scene;
    rsv_light *solution;
} solved;

static rsv_light *solve(rsv_scene *scene)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_light *solution;
    desc.element_target = 100;
    desc.rays_per_element = 64;
    assert_int_equal(rsv_light_create(scene, &desc, &solution), RSV_OK);
    return solution;
}

/// The box, from a file. @param keep whether its scene keeps that
static solved solve_box(const fixture *f, bool keep)
{
    solved s = { .place = new_folder() };
    rsv_scene *box;
    rsv_load_desc load = rsv_default_load_desc();
    assert_true(load.keep_document);
    load.keep_document = keep;
    assert_int_equal(rsv_scene_builtin(f->context, "cornell-blocks", &box), RSV_OK);
    assert_int_equal(rsv_scene_save(box, path_in(&s.place, "box.glb")), RSV_OK);
    rsv_scene_destroy(box);
    assert_int_equal(
        rsv_scene_load_with(f->context, path_in(&s.place, "box.glb"), &load, &s.scene), RSV_OK);
    s.solution = solve(s.scene);
    return s;
}

static void end(solved *s)
{
    rsv_light_destroy(s->solution);
    rsv_scene_destroy(s->scene);
    remove_folder(s->place.path);
}

static char *read_all(const char *path, size_t *count)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    *count = (size_t)ftell(file);
    rewind(file);
    char *bytes = malloc(*count + 1);
    assert_int_equal(fread(bytes, 1, *count, file), *count);
    bytes[*count] = 0;
    fclose(file);
    return bytes;
}

/// The document is the user's file, byte for byte, even if its folder has moved.
static void scenes_keep_their_file_if_they_are_to(void **state)
{
    const fixture *f = *state;
    solved with = solve_box(f, true), without = solve_box(f, false);
    size_t count;
    char *bytes = read_all(path_in(&with.place, "box.glb"), &count);
    const rsv_scene_document *kept = rsv_scene_find_document(with.scene);
    assert_non_null(kept);
    assert_int_equal(kept->count, count);
    assert_memory_equal(kept->bytes, bytes, count);
    assert_null(rsv_scene_find_document(without.scene));
    rsv_scene_drop_document(with.scene);
    assert_null(rsv_scene_find_document(with.scene));
    assert_int_equal(rsv_bake_vertices(with.solution, path_in(&with.place, "out.glb"), NULL, NULL),
        RSV_OK); // one of its own then
    free(bytes);
    end(&with);
    end(&without);
}

static void targets_are_found_by_their_names(void **state)
{
    solved s = solve_box(*state, true);
    const char *const *name = rsv_bake_target_names();
    size_t found = 0;
    for (; *name; name++)
        found += !strcmp(*name, "vertex") || !strcmp(*name, "lightmap") || !strcmp(*name, "probes");
    assert_int_equal(found, 3);
    assert_string_equal(rsv_bake_target_extension("probes"), ".json");
    assert_null(rsv_bake_target_extension("none"));
    const char *path = path_in(&s.place, "out.glb");
    assert_int_equal(rsv_bake(s.solution, "none", path, NULL, NULL), RSV_ERROR_ARGUMENT);
    assert_int_equal(rsv_bake(s.solution, "probes", path, NULL, NULL), RSV_ERROR_ARGUMENT);
    end(&s);
}

static void bake_relit(rsv_light *light, float green, const char *path)
{
    const rsv_albedo_change change = { "green", { 0.125F, green, 0.25F } };
    const rsv_relight_desc desc = { .size = sizeof desc, .albedo = &change, .albedo_count = 1 };
    assert_int_equal(rsv_light_relight(light, &desc), RSV_OK);
    if (rsv_bake_vertices(light, path, NULL, NULL)) fail_msg("%s", rsv_last_error());
}

/// Two lights side by side are baked each with its own colours, the scene itself with those of its file.
static void lights_are_baked_as_each_was_relit(void **state)
{
    solved s = solve_box(*state, true);
    rsv_light *other;
    static const char *const colors[] = { "[0.125,0.5,0.25,1]", "[0.125,0.75,0.25,1]" };
    char path[2][256];
    assert_int_equal(rsv_light_copy(s.solution, &other), RSV_OK);
    for (int k = 0; k < 2; k++)
        snprintf(path[k], sizeof path[k], "%s", path_in(&s.place, k ? "b.glb" : "a.glb"));
    bake_relit(s.solution, 0.5F, path[0]);
    bake_relit(other, 0.75F, path[1]);
    for (int k = 0; k < 2; k++) {
        size_t count;
        char *bytes = read_all(path[k], &count);
        assert_non_null(memmem(bytes, count, colors[k], strlen(colors[k])));
        assert_null(memmem(bytes, count, colors[!k], strlen(colors[!k])));
        free(bytes);
    }
    rsv_light_destroy(other);
    end(&s);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest quick[] = {
        cmocka_unit_test_setup_teardown(
            archives_hold_the_text_and_the_files_beside_it, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            archives_are_opened_as_the_file_was, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            damaged_archives_are_refused_or_read, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            scenes_keep_their_file_if_they_are_to, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(
            targets_are_found_by_their_names, fixture_setup, fixture_teardown),
    };
    const struct CMUnitTest slow[] = {
        cmocka_unit_test_setup_teardown(
            lights_are_baked_as_each_was_relit, fixture_setup, fixture_teardown),
    };
    return RUN_HALF(argc, argv, quick, slow);
}
