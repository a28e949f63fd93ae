/// Processes compared with threads: this program, started again by mpirun.
#include "benchmarks.h"

#include <cJSON.h>
#include <errno.h>
#include <math.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#define PROGRAM "/proc/self/exe"
#define LAUNCHER "mpirun"
#define FEWEST_TRIANGLES 5000.0 // of terraces

/// How a scene is solved.
typedef struct setup {
    uint32_t processes, threads;
    const char *scene;
} setup;

static const char *const phases[] = { "assemble_critical", "solve_critical", "assemble_seconds",
    "solve_seconds" };
enum { phase_count = sizeof phases / sizeof phases[0] };

// ---- running ------------------------------------------------------------------------------------

/// Starts a program whose output goes into `pipe_end`. @return 0, or why not
static int start(char *const *argument, const int pipe_end[2], pid_t *process)
{
    extern char **environ;
    posix_spawn_file_actions_t actions;
    int error = posix_spawn_file_actions_init(&actions);
    if (error) return error;
    posix_spawn_file_actions_adddup2(&actions, pipe_end[1], STDOUT_FILENO);
    posix_spawn_file_actions_addclose(&actions, pipe_end[0]);
    posix_spawn_file_actions_addclose(&actions, pipe_end[1]);
    error = posix_spawnp(process, argument[0], &actions, NULL, argument, environ);
    posix_spawn_file_actions_destroy(&actions);
    return error;
}

/// Reads up to the end. @return to be freed; NULL = out of memory
static char *read_all(int descriptor)
{
    char *text = NULL, piece[4096];
    size_t length = 0;
    FILE *all = open_memstream(&text, &length);
    if (!all) return NULL;
    for (ssize_t count; (count = read(descriptor, piece, sizeof piece)) != 0;) {
        if (count > 0)
            fwrite(piece, 1, (size_t)count, all);
        else if (errno != EINTR)
            break;
    }
    return fclose(all) == 0 ? text : NULL;
}

