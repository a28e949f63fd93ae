#include "command.h"
#include "options.h"
#include "output_file.h"
#include "stats.h"
#include "subject.h"

#include "resolvent/bake.h"

#include <cJSON.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const char help[] =
    "usage: resolvent bake SCENE -o OUT.glb --to vertex [options]\n"
    "\n"
    "Solves the light of SCENE and writes it into a copy of its glTF file for engines and web\n"
    "pages. All else of the file stays as it is: nodes, animations, cameras, extras, extensions.\n"
    "Scenes that are no glTF file become one first. docs/bake.md says what is written.\n"
    "\n"
    "  --to vertex        light in COLOR_0, surfaces tessellated where light asks for it\n"
    "  -o OUT.glb         the file to write\n"
    "  --basis            also write what each light does by itself: OUT.light.safetensors, for\n"
    "                     relighting at run time (docs/runtime.md)\n"
    "  --dry-run          say what would come out, write nothing\n"
    "\n"
    "  --tolerance SHARE  vertex: error of light between vertices (default 2%)\n"
    "  --unlit            vertex: mark diffuse materials KHR_materials_unlit, for viewers\n"
    "\n" CLI_MESH_HELP CLI_ENVIRONMENT_HELP CLI_SOLVE_HELP
    "  --threads N        default: one per processor; the files do not depend on it\n"
    "  --stats FILE.json  what came out, and how long it took\n"
    "\n"
    "examples:\n"
    "  resolvent bake room.glb -o room-lit.glb --to vertex --unlit\n"
    "  resolvent bake cornell-blocks -o box.glb --to vertex --basis --quality high\n";

typedef rsv_status (*bake_function)(const rsv_solution *solution, const char *input,
    const char *output, const rsv_bake_desc *desc, rsv_bake_report *report);

static const char *const target_names[] = { "vertex", NULL };
static const bake_function bake_to[] = { rsv_bake_vertices };

typedef struct settings {
    const char *scene, *output, *stats, *mesh;
    int target; ///< index into target_names; -1 = missing
    cli_environment environment;
    cli_solve_choice solve;
    uint32_t threads;
    rsv_bake_desc bake;
} settings;

static bool ends_in(const char *text, const char *end)
{
    size_t length = strlen(text), tail = strlen(end);
    return length > tail && strcmp(text + length - tail, end) == 0;
}

static bool parse_settings(settings *s, int argc, char **argv, int *exit_status)
{
    const cli_option options[] = {
        { .name = "-o", .kind = CLI_TEXT, .value = &s->output },
        { .name = "--to", .kind = CLI_CHOICE, .value = &s->target, .choices = target_names },
        { .name = "--basis", .kind = CLI_FLAG, .value = &s->bake.basis },
        { .name = "--dry-run", .kind = CLI_FLAG, .value = &s->bake.dry_run },
        { .name = "--tolerance",
            .kind = CLI_SHARE,
            .value = &s->bake.tolerance,
            .min = 0.002,
            .max = 1 },
        { .name = "--unlit", .kind = CLI_FLAG, .value = &s->bake.unlit },
        { .name = "--threads", .kind = CLI_COUNT, .value = &s->threads, .max = 1024 },
        CLI_MESH_OPTION(&s->mesh),
        CLI_SOLVE_OPTIONS(&s->solve),
        CLI_ENVIRONMENT_OPTIONS(&s->environment),
        { .name = "--stats", .kind = CLI_TEXT, .value = &s->stats },
        { .name = NULL },
    };
    const cli_usage usage = { "bake", help, options, "SCENE", 1, 1 };
    if (!cli_parse(&usage, argc, argv, &s->scene, exit_status)) return false;
    if (s->target < 0)
        *exit_status = cli_usage_error("bake", "--to vertex is missing");
    else if (!s->output)
        *exit_status = cli_usage_error("bake", "-o OUT.glb is missing");
    else if (!ends_in(s->output, ".glb"))
        *exit_status = cli_usage_error("bake", "-o '%s' does not end in .glb", s->output);
    else
        return true;
    return false;
}

