/// Loops on threads of the calling program: results are the same bytes for any order of tasks and any threads.
#include "core/parallel.h"
#include "file_fixture.h"
#include "resolvent/resolvent.h"
#include "slow_tests.h"

#include <pthread.h>

/// The thread sanitizer does not see how OpenMP's threads wait for each other.
#if defined(__SANITIZE_THREAD__)
#define WITHOUT_OPENMP true
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define WITHOUT_OPENMP true
#endif
#endif
#ifndef WITHOUT_OPENMP
#define WITHOUT_OPENMP false
#endif

enum { WORKERS = 7, POOL = 3 };

/// How a program runs tasks.
typedef struct program {
    void (*parallel)(void *user, size_t count, void (*task)(void *data, size_t index), void *data);
    size_t loops, most; ///< how many it ran, and the most tasks of one
    uint32_t random;
} program;

static void note(program *p, size_t count)
{
    p->loops++;
    if (p->most < count) p->most = count;
}

static void run_in_order(void *user, size_t count, void (*task)(void *, size_t), void *data)
{
    note(user, count);
    for (size_t k = 0; k < count; k++)
        task(data, k);
}

static void run_backwards(void *user, size_t count, void (*task)(void *, size_t), void *data)
{
    note(user, count);
    for (size_t k = count; k-- > 0;)
        task(data, k);
}

/// Tasks in a random order, for fewer threads than tasks.
typedef struct pool_job {
    void (*task)(void *, size_t);
    void *data;
    size_t order[64], count;
    atomic_size_t next;
} pool_job;

static void *take_tasks(void *data)
{
    pool_job *job = data;
    for (size_t k; (k = atomic_fetch_add(&job->next, 1)) < job->count;)
        job->task(job->data, job->order[k]);
    return NULL;
}

static void shuffle(pool_job *job, uint32_t *random)
{
    for (size_t k = 0; k < job->count; k++) {
        *random = *random * 1664525 + 1013904223;
        size_t place = (*random >> 8) % (k + 1);
        job->order[k] = job->order[place];
        job->order[place] = k;
    }
}

static void run_on_pool(void *user, size_t count, void (*task)(void *, size_t), void *data)
{
    program *p = user;
    pthread_t thread[POOL];
    pool_job job = { .task = task, .data = data, .count = count };
    note(p, count);
    assert_true(count <= sizeof job.order / sizeof *job.order);
    shuffle(&job, &p->random);
    for (int k = 0; k < POOL; k++)
        assert_int_equal(pthread_create(&thread[k], NULL, take_tasks, &job), 0);
    for (int k = 0; k < POOL; k++)
        assert_int_equal(pthread_join(thread[k], NULL), 0);
}

// ---- what is compared -------------------------------------------------------------------------------

/// All results of one scene, byte by byte.
typedef struct outcome {
    char *bytes;
    size_t count;
} outcome;

static void append(outcome *o, const void *bytes, size_t count)
{
    o->bytes = realloc(o->bytes, o->count + count);
    assert_non_null(o->bytes);
    memcpy(o->bytes + o->count, bytes, count);
    o->count += count;
}

static void append_file(outcome *o, const char *path)
{
    char buffer[65536];
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    for (size_t read; (read = fread(buffer, 1, sizeof buffer, file)) > 0;)
        append(o, buffer, read);
    fclose(file);
}

static void append_picture(outcome *o, const rsv_light *light, rsv_render_mode mode)
{
    rsv_render_desc desc = rsv_default_render_desc();
    rsv_image *image;
    desc.mode = mode;
    desc.width = 24;
    desc.height = 16;
    desc.samples = 2;
    assert_int_equal(rsv_render(light, &desc, &image), RSV_OK);
    append(o, rsv_image_const_pixels(image, 0), 24 * 16 * sizeof(rsv_rgb));
    rsv_image_destroy(image);
}

static void append_bake(outcome *o, const rsv_light *light, const char *target, const char *path)
{
    rsv_bake_desc desc = rsv_default_bake_desc();
    desc.map_size = 32;
    desc.probe_spacing = 1;
    desc.error = 0.2f;
    if (rsv_bake(light, target, path, &desc, NULL) != RSV_OK)
        fail_msg("%s: %s", target, rsv_last_error());
    append_file(o, path);
}

static void append_relit(outcome *o, rsv_light *light)
{
    const rsv_light_scale scale = { .name = "light", .scale = { 0.5f, 0.25f, 1 } };
    const rsv_light_move move = { .name = "light", .offset = { 0.1f, 0, 0.05f } };
    const rsv_relight_desc dim = { .size = sizeof dim, .light = &scale, .light_count = 1 };
    const rsv_relight_desc moved = { .size = sizeof moved, .move = &move, .move_count = 1 };
    assert_int_equal(rsv_light_relight(light, &dim), RSV_OK);
    append_picture(o, light, RSV_RENDER_OPERATOR);
    assert_int_equal(rsv_light_relight(light, &moved), RSV_OK);
    append_picture(o, light, RSV_RENDER_OPERATOR);
}

