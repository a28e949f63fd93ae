/// Solving a scene again after an edit, from a store in memory: compared with folders, and behaviour of both kinds of
/// store.
#include "thread_team.h" // which has rooms of another kind

#include "history_fixture.h"
#include "resolvent/update.h"
#include "slow_tests.h"

// ---- stores ---------------------------------------------------------------------------------------

static rsv_status add_name(void *user, const char *name)
{
    strcat(strcat(user, name), " ");
    return RSV_OK;
}

/// What a blob holds, all of its parts, as text.
static const char *text_of(rsv_store *s, const char *name)
{
    static char text[64];
    size_t length = 0;
    rsv_blob blob;
    for (size_t part = 0;; part++) {
        assert_int_equal(s->table->read(s, name, part, &blob), RSV_OK);
        if (blob.count == 0) break;
        assert_true(length + blob.count < sizeof text);
        memcpy(text + length, blob.byte, blob.count);
        length += blob.count;
        s->table->release(s, &blob);
    }
    text[length] = 0;
    return text;
}

static void append(rsv_store *s, const char *name, size_t keep, const char *text)
{
    int end;
    assert_int_equal(s->table->open(s, name, keep, &end), 0);
    assert_int_equal(s->table->append(s, end, text, strlen(text)), 0);
    s->table->close(s, end);
}

static void check_store(rsv_store *s)
{
    char names[64] = "";
    assert_string_equal(text_of(s, "none"), "");
    assert_int_equal(s->table->write(s, "b", "old", 3), 0);
    assert_int_equal(s->table->write(s, "b", "newer", 5), 0);
    append(s, "a", 0, "abc");
    append(s, "c", 0, "");
    append(s, "a", 3, "def");
    assert_string_equal(text_of(s, "a"), "abcdef");
    append(s, "a", 3, "ghi");
    assert_string_equal(text_of(s, "a"), "abcghi");
    assert_string_equal(text_of(s, "b"), "newer");
    assert_string_equal(text_of(s, "c"), "");
    assert_int_equal(s->table->list(s, add_name, names), RSV_OK);
    assert_string_equal(names, "a b c ");
    rsv_store_destroy(s);
}

static void stores_of_each_kind_keep_blobs(void **state)
{
    (void)state;
    folder f = new_folder();
    world *w = world_begin(1);
    rsv_store *s = NULL;
    assert_int_equal(rsv_store_memory(w->context, &s), RSV_OK);
    check_store(s);
    assert_int_equal(rsv_store_folder(w->context, f.path, &s), RSV_OK);
    check_store(s);
    world_end(w);
    remove_folder(f.path);
}

// ---- updates --------------------------------------------------------------------------------------

static rsv_solve_desc fewer_elements(void)
{
    rsv_solve_desc desc = few_elements(NULL, NULL);
    desc.element_target = 200;
    return desc;
}

/// A store in a context of its own, which counts what is alive.
typedef struct memory {
    world *w;
    rsv_update_store *store;
} memory;

static memory new_memory(void)
{
    memory m = { .w = world_begin(1) };
    assert_int_equal(rsv_update_store_create(m.w->context, &m.store), RSV_OK);
    return m;
}

static void end_memory(memory *m)
{
    rsv_update_store_destroy(m->store);
    world_end(m->w);
}

static rsv_light *update_by(
    const world *w, const rsv_solve_desc *desc, rsv_update_store *store, rsv_update_report *report)
{
    rsv_light *s = NULL;
    if (rsv_operator_update(w->scene, desc, store, &s, report) != RSV_OK)
        fail_msg("%s", rsv_last_error());
    return s;
}

static rsv_light *update(const world *w, rsv_update_store *store, rsv_update_report *report)
{
    const rsv_solve_desc desc = fewer_elements();
    return update_by(w, &desc, store, report);
}

static void check_same(const rsv_light *a, const rsv_light *b)
{
    const rsv_light_view *p = inside(a), *q = inside(b);
    assert_int_equal(p->elements->node_count, q->elements->node_count);
    assert_memory_equal(
        p->irradiance, q->irradiance, p->elements->node_count * sizeof *p->irradiance);
    assert_int_equal(p->fine.elements->node_count, q->fine.elements->node_count);
    assert_memory_equal(
        p->fine.direct, q->fine.direct, p->fine.elements->node_count * sizeof *p->fine.direct);
    assert_int_equal(p->report.kept_row_rays, q->report.kept_row_rays);
}