/// @param processor_seconds of the program and all its children, out
/// @return what it printed; NULL = it failed and printed why, or cannot be started (errno)
static cJSON *run_program(char *const *argument, double *processor_seconds)
{
    int ends[2], exit_status = 1;
    pid_t process;
    struct rusage usage;
    if (pipe(ends) != 0) return NULL;
    errno = start(argument, ends, &process);
    bool started = errno == 0;
    close(ends[1]);
    char *text = started ? read_all(ends[0]) : NULL;
    close(ends[0]);
    while (started && wait4(process, &exit_status, 0, &usage) < 0 && errno == EINTR) {}
    if (started) errno = 0;
    cJSON *printed = exit_status == 0 && text ? cJSON_Parse(text) : NULL;
    free(text);
    if (printed)
        *processor_seconds = (double)(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
                             1e-6 * (double)(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
    return printed;
}

/// Solves a scene as `bench scale` does. @return its numbers; NULL as run_program
static cJSON *run_setup(const cli_bench_task *bench, const setup *s, double *processor_seconds)
{
    char processes[16], threads[16], program[4096] = "";
    snprintf(processes, sizeof processes, "%u", s->processes);
    snprintf(threads, sizeof threads, "%u", s->threads);
    if (readlink(PROGRAM, program, sizeof program - 1) < 0) return NULL;
    char *argument[] = { LAUNCHER, "-n", processes, program, "bench", "scale", (char *)s->scene,
        "--threads", threads, "--json", bench->session->mesh ? "--mesh" : NULL,
        (char *)bench->session->mesh, NULL };
    cJSON *printed = run_program(s->processes > 1 ? argument : argument + 3, processor_seconds);
    cJSON *numbers = cJSON_DetachItemFromArray(cJSON_GetObjectItem(printed, "scenes"), 0);
    cJSON_Delete(printed);
    return numbers;
}

// ---- measurements -------------------------------------------------------------------------------

static void keep_least(cJSON *result, const char *name, double value)
{
    cJSON *member = cJSON_GetObjectItem(result, name);
    if (!member)
        cJSON_AddNumberToObject(result, name, value);
    else
        cJSON_SetNumberHelper(member, fmin(member->valuedouble, value));
}

/// Runs each setup once and keeps the least times. @return false: a run failed
static bool run_round(const cli_bench_task *bench, const setup *setups, size_t count, cJSON *list)
{
    for (size_t k = 0; k < count; k++) {
        double processor_seconds = 0;
        cJSON *numbers = run_setup(bench, &setups[k], &processor_seconds);
        if (!numbers) return false;
        cJSON *item = cJSON_GetArrayItem(list, (int)k);
        for (int p = 0; p < phase_count; p++)
            keep_least(item, phases[p], cli_json_number(numbers, phases[p]));
        keep_least(item, "processor_seconds", processor_seconds);
        keep_least(item, "rows", cli_json_number(numbers, "rows"));
        cJSON_Delete(numbers);
    }
    return true;
}

/// Runs setups in alternation, so that other load on the machine affects all alike.
static bool run_rounds(const cli_bench_task *bench, const setup *setups, size_t count, cJSON *list)
{
    for (size_t k = 0; k < count; k++) {
        cJSON *item = cJSON_CreateObject();
        cJSON_AddStringToObject(item, "scene", setups[k].scene);
        cJSON_AddNumberToObject(item, "processes", setups[k].processes);
        cJSON_AddNumberToObject(item, "threads", setups[k].threads);
        cJSON_AddItemToArray(list, item);
    }
    bool complete = true;
    for (uint32_t round = 0; round < bench->repetitions && complete; round++)
        complete = run_round(bench, setups, count, list);
    return complete;
}

/// One scene by more and more processes, and by two threads.
static bool measure_strong(const cli_bench_task *bench, cJSON *list)
{
    const setup setups[] = { { 1, 1, bench->scene }, { 1, 2, bench->scene }, { 2, 1, bench->scene },
        { 4, 1, bench->scene } };
    return run_rounds(bench, setups, sizeof setups / sizeof setups[0], list);
}

/// Scenes that grow with the processes, up to the one named if it is not too small for that.
static bool measure_weak(const cli_bench_task *bench, cJSON *list)
{
    double triangles = fmax(strtod(strchr(bench->scene, ':') + 1, NULL), 4 * FEWEST_TRIANGLES);
    char name[3][64];
    setup setups[3];
    for (uint32_t k = 0; k < 3; k++) {
        snprintf(name[k], sizeof name[k], "terraces:%.0f", triangles / (4 >> k));
        setups[k] = (setup){ 1u << k, 1, name[k] };
    }
    return run_rounds(bench, setups, 3, list);
}

bool cli_measure_scaling(const cli_bench_task *bench, cJSON *result)
{
    double unused;
    char *const version[] = { LAUNCHER, "--version", NULL };
    setenv("OMPI_MCA_rmaps_base_oversubscribe", "1", 0);
    setenv("OMPI_MCA_mpi_yield_when_idle", "1", 0);
    setenv("OMP_WAIT_POLICY", "passive", 0); // or waiting for other threads would count as work
    cJSON_Delete(run_program(version, &unused));
    if (errno != 0) return true;
    cJSON *strong = cJSON_AddArrayToObject(result, "strong");
    cJSON *weak = cJSON_AddArrayToObject(result, "weak");
    bool grows = strncmp(bench->scene, "terraces:", strlen("terraces:")) == 0;
    return measure_strong(bench, strong) && (!grows || measure_weak(bench, weak));
}

// ---- output -------------------------------------------------------------------------------------

static void print_runs(const char *title, const cJSON *list)
{
    if (cJSON_GetArraySize(list) == 0) return;
    printf("  %-14s %9s %9s %22s %22s %11s\n", title, "processes", "rows", "assembly, s: path/wall",
        "solve, s: path/wall", "processor s");
    const cJSON *item;
    cJSON_ArrayForEach(item, list)
        printf("  %-14s %5.0f x %.0f %9.0f %12.2f %9.2f %12.3f %9.3f %11.2f\n",
            cJSON_GetStringValue(cJSON_GetObjectItem(item, "scene")),
            cli_json_number(item, "processes"), cli_json_number(item, "threads"),
            cli_json_number(item, "rows"), cli_json_number(item, "assemble_critical"),
            cli_json_number(item, "assemble_seconds"), cli_json_number(item, "solve_critical"),
            cli_json_number(item, "solve_seconds"), cli_json_number(item, "processor_seconds"));
}

void cli_print_scaling(const cJSON *result)
{
    const cJSON *strong = cJSON_GetObjectItem(result, "strong");
    if (!strong) {
        printf("  no " LAUNCHER ": nothing is known of real processes\n");
        return;
    }
    print_runs("strong", strong);
    const cJSON *threads = cJSON_GetArrayItem(strong, 1),
                *processes = cJSON_GetArrayItem(strong, 2);
    printf("  2 processes have %.2f of the speed of 2 threads in assembly, %.2f in solving\n",
        cli_json_number(threads, phases[0]) / cli_json_number(processes, phases[0]),
        cli_json_number(threads, phases[1]) / cli_json_number(processes, phases[1]));
    print_runs("weak", cJSON_GetObjectItem(result, "weak"));
}
