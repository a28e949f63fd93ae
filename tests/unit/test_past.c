/// Solving a scene again after an edit, from what the solution before knew.
#include "elements/element_keys.h"
#include "elements/past_file.h"
#include "file_fixture.h"
#include "light_fixture.h"
#include "solve/budget.h"
#include "solve/solution.h"

#include <math.h>

/// What is edited. Metres.
typedef struct room {
    float box_at;   ///< x of a box on the floor
    float albedo;   ///< of that box
    float radiance; ///< of the lamp
} room;

static const room plain = { 0.5f, 0.5f, 1 };

static world *build(const room *r, int threads)
{
    world *w = world_begin(threads);
    uint32_t walls = world_lambert(w, 0.7f, 0), box = world_lambert(w, r->albedo, 0);
    uint32_t lamp = world_lambert(w, 0, r->radiance);
    world_room(w, walls, v3(0, 0, 0), v3(6, 2, 2));
    world_box(w, box, v3(r->box_at, 1e-4f, 0.5f), v3(r->box_at + 0.3f, 0.4f, 0.8f));
    world_box(w, lamp, v3(1, 1.9f, 0.8f), v3(1.3f, 1.95f, 1.2f));
    world_commit(w);
    return w;
}

static rsv_solve_desc few_elements(const char *rows, const char *earlier)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = 400;
    desc.rays_per_element = 64;
    desc.refinements = 1;
    desc.direct_levels = 2;
    desc.checkpoint = rows;
    desc.earlier = earlier;
    return desc;
}

static rsv_solution *solve(const world *w, const char *rows, const char *earlier)
{
    rsv_solution *s = NULL;
    rsv_solve_desc desc = few_elements(rows, earlier);
    if (rsv_solution_create(w->scene, &desc, &s) != RSV_OK) fail_msg("%s", rsv_last_error());
    return s;
}

/// Solves a room and leaves what it knows in `rows`.
static void leave(const room *r, const char *rows, const char *earlier)
{
    world *w = build(r, 2);
    rsv_solution_destroy(solve(w, rows, earlier));
    world_end(w);
}

/// RMS difference of irradiance at the middles and corners of triangles, over its RMS.
static double difference(const rsv_solution *a, const rsv_solution *b)
{
    double sum = 0, all = 0;
    for (uint32_t t = 0; t < a->scene.view->triangle_count; t++)
        for (uint32_t k = 0; k < 64; k++) {
            float x, y;
            rsv_sobol_2d(k, t, &x, &y);
            float root = sqrtf(x), u = 1 - root, v = root * y;
            double area = (double)rsv_triangle_area(a->scene.view, t);
            double p = (double)rgb_luminance(rsv_solution_irradiance(a, t, u, v, false, RSV_NONE));
            double q = (double)rgb_luminance(rsv_solution_irradiance(b, t, u, v, false, RSV_NONE));
            sum += area * (p - q) * (p - q);
            all += area * p * p;
        }
    return sqrt(sum / all);
}

enum { WHOLE = 4 }; ///< solutions with other random numbers

/// Mean difference of a solution to all of `whole` but itself.
static double distance(const rsv_solution *s, rsv_solution *const whole[WHOLE])
{
    double sum = 0;
    int count = 0;
    for (int k = 0; k < WHOLE; k++) {
        if (whole[k] == s) continue;
        sum += difference(whole[k], s);
        count++;
    }
    return sum / count;
}

/// Solves a room after an edit, beside solving it as a whole: that stands no farther from the others than one of them.
static void check_against_whole(const room *now, const char *rows, const char *earlier)
{
    world *w = build(now, 2);
    rsv_solution *again = solve(w, rows, earlier), *whole[WHOLE];
    double farthest = 0;
    for (uint32_t k = 0; k < WHOLE; k++) {
        rsv_solve_desc desc = few_elements(NULL, NULL);
        desc.seed = 2 + k;
        assert_int_equal(rsv_solution_create(w->scene, &desc, &whole[k]), RSV_OK);
    }
    for (int k = 0; k < WHOLE; k++)
        farthest = fmax(farthest, distance(whole[k], whole));
    assert_true(again->report.kept_row_rays > again->report.row_rays / 2);
    assert_true(distance(again, whole) <= farthest);
    for (int k = 0; k < WHOLE; k++)
        rsv_solution_destroy(whole[k]);
    rsv_solution_destroy(again);
    world_end(w);
}