/// A box that is moved, painted, and moved back.
static void memory_does_what_folders_do(void **state)
{
    (void)state;
    enum { VERSIONS = 4 };
    room version[VERSIONS] = { plain, moved, moved, plain };
    version[2].albedo = 0.1f;
    folder f[VERSIONS];
    memory m = new_memory();
    for (int k = 0; k < VERSIONS; k++) {
        world *w = build(&version[k], 1 + k % 2);
        rsv_solve_desc desc = fewer_elements();
        rsv_light *by_folder = NULL, *by_memory = update(w, m.store, NULL);
        f[k] = new_folder();
        desc.checkpoint = f[k].path;
        desc.earlier = k > 0 ? f[k - 1].path : NULL;
        assert_int_equal(rsv_light_create(w->scene, &desc, &by_folder), RSV_OK);
        check_same(by_memory, by_folder);
        rsv_light_destroy(by_memory);
        rsv_light_destroy(by_folder);
        world_end(w);
    }
    for (int k = 0; k < VERSIONS; k++)
        remove_folder(f[k].path);
    end_memory(&m);
}

static void the_report_says_what_was_kept(void **state)
{
    (void)state;
    rsv_update_report first, same, painted, edited;
    room dark = plain;
    dark.albedo = 0.1f;
    world *w[3] = { build(&plain, 2), build(&dark, 2), build(&moved, 2) };
    memory m = new_memory();
    assert_int_equal(rsv_update_store_bytes(m.store), 0);
    rsv_light_destroy(update(w[0], m.store, &first));
    assert_true(rsv_update_store_bytes(m.store) > first.row_rays);
    rsv_light_destroy(update(w[0], m.store, &same));
    rsv_light_destroy(update(w[1], m.store, &painted));
    rsv_light_destroy(update(w[2], m.store, &edited));
    assert_true(first.rows > 0 && first.row_rays > 0 && first.lit_elements > first.rows);
    assert_int_equal(
        first.kept_elements + first.kept_rows + first.kept_row_rays + first.kept_lit_elements, 0);
    const rsv_update_report *all[] = { &same, &painted };
    for (int k = 0; k < 2; k++) {
        assert_int_equal(all[k]->kept_elements, all[k]->rows);
        assert_int_equal(all[k]->kept_rows, all[k]->rows);
        assert_int_equal(all[k]->kept_row_rays, all[k]->row_rays);
        assert_int_equal(all[k]->kept_lit_elements, all[k]->lit_elements);
    }
    assert_true(edited.kept_elements > edited.rows / 2 && edited.kept_elements < edited.rows);
    assert_true(edited.kept_rows > 0 && edited.kept_rows < edited.kept_elements);
    assert_true(
        edited.kept_row_rays > edited.row_rays / 2 && edited.kept_row_rays < edited.row_rays);
    assert_true(edited.kept_lit_elements > edited.lit_elements / 4 &&
                edited.kept_lit_elements < edited.lit_elements);
    rsv_update_store_clear(m.store);
    assert_int_equal(rsv_update_store_bytes(m.store), 0);
    end_memory(&m);
    for (int k = 0; k < 3; k++)
        world_end(w[k]);
}

/// The largest difference from independent solutions: those of five seeds scatter by a fifth.
static double chance_difference(const world *w, const rsv_light *first)
{
    rsv_solve_desc desc = fewer_elements();
    double largest = 0;
    for (desc.seed = 2; desc.seed <= 6; desc.seed++) {
        rsv_light *other;
        assert_int_equal(rsv_light_create(w->scene, &desc, &other), RSV_OK);
        largest = fmax(largest, difference(first, other));
        rsv_light_destroy(other);
    }
    return largest;
}

/// The same room after each pair of edits: neither its light nor the size of the store drifts. Elements may settle
/// otherwise than at first, by chance, within a few pairs; from then on, edits and back leave the light as it was.
static void edits_back_and_forth_end_where_they_began(void **state)
{
    (void)state;
    enum { PAIRS = 5 };
    world *w[2] = { build(&plain, 2), build(&moved, 2) };
    memory m = new_memory();
    rsv_light *first = update(w[0], m.store, NULL), *before = NULL, *last = NULL;
    size_t bytes = rsv_update_store_bytes(m.store);
    for (int pair = 0; pair < PAIRS; pair++) {
        rsv_light_destroy(before);
        before = last;
        rsv_light_destroy(update(w[1], m.store, NULL));
        last = update(w[0], m.store, NULL);
    }
    double chance = chance_difference(w[0], first), drift = difference(first, last);
    if (!(drift < chance)) fail_msg("%g after edits, %g by chance", drift, chance);
    drift = difference(before, last);
    if (!(drift < 0.01 * chance)) fail_msg("%g by the last edits, %g by chance", drift, chance);
    assert_true((double)rsv_update_store_bytes(m.store) < 1.1 * (double)bytes);
    rsv_light_destroy(first);
    rsv_light_destroy(before);
    rsv_light_destroy(last);
    end_memory(&m);
    world_end(w[0]);
    world_end(w[1]);
}

