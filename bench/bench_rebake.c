/// One object moved: the scene solved again with data of the previous solution, compared with a solve from scratch.
#include "benchmarks.h"
#include "command.h"
#include "light_difference.h"
#include "moved_scene.h"
#include "scratch_folder.h"

#include "resolvent/solve.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/// Seconds that making something took.
typedef struct cost {
    double clock, processor; ///< processor: all threads together
    double
        thread; ///< processor time of the first thread: the clock of a machine with nothing else to do
} cost;

static cost now(void)
{
    struct timespec thread = { 0 };
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &thread);
    return (cost){ cli_seconds(), (double)clock() / CLOCKS_PER_SEC,
        (double)thread.tv_sec + 1e-9 * (double)thread.tv_nsec };
}

/// @param rows folders for rows and for those of the scene before; NULL = none
static rsv_solve_desc describe(const cli_bench_task *bench, uint32_t seed)
{
    rsv_solve_desc desc = cli_bench_solve_desc(bench, bench->quality);
    desc.seed = seed;
    return desc;
}

static rsv_status solve(
    const rsv_scene *scene, const rsv_solve_desc *desc, rsv_light **solution, cost *took)
{
    cost start = now();
    rsv_status status = rsv_light_create(scene, desc, solution);
    cost end = now();
    *took = (cost){ end.clock - start.clock, end.processor - start.processor,
        end.thread - start.thread };
    return status;
}

static void add_cost(cJSON *result, const char *name, cost took)
{
    char field[64];
    snprintf(field, sizeof field, "%s_s", name);
    cJSON_AddNumberToObject(result, field, took.clock);
    snprintf(field, sizeof field, "%s_processor_s", name);
    cJSON_AddNumberToObject(result, field, took.processor);
    snprintf(field, sizeof field, "%s_thread_s", name);
    cJSON_AddNumberToObject(result, field, took.thread);
}

/// The moved scene: from kept data, from scratch, and from scratch with other random numbers.
static rsv_status compare(const cli_bench_task *bench, const rsv_scene *moved, const char *rows,
    const char *earlier, cJSON *result)
{
    rsv_light *again = NULL, *whole = NULL, *other = NULL;
    cost took[3];
    rsv_solve_desc update = describe(bench, 1), anew = describe(bench, 1),
                   noise = describe(bench, 2);
    update.checkpoint = rows;
    update.earlier = earlier;
    rsv_status status = solve(moved, &update, &again, &took[0]);
    if (!status) status = solve(moved, &anew, &whole, &took[1]);
    if (!status) status = solve(moved, &noise, &other, &took[2]);
    if (!status) {
        const rsv_solve_report *r = rsv_light_report(again);
        cJSON_AddNumberToObject(result, "elements", (double)r->elements);
        cJSON_AddNumberToObject(result, "direct_elements", (double)r->direct_elements);
        cJSON_AddNumberToObject(
            result, "kept_rays", (double)r->kept_row_rays / (double)r->row_rays);
        add_cost(result, "rebake", took[0]);
        add_cost(result, "full", took[1]);
        cJSON_AddNumberToObject(result, "speedup", took[1].clock / took[0].clock);
        cJSON_AddNumberToObject(result, "processor_speedup", took[1].processor / took[0].processor);
        cJSON_AddNumberToObject(result, "thread_speedup", took[1].thread / took[0].thread);
        cJSON_AddNumberToObject(result, "difference", cli_light_difference(whole, again));
        cJSON_AddNumberToObject(result, "difference_of_seeds", cli_light_difference(whole, other));
        cJSON_AddNumberToObject(
            result, "difference_to_other_seed", cli_light_difference(other, again));
    }
    rsv_light_destroy(again);
    rsv_light_destroy(whole);
    rsv_light_destroy(other);
    return status;
}