static void an_edit_gives_what_a_whole_solution_gives(void **state)
{
    (void)state;
    folder f[3] = { new_folder(), new_folder(), new_folder() };
    room moved = plain, dark = plain;
    moved.box_at = 0.8f;
    dark.albedo = 0.1f;
    leave(&plain, f[0].path, NULL);
    check_against_whole(&moved, f[1].path, f[0].path);
    check_against_whole(
        &dark, f[2].path, f[1].path); // what was solved again serves as well, and moves back
    for (int k = 0; k < 3; k++)
        remove_folder(f[k].path);
}

static void albedos_need_no_rays_of_rows(void **state)
{
    (void)state;
    folder before = new_folder(), after = new_folder();
    room dark = plain;
    dark.albedo = 0.1f;
    leave(&plain, before.path, NULL);
    world *w = build(&dark, 2);
    rsv_solution *s = solve(w, after.path, before.path);
    assert_true(s->report.kept_row_rays > 0);
    assert_int_equal(s->report.kept_row_rays, s->report.row_rays);
    rsv_solution_destroy(s);
    world_end(w);
    remove_folder(before.path);
    remove_folder(after.path);
}

static void threads_make_no_difference(void **state)
{
    (void)state;
    folder before = new_folder();
    room moved = plain;
    moved.box_at = 0.8f;
    leave(&plain, before.path, NULL);
    rsv_solution *s[2];
    world *w[2];
    for (int k = 0; k < 2; k++) {
        folder after = new_folder();
        w[k] = build(&moved, k + 1);
        s[k] = solve(w[k], after.path, before.path);
        remove_folder(after.path);
    }
    assert_int_equal(s[0]->fine.elements->node_count, s[1]->fine.elements->node_count);
    assert_memory_equal(
        s[0]->irradiance, s[1]->irradiance, s[0]->elements->node_count * sizeof *s[0]->irradiance);
    assert_memory_equal(s[0]->fine.direct, s[1]->fine.direct,
        s[0]->fine.elements->node_count * sizeof *s[0]->fine.direct);
    for (int k = 0; k < 2; k++) {
        rsv_solution_destroy(s[k]);
        world_end(w[k]);
    }
    remove_folder(before.path);
}

/// The file of what a solve knew, in a folder. @return to be freed
static rsv_past_header *read_past(const char *folder_path, size_t *bytes)
{
    char path[512] = { 0 };
    DIR *directory = opendir(folder_path);
    for (struct dirent *entry; (entry = readdir(directory));)
        if (strstr(entry->d_name, ".past"))
            snprintf(path, sizeof path, "%.200s/%.200s", folder_path, entry->d_name);
    closedir(directory);
    return (rsv_past_header *)(void *)read_bytes(path, bytes);
}

static void write_past(const char *folder_path, rsv_past_header *h, size_t bytes)
{
    char path[512];
    assert_true(rsv_past_path(folder_path, h->settings, path, sizeof path));
    h->checksum = rsv_past_checksum(h, bytes);
    write_bytes(path, h, bytes);
}

/// Leaves in `rows` what a solve of the room knew, as if that had been one by `settings`.
static void leave_for(const room *r, const char *rows, uint64_t settings)
{
    size_t bytes;
    leave(r, rows, NULL);
    rsv_past_header *h = read_past(rows, &bytes);
    h->settings = settings;
    write_past(rows, h, bytes);
    free(h);
}

