#include "session.h"

#include "command.h"
#include "crew.h"
#include "device.h"
#include "moment.h"
#include "near_name.h"

#include <malloc.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#if defined(_OPENMP)
#include <omp.h>
#endif

/// A signal handler has no argument of its own to find these by.
static volatile sig_atomic_t interrupted;
static rsv_context *volatile interruptible;
static volatile sig_atomic_t on_terminal; ///< where progress is drawn, without an end of its line

static void on_signal(int signal_number)
{
    (void)signal_number;
    interrupted = 1;
    if (interruptible) rsv_context_cancel(interruptible);
}

/// Operator files and rows are memory-mapped: reading past the end of a file that has since been truncated raises a
/// signal.
static void on_lost_page(int signal_number)
{
    static const char clear[] = "\r\033[K"; // of progress
    static const char text[] =
        "error: a file was truncated while it was being read, or its disk has failed: check what "
        "else writes to operator files and checkpoints, and run the command again\n";
    static atomic_flag said = ATOMIC_FLAG_INIT;
    (void)signal_number;
    while (atomic_flag_test_and_set(&said))
        pause(); // another thread says it
    ssize_t written = on_terminal ? write(STDERR_FILENO, clear, sizeof clear - 1) : 0;
    written += write(STDERR_FILENO, text, sizeof text - 1);
    (void)written; // nowhere to say it, then
    _exit(CLI_FAILURE);
}

/// The first signal asks the work to stop; a second one has its default effect and kills.
static void catch_signals(rsv_context *context)
{
    struct sigaction action = { .sa_handler = on_signal,
        .sa_flags = (int)SA_RESETHAND | SA_RESTART };
    sigemptyset(&action.sa_mask);
    interruptible = context;
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    on_terminal = isatty(STDERR_FILENO);
    signal(SIGBUS, on_lost_page);
    signal(SIGXFSZ, SIG_IGN); // a file that may not grow is an error of writing, not an end
}

bool cli_interrupted(void) { return interrupted != 0; }

void cli_error(const char *format, ...)
{
    char message[RSV_MESSAGE_BYTES];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    const char *agreed = cli_crew_fail(RSV_ERROR_ARGUMENT, message);
    if (cli_crew_speaks()) fprintf(stderr, "error: %s\n", agreed);
}

/// Adds a message to those that were said; false if it is one of them.
static bool is_news(cli_messages *said, const char *message)
{
    for (size_t i = 0; i < said->count; i++)
        if (strcmp(said->text[i], message) == 0) return false;
    char *copy = strdup(message);
    char **grown = copy ? realloc(said->text, (said->count + 1) * sizeof *grown) : NULL;
    if (!grown) {
        free(copy);
        return true;
    }
    said->text = grown;
    said->text[said->count++] = copy;
    return true;
}

static void forget(cli_messages *said)
{
    for (size_t i = 0; i < said->count; i++)
        free(said->text[i]);
    free(said->text);
}

/// Says a message unless it was said before. Threads wait for each other.
static void say(cli_session *session, cli_messages *said, const char *kind, const char *message)
{
    while (atomic_flag_test_and_set(&session->speaking)) {}
    if (cli_crew_speaks() && is_news(said, message)) {
        cli_progress_clear(&session->progress);
        fprintf(stderr, "%s: %s\n", kind, message);
    }
    atomic_flag_clear(&session->speaking);
}

void cli_warn(cli_session *session, const char *message)
{
    say(session, &session->warnings, "warning", message);
}

void cli_note(cli_session *session, const char *message)
{
    say(session, &session->notes, "note", message);
}

static void on_log(void *user, rsv_log_level level, const char *message)
{
    cli_session *session = user;
    if (level == RSV_LOG_WARNING)
        cli_warn(session, message);
    else
        cli_note(session, message);
}

static bool on_progress(void *user, const char *phase, double fraction)
{
    cli_session *session = user;
    if (session->watch)
        return session->watch(session->watch_user, phase, fraction) && !cli_interrupted();
    if (cli_crew_speaks()) cli_progress_update(&session->progress, phase, fraction);
    return !cli_interrupted();
}

/// Keeps the scene that is being opened within --max-memory. @return false where it takes more
static bool count_bytes(cli_session *session, size_t bytes)
{
    if (!session->opens_scene || !session->max_bytes) return true;
    long long taken = atomic_fetch_add(&session->opened_bytes, (long long)bytes) + (long long)bytes;
    if (taken <= (long long)session->max_bytes) return true;
    atomic_fetch_sub(&session->opened_bytes, (long long)bytes);
    session->is_too_large = true;
    return false;
}

static void *allocate(void *user, size_t bytes)
{
    cli_session *session = user;
    session->allocations++;
    void *memory = aligned_alloc(64, bytes);
    if (!memory || count_bytes(session, malloc_usable_size(memory))) return memory;
    free(memory);
    return NULL;
}