/// A scene that is no glTF file, written as one beside the output and opened again.
static rsv_scene *open_as_gltf(
    cli_session *session, const settings *s, rsv_scene *scene, char *path, size_t bytes)
{
    snprintf(path, bytes, "%s.%ld.glb", s->output, (long)getpid());
    rsv_status status = rsv_scene_save(scene, path);
    rsv_scene_destroy(scene);
    if (status == RSV_OK) return cli_open_scene(session, path, &s->environment);
    cli_report_failure(session, status);
    *path = 0;
    return NULL;
}

static void print_report(const rsv_bake_report *r)
{
    printf(
        "vertices    %zu, %zu triangles (of %zu)\n", r->vertices, r->triangles, r->input_triangles);
    printf("light scale %.4g\n", (double)r->light_scale);
    if (r->lights) printf("lights      %zu\n", r->lights);
}

static bool write_stats(const cli_session *session, const settings *s, const rsv_bake_report *r)
{
    cJSON *root = cJSON_CreateObject();
    cJSON_AddStringToObject(root, "command", "bake");
    cJSON_AddStringToObject(root, "scene", s->scene);
    cJSON_AddStringToObject(root, "to", target_names[s->target]);
    cJSON_AddNumberToObject(root, "vertices", (double)r->vertices);
    cJSON_AddNumberToObject(root, "triangles", (double)r->triangles);
    cJSON_AddNumberToObject(root, "light_scale", (double)r->light_scale);
    cJSON_AddNumberToObject(root, "time_s", cli_seconds() - session->started);
    bool written = cli_write_json(s->stats, root);
    cJSON_Delete(root);
    return written;
}

/// Solves and bakes. @param input the scene's glTF file
static int bake(cli_session *session, const settings *s, const rsv_scene *scene, const char *input)
{
    rsv_solution *solution = NULL;
    rsv_bake_report report = { 0 };
    rsv_solve_desc desc = cli_describe_solve(&s->solve);
    rsv_status status = rsv_solution_create(scene, &desc, &solution);
    if (status == RSV_OK)
        status = bake_to[s->target](solution, input, s->output, &s->bake, &report);
    rsv_solution_destroy(solution);
    if (status != RSV_OK) return cli_report_failure(session, status);
    cli_progress_clear(&session->progress);
    print_report(&report);
    return !s->stats || write_stats(session, s, &report) ? CLI_SUCCESS : CLI_FAILURE;
}

static int run(cli_session *session, const settings *s)
{
    char temporary[4096] = "";
    bool gltf = ends_in(s->scene, ".gltf") || ends_in(s->scene, ".glb");
    rsv_scene *scene = cli_open_scene(session, s->scene, &s->environment);
    if (scene && !gltf) scene = open_as_gltf(session, s, scene, temporary, sizeof temporary);
    int exit_status = scene ? bake(session, s, scene, gltf ? s->scene : temporary) : CLI_FAILURE;
    rsv_scene_destroy(scene);
    if (*temporary) unlink(temporary);
    return exit_status;
}

int cli_bake(int argc, char **argv)
{
    settings s = { .target = -1,
        .solve = CLI_DEFAULT_SOLVE,
        .environment = CLI_DEFAULT_ENVIRONMENT,
        .bake = rsv_default_bake_desc() };
    int exit_status;
    if (!parse_settings(&s, argc, argv, &exit_status)) return exit_status;
    if (!cli_check_output(s.output) || (s.stats && !cli_check_output(s.stats)) ||
        !cli_check_apart(s.output, s.scene) || !cli_check_apart(s.stats, s.output))
        return CLI_FAILURE;
    cli_session session;
    if (!cli_session_begin(&session, s.threads)) return CLI_FAILURE;
    session.mesh = s.mesh;
    exit_status = run(&session, &s);
    cli_session_end(&session);
    return exit_status;
}