/// A closed room with a box on the floor. @param specular of all: 1 = coated, as glTF's materials are by default
static world *build_coated(float specular, float x, float z)
{
    rsv_material coated = lambert_material(0.6f, 0);
    coated.specular = specular;
    coated.roughness = 0.3f;
    world *w = world_begin(2);
    uint32_t walls = world_material(w, coated);
    coated.base_color = rgb(0.7f, 0.1f, 0.1f);
    uint32_t box = world_material(w, coated), lamp = world_lambert(w, 0, 10);
    world_room(w, walls, v3(0, 0, 0), v3(4, 2, 4));
    world_box(w, box, v3(x, 0.02f, z), v3(x + 0.3f, 0.4f, z + 0.3f));
    world_box(w, lamp, v3(1.8f, 1.9f, 1.8f), v3(2.2f, 1.95f, 2.2f));
    world_commit(w);
    return w;
}

/// The share of its rays that are kept after a move along x.
static double kept_share(float specular, float z)
{
    world *w[2] = { build_coated(specular, 0.5f, z), build_coated(specular, 0.9f, z) };
    rsv_update_report report;
    memory m = new_memory();
    rsv_light_destroy(update(w[0], m.store, NULL));
    rsv_light_destroy(update(w[1], m.store, &report));
    end_memory(&m);
    world_end(w[0]);
    world_end(w[1]);
    return (double)report.kept_row_rays / (double)report.row_rays;
}

/// Coats reflect some rays, which are traced again; the others end where they did. In one place alone, the elements
/// that each happens to get change the ratio by 0.06.
static void coated_surfaces_keep_most_of_their_rays(void **state)
{
    (void)state;
    double bare = 0, coated = 0;
    for (int k = 0; k < 3; k++) {
        bare += kept_share(0, 0.5f + 0.6f * (float)k) / 3;
        coated += kept_share(1, 0.5f + 0.6f * (float)k) / 3;
    }
    if (!(coated > 0.7 * bare && coated < bare))
        fail_msg("%g of the rays were kept, and %g without coats", coated, bare);
}

/// The mean irradiance after one random move, updated and solved as a whole, less 1.
static double apart_after_a_move(uint32_t seed)
{
    rsv_random random = rsv_random_from(seed, 0, 0);
    rsv_solve_desc desc = fewer_elements();
    desc.element_target = 600;
    desc.rays_per_element = 256;
    desc.refinements = desc.direct_levels = 0;
    desc.seed = seed;
    memory m = new_memory();
    world *w = NULL;
    rsv_light *updated = NULL, *whole = NULL;
    for (int k = 0; k < 2; k++) {
        float x = 0.1f + 3.5f * rsv_random_float(&random);
        rsv_light_destroy(updated);
        if (w) world_end(w);
        w = build_coated(1, x, 0.1f + 3.5f * rsv_random_float(&random));
        updated = update_by(w, &desc, m.store, NULL);
    }
    assert_int_equal(rsv_light_create(w->scene, &desc, &whole), RSV_OK);
    double apart =
        rsv_light_report(updated)->mean_irradiance / rsv_light_report(whole)->mean_irradiance - 1;
    rsv_light_destroy(updated);
    rsv_light_destroy(whole);
    world_end(w);
    end_memory(&m);
    return apart;
}

/// Updates are off by their sampling error alone: over many moves the mean is nothing but noise, of less than 0.2 %. Each
/// move has random numbers of its own, as errors of rows that are kept go on with them.
static void moves_are_as_good_as_solving_anew(void **state)
{
    enum { MOVES = 20 };
    (void)state;
    double sum = 0, squares = 0;
    for (uint32_t k = 0; k < MOVES; k++) {
        double apart = apart_after_a_move(k + 1);
        sum += apart;
        squares += apart * apart;
    }
    double mean = sum / MOVES, noise = sqrt((squares / MOVES - mean * mean) / (MOVES - 1));
    if (!(fabs(mean) < 2e-3 && noise < 2e-3 && fabs(mean) < 3 * noise))
        fail_msg("off by %g on average, with a standard error of %g", mean, noise);
    print_message("off by %.3g %% on average, standard error %.3g %%\n", 100 * mean, 100 * noise);
}

