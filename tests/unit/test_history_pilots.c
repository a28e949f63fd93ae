/// Pilots and budgets of a scene that is solved again after an edit.
#include "history_fixture.h"

/// Pilots gather light of the sky again near an edit, and reuse the rest.
static void pilots_split_under_a_sky_after_an_edit(void **state)
{
    (void)state;
    room then = plain, now = moved;
    then.sky = now.sky = 1;
    edited_room r = edit(&then, &now);
    rsv_light *whole = solve_as(r.w, NULL, NULL, 1), *other = solve_as(r.w, NULL, NULL, 2);
    assert_true(inside(r.s)->report.kept_row_rays > inside(r.s)->report.row_rays / 2);
    double rows = (double)rsv_light_report(r.s)->rows,
           rows_whole = (double)rsv_light_report(whole)->rows;
    assert_true(rows > 0.8 * rows_whole && rows < 1.25 * rows_whole);
    assert_true(difference(whole, r.s) < 1.5 * difference(whole, other));
    rsv_light_destroy(whole);
    rsv_light_destroy(other);
    end_edit(&r);
}

static void memory_enough_changes_nothing_after_an_edit(void **state)
{
    (void)state;
    edited_room r = edit(&plain, &moved);
    folder before = new_folder(), after = new_folder();
    world *w = build(&plain, 2);
    rsv_light *s = NULL;
    rsv_solve_desc desc = few_elements(before.path, NULL);
    desc.max_bytes = (size_t)4 << 30;
    assert_int_equal(rsv_light_create(w->scene, &desc, &s), RSV_OK);
    rsv_light_destroy(s);
    desc.checkpoint = after.path;
    desc.earlier = before.path;
    assert_int_equal(rsv_light_create(r.w->scene, &desc, &s), RSV_OK);
    assert_int_equal(inside(s)->report.kept_row_rays, inside(r.s)->report.kept_row_rays);
    assert_int_equal(inside(s)->elements->node_count, inside(r.s)->elements->node_count);
    assert_memory_equal(inside(s)->irradiance, inside(r.s)->irradiance,
        inside(s)->elements->node_count * sizeof(rsv_rgb));
    rsv_light_destroy(s);
    world_end(w);
    remove_folder(before.path);
    remove_folder(after.path);
    end_edit(&r);
}

/// Stores in `rows` what a solve of the room leaves, as if it had been solved with `settings`.
static void leave_for(const room *r, const char *rows, uint64_t settings)
{
    size_t bytes;
    leave(r, rows, NULL);
    rsv_history_header *h = read_past(rows, &bytes);
    h->settings = settings;
    write_past(rows, h, bytes);
    free(h);
}

static void budgets_coarsen_what_was_finer_before(void **state)
{
    (void)state;
    folder before = new_folder(), after = new_folder();
    world *w = build(&moved, 2);
    rsv_light *s = NULL;
    rsv_solve_desc desc = few_elements(after.path, NULL);
    desc.max_elements = 150;
    desc.direct_level = false;
    assert_int_equal(rsv_light_create(w->scene, &desc, &s), RSV_OK);
    size_t bytes;
    rsv_history_header *h = read_past(after.path, &bytes);
    float metres = inside(s)->elements->spacing;
    assert_true(metres > 1.1f * h->spacing[0]); // what was asked for: the next one begins there
    rsv_light_destroy(s);
    leave_for(&plain, before.path, h->settings);
    free(h);
    desc.earlier = before.path;
    assert_int_equal(rsv_light_create(w->scene, &desc, &s), RSV_OK);
    assert_true(rsv_light_report(s)->rows <= desc.max_elements);
    assert_true(inside(s)->elements->spacing < 1.5f * metres); // not clusters of what is too fine
    rsv_light_destroy(s);
    world_end(w);
    remove_folder(before.path);
    remove_folder(after.path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pilots_split_under_a_sky_after_an_edit),
        cmocka_unit_test(memory_enough_changes_nothing_after_an_edit),
        cmocka_unit_test(budgets_coarsen_what_was_finer_before),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