static void budgets_coarsen_what_was_finer_before(void **state)
{
    (void)state;
    folder before = new_folder(), after = new_folder();
    room moved = plain;
    moved.box_at = 0.8f;
    world *w = build(&moved, 2);
    rsv_solution *s = NULL;
    rsv_solve_desc desc = few_elements(after.path, NULL);
    desc.max_elements = 150;
    desc.direct_level = false;
    assert_int_equal(rsv_solution_create(w->scene, &desc, &s), RSV_OK);
    size_t bytes;
    rsv_past_header *h = read_past(after.path, &bytes);
    float metres = s->elements->spacing;
    assert_true(metres > 1.1f * h->spacing[0]); // what was asked for: the next one begins there
    rsv_solution_destroy(s);
    leave_for(&plain, before.path, h->settings);
    free(h);
    desc.earlier = before.path;
    assert_int_equal(rsv_solution_create(w->scene, &desc, &s), RSV_OK);
    assert_true(rsv_solution_rows(s) <= desc.max_elements);
    assert_true(s->elements->spacing < 1.5f * metres); // not clusters of what is too fine
    rsv_solution_destroy(s);
    world_end(w);
    remove_folder(before.path);
    remove_folder(after.path);
}

typedef void (*forger)(rsv_past_header *, const rsv_past_layout *);

static void forge_nothing(rsv_past_header *h, const rsv_past_layout *l) { (void)h, (void)l; }

static void forge_spacing(rsv_past_header *h, const rsv_past_layout *l)
{
    (void)l;
    h->spacing[1] = NAN;
}

static void forge_light(rsv_past_header *h, const rsv_past_layout *l)
{
    (void)h;
    ((rsv_past_node *)(void *)l->nodes[RSV_PAST_FINE].value)[3].direct.g = NAN;
}

static void forge_box(rsv_past_header *h, const rsv_past_layout *l)
{
    (void)h;
    l->triangle[0].low.x = NAN;
}

enum { KEPT_KEY = 1000 };

/// No slot is free, every cell was split, and faces have levels that there are not.
static void forge_cells(rsv_past_header *h, const rsv_past_layout *l)
{
    (void)h;
    const rsv_past_table *t = &l->cells[RSV_PAST_COARSE];
    for (size_t k = 0; k < t->slots; k++) {
        t->key[k] = KEPT_KEY + k;
        t->value[k] = 0xff;
    }
}

/// What is written of a room, forged, and opened again.
static rsv_past *open_forged(const world *w, const folder *f, forger forge)
{
    size_t bytes;
    rsv_past *past = NULL;
    const rsv_spacing spacing = { .metres = 1, .reach = INFINITY };
    const rsv_past_fields nothing[RSV_PAST_LEVELS] = { { 0 } };
    rsv_past_write(&w->transport, w->lights, f->path, 1, &spacing, nothing);
    rsv_past_header *h = read_past(f->path, &bytes);
    rsv_past_layout layout = rsv_past_layout_of(h);
    forge(h, &layout);
    write_past(f->path, h, bytes);
    free(h);
    assert_int_equal(rsv_past_open(&w->transport, w->lights, f->path, 1, &past), RSV_OK);
    return past;
}

static void forged_files_lead_nowhere(void **state)
{
    (void)state;
    folder f = new_folder();
    world *w = build(&plain, 1);
    rsv_past *past = open_forged(w, &f, forge_nothing);
    assert_non_null(past);
    rsv_past_close(past);
    assert_null(open_forged(w, &f, forge_spacing));
    assert_null(open_forged(w, &f, forge_light));
    assert_null(open_forged(w, &f, forge_box));
    past = open_forged(w, &f, forge_cells);
    assert_non_null(past);
    uint8_t halvings, level;
    assert_true(rsv_past_was_split(past, RSV_PAST_COARSE, KEPT_KEY));
    assert_false(rsv_past_was_split(past, RSV_PAST_COARSE, KEPT_KEY - 1)); // comes back at all
    assert_false(rsv_past_find_face(past, KEPT_KEY, &halvings, &level));
    rsv_past_close(past);
    world_end(w);
    remove_folder(f.path);
}

