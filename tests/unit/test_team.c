/// Work divided among the processes of a team: results do not depend on how many there are, and no failure of one
/// leaves the others waiting.
#include "resolvent/opfile.h"

#include "file_fixture.h"
#include "light_view.h"
#include "operator/division.h"
#include "slow_tests.h"
#include "thread_team.h"

// ---- parts of the curve --------------------------------------------------------------------------

static rsv_light *solve_alone(fixture *f, const char *scene_name, rsv_scene **scene)
{
    rsv_light *solution;
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = 400;
    desc.rays_per_element = 64;
    desc.photon_count = 4000;
    assert_int_equal(rsv_scene_builtin(f->context, scene_name, scene), RSV_OK);
    assert_int_equal(rsv_light_create(*scene, &desc, &solution), RSV_OK);
    return solution;
}

static rsv_vec3 place_of(const rsv_elements *e, uint32_t node)
{
    uint32_t face;
    float u, v;
    rsv_elements_place_node(e, node, &face, &u, &v);
    return rsv_surface_point_at(e->scene, e->face_triangle[face], u, v, e->face_back[face])
        .position;
}

static void neighbours_on_the_curve_are_neighbours_in_space(void **state)
{
    rsv_scene *scene;
    rsv_division *d;
    rsv_light *s = solve_alone(*state, "cornell-blocks", &scene);
    assert_int_equal(rsv_division_create(inside(s)->elements, &d), RSV_OK);
    uint8_t *seen = calloc(d->node_count, 1);
    double length = 0;
    for (size_t k = 0; k < d->node_count; k++) {
        assert_false(seen[d->order[k]]++); // each node once
        if (k > 0)
            length += (double)v3_length(v3_sub(place_of(inside(s)->elements, d->order[k]),
                place_of(inside(s)->elements, d->order[k - 1])));
    }
    // nodes on a grid with that spacing cannot follow each other more closely than it; jumps between walls come on top
    assert_true(length / (double)d->node_count < 2 * (double)inside(s)->elements->spacing);
    free(seen);
    rsv_division_destroy(d);
    rsv_light_destroy(s);
    rsv_scene_destroy(scene);
}

static double cost_of(const rsv_division *d, uint32_t part)
{
    double sum = 0;
    for (size_t k = d->begin[part]; k < d->begin[part + 1]; k++)
        sum += (double)d->cost[d->order[k]];
    return sum;
}

static void parts_cost_the_same(void **state)
{
    rsv_scene *scene;
    rsv_division *d;
    rsv_light *s = solve_alone(*state, "cornell-blocks", &scene);
    assert_int_equal(rsv_division_create(inside(s)->elements, &d), RSV_OK);
    double total = 0, dearest = 0;
    for (size_t n = 0; n < d->node_count; n++) {
        d->cost[n] = n % 3 == 0 ? 0 : n % 7 == 0 ? 20 : 1; // glass among plaster, nodes that hang
        total += (double)d->cost[n];
        dearest = fmax(dearest, (double)d->cost[n]);
    }
    for (uint32_t parts = 1; parts <= 9; parts++) {
        assert_int_equal(rsv_division_cut(d, 0, parts), RSV_OK);
        assert_int_equal(d->begin[0], 0);
        assert_int_equal(d->begin[parts], d->node_count);
        for (uint32_t part = 0; part < parts; part++) // half a row over at either end
            assert_true(fabs(cost_of(d, part) - total / parts) <= dearest);
    }
    assert_int_equal(rsv_division_cut(d, 0, (uint32_t)d->node_count + 100), RSV_OK);
    assert_int_equal(d->begin[d->node_count + 100], d->node_count);
    rsv_division_destroy(d);
    rsv_light_destroy(s);
    rsv_scene_destroy(scene);
}

// ---- the same bytes ------------------------------------------------------------------------------

/// The work of all threads, and its result.
typedef struct job {
    const char *scene, *other_scene; ///< of process 1, if not NULL
    const char *path, *checkpoint;
    rsv_solver solver;
    bool complete;
    size_t allocations; ///< that process 1 may make; 0 = any number
    rsv_status status[TEAM_MOST];
    char message[TEAM_MOST][256];
    size_t entries[TEAM_MOST];
} job;

static void *limited_allocate(void *user, size_t bytes)
{
    size_t *left = user;
    if (*left != SIZE_MAX && (*left)-- == 0) {
        *left = 0;
        return NULL;
    }
    return aligned_alloc(64, bytes);
}

static void plain_release(void *user, void *memory)
{
    (void)user;
    free(memory);
}

