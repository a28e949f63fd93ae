#include "bench.h"
#include "command.h"
#include "options.h"
#include "output_file.h"

#include <cJSON.h>
#include <stdio.h>
#include <string.h>

static const char help[] =
    "usage: resolvent bench NAME [SCENE] [options]\n"
    "\n"
    "Measures this machine, on SCENE or else on cornell-blocks and cornell-spheres:\n"
    "\n"
    "  trace  millions of rays per second: rays of the camera, cosine-distributed rays from what "
    "it\n"
    "         sees, and occlusion between such points; one at a time and in packets of sixteen\n"
    "\n"
    "  --threads N  default: one per processor\n"
    "  --json       print JSON, in rays per second\n"
    "\n"
    "examples:\n"
    "  resolvent bench trace\n"
    "  resolvent bench trace room.glb --threads 1 --json\n";

typedef struct benchmark {
    const char *name;
    rsv_status (*run)(const rsv_scene *scene, uint32_t threads, cJSON *result);
} benchmark;

static const benchmark benchmarks[] = {
    { "trace", cli_bench_trace },
};

static const benchmark *find_benchmark(const char *name)
{
    for (size_t i = 0; i < sizeof benchmarks / sizeof benchmarks[0]; i++)
        if (strcmp(benchmarks[i].name, name) == 0) return &benchmarks[i];
    return NULL;
}

typedef struct settings {
    const char *operand[2]; ///< name of the benchmark, scene or NULL
    uint32_t threads;
    bool json;
} settings;

/// One scene through one benchmark; NULL after a message.
static cJSON *measure(
    cli_session *session, const benchmark *bench, const char *name, uint32_t threads)
{
    rsv_scene *scene = cli_open_scene(session, name);
    if (!scene) return NULL;
    cJSON *result = cJSON_CreateObject();
    cJSON_AddStringToObject(result, "scene", name);
    cJSON_AddNumberToObject(result, "triangles", (double)rsv_scene_get_view(scene)->triangle_count);
    rsv_status status = bench->run(scene, threads, result);
    if (status != RSV_OK) {
        cli_report_failure(session, status);
        cJSON_Delete(result);
        result = NULL;
    }
    rsv_scene_destroy(scene);
    return result;
}

static void print_result(const cJSON *result)
{
    const cJSON *member;
    cJSON_ArrayForEach(member, result)
    {
        if (cJSON_IsString(member)) printf("%s\n", member->valuestring);
        if (cJSON_IsNumber(member)) printf("  %-20s %.4g\n", member->string, member->valuedouble);
    }
    cJSON_ArrayForEach(member, cJSON_GetObjectItem(result, "rays_per_second"))
    {
        printf("  %-20s %.4g M rays/s\n", member->string, 1e-6 * member->valuedouble);
    }
}

static int run(cli_session *session, const settings *s, const benchmark *bench)
{
    static const char *const usual_scenes[] = { "cornell-blocks", "cornell-spheres" };
    size_t scene_count = s->operand[1] ? 1 : sizeof usual_scenes / sizeof usual_scenes[0];
    uint32_t threads = cli_thread_count(s->threads);
    int exit_status = CLI_FAILURE;
    cJSON *root = cJSON_CreateObject();
    cJSON_AddStringToObject(root, "bench", bench->name);
    cJSON_AddNumberToObject(root, "threads", threads);
    cJSON *scenes = cJSON_AddArrayToObject(root, "scenes");
    for (size_t i = 0; i < scene_count; i++) {
        const char *name = s->operand[1] ? s->operand[1] : usual_scenes[i];
        cJSON *result = measure(session, bench, name, threads);
        if (!result) goto cleanup;
        cJSON_AddItemToArray(scenes, result);
        if (!s->json) print_result(result);
    }
    if (!s->json || cli_write_json(NULL, root)) exit_status = CLI_SUCCESS;

cleanup:
    cJSON_Delete(root);
    return exit_status;
}

int cli_bench(int argc, char **argv)
{
    settings s = { 0 };
    const cli_option options[] = {
        { .name = "--threads", .kind = CLI_COUNT, .value = &s.threads, .max = 1024 },
        { .name = "--json", .kind = CLI_FLAG, .value = &s.json },
        { .name = NULL },
    };
    const cli_usage usage = { "bench", help, options, "NAME of a benchmark", 1, 2 };
    int exit_status;
    if (!cli_parse(&usage, argc, argv, s.operand, &exit_status)) return exit_status;
    const benchmark *bench = find_benchmark(s.operand[0]);
    if (!bench) return cli_usage_error("bench", "'%s' is not a benchmark", s.operand[0]);
    cli_session session;
    if (!cli_session_begin(&session, s.threads)) return CLI_FAILURE;
    exit_status = run(&session, &s, bench);
    cli_session_end(&session);
    return exit_status;
}