static void release(void *user, void *memory)
{
    cli_session *session = user;
    if (session->opens_scene && memory)
        atomic_fetch_sub(&session->opened_bytes, (long long)malloc_usable_size(memory));
    free(memory);
}

const char *const cli_light_unit_names[] = { [RSV_LIGHT_UNITS_AUTO] = "auto",
    [RSV_LIGHT_UNITS_WATT] = "watt",
    [RSV_LIGHT_UNITS_PHOTOMETRIC] = "photometric",
    NULL };

const char *const cli_emit_names[] = { "file", "both", NULL };

const char *cli_reading_given(const cli_reading *reading)
{
    return reading->light_units        ? "--light-units"
           : reading->two_sided        ? "--two-sided"
           : reading->emit             ? "--emit"
           : reading->variant          ? "--variant"
           : reading->luminaires.count ? "--luminaire"
                                       : NULL;
}

bool cli_session_begin(cli_session *session, uint32_t threads)
{
    *session = (cli_session){
        .moment = CLI_AT_REST, .started = cli_seconds(), .speaking = ATOMIC_FLAG_INIT
    };
    cli_progress_begin(&session->progress);
    rsv_context_desc desc = rsv_default_context_desc();
    desc.thread_count = (int)threads;
    desc.log = on_log;
    desc.progress = on_progress;
    desc.allocate = allocate;
    desc.release = release;
    desc.user = session;
    desc.team = cli_crew();
    desc.device = cli_device();
    if (rsv_context_create(&desc, &session->context) != RSV_OK) {
        cli_error("%s", rsv_last_error());
        return false;
    }
    catch_signals(session->context);
    return true;
}

void cli_close_animation(cli_session *session)
{
    rsv_animation_destroy(session->animation);
    session->animation = NULL;
}

void cli_session_end(cli_session *session)
{
    cli_progress_clear(&session->progress);
    interruptible = NULL;
    cli_close_animation(session);
    rsv_context_destroy(session->context);
    forget(&session->warnings);
    forget(&session->notes);
    for (size_t k = 0; k < session->luminaire_count; k++)
        free((void *)session->luminaire[k].name);
    *session = (cli_session){ 0 };
}

rsv_status cli_build_scene(cli_session *session, const char *name, rsv_scene **scene)
{
    static const float crease_angle = 1.4f; // radians: scanned surfaces are smooth, coarse or fine
    rsv_builtin_desc desc = rsv_default_builtin_desc();
    rsv_load_desc load = rsv_default_load_desc();
    rsv_scene *body = NULL;
    rsv_status status = RSV_OK;
    load.crease_angle = crease_angle;
    load.is_part = true;
    if (session->mesh) status = rsv_scene_load_with(session->context, session->mesh, &load, &body);
    desc.body = body;
    if (status == RSV_OK) status = rsv_scene_builtin_with(session->context, name, &desc, scene);
    rsv_scene_destroy(body);
    return status;
}

/// @param names ends with NULL
static const char *near_builtin(const char *name, const char *const *names)
{
    size_t count = 0;
    while (names[count])
        count++;
    return cli_near_name(name, names, count);
}

/// Whether a mistyped name of built-in surroundings would be taken for a picture.
static bool environment_is_mistyped(const cli_environment *environment)
{
    const char *name = environment ? environment->path : NULL;
    if (!name || access(name, F_OK) == 0 || rsv_environment_is_builtin(name)) return false;
    const char *near = near_builtin(name, rsv_environment_builtin_names());
    if (near) cli_error("--env %s: there is no such file; did you mean '%s'?", name, near);
    return near != NULL;
}

static rsv_status add_environment(
    cli_session *session, rsv_scene *scene, const cli_environment *environment)
{
    if (!environment) return RSV_OK;
    const char *name = environment->path;
    if (name) {
        bool is_file = access(name, F_OK) == 0 || !rsv_environment_is_builtin(name);
        return (is_file ? rsv_scene_load_environment : rsv_scene_set_builtin_environment)(
            scene, name, environment->intensity, environment->rotation);
    }
    if (environment->intensity != 1 || environment->rotation != 0)
        cli_warn(session, "--env-intensity and --env-rotate require --env");
    return RSV_OK;
}

/// Warns of options for reading files: built-in scenes ignore all of them but --luminaire.
static void warn_of_reading(cli_session *session)
{
    char line[64];
    cli_reading others = session->reading;
    others.luminaires.count = 0;
    const char *given = cli_reading_given(&others);
    if (!given) return;
    snprintf(line, sizeof line, "%s has no effect on built-in scenes", given);
    cli_warn(session, line);
}

/// Options that the kind of scene has no use for.
static bool check_kind(const cli_session *session, const char *name, bool is_file)
{
    if (session->mesh && !rsv_scene_is_builtin(name))
        cli_error("--mesh %s: '%s' is not a built-in scene; only those accept a mesh",
            session->mesh, name);
    else if (isfinite(session->moment.time) && !is_file && rsv_scene_is_builtin(name))
        cli_error("--time: '%s' is a built-in scene; only glTF files are animated", name);
    else
        return true;
    return false;
}

