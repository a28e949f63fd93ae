/// Rows taken over from before an edit of the scene: ray by ray the same as in a full build.
#include "elements/burial.h"
#include "elements/contact.h"
#include "elements/spacing.h"
#include "file_fixture.h"
#include "light_fixture.h"
#include "operator/row_tracer.h"
#include "update/kept_rows.h"
#include "update/update.h"

enum { RAYS = 256, SEED = 1, NAME_BYTES = 64 };

/// The edit. All lengths are in metres.
typedef struct room {
    float box_at;       ///< x of a box on the floor; negative = there is none
    float albedo;       ///< of that box
    float radiance;     ///< of a panel under the ceiling
    bool mirror, glass; ///< what the second box is made of; neither = plaster
    const char *rows;   ///< folder for the rows
} room;

static const room plain = { 0.5f, 0.5f, 1, false, false, NULL };

typedef struct built {
    world *w;
    rsv_elements *elements;
    uint16_t *valid_points;
} built;

static built build(const room *r)
{
    built b = { .w = world_begin(2) };
    world *w = b.w;
    uint32_t walls = world_lambert(w, 0.7f, 0), box = world_lambert(w, r->albedo, 0);
    uint32_t panel = world_lambert(w, 0.1f, r->radiance), other = walls;
    if (r->mirror) other = world_material(w, mirror_material(0.9f));
    if (r->glass) other = world_material(w, glass_material());
    world_room(w, walls, v3(0, 0, 0), v3(3, 2, 2));
    float x = r->box_at;
    if (x >= 0) world_box(w, box, v3(x, 1e-4f, 0.5f), v3(x + 0.3f, 0.4f, 0.8f));
    world_box(w, other, v3(2.3f, 0.01f, 1.2f), v3(2.6f, 0.4f, 1.5f));
    world_box(w, panel, v3(1, 1.9f, 0.8f), v3(1.5f, 1.95f, 1.2f));
    world_commit(w);
    uint64_t rays = 0;
    const rsv_spacing spacing = { .metres = 0.2f };
    assert_int_equal(rsv_elements_create(w->scene, w->bsdf, &spacing, &b.elements), RSV_OK);
    assert_int_equal(
        rsv_elements_refine_contacts(&w->transport, 1000, NULL, &b.elements, &rays), RSV_OK);
    assert_int_equal(rsv_elements_separate(&w->transport, NULL, b.elements, &rays), RSV_OK);
    b.valid_points = calloc(b.elements->node_count, sizeof *b.valid_points);
    assert_non_null(b.valid_points);
    assert_int_equal(
        rsv_find_buried(&w->transport, b.elements, (rsv_support_draw){ RSV_SUPPORT_POINTS, SEED },
            NULL, b.valid_points, &rays),
        RSV_OK);
    assert_int_equal(rsv_elements_bridge_buried(b.elements, b.valid_points), RSV_OK);
    return b;
}

static void destroy(built *b)
{
    rsv_elements_destroy(b->elements);
    free(b->valid_points);
    world_end(b->w);
}

static rsv_store *open_folder(rsv_context *context, const char *path)
{
    rsv_store *store = NULL;
    assert_int_equal(rsv_store_folder(context, path, &store), RSV_OK);
    return store;
}

/// Leaves rows in the room's folder.
static void trace_rows(const room *r)
{
    built b = build(r);
    rsv_transport *transport;
    rsv_update update = { .store = open_folder(b.w->context, r->rows) };
    b.w->transport.update = &update;
    assert_int_equal(rsv_transport_create(&(rsv_transport_desc){ &b.w->transport, b.w->lights,
                                              b.elements, b.valid_points, RAYS, SEED },
                         &transport),
        RSV_OK);
    rsv_transport_destroy(transport);
    rsv_store_destroy(update.store);
    destroy(&b);
}

static void check_same_row(const rsv_row_scratch *a, const rsv_row_scratch *b)
{
    assert_memory_equal(a->column, b->column, RAYS * sizeof *a->column);
    assert_memory_equal(a->kind, b->kind, RAYS * sizeof *a->kind);
    assert_int_equal(a->tinted_count, b->tinted_count);
    assert_memory_equal(
        a->tinted_column, b->tinted_column, a->tinted_count * sizeof *a->tinted_column);
    assert_memory_equal(
        a->tinted_weight, b->tinted_weight, a->tinted_count * sizeof *a->tinted_weight);
    assert_memory_equal(&a->emission, &b->emission, sizeof a->emission);
    assert_int_equal(a->escapes.count, b->escapes.count);
    assert_int_equal(a->valid, b->valid);
}