/// Without threads of the program, progress is reported from the thread that entered the library.
static bool progress_is_of_the_caller(void *user, const char *phase, double fraction)
{
    if (!pthread_equal(*(const pthread_t *)user, pthread_self()))
        fail_msg("%s was reported from another thread", phase);
    return fraction >= 0 && fraction <= 1;
}

/// Solves, saves, shows, bakes and relights a scene. @param p NULL = OpenMP's threads @param all also what takes longer
static outcome run_scene(program *p, bool all)
{
    const pthread_t caller = pthread_self();
    outcome o = { 0 };
    folder files = new_folder();
    rsv_context_desc own = rsv_default_context_desc();
    rsv_solve_desc solve = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_context *context;
    rsv_scene *scene;
    rsv_light *light;
    own.thread_count = p ? WORKERS : 2;
    own.parallel = p ? p->parallel : NULL;
    own.user = p ? (void *)p : (void *)&caller;
    if (!p) own.progress = progress_is_of_the_caller;
    solve.element_target = all ? 300 : 100;
    solve.rays_per_element = 64;
    solve.refinements = 1;
    solve.photon_count = 1000;
    assert_int_equal(rsv_context_create(&own, &context), RSV_OK);
    assert_int_equal(
        rsv_scene_builtin(context, all ? "cornell-spheres" : "cornell-blocks", &scene), RSV_OK);
    assert_int_equal(rsv_scene_save(scene, path_in(&files, "scene.glb")), RSV_OK);
    rsv_scene_destroy(scene); // bakes go into the file of a scene
    assert_int_equal(rsv_scene_load(context, path_in(&files, "scene.glb"), &scene), RSV_OK);
    assert_int_equal(rsv_light_create(scene, &solve, &light), RSV_OK);
    assert_int_equal(rsv_light_save(light, "spheres", path_in(&files, "a.safetensors")), RSV_OK);
    append_file(&o, path_in(&files, "a.safetensors"));
    append_picture(&o, light, RSV_RENDER_OPERATOR);
    if (all) append_picture(&o, light, RSV_RENDER_FINAL);
    append_bake(&o, light, "probes", path_in(&files, "a.json"));
    if (all) append_bake(&o, light, "lightmap", path_in(&files, "a.glb"));
    append_relit(&o, light);
    rsv_light_destroy(light);
    rsv_scene_destroy(scene);
    rsv_context_destroy(context);
    remove_folder(files.path);
    return o;
}

// ---- tests --------------------------------------------------------------------------------------------

static void assert_same_bytes(const outcome *a, const outcome *b)
{
    assert_int_equal(a->count, b->count);
    assert_memory_equal(a->bytes, b->bytes, a->count);
}

static void compare_programs(bool all)
{
    program programs[] = { { .parallel = run_in_order }, { .parallel = run_backwards },
        { .parallel = run_on_pool, .random = 1 } };
    outcome expected = { 0 };
    if (!WITHOUT_OPENMP) expected = run_scene(NULL, all);
    for (size_t k = 0; k < sizeof programs / sizeof *programs; k++) {
        outcome o = run_scene(&programs[k], all);
        assert_true(programs[k].loops > 50);
        assert_int_equal(programs[k].most, WORKERS); // more than the pool has threads
        if (expected.count) assert_same_bytes(&o, &expected);
        if (expected.count)
            free(o.bytes);
        else
            expected = o;
    }
    free(expected.bytes);
}

static void run_nothing(void *user, size_t count, void (*task)(void *, size_t), void *data)
{
    (void)task;
    (void)data;
    note(user, count);
}

static void run_all_twice(void *user, size_t count, void (*task)(void *, size_t), void *data)
{
    run_backwards(user, count, task, data);
    run_in_order(user, count, task, data);
}

static void results_do_not_depend_on_who_runs_the_tasks(void **state)
{
    (void)state;
    compare_programs(false);
}

static void nor_do_bakes_and_gathered_light(void **state)
{
    (void)state;
    compare_programs(true);
}

static void add_up(void *job, rsv_span span)
{
    size_t *sum = job;
    for (size_t k = span.begin; k < span.end; k++)
        *sum += k;
}

static void programs_that_break_the_rule_get_the_right_sum(void **state)
{
    (void)state;
    program programs[] = { { .parallel = run_nothing }, { .parallel = run_all_twice } };
    for (size_t k = 0; k < sizeof programs / sizeof *programs; k++) {
        rsv_context_desc own = rsv_default_context_desc();
        rsv_context *context;
        size_t sum = 0;
        own.thread_count = WORKERS;
        own.parallel = programs[k].parallel;
        own.user = &programs[k];
        assert_int_equal(rsv_context_create(&own, &context), RSV_OK);
        rsv_parallel_for(context, 1000, 10, add_up, &sum); // one after the other: no lock
        assert_int_equal(sum, 999 * 1000 / 2);
        rsv_context_destroy(context);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest quick[] = {
        cmocka_unit_test(results_do_not_depend_on_who_runs_the_tasks),
        cmocka_unit_test(programs_that_break_the_rule_get_the_right_sum),
    };
    const struct CMUnitTest longest[] = {
        cmocka_unit_test(nor_do_bakes_and_gathered_light),
    };
    return RUN_HALF(argc, argv, quick, longest);
}