/// A cell as small as there are, which its past says was split all the same.
static void cells_are_split_to_the_finest_level_at_most(void **state)
{
    (void)state;
    folder f = new_folder();
    world *w = build(&plain, 1);
    rsv_elements *e = NULL;
    const rsv_spacing spacing = { .metres = 10, .reach = INFINITY };
    assert_int_equal(rsv_elements_create(w->scene, w->bsdf, &spacing, &e), RSV_OK);
    rsv_past *past = NULL;
    rsv_past_header *h;
    size_t bytes;
    const rsv_past_fields nothing[RSV_PAST_LEVELS] = { { 0 } };
    rsv_past_write(&w->transport, w->lights, f.path, 1, &spacing, nothing);
    h = read_past(f.path, &bytes);
    rsv_past_layout layout = rsv_past_layout_of(h);
    rsv_cell *cell = &e->cell[0];
    for (int finest = 0; finest < 2; finest++) {
        cell->level = (uint8_t)(RSV_MAX_LEVEL - 1 + finest);
        uint64_t key = rsv_cell_key_on(rsv_face_key(e, cell->face), cell);
        size_t slot = rsv_past_slot(&layout.cells[RSV_PAST_FINE], key);
        layout.cells[RSV_PAST_FINE].key[slot] = key;
        layout.cells[RSV_PAST_FINE].value[slot] = RSV_PAST_SPLIT;
    }
    write_past(f.path, h, bytes);
    free(h);
    assert_int_equal(rsv_past_open(&w->transport, w->lights, f.path, 1, &past), RSV_OK);
    assert_non_null(past);
    assert_false(rsv_past_was_cell_split(past, RSV_PAST_FINE, e, 0));
    cell->level--;
    assert_true(rsv_past_was_cell_split(past, RSV_PAST_FINE, e, 0));
    rsv_past_close(past);
    rsv_elements_destroy(e);
    world_end(w);
    remove_folder(f.path);
}

static uint64_t key_of_coat(rsv_rgb specular_color, rsv_rgb sheen_color, float roughness)
{
    world *w = world_begin(1);
    rsv_material coat = lambert_material(0.5f, 0);
    coat.specular = 1;
    coat.specular_color = specular_color;
    coat.sheen_color = sheen_color;
    coat.roughness = roughness;
    world_room(w, world_material(w, coat), v3(0, 0, 0), v3(1, 1, 1));
    world_commit(w);
    uint64_t key = rsv_past_triangle_key(&w->transport, 0);
    world_end(w);
    return key;
}

static void another_coat_is_another_surface(void **state)
{
    (void)state;
    const rsv_rgb black = rgb_gray(0), white = rgb_gray(1), red = rgb(1, 0.5f, 0.5f);
    uint64_t key = key_of_coat(white, black, 0.5f);
    assert_int_equal(key_of_coat(white, black, 0.5f), key);
    assert_int_not_equal(key_of_coat(red, black, 0.5f), key);
    assert_int_not_equal(key_of_coat(white, red, 0.5f), key);
    assert_int_not_equal(key_of_coat(white, black, 0.25f), key);
}

static bool segment_meets(rsv_vec3 from, rsv_vec3 to, rsv_vec3 low, rsv_vec3 high)
{
    for (int step = 0; step <= 200; step++) { // slow and obvious
        rsv_vec3 p = v3_mad(from, (float)step / 200, v3_sub(to, from));
        if (p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y && p.z >= low.z &&
            p.z <= high.z)
            return true;
    }
    return false;
}