/// How much of the rows of one room still holds in another.
typedef struct kept {
    double rays; ///< share of those of all rows
    size_t rows; ///< that were known
    size_t all;
} kept;

/// Every row that is taken over against the same row with all of its rays traced.
static kept compare_rows(const rsv_row_tracer *tracer, const rsv_kept_rows *earlier)
{
    rsv_context *context = tracer->elements->context;
    static const uint8_t nothing[RAYS];
    rsv_row_scratch anew = { 0 }, whole = { 0 };
    kept k = { 0 };
    assert_int_equal(rsv_row_scratch_create(context, RAYS, &anew), RSV_OK);
    assert_int_equal(rsv_row_scratch_create(context, RAYS, &whole), RSV_OK);
    for (uint32_t n = 0; n < tracer->elements->node_count; n++) {
        rsv_kept_row past;
        if (!tracer->valid_points[n]) continue;
        k.all++;
        if (!rsv_kept_rows_find(earlier, n, &past)) continue;
        k.rows++;
        rsv_row_retrace(tracer, n, &past, &anew);
        past.kind = nothing;
        rsv_row_retrace(tracer, n, &past, &whole);
        check_same_row(&anew, &whole);
    }
    k.rays = (double)anew.kept / ((double)k.all * RAYS);
    rsv_row_scratch_destroy(context, &anew);
    rsv_row_scratch_destroy(context, &whole);
    return k;
}

static kept update(const room *before, const room *after)
{
    built b = build(after);
    rsv_row_catalogue *now;
    rsv_store *store = open_folder(b.w->context, before->rows);
    rsv_kept_rows *earlier;
    rsv_row_tracer tracer = { .scene = &b.w->transport,
        .lights = b.w->lights,
        .elements = b.elements,
        .valid_points = b.valid_points,
        .seed = SEED };
    assert_int_equal(rsv_row_tracer_begin(&tracer, RAYS), RSV_OK);
    uint8_t *kind = calloc(b.w->transport.view->triangle_count, 2);
    assert_non_null(kind);
    for (size_t side = 0; side < 2 * (size_t)b.w->transport.view->triangle_count; side++)
        kind[side] = tracer.target[side].kind;
    const rsv_row_basis basis = { &b.w->transport, b.elements, b.valid_points, kind, RAYS, SEED };
    assert_int_equal(rsv_row_catalogue_create(&basis, &now), RSV_OK);
    assert_int_equal(rsv_kept_rows_open(&basis, now, store, &earlier), RSV_OK);
    free(kind);
    kept k = compare_rows(&tracer, earlier);
    rsv_kept_rows_close(earlier);
    rsv_store_destroy(store);
    rsv_row_catalogue_destroy(now);
    rsv_row_tracer_end(&tracer);
    destroy(&b);
    return k;
}

static kept edit(room before, room after)
{
    folder rows = new_folder();
    before.rows = rows.path;
    trace_rows(&before);
    kept k = update(&before, &after);
    remove_folder(rows.path);
    return k;
}

static void an_unchanged_scene_keeps_all(void **state)
{
    (void)state;
    kept k = edit(plain, plain);
    assert_int_equal(k.rows, k.all);
    assert_true(k.rays == 1);
}

static void albedo_and_emission_keep_all(void **state)
{
    (void)state;
    room painted = plain, lit = plain;
    painted.albedo = 0.2f;
    lit.radiance = 3;
    assert_true(edit(plain, painted).rays == 1);
    assert_true(edit(plain, lit).rays == 1);
}

static void a_moved_object_costs_the_rays_that_meet_it(void **state)
{
    (void)state;
    room moved = plain;
    moved.box_at = 0.9f;
    kept k = edit(plain, moved);
    assert_true(k.rows < k.all);
    assert_true(k.rays > 0.7 && k.rays < 1);
}