/// Parses NAME=FILE of every --luminaire; prints an error and returns false if one is invalid.
static bool read_luminaires(cli_session *session)
{
    const cli_list *given = &session->reading.luminaires;
    for (size_t k = session->luminaire_count; k < given->count; k++) {
        const char *cut = strchr(given->item[k], '=');
        if (!cut || cut == given->item[k] || !cut[1]) {
            cli_error("--luminaire: '%s' is not NAME=FILE", given->item[k]);
            return false;
        }
        char *name = strndup(given->item[k], (size_t)(cut - given->item[k]));
        session->luminaire[k] = (rsv_load_luminaire){ name, cut + 1 };
        session->luminaire_count = k + 1;
        if (!name) return false;
    }
    return true;
}

rsv_load_desc cli_describe_load(const cli_session *session)
{
    rsv_load_desc load = rsv_default_load_desc();
    load.keep_document = session->keep_document;
    load.light_units = (rsv_light_units)session->reading.light_units;
    load.two_sided = session->reading.two_sided;
    load.emit_both = session->reading.emit;
    load.variant = session->reading.variant;
    load.luminaire = session->luminaire;
    load.luminaire_count = session->luminaire_count;
    return load;
}

static bool read_scene(cli_session *session, const char *name, bool is_file, rsv_scene **scene)
{
    rsv_status status;
    if (is_file && isfinite(session->moment.time)) return cli_load_moment(session, name, scene);
    if (is_file) {
        const rsv_load_desc load = cli_describe_load(session);
        status = rsv_scene_load_with(session->context, name, &load, scene);
    } else if (rsv_scene_is_builtin(name)) {
        warn_of_reading(session);
        status = cli_build_scene(session, name, scene);
        if (status == RSV_OK)
            status =
                rsv_scene_load_luminaires(*scene, session->luminaire, session->luminaire_count);
    } else {
        const char *near = near_builtin(name, rsv_scene_builtin_names());
        cli_error("'%s': there is no such file and no built-in scene of that name; %s%s%s", name,
            near ? "did you mean '" : "`resolvent --help` lists them", near ? near : "",
            near ? "'?" : "");
        return false;
    }
    if (status != RSV_OK) cli_report_failure(session, status);
    return status == RSV_OK;
}

static rsv_scene *open_scene(
    cli_session *session, const char *name, const cli_environment *environment)
{
    rsv_scene *scene = NULL;
    rsv_fog fog = rsv_default_fog();
    double started = cli_seconds();
    bool is_file = access(name, F_OK) == 0 && !session->mesh;
    if (environment && !cli_read_fog(&environment->fog, &fog)) return NULL;
    if (!read_luminaires(session)) return NULL;
    if (!check_kind(session, name, is_file) || environment_is_mistyped(environment)) return NULL;
    if (!read_scene(session, name, is_file, &scene)) return NULL;
    rsv_status status = add_environment(session, scene, environment);
    // without --fog, a built-in scene keeps its own
    if (status == RSV_OK && environment && environment->fog.volume)
        status = rsv_scene_load_volume(scene, &fog, environment->fog.volume);
    else if (status == RSV_OK && environment && environment->fog.medium)
        status = rsv_scene_set_fog(scene, &fog);
    if (status == RSV_OK) status = rsv_scene_compare(scene);
    session->time_load += cli_seconds() - started;
    if (status == RSV_OK) return scene;
    cli_report_failure(session, status);
    rsv_scene_destroy(scene);
    return NULL;
}

rsv_scene *cli_open_scene(
    cli_session *session, const char *name, const cli_environment *environment)
{
    session->opened_bytes = 0;
    session->is_too_large = false;
    session->opens_scene = true;
    rsv_scene *scene = open_scene(session, name, environment);
    session->opens_scene = false;
    return scene;
}

int cli_report_failure(cli_session *session, rsv_status status)
{
    char budget[96];
    bool over_budget = status == RSV_ERROR_MEMORY && session->is_too_large;
    cli_progress_clear(&session->progress);
    snprintf(budget, sizeof budget, "the memory budget of %.0f MiB is too small to read the scene",
        (double)session->max_bytes / (1 << 20));
    const char *message = cli_crew_fail(status, over_budget ? budget : rsv_last_error());
    if (status != RSV_ERROR_CANCELLED)
        cli_error("%s", message);
    else if (cli_crew_speaks() && session->checkpoint)
        fprintf(stderr, "cancelled; the same command continues with the rows saved in '%s'\n",
            session->checkpoint);
    else if (cli_crew_speaks())
        fputs("cancelled\n", stderr);
    return CLI_FAILURE;
}

uint32_t cli_thread_count(uint32_t threads)
{
#if defined(_OPENMP)
    return threads ? threads : (uint32_t)omp_get_num_procs();
#else
    (void)threads;
    return 1;
#endif
}