/// Solves `scene` once, then measures the moved one. @param made out: false if the kept data cannot be stored
static rsv_status measure_scenes(const cli_bench_task *bench, const rsv_scene *scene,
    const rsv_scene *moved, cJSON *result, bool *made)
{
    char before[PATH_MAX] = "", after[PATH_MAX] = "";
    rsv_light *solution = NULL;
    rsv_solve_desc first = describe(bench, 1);
    cost took;
    rsv_status status = RSV_ERROR_IO;
    first.checkpoint = before;
    *made = cli_make_scratch_folder("rebake", before) && cli_make_scratch_folder("rebake", after);
    if (*made) {
        status = solve(scene, &first, &solution, &took);
        rsv_light_destroy(solution);
        add_cost(result, "first", took);
        if (!status) status = compare(bench, moved, after, before, result);
    }
    cli_remove_scratch_folder(before);
    cli_remove_scratch_folder(after);
    return status;
}

/// @param made as of measure_scenes
static rsv_status measure(
    const cli_bench_task *bench, const rsv_scene *scene, cJSON *result, bool *made)
{
    uint32_t object = cli_find_movable_object(scene);
    rsv_scene *before = NULL, *moved = NULL;
    if (object == RSV_NONE) return RSV_ERROR_SCENE;
    float extent = cli_object_extent(scene, object);
    cJSON_AddStringToObject(result, "object", rsv_scene_get_view(scene)->object_name[object]);
    cJSON_AddNumberToObject(result, "metres", (double)extent);
    rsv_status status = cli_copy_scene_moved(scene, RSV_NONE, 0, &before);
    if (!status) status = cli_copy_scene_moved(scene, object, extent, &moved);
    if (!status) status = measure_scenes(bench, before, moved, result, made);
    rsv_scene_destroy(before);
    rsv_scene_destroy(moved);
    return status;
}

bool cli_bench_rebake(const cli_bench_task *bench, cJSON *result)
{
    rsv_scene *scene = cli_open_bench_scene(bench);
    if (!scene) return false;
    bool made = true;
    rsv_status status = measure(bench, scene, result, &made);
    rsv_scene_destroy(scene);
    if (status == RSV_ERROR_SCENE || status == RSV_ERROR_UNSUPPORTED)
        cli_error(
            "bench rebake: '%s' has textures, or no object small enough to be moved", bench->scene);
    else if (!made)
        cli_error("bench rebake: cannot make a folder for temporary files; set TMPDIR to a place "
                  "for them");
    else if (status != RSV_OK)
        cli_report_failure(bench->session, status);
    return status == RSV_OK;
}

void cli_print_rebake(const cJSON *result)
{
    printf("  %.0f elements, %.0f of direct light; '%s' moved by %.2g m\n",
        cli_json_number(result, "elements"), cli_json_number(result, "direct_elements"),
        cJSON_GetStringValue(cJSON_GetObjectItem(result, "object")),
        cli_json_number(result, "metres"));
    printf("                         clock  first thread  processor\n");
    printf("  as a whole           %7.1f s %11.1f s %8.1f s\n", cli_json_number(result, "full_s"),
        cli_json_number(result, "full_thread_s"), cli_json_number(result, "full_processor_s"));
    printf("  from what is kept    %7.1f s %11.1f s %8.1f s; %.1f %% of the rows' rays\n",
        cli_json_number(result, "rebake_s"), cli_json_number(result, "rebake_thread_s"),
        cli_json_number(result, "rebake_processor_s"), 100 * cli_json_number(result, "kept_rays"));
    printf("  times faster         %7.1f   %11.1f   %8.1f\n", cli_json_number(result, "speedup"),
        cli_json_number(result, "thread_speedup"), cli_json_number(result, "processor_speedup"));
    printf("  differ by              %.2f %%; two as a whole with other random numbers by %.2f %%, "
           "those others from what is kept by %.2f %%\n",
        100 * cli_json_number(result, "difference"),
        100 * cli_json_number(result, "difference_of_seeds"),
        100 * cli_json_number(result, "difference_to_other_seed"));
}

bool cli_write_rebake_csv(const char *path, const cJSON *scenes)
{
    static const char *const columns[] = { "elements", "direct_elements", "kept_rays", "first_s",
        "full_s", "full_thread_s", "full_processor_s", "rebake_s", "rebake_thread_s",
        "rebake_processor_s", "speedup", "thread_speedup", "processor_speedup", "difference",
        "difference_of_seeds", "difference_to_other_seed" };
    return cli_write_columns(path, scenes, columns, sizeof columns / sizeof columns[0]);
}