static rsv_status solve_and_save(rsv_context *context, const job *j, const char *name,
    rsv_scene **scene, rsv_light **solution, size_t *entries)
{
    rsv_status status;
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = UNLESS_SANITIZED(400, 150);
    desc.rays_per_element = 64;
    desc.refinements = 1;
    desc.photon_count = UNLESS_SANITIZED(4000, 1000);
    desc.solver = j->solver;
    desc.checkpoint = j->checkpoint;
    RSV_TRY(rsv_scene_builtin(context, name, scene));
    RSV_TRY(rsv_scene_compare(*scene));
    RSV_TRY(rsv_light_create(*scene, &desc, solution));
    *entries = rsv_transport_entries(inside(*solution)->transport);
    if (j->complete)
        RSV_TRY(rsv_transport_complete(rsv_operator_get_view(inside(*solution)->op)->transport));
    if (j->path) RSV_TRY(rsv_light_save(*solution, name, j->path));
cleanup:
    return status;
}

static void run_member(rsv_team *team, void *user)
{
    job *j = user;
    rsv_context *context;
    rsv_scene *scene = NULL;
    rsv_light *solution = NULL;
    uint32_t rank = team ? team->rank : 0;
    size_t left = rank == 1 && j->allocations ? j->allocations : SIZE_MAX;
    rsv_context_desc desc = rsv_default_context_desc();
    desc.thread_count = 1;
    desc.team = team;
    desc.allocate = limited_allocate;
    desc.release = plain_release;
    desc.user = &left;
    if (rsv_context_create(&desc, &context) != RSV_OK) abort();
    const char *name = rank == 1 && j->other_scene ? j->other_scene : j->scene;
    rsv_status status = solve_and_save(context, j, name, &scene, &solution, &j->entries[rank]);
    j->status[rank] = rsv_team_agree(team, status, NULL);
    snprintf(j->message[rank], sizeof j->message[rank], "%s", rsv_last_error());
    rsv_light_destroy(solution);
    rsv_scene_destroy(scene);
    rsv_context_destroy(context);
}

static char *read_whole(const char *path, size_t *bytes)
{
    struct stat info;
    assert_int_equal(stat(path, &info), 0);
    *bytes = (size_t)info.st_size;
    char *text = malloc(*bytes + 1);
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fread(text, 1, *bytes, file), *bytes);
    fclose(file);
    return text;
}

/// The file of `size` processes against that of one.
static void check_same_file(job base, uint32_t size)
{
    folder f = new_folder();
    char one[256], many[256];
    size_t one_bytes, many_bytes, entries = 0;
    snprintf(one, sizeof one, "%s", path_in(&f, "one.safetensors"));
    snprintf(many, sizeof many, "%s", path_in(&f, "many.safetensors"));
    job alone = base, together = base;
    alone.path = one;
    alone.checkpoint = NULL;
    together.path = many;
    run_member(NULL, &alone);
    assert_int_equal(alone.status[0], RSV_OK);
    run_team(size, run_member, &together);
    for (uint32_t r = 0; r < size; r++) {
        if (together.status[r] != RSV_OK) print_message("%s\n", together.message[r]);
        assert_int_equal(together.status[r], RSV_OK);
        entries += together.entries[r];
    }
    if (base.solver == RSV_SOLVER_AUTO) assert_int_equal(entries, alone.entries[0]);
    char *first = read_whole(one, &one_bytes), *second = read_whole(many, &many_bytes);
    assert_int_equal(one_bytes, many_bytes);
    assert_memory_equal(first, second, one_bytes);
    free(first);
    free(second);
    remove_folder(f.path);
}

static void the_file_does_not_depend_on_the_number_of_processes(void **state)
{
    (void)state;
    check_same_file((job){ .scene = "cornell-spheres" }, 3);
}

static void rows_brought_together_are_those_of_one_process(void **state)
{
    (void)state;
    check_same_file((job){ .scene = "cornell-blocks", .complete = true }, 3);
    check_same_file((job){ .scene = "cornell-blocks", .solver = RSV_SOLVER_SOUTHWELL }, 2);
    check_same_file((job){ .scene = "cornell-blocks", .solver = RSV_SOLVER_TWO_GRID }, 2);
}

/// Cuts the files of a folder off in the middle of a row.
static void cut_files(const char *path)
{
    DIR *directory = opendir(path);
    assert_non_null(directory);
    for (struct dirent *entry; (entry = readdir(directory));) {
        char name[512];
        struct stat info;
        if (entry->d_name[0] == '.') continue;
        snprintf(name, sizeof name, "%.200s/%.200s", path, entry->d_name);
        assert_int_equal(stat(name, &info), 0);
        assert_int_equal(truncate(name, info.st_size * 3 / 5), 0);
    }
    closedir(directory);
}