static void check_whole(const world *w, const rsv_solve_desc *desc, rsv_update_store *store)
{
    rsv_update_report report;
    rsv_light *whole = NULL, *updated = update_by(w, desc, store, &report);
    assert_int_equal(rsv_light_create(w->scene, desc, &whole), RSV_OK);
    assert_int_equal(report.kept_elements + report.kept_rows + report.kept_row_rays, 0);
    assert_int_equal(report.kept_lit_elements, 0);
    check_same(updated, whole);
    rsv_light_destroy(updated);
    rsv_light_destroy(whole);
}

static world *build_elsewhere(void)
{
    world *w = world_begin(2);
    world_room(w, world_lambert(w, 0.5f, 0), v3(20, 0, 0), v3(23, 2, 2));
    world_box(w, world_lambert(w, 0, 5), v3(21, 1.9f, 0.8f), v3(21.3f, 1.95f, 1.1f));
    world_commit(w);
    return w;
}

static void what_does_not_fit_is_solved_as_a_whole(void **state)
{
    (void)state;
    world *w = build(&plain, 2), *elsewhere = build_elsewhere();
    rsv_solve_desc desc = fewer_elements();
    memory m = new_memory();
    rsv_light_destroy(update(w, m.store, NULL));
    check_whole(elsewhere, &desc, m.store);
    desc.seed = 7;
    check_whole(elsewhere, &desc, m.store);
    desc.seed = 1;
    desc.rays_per_element = 128;
    check_whole(w, &desc, m.store);
    end_memory(&m);
    world_end(elsewhere);
    world_end(w);
}

static void wrong_settings_are_one_error_and_leave_the_store_alone(void **state)
{
    (void)state;
    world *w = build(&plain, 2);
    memory m = new_memory();
    rsv_update_report report;
    rsv_light *s = NULL;
    rsv_light_destroy(update(w, m.store, NULL));
    size_t bytes = rsv_update_store_bytes(m.store);
    for (int k = 0; k < 3; k++) {
        rsv_solve_desc desc = fewer_elements();
        if (k == 0) desc.checkpoint = "rows";
        if (k == 1) desc.earlier = "rows";
        if (k == 2) desc.rays_per_element = 100;
        assert_int_equal(
            rsv_operator_update(w->scene, &desc, m.store, &s, &report), RSV_ERROR_ARGUMENT);
        assert_null(s);
        assert_non_null(strstr(rsv_last_error(), k < 2 ? "leave both NULL" : "rays_per_element"));
        assert_int_equal(rsv_update_store_bytes(m.store), bytes);
    }
    rsv_light_destroy(update(w, m.store, &report));
    assert_int_equal(report.kept_rows, report.rows);
    end_memory(&m);
    world_end(w);
}

/// Fails one allocation of an update. @param of the scene's context or the store's @return whether there were so many
static bool fail_one(const world *w, memory *m, world *of, long which)
{
    const rsv_solve_desc desc = fewer_elements();
    rsv_light *s = NULL;
    long alive = w->alive;
    of->fail_once = true;
    of->until_failure = which;
    rsv_status status = rsv_operator_update(w->scene, &desc, m->store, &s, NULL);
    bool failed = of->until_failure < 0;
    of->until_failure = -1;
    if (!failed) assert_int_equal(status, RSV_OK);
    if (status != RSV_OK) assert_int_equal(status, RSV_ERROR_MEMORY);
    if (status != RSV_OK) assert_null(s);
    rsv_light_destroy(s);
    assert_int_equal(w->alive, alive); // what the store keeps is the other context's
    return failed;
}

/// The next allocation to fail; with RSV_FAULTS=1 in the environment, every one does in turn.
static long after(long which) { return getenv("RSV_FAULTS") ? which + 1 : which + 1 + which / 2; }

