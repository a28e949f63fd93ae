#include "view_refiner.h"

#include "../stats.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#if defined(__linux__)
#include <sys/resource.h>
#endif

/// How much the thread yields to frames where both want a processor.
#define NICENESS 5

enum { MOST_STAGES = 4 };

/// A light to be computed.
typedef struct stage {
    const char *name;
    rsv_solve_desc desc;
} stage;

struct cli_refiner {
    cli_refiner_desc desc;
    stage stage[MOST_STAGES];
    int stage_count;
    pthread_t thread;
    pthread_mutex_t lock; ///< protects the members below
    cli_lit ready;        ///< frames NULL = nothing
    const char *making;   ///< name of the stage; NULL = nothing
    char phase[32];
    double fraction;
    bool stopping, done;
    rsv_status failure;
    char message[CLI_VIEW_TEXT_LENGTH];
};

void cli_free_lit(cli_lit *lit)
{
    cli_view_frames_destroy(lit->frames);
    rsv_relighter_destroy(lit->relighter);
    rsv_light_destroy(lit->light);
    *lit = (cli_lit){ 0 };
}

// ---- stages -------------------------------------------------------------------------------------

/// Few elements, few rays and no caustics: a light that is ready while the user waits.
static rsv_solve_desc coarse_desc(const rsv_solve_desc *best)
{
    rsv_solve_desc desc = *best;
    desc.element_target = 150;
    desc.rays_per_element = 64;
    desc.refinements = 0;
    desc.light_samples = 16;
    desc.photon_count = 0;
    desc.direct_levels = 0;
    desc.tolerance = 1e-3f;
    return desc;
}

/// The presets below the best one.
static rsv_solve_desc preset_desc(rsv_quality quality, const rsv_solve_desc *best)
{
    rsv_solve_desc desc = rsv_default_solve_desc(quality);
    desc.solver = best->solver;
    desc.seed = best->seed;
    desc.max_elements = best->max_elements;
    return desc;
}

/// Plans the stages. If memory is limited, only the final light is computed.
static void plan(cli_refiner *r)
{
    const rsv_solve_desc *best = &r->desc.solve;
    if (r->desc.light) return;
    if (!best->max_bytes) {
        r->stage[r->stage_count++] = (stage){ "coarse", coarse_desc(best) };
        for (int q = 0; q < (int)r->desc.quality; q++)
            r->stage[r->stage_count++] =
                (stage){ cli_quality_names[q], preset_desc((rsv_quality)q, best) };
    }
    r->stage[r->stage_count++] = (stage){ cli_quality_names[r->desc.quality], *best };
}

// ---- the thread ---------------------------------------------------------------------------------

/// Threads that this one starts are as nice as it is.
static void yield_to_frames(void)
{
#if defined(__linux__)
    setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, 0) + NICENESS);
#endif
}

static void begin_stage(cli_refiner *r, const char *name)
{
    pthread_mutex_lock(&r->lock);
    r->making = name;
    r->phase[0] = '\0';
    r->fraction = 0;
    pthread_mutex_unlock(&r->lock);
}

static bool on_progress(void *user, const char *phase, double fraction)
{
    cli_refiner *r = user;
    pthread_mutex_lock(&r->lock);
    snprintf(r->phase, sizeof r->phase, "%s", phase);
    r->fraction = fraction;
    bool goes_on = !r->stopping;
    pthread_mutex_unlock(&r->lock);
    return goes_on;
}

static bool is_stopping(cli_refiner *r)
{
    pthread_mutex_lock(&r->lock);
    bool stopping = r->stopping;
    pthread_mutex_unlock(&r->lock);
    return stopping;
}

/// Leaves a light for cli_refiner_take, and frees one that was not taken.
static void post(cli_refiner *r, const cli_lit *lit)
{
    pthread_mutex_lock(&r->lock);
    cli_lit before = r->ready;
    r->ready = *lit;
    pthread_mutex_unlock(&r->lock);
    cli_free_lit(&before);
}

/// Prepares a light for its frames. @param lit the light, with a relighter or none; taken over
static rsv_status present(cli_refiner *r, cli_lit *lit)
{
    const cli_refiner_desc *d = &r->desc;
    rsv_status status = cli_view_frames_create(lit->light, d->body, d->budget_ms, &lit->frames);
    if (status == RSV_OK && d->keeps_pace) cli_view_frames_keep_pace(lit->frames);
    if (status == RSV_OK && lit->relighter)
        status = cli_view_frames_attach(lit->frames, lit->relighter);
    if (status == RSV_OK) status = cli_view_frames_prepare(lit->frames, d->width, d->height);
    if (status == RSV_OK)
        post(r, lit);
    else
        cli_free_lit(lit);
    return status;
}