/// Lines from a cell to the lamp against all boxes of the change.
static bool any_line_meets(const rsv_scene_change *change, const rsv_elements *e, uint32_t c)
{
    rsv_random random = rsv_random_from(1, c, 0);
    for (int line = 0; line < 24; line++) {
        float u[3], v[3], a = rsv_random_float(&random), b = rsv_random_float(&random);
        for (int k = 0; k < 3; k++)
            rsv_cell_corner(&e->cell[c], k, &u[k], &v[k]);
        if (a + b > 1) a = 1 - a, b = 1 - b;
        uint32_t face = e->cell[c].face;
        rsv_vec3 from = rsv_surface_point_at(e->scene, e->face_triangle[face],
            u[0] + a * (u[1] - u[0]) + b * (u[2] - u[0]),
            v[0] + a * (v[1] - v[0]) + b * (v[2] - v[0]), e->face_back[face])
                            .position;
        rsv_vec3 to =
            v3(1 + 0.3f * rsv_random_float(&random), 1.9f, 0.8f + 0.4f * rsv_random_float(&random));
        for (uint32_t k = 0; k < change->count; k++)
            if (segment_meets(from, to, change->low[k], change->high[k])) return true;
    }
    return false;
}

static void light_is_the_same_only_where_no_line_to_a_lamp_meets_the_change(void **state)
{
    (void)state;
    folder before = new_folder(), after = new_folder();
    room moved = plain;
    moved.box_at = 0.8f;
    leave(&plain, before.path, NULL);
    world *w = build(&moved, 2);
    rsv_solution *s = solve(w, after.path, before.path);
    rsv_past *past = NULL;
    DIR *directory = opendir(before.path);
    unsigned long long settings = 0;
    for (struct dirent *entry; (entry = readdir(directory));)
        if (strstr(entry->d_name, ".past")) settings = strtoull(entry->d_name, NULL, 16);
    closedir(directory);
    assert_int_equal(rsv_past_open(&s->scene, s->lights, before.path, settings, &past), RSV_OK);
    assert_non_null(past);
    size_t same = 0;
    for (uint32_t c = 0; c < s->elements->cell_count; c++) {
        if (rsv_past_is_lit_anew(past, s->elements, c)) continue;
        same++;
        assert_false(any_line_meets(rsv_past_change(past), s->elements, c));
    }
    assert_true(same > s->elements->cell_count / 3);
    rsv_past_close(past);
    rsv_solution_destroy(s);
    world_end(w);
    remove_folder(before.path);
    remove_folder(after.path);
}

static void damage(const char *folder_path)
{
    DIR *directory = opendir(folder_path);
    for (struct dirent *entry; (entry = readdir(directory));) {
        char path[512];
        if (!strstr(entry->d_name, ".past")) continue;
        snprintf(path, sizeof path, "%.200s/%.200s", folder_path, entry->d_name);
        FILE *file = fopen(path, "r+b");
        assert_non_null(file);
        assert_int_equal(fseek(file, 5000, SEEK_SET), 0);
        assert_int_equal(fputc(0x55, file), 0x55);
        fclose(file);
    }
    closedir(directory);
}

static void damaged_files_are_passed_over(void **state)
{
    (void)state;
    folder before = new_folder(), after = new_folder();
    room brighter = plain;
    brighter.radiance = 2;
    leave(&plain, before.path, NULL);
    damage(before.path);
    world *w = build(&brighter, 2);
    rsv_solution *again = solve(w, after.path, before.path), *whole = solve(w, NULL, NULL);
    assert_int_equal(again->elements->node_count, whole->elements->node_count);
    assert_memory_equal(again->irradiance, whole->irradiance,
        whole->elements->node_count * sizeof *whole->irradiance);
    rsv_solution_destroy(again);
    rsv_solution_destroy(whole);
    world_end(w);
    remove_folder(before.path);
    remove_folder(after.path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_edit_gives_what_a_whole_solution_gives),
        cmocka_unit_test(albedos_need_no_rays_of_rows),
        cmocka_unit_test(threads_make_no_difference),
        cmocka_unit_test(light_is_the_same_only_where_no_line_to_a_lamp_meets_the_change),
        cmocka_unit_test(damaged_files_are_passed_over),
        cmocka_unit_test(budgets_coarsen_what_was_finer_before),
        cmocka_unit_test(forged_files_lead_nowhere),
        cmocka_unit_test(cells_are_split_to_the_finest_level_at_most),
        cmocka_unit_test(another_coat_is_another_surface),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
