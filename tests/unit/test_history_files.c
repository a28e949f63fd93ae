/// Damaged and forged files of the previous solve.
#include "elements/elements.h"
#include "elements/open_corners.h"
#include "history_fixture.h"

static void damage(const char *folder_path)
{
    DIR *directory = opendir(folder_path);
    for (struct dirent *entry; (entry = readdir(directory));) {
        char path[512];
        if (!strstr(entry->d_name, ".history")) continue;
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
    rsv_light *again = solve(w, after.path, before.path), *whole = solve(w, NULL, NULL);
    assert_int_equal(inside(again)->elements->node_count, inside(whole)->elements->node_count);
    assert_memory_equal(inside(again)->irradiance, inside(whole)->irradiance,
        inside(whole)->elements->node_count * sizeof *inside(whole)->irradiance);
    rsv_light_destroy(again);
    rsv_light_destroy(whole);
    world_end(w);
    remove_folder(before.path);
    remove_folder(after.path);
}

typedef void (*forger)(rsv_history_header *, const rsv_history_layout *);

static void forge_nothing(rsv_history_header *h, const rsv_history_layout *l) { (void)h, (void)l; }

static void forge_spacing(rsv_history_header *h, const rsv_history_layout *l)
{
    (void)l;
    h->spacing[1] = NAN;
}

static void forge_light(rsv_history_header *h, const rsv_history_layout *l)
{
    (void)h;
    ((rsv_history_light *)(void *)l->nodes[RSV_HISTORY_FINE].value)[3].direct.g = NAN;
}

static void forge_node(rsv_history_header *h, const rsv_history_layout *l)
{
    (void)h;
    ((rsv_history_node *)(void *)l->nodes[RSV_HISTORY_COARSE].value)[3].indirect.g = NAN;
}

static void forge_box(rsv_history_header *h, const rsv_history_layout *l)
{
    (void)h;
    l->triangle[0].low.x = NAN;
}

/// No slot is free.
static void forge_table(rsv_history_header *h, const rsv_history_layout *l)
{
    (void)h;
    const rsv_history_table *t = &l->nodes[RSV_HISTORY_COARSE];
    for (size_t k = 0; k < t->slots; k++)
        t->key[k] = 1000 + k;
}

static void forge_level(rsv_history_header *h, const rsv_history_layout *l)
{
    (void)h;
    l->cells[RSV_HISTORY_COARSE].face[0].level = RSV_MAX_LEVEL + 1;
}

static void forge_halvings(rsv_history_header *h, const rsv_history_layout *l)
{
    (void)h;
    l->cells[RSV_HISTORY_COARSE].face[0].halvings = 255;
}

static void forge_grid_past_the_end(rsv_history_header *h, const rsv_history_layout *l)
{
    l->cells[RSV_HISTORY_COARSE].face[0].slot = (uint32_t)h->slots[RSV_HISTORY_COARSE];
}

static void forge_children_past_the_end(rsv_history_header *h, const rsv_history_layout *l)
{
    l->cells[RSV_HISTORY_COARSE].slot[0] =
        RSV_SLOT_SPLIT | (uint32_t)(h->slots[RSV_HISTORY_COARSE] - 3);
}

/// A cell that is its own child.
static void forge_loop(rsv_history_header *h, const rsv_history_layout *l)
{
    (void)h;
    l->cells[RSV_HISTORY_COARSE].slot[0] = RSV_SLOT_SPLIT;
}

/// What a solve of the room left, forged, and opened again.
static opened open_forged(
    const world *w, const folder *f, const rsv_history_header *left, size_t bytes, forger forge)
{
    rsv_history_header *h = malloc(bytes);
    assert_non_null(h);
    memcpy(h, left, bytes);
    rsv_history_layout layout = rsv_history_layout_of(h);
    forge(h, &layout);
    write_past(f->path, h, bytes);
    opened o = open_history(&w->transport, w->lights, f->path, h->settings);
    free(h);
    return o;
}

static void forged_files_lead_nowhere(void **state)
{
    (void)state;
    static const forger refused[] = { forge_spacing, forge_light, forge_node, forge_box,
        forge_level, forge_halvings, forge_grid_past_the_end, forge_children_past_the_end,
        forge_loop };
    folder f = new_folder();
    world *w = build(&plain, 1);
    size_t bytes;
    rsv_light_destroy(solve(w, f.path, NULL));
    rsv_history_header *left = read_past(f.path, &bytes);
    opened o = open_forged(w, &f, left, bytes, forge_nothing);
    assert_non_null(o.history);
    close_history(&o);
    for (size_t k = 0; k < sizeof refused / sizeof *refused; k++) {
        o = open_forged(w, &f, left, bytes, refused[k]);
        assert_null(o.history);
        close_history(&o);
    }
    o = open_forged(w, &f, left, bytes, forge_table);
    assert_non_null(o.history);
    rsv_elements *e = NULL;
    const rsv_spacing spacing = { .metres = 1, .reach = INFINITY };
    assert_int_equal(rsv_elements_create(w->scene, w->bsdf, &spacing, &e), RSV_OK);
    assert_null(rsv_history_find_node(o.history, e, 0, 999)); // comes back at all
    rsv_elements_destroy(e);
    close_history(&o);
    free(left);
    world_end(w);
    remove_folder(f.path);
}

/// The parent of a cell, in slow and obvious ways.
static rsv_cell parent_of(rsv_cell cell)
{
    for (int flipped = 0; flipped < 2; flipped++)
        for (int k = 0; k < 4; k++) {
            rsv_cell parent = { cell.face, cell.i / 2, cell.j / 2, (uint8_t)(cell.level - 1),
                (uint8_t)flipped };
            rsv_cell child = rsv_child_cell(parent, k);
            if (child.i == cell.i && child.j == cell.j && child.flipped == cell.flipped)
                return parent;
        }
    fail();
    return cell;
}

static void cells_are_found_again(void **state)
{
    (void)state;
    folder f = new_folder();
    world *w = build(&plain, 1);
    size_t bytes, parents = 0;
    rsv_light *s = solve(w, f.path, NULL);
    rsv_history_header *h = read_past(f.path, &bytes);
    opened o = open_history(&w->transport, w->lights, f.path, h->settings);
    const rsv_history *past = o.history;
    assert_non_null(past);
    rsv_elements *e = inside(s)->fine.elements, unjudged = *e;
    unjudged.cell_openness = NULL;
    uint64_t rays = 0;
    for (uint32_t c = 0; c < e->cell_count; c++) {
        uint8_t openness = 0xff;
        assert_false(rsv_history_was_split(past, RSV_HISTORY_FINE, e, c));
        assert_true(rsv_history_openness(past, e, c, &openness));
        assert_int_equal(openness, e->cell_openness[c]);
        rsv_cell cell = e->cell[c];
        if (cell.level == e->face_level[cell.face]) continue;
        e->cell[c] = parent_of(cell);
        assert_true(rsv_history_was_split(past, RSV_HISTORY_FINE, e, c));
        rsv_cell_shape shape = rsv_cell_shape_of(e, c);
        uint8_t judged = rsv_cell_openness(&w->transport, &unjudged, c, &shape, &rays);
        if (rsv_history_openness(past, e, c, &openness)) assert_int_equal(openness, judged);
        e->cell[c] = cell;
        parents++;
    }
    assert_true(parents > e->cell_count / 2);
    close_history(&o);
    rsv_light_destroy(s);
    free(h);
    world_end(w);
    remove_folder(f.path);
}

/// Splits deeper than there are levels, below one cell of a file.
static void dig(rsv_history_header **h, size_t *bytes)
{
    enum { MORE = 4 * (RSV_MAX_LEVEL + 1) };
    rsv_history_layout l = rsv_history_layout_of(*h);
    rsv_history_header *deeper = calloc(*bytes + 5 * MORE + 16, 1);
    assert_non_null(deeper);
    *deeper = **h;
    deeper->slots[RSV_HISTORY_FINE] += MORE;
    rsv_history_layout to = rsv_history_layout_of(deeper);
    memcpy(to.triangle, l.triangle, (*h)->triangle_count * sizeof *to.triangle);
    for (int level = 0; level < RSV_HISTORY_LEVELS; level++) {
        const rsv_history_cells *c = &l.cells[level];
        memcpy(to.cells[level].face, c->face, c->face_count * sizeof *c->face);
        memcpy(to.cells[level].slot, c->slot, c->slot_count * sizeof *c->slot);
    }
    uint32_t slot = l.cells[RSV_HISTORY_FINE].face[0].slot,
             *slots = to.cells[RSV_HISTORY_FINE].slot;
    while (slots[slot] & RSV_SLOT_SPLIT)
        slot = slots[slot] & ~RSV_SLOT_SPLIT;
    for (uint32_t next = (uint32_t)l.cells[RSV_HISTORY_FINE].slot_count;
         next < to.cells[RSV_HISTORY_FINE].slot_count; slot = next, next += 4)
        slots[slot] = RSV_SLOT_SPLIT | next;
    *bytes = to.bytes;
    free(*h);
    *h = deeper;
}

/// A cell of the smallest size, which the history file nevertheless calls split.
static void cells_are_split_to_the_finest_level_at_most(void **state)
{
    (void)state;
    folder f = new_folder();
    world *w = build(&plain, 1);
    size_t bytes;
    rsv_light *s = solve(w, f.path, NULL);
    rsv_history_header *h = read_past(f.path, &bytes);
    dig(&h, &bytes);
    write_past(f.path, h, bytes);
    opened o = open_history(&w->transport, w->lights, f.path, h->settings);
    const rsv_history *past = o.history;
    assert_non_null(past);
    rsv_cell *cell = &inside(s)->fine.elements->cell[0]; // the first of its face, at any depth
    *cell = (rsv_cell){ .level = RSV_MAX_LEVEL };
    assert_false(rsv_history_was_split(past, RSV_HISTORY_FINE, inside(s)->fine.elements, 0));
    cell->level--;
    assert_true(rsv_history_was_split(past, RSV_HISTORY_FINE, inside(s)->fine.elements, 0));
    close_history(&o);
    rsv_light_destroy(s);
    free(h);
    world_end(w);
    remove_folder(f.path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(damaged_files_are_passed_over),
        cmocka_unit_test(forged_files_lead_nowhere),
        cmocka_unit_test(cells_are_found_again),
        cmocka_unit_test(cells_are_split_to_the_finest_level_at_most),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