static void objects_come_and_go(void **state)
{
    (void)state;
    room empty = plain;
    empty.box_at = -1;
    kept added = edit(empty, plain), removed = edit(plain, empty);
    assert_true(added.rays > 0.7 && added.rays < 1);
    assert_true(removed.rays > 0.7 && removed.rays < 1);
}

static void another_way_to_scatter_costs_the_rays_that_meet_it(void **state)
{
    (void)state;
    room mirror = plain, glass = plain;
    mirror.mirror = glass.glass = true;
    const room *rooms[] = { &plain, &mirror, &glass };
    for (int from = 0; from < 3; from++)
        for (int to = 0; to < 3; to++) {
            kept k = edit(*rooms[from], *rooms[to]);
            assert_true(k.rays > 0.7);
            assert_true(k.rays < 1 || (from == 0 && to == 0));
        }
}

/// Name of the only file in the folder that has the ending.
static void find_file(const folder *f, const char *ending, char name[NAME_BYTES])
{
    int found = 0;
    DIR *directory = opendir(f->path);
    assert_non_null(directory);
    for (struct dirent *entry; (entry = readdir(directory));) {
        if (!strstr(entry->d_name, ending)) continue;
        snprintf(name, NAME_BYTES, "%.60s", entry->d_name); // a key of 16 digits, and the ending
        found++;
    }
    closedir(directory);
    assert_int_equal(found, 1);
}

static void damaged_catalogues_are_passed_over(void **state)
{
    (void)state;
    folder rows = new_folder();
    room before = plain;
    char name[NAME_BYTES];
    before.rows = rows.path;
    trace_rows(&before);
    find_file(&rows, ".scene", name);
    FILE *file = fopen(path_in(&rows, name), "r+b");
    assert_non_null(file);
    assert_int_equal(fseek(file, 2000, SEEK_SET), 0);
    assert_int_equal(fputc(0x55, file), 0x55);
    fclose(file);
    assert_int_equal(update(&before, &plain).rows, 0);
    remove_folder(rows.path);
}

static size_t count_found(const rsv_row_reader *files)
{
    size_t found = 0;
    for (uint32_t n = 0; n < files->node_count; n++)
        found += rsv_row_reader_find(files, n) != NULL;
    return found;
}

/// Another process overwrites the second half of a mapped file of rows.
static void records_written_over_meanwhile_are_not_taken(void **state)
{
    (void)state;
    folder rows = new_folder();
    room before = plain;
    before.rows = rows.path;
    trace_rows(&before);
    char name[NAME_BYTES], key[RSV_ROW_KEY_DIGITS + 1];
    find_file(&rows, ".rows", name);
    snprintf(key, sizeof key, "%.*s", RSV_ROW_KEY_DIGITS, name);
    const char *path = path_in(&rows, name);
    built b = build(&plain);
    rsv_row_reader files = { .context = b.w->context,
        .store = open_folder(b.w->context, rows.path),
        .node_count = b.elements->node_count,
        .ray_count = RAYS };
    rsv_store *store = files.store;
    size_t own, bytes;
    assert_int_equal(rsv_row_reader_open(&files, key, name, &own), RSV_OK);
    size_t all = count_found(&files);
    assert_true(all > 100);
    uint8_t *content = read_bytes(path, &bytes);
    FILE *file = fopen(path, "r+b");
    assert_non_null(file);
    memset(content + bytes / 2, 0, bytes - bytes / 2);
    assert_int_equal(fwrite(content, 1, bytes, file), bytes);
    fclose(file);
    free(content);
    size_t left = count_found(&files);
    assert_true(left > all / 3 && left < 2 * all / 3);
    rsv_row_reader_close(&files);
    rsv_store_destroy(store);
    destroy(&b);
    remove_folder(rows.path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_unchanged_scene_keeps_all),
        cmocka_unit_test(albedo_and_emission_keep_all),
        cmocka_unit_test(a_moved_object_costs_the_rays_that_meet_it),
        cmocka_unit_test(objects_come_and_go),
        cmocka_unit_test(another_way_to_scatter_costs_the_rays_that_meet_it),
        cmocka_unit_test(damaged_catalogues_are_passed_over),
        cmocka_unit_test(records_written_over_meanwhile_are_not_taken),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