static void memory_that_runs_out_costs_no_more_than_the_update(void **state)
{
    (void)state;
    world *w[2] = { build(&plain, 1), build(&moved, 1) };
    memory m = new_memory();
    rsv_update_report report;
    for (int of_store = 0; of_store < 2; of_store++) {
        rsv_light_destroy(update(w[0], m.store, NULL));
        long which = 0;
        for (int edit = 1; fail_one(w[edit & 1], &m, of_store ? m.w : w[edit & 1], which); edit++)
            which = after(which);
    }
    rsv_light_destroy(update(w[0], m.store, NULL));
    rsv_light_destroy(update(w[1], m.store, &report));
    assert_true(report.kept_row_rays > report.row_rays / 2);
    end_memory(&m);
    world_end(w[0]);
    world_end(w[1]);
}

/// The result of each process of a team for an edited room.
typedef struct team_result {
    rsv_rgb *irradiance[TEAM_MOST]; ///< [count], to be freed
    size_t count[TEAM_MOST];
    rsv_update_report report[TEAM_MOST];
} team_result;

static rsv_scene *furnish_scene(rsv_context *context, const room *r)
{
    world w = { .context = context };
    if (rsv_scene_create(context, &w.scene) != RSV_OK) abort();
    furnish(&w, r);
    rsv_lights_destroy(w.lights);
    rsv_tracer_destroy(w.tracer);
    free(w.bsdf);
    return w.scene;
}

static void update_twice(rsv_team *team, void *user)
{
    team_result *result = user;
    rsv_context_desc desc = rsv_default_context_desc();
    const rsv_solve_desc solve_desc = fewer_elements();
    const room *version[] = { &plain, &moved };
    rsv_context *context;
    rsv_update_store *store;
    desc.thread_count = 1;
    desc.team = team;
    if (rsv_context_create(&desc, &context) != RSV_OK) abort();
    if (rsv_update_store_create(context, &store) != RSV_OK) abort();
    for (uint32_t k = 0, rank = team ? team->rank : 0; k < 2; k++) {
        rsv_light *s = NULL;
        rsv_scene *scene = furnish_scene(context, version[k]);
        if (rsv_operator_update(scene, &solve_desc, store, &s, &result->report[rank]) != RSV_OK)
            abort();
        free(result->irradiance[rank]);
        size_t count = result->count[rank] = inside(s)->elements->node_count;
        result->irradiance[rank] = malloc(count * sizeof(rsv_rgb));
        if (!result->irradiance[rank]) abort();
        memcpy(result->irradiance[rank], inside(s)->irradiance, count * sizeof(rsv_rgb));
        rsv_light_destroy(s);
        rsv_scene_destroy(scene);
    }
    rsv_update_store_destroy(store);
    rsv_context_destroy(context);
}

static void processes_of_a_team_have_stores_of_their_own(void **state)
{
    (void)state;
    enum { SIZE = 3 };
    team_result alone = { 0 }, together = { 0 };
    update_twice(NULL, &alone);
    run_team(SIZE, update_twice, &together);
    for (int rank = 0; rank < SIZE; rank++) {
        const rsv_update_report *r = &together.report[rank];
        assert_int_equal(together.count[rank], alone.count[0]);
        assert_memory_equal(
            together.irradiance[rank], alone.irradiance[0], alone.count[0] * sizeof(rsv_rgb));
        assert_int_equal(r->kept_elements, alone.report[0].kept_elements);
        assert_int_equal(r->kept_lit_elements, alone.report[0].kept_lit_elements);
        assert_true(r->kept_row_rays > r->row_rays / 2);
        free(together.irradiance[rank]);
    }
    free(alone.irradiance[0]);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest quick[] = {
        cmocka_unit_test(stores_of_each_kind_keep_blobs),
        cmocka_unit_test(memory_does_what_folders_do),
        cmocka_unit_test(the_report_says_what_was_kept),
        cmocka_unit_test(edits_back_and_forth_end_where_they_began),
        cmocka_unit_test(what_does_not_fit_is_solved_as_a_whole),
        cmocka_unit_test(wrong_settings_are_one_error_and_leave_the_store_alone),
        cmocka_unit_test(memory_that_runs_out_costs_no_more_than_the_update),
        cmocka_unit_test(processes_of_a_team_have_stores_of_their_own),
    };
    const struct CMUnitTest slow[] = {
        cmocka_unit_test(coated_surfaces_keep_most_of_their_rays),
    };
    const struct CMUnitTest longest[] = {
        cmocka_unit_test(moves_are_as_good_as_solving_anew),
    };
    return RUN_THIRD(argc, argv, quick, slow, longest);
}