static rsv_status show_light(cli_refiner *r, const char *name, rsv_light *light)
{
    cli_lit lit = { .name = name, .light = light };
    return present(r, &lit);
}

/// Of a copy of the light: a relighter changes its own, which frames may be reading.
static rsv_status show_changeable(cli_refiner *r, const char *name, rsv_light *copy)
{
    cli_lit lit = { .name = name, .light = copy };
    begin_stage(r, "lights to change");
    rsv_status status = rsv_relighter_create(copy, &lit.relighter);
    if (status == RSV_OK) status = rsv_relighter_prepare(lit.relighter);
    if (status == RSV_OK) return present(r, &lit);
    cli_free_lit(&lit);
    return status;
}

/// Computes all lights. A preliminary one that fails is no error.
static rsv_status make_lights(cli_refiner *r)
{
    rsv_light *light = r->desc.light, *copy = NULL;
    const char *name = "solved";
    rsv_status status = RSV_OK;
    for (int k = 0; k < r->stage_count && status == RSV_OK && !is_stopping(r); k++) {
        name = r->stage[k].name;
        begin_stage(r, name);
        status = rsv_light_create(r->desc.scene, &r->stage[k].desc, &light);
        bool was_asked_for = k == r->stage_count - 1;
        if (status == RSV_OK && was_asked_for) break;
        if (status == RSV_OK) status = show_light(r, name, light);
        light = NULL;
        if (status != RSV_OK && !was_asked_for && status != RSV_ERROR_CANCELLED) status = RSV_OK;
    }
    if (status != RSV_OK || !light) return status;
    status = show_light(
        r, name, light); // its frames only read it, and keep it until a better one replaces it
    if (status == RSV_OK && !is_stopping(r)) status = rsv_light_copy(light, &copy);
    if (status == RSV_OK && !is_stopping(r)) return show_changeable(r, name, copy);
    rsv_light_destroy(copy);
    return status;
}

static void *refine(void *user)
{
    cli_refiner *r = user;
    yield_to_frames();
    rsv_status status = make_lights(r);
    pthread_mutex_lock(&r->lock);
    r->done = true;
    r->making = NULL;
    r->failure = r->stopping ? RSV_OK : status;
    snprintf(r->message, sizeof r->message, "%.250s", rsv_last_error());
    pthread_mutex_unlock(&r->lock);
    return NULL;
}

// ---- from outside -------------------------------------------------------------------------------

cli_refiner *cli_refiner_start(const cli_refiner_desc *desc)
{
    cli_refiner *r = calloc(1, sizeof *r);
    if (!r) return NULL;
    r->desc = *desc;
    plan(r);
    pthread_mutex_init(&r->lock, NULL);
    desc->session->watch = on_progress;
    desc->session->watch_user = r;
    if (pthread_create(&r->thread, NULL, refine, r) == 0) return r;
    desc->session->watch = NULL;
    pthread_mutex_destroy(&r->lock);
    free(r);
    return NULL;
}

void cli_refiner_stop(cli_refiner *r)
{
    if (!r) return;
    pthread_mutex_lock(&r->lock);
    r->stopping = true;
    bool done = r->done;
    pthread_mutex_unlock(&r->lock);
    if (!done) rsv_context_cancel(r->desc.session->context);
    pthread_join(r->thread, NULL);
    r->desc.session->watch = NULL;
    cli_free_lit(&r->ready);
    pthread_mutex_destroy(&r->lock);
    free(r);
}

bool cli_refiner_take(cli_refiner *r, cli_lit *lit)
{
    pthread_mutex_lock(&r->lock);
    bool found = r->ready.frames != NULL;
    if (found) *lit = r->ready;
    r->ready = (cli_lit){ 0 };
    pthread_mutex_unlock(&r->lock);
    return found;
}

void cli_refiner_say(cli_refiner *r, char *text)
{
    pthread_mutex_lock(&r->lock);
    text[0] = '\0';
    if (r->making)
        snprintf(
            text, CLI_VIEW_TEXT_LENGTH, "%s: %s %.0f %%", r->making, r->phase, 100 * r->fraction);
    pthread_mutex_unlock(&r->lock);
}

bool cli_refiner_is_done(cli_refiner *r)
{
    pthread_mutex_lock(&r->lock);
    bool done = r->done;
    pthread_mutex_unlock(&r->lock);
    return done;
}

rsv_status cli_refiner_failure(cli_refiner *r, char *message)
{
    pthread_mutex_lock(&r->lock);
    rsv_status status = r->failure;
    r->failure = RSV_OK;
    if (status != RSV_OK) memcpy(message, r->message, sizeof r->message);
    pthread_mutex_unlock(&r->lock);
    return status;
}
