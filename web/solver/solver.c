/// The library in a web page: a glTF file is solved and baked in a worker, on threads of a pool where the page may have
/// some. Files are those of Emscripten's file system, in memory.
#include <resolvent/resolvent.h>

#include <emscripten.h>
#include <stdio.h>
#include <string.h>
#if defined(RSV_PAGE_THREADS)
#include <pthread.h>
#endif

/// What the page is told: `Module.onSolverProgress(phase, fraction)` and `Module.onSolverNote(text)`.
EM_JS(void, tell_progress, (const char *phase, double fraction), {
    if (Module["onSolverProgress"]) Module["onSolverProgress"](UTF8ToString(phase), fraction);
});
EM_JS(void, tell_note, (const char *text), {
    if (Module["onSolverNote"]) Module["onSolverNote"](UTF8ToString(text));
});

const char *rsv_page_problem(void);
typedef struct page_task page_task;
int rsv_page_solve(const char *input, const char *output, const page_task *task);

// ---- threads ----------------------------------------------------------------------------------------

#if defined(RSV_PAGE_THREADS)

enum { MOST_THREADS = 16 };

/// Threads that wait for loops. The thread that solves takes part in each.
typedef struct pool {
    pthread_mutex_t lock;
    pthread_cond_t changed;
    pthread_t caller;
    void (*task)(void *data, size_t index);
    void *data;
    size_t next, count, running;
    int thread_count;
} pool;

static pool shared = { .lock = PTHREAD_MUTEX_INITIALIZER, .changed = PTHREAD_COND_INITIALIZER };

/// Runs tasks as long as there are any; the lock is held before and after.
static void take_tasks(pool *p)
{
    while (p->next < p->count) {
        size_t index = p->next++;
        p->running++;
        pthread_mutex_unlock(&p->lock);
        p->task(p->data, index);
        pthread_mutex_lock(&p->lock);
        if (--p->running == 0) pthread_cond_broadcast(&p->changed);
    }
}

static void *serve(void *user)
{
    pool *p = user;
    pthread_mutex_lock(&p->lock);
    for (;;) { // until the page ends the worker
        take_tasks(p);
        pthread_cond_wait(&p->changed, &p->lock);
    }
    return NULL;
}

/// rsv_context_desc.parallel
static void run(void *user, size_t count, void (*task)(void *data, size_t index), void *data)
{
    pool *p = user;
    pthread_mutex_lock(&p->lock);
    p->task = task;
    p->data = data;
    p->next = 0;
    p->count = count;
    pthread_cond_broadcast(&p->changed);
    take_tasks(p);
    while (p->running > 0)
        pthread_cond_wait(&p->changed, &p->lock);
    pthread_mutex_unlock(&p->lock);
}

static void start_threads(int count, rsv_context_desc *desc)
{
    shared.caller = pthread_self();
    if (count > MOST_THREADS) count = MOST_THREADS;
    for (pthread_t thread; shared.thread_count + 1 < count; shared.thread_count++)
        if (pthread_create(&thread, NULL, serve, &shared) != 0) break;
    desc->thread_count = shared.thread_count + 1;
    desc->parallel = run;
    desc->user = &shared;
}

/// Whether this thread may call the page.
static bool is_caller(void) { return pthread_equal(pthread_self(), shared.caller); }

#else

static void start_threads(int count, rsv_context_desc *desc)
{
    (void)count;
    desc->thread_count = 1;
}

static bool is_caller(void) { return true; }

#endif

// ---- messages ---------------------------------------------------------------------------------------

static bool show_progress(void *user, const char *phase, double fraction)
{
    (void)user;
    if (is_caller()) tell_progress(phase, fraction);
    return true; // the page cancels by ending the worker
}

static void show_note(void *user, rsv_log_level level, const char *message)
{
    (void)user;
    if (level == RSV_LOG_WARNING && is_caller()) tell_note(message);
}

static char problem[1024]; // why the last scene was not solved

const char *rsv_page_problem(void) { return problem; }

/// Keeps the library's message for the page.
static bool keep_problem(rsv_status status)
{
    if (status != RSV_OK) snprintf(problem, sizeof problem, "%s", rsv_last_error());
    return status == RSV_OK;
}

// ---- work -------------------------------------------------------------------------------------------

/// How a scene is to be solved; the page fills it in.
struct page_task {
    int threads;   ///< that the page has
    int triangles; ///< more are refused
    int elements;  ///< wanted number of coarse elements; 0 = as quality draft has it
    int map_size;  ///< texels along a side of the lightmap at most
    float error;   ///< wanted of direct light at the median texel, relative
    int levels;    ///< finer levels of direct light at most; -1 = as quality draft has it
    int samples;   ///< shadow rays per element, a power of two; 0 = as quality draft has it
};

static bool check_size(const rsv_scene *scene, const page_task *task)
{
    size_t triangles = rsv_scene_get_view(scene)->triangle_count;
    if (triangles <= (size_t)task->triangles) return true;
    snprintf(problem, sizeof problem,
        "the scene has %zu triangles; a page solves %d at most: solve it with the program `resolvent`",
        triangles, task->triangles);
    return false;
}

static rsv_status solve(const rsv_scene *scene, const page_task *task, rsv_light **light)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    if (task->elements > 0) desc.element_target = (uint32_t)task->elements;
    if (task->levels >= 0) desc.direct_levels = (uint32_t)task->levels;
    if (task->samples > 0) desc.light_samples = (uint32_t)task->samples;
    return rsv_light_create(scene, &desc, light);
}

static rsv_status bake(const rsv_light *light, const page_task *task, const char *output)
{
    rsv_bake_desc desc = rsv_default_bake_desc();
    desc.basis = true;
    desc.map_size = (uint32_t)task->map_size;
    desc.error = task->error;
    return rsv_bake_lightmap(light, output, &desc, NULL);
}

/// Reads `input`, a .glb, and writes `output`, the same with a lightmap, and the light of each source beside it.
/// @return 1, or 0: rsv_page_problem() says why
int rsv_page_solve(const char *input, const char *output, const page_task *task)
{
    rsv_context *context = NULL;
    rsv_scene *scene = NULL;
    rsv_light *light = NULL;
    rsv_context_desc desc = rsv_default_context_desc();
    desc.progress = show_progress;
    desc.log = show_note;
    start_threads(task->threads, &desc);
    bool done = keep_problem(rsv_context_create(&desc, &context)) &&
                keep_problem(rsv_scene_load(context, input, &scene)) && check_size(scene, task) &&
                keep_problem(solve(scene, task, &light)) && keep_problem(bake(light, task, output));
    rsv_light_destroy(light);
    rsv_scene_destroy(scene);
    rsv_context_destroy(context);
    return done;
}