static void a_run_cut_off_goes_on_with_the_same_bytes(void **state)
{
    (void)state;
    folder rows = new_folder();
    job first = { .scene = "cornell-blocks", .checkpoint = rows.path };
    run_team(3, run_member, &first);
    assert_int_equal(first.status[0], RSV_OK);
    cut_files(rows.path);
    check_same_file((job){ .scene = "cornell-blocks", .checkpoint = rows.path }, 2);
    remove_folder(rows.path);
}

static void most_processes_may_have_next_to_nothing_to_do(void **state)
{
    (void)state;
    check_same_file((job){ .scene = "furnace" }, TEAM_MOST);
}

// ---- failures ------------------------------------------------------------------------------------

static void the_failure_of_one_is_the_failure_of_all(void **state)
{
    (void)state;
    for (size_t allocations = 40; allocations < 5000; allocations = 4 * allocations + 1) {
        job j = { .scene = "cornell-spheres", .allocations = allocations };
        run_team(3, run_member, &j);
        if (j.status[0] == RSV_OK) return; // so many are enough
        for (uint32_t r = 0; r < 3; r++) {
            assert_int_equal(j.status[r], RSV_ERROR_MEMORY);
            assert_non_null(strstr(j.message[r], "process 1 of 3: out of memory"));
        }
    }
}

static void different_scenes_are_refused(void **state)
{
    (void)state;
    job j = { .scene = "cornell-spheres", .other_scene = "cornell-blocks" };
    run_team(3, run_member, &j);
    for (uint32_t r = 0; r < 3; r++) {
        assert_int_equal(j.status[r], RSV_ERROR_ARGUMENT);
        assert_non_null(strstr(j.message[r], "process 1 of 3: its scene differs"));
    }
}

/// Process 1 fails while the others are in the middle of their work.
static void fail_at_work(rsv_team *team, void *user)
{
    job *j = user;
    rsv_context *context;
    rsv_context_desc desc = rsv_default_context_desc();
    desc.team = team;
    if (rsv_context_create(&desc, &context) != RSV_OK) abort();
    rsv_status status = RSV_OK;
    if (team->rank == 1) {
        rsv_team_alarm(context);
        rsv_progress(context, "work", 0);
        status = rsv_fail(RSV_ERROR_IO, "the disk is full");
    }
    while (status == RSV_OK) // not collective
        status = rsv_progress(context, "work", 0);
    j->status[team->rank] = rsv_team_meet(context, status);
    snprintf(j->message[team->rank], sizeof j->message[0], "%s", rsv_last_error());
    rsv_context_destroy(context);
}

static void a_failure_does_not_wait_for_the_work_of_others(void **state)
{
    (void)state;
    job j = { 0 };
    run_team(3, fail_at_work, &j);
    for (uint32_t r = 0; r < 3; r++) {
        assert_int_equal(j.status[r], RSV_ERROR_IO); // not that the others were asked to stop
        assert_string_equal(j.message[r], "process 1 of 3: the disk is full");
    }
}

static void a_disk_that_refuses_ends_all(void **state)
{
    (void)state;
    job j = { .scene = "furnace", .path = "/no/such/folder/a.safetensors" };
    run_team(2, run_member, &j);
    for (uint32_t r = 0; r < 2; r++) {
        assert_int_equal(j.status[r], RSV_ERROR_IO);
        assert_non_null(strstr(j.message[r], "/no/such/folder"));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(
            neighbours_on_the_curve_are_neighbours_in_space, fixture_setup, fixture_teardown),
        cmocka_unit_test_setup_teardown(parts_cost_the_same, fixture_setup, fixture_teardown),
        cmocka_unit_test(the_file_does_not_depend_on_the_number_of_processes),
        cmocka_unit_test(rows_brought_together_are_those_of_one_process),
        cmocka_unit_test(a_run_cut_off_goes_on_with_the_same_bytes),
        cmocka_unit_test(most_processes_may_have_next_to_nothing_to_do),
        cmocka_unit_test(the_failure_of_one_is_the_failure_of_all),
        cmocka_unit_test(a_failure_does_not_wait_for_the_work_of_others),
        cmocka_unit_test(different_scenes_are_refused),
        cmocka_unit_test(a_disk_that_refuses_ends_all),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
