#include "checkpoint.h"
#include "command.h"
#include "options.h"
#include "output_file.h"
#include "stats.h"
#include "subject.h"

#include "resolvent/bake.h"

#include <cJSON.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const char help[] =
    "usage: resolvent bake SCENE -o OUT.glb --to vertex|lightmap|probes [options]\n"
    "\n"
    "Solves the light of SCENE and writes it into a copy of its glTF file for engines and web\n"
    "pages. All else of the file stays as it is: nodes, animations, cameras, extras, extensions.\n"
    "Scenes that are no glTF file become one first. docs/bake.md says what is written.\n"
    "\n"
    "  --to vertex        light in COLOR_0, surfaces tessellated where light asks for it\n"
    "  --to lightmap      irradiance in a texture (MOZ_lightmap), and as OUT.lightmap.exr\n"
    "  --to probes        a grid of spherical harmonics, for what moves: OUT.json and\n"
    "                     OUT.probes.bin\n"
    "  -o OUT             the file to write: .glb, probes .json\n"
    "  --basis            also write what each light does by itself: OUT.light.safetensors, for\n"
    "                     relighting at run time (docs/runtime.md)\n"
    "  --operator         vertex, lightmap: also write the operator: OUT.operator.safetensors, "
    "for\n"
    "                     lights at run time that were not baked (docs/runtime.md)\n"
    "  --env-turns N      with --basis: surroundings at N angles of a full turn (1..64), so that\n"
    "                     they can be turned at run time (default 1: as they are)\n"
    "  --dry-run          say what would come out, write nothing\n"
    "\n"
    "  --tolerance SHARE  vertex: error of light between vertices (default 2%)\n"
    "  --unlit            vertex: mark diffuse materials KHR_materials_unlit, for viewers\n"
    "  --map-size N       lightmap: texels along a side at most (default 1024; up to\n"
    "                     4096 where there are many small surfaces)\n"
    "  --density D        lightmap: texels per metre (default: as many as fit)\n"
    "  --padding N        lightmap: texels between charts (default 2)\n"
    "  --directional      lightmap: also where light comes from, for normal maps:\n"
    "                     OUT.lightmap-x.exr, -y and -z\n"
    "  --new-uv           lightmap: make texture coordinates even where the file has second ones\n"
    "  --spacing M        probes: metres between them (default: a sixteenth of the longest side)\n"
    "  --probe-samples N  probes: rays for each of 32 directions (default 64)\n"
    "\n" CLI_MESH_HELP CLI_ENVIRONMENT_HELP CLI_SOLVE_HELP CLI_CHECKPOINT_HELP
    "  --threads N        default: one per processor; the files do not depend on it\n"
    "  --stats FILE.json  what came out, and how long it took\n"
    "\n"
    "examples:\n"
    "  resolvent bake room.glb -o room-lit.glb --to vertex --unlit\n"
    "  resolvent bake room.glb -o room-map.glb --to lightmap --map-size 2048\n"
    "  resolvent bake cornell-blocks -o box.glb --to vertex --basis --quality high\n";

typedef rsv_status (*bake_function)(const rsv_solution *solution, const char *input,
    const char *output, const rsv_bake_desc *desc, rsv_bake_report *report);

static const char *const target_names[] = { "vertex", "lightmap", "probes", NULL };
static const bake_function bake_to[] = { rsv_bake_vertices, rsv_bake_lightmap, rsv_bake_probes };
enum { TO_VERTEX, TO_LIGHTMAP, TO_PROBES };

typedef struct settings {
    const char *scene, *output, *stats, *mesh;
    int target; ///< index into target_names; -1 = missing
    cli_environment environment;
    cli_solve_choice solve;
    cli_checkpoint checkpoint;
    uint32_t threads;
    bool new_uv;
    rsv_bake_desc bake;
} settings;

static bool parse_settings(settings *s, int argc, char **argv, int *exit_status)
{
    const cli_option options[] = {
        { .name = "-o", .kind = CLI_TEXT, .value = &s->output },
        { .name = "--to", .kind = CLI_CHOICE, .value = &s->target, .choices = target_names },
        { .name = "--basis", .kind = CLI_FLAG, .value = &s->bake.basis },
        { .name = "--operator", .kind = CLI_FLAG, .value = &s->bake.operator_file },
        { .name = "--env-turns",
            .kind = CLI_COUNT,
            .value = &s->bake.turns,
            .min = 1,
            .max = 64,
            .goes_with = "--basis" },
        { .name = "--dry-run", .kind = CLI_FLAG, .value = &s->bake.dry_run },
        { .name = "--tolerance",
            .kind = CLI_SHARE,
            .value = &s->bake.tolerance,
            .min = 0.002,
            .max = 1,
            .goes_with = "--to=vertex" },
        { .name = "--unlit",
            .kind = CLI_FLAG,
            .value = &s->bake.unlit,
            .goes_with = "--to=vertex" },
        { .name = "--map-size",
            .kind = CLI_COUNT,
            .value = &s->bake.map_size,
            .min = 16,
            .max = 8192,
            .goes_with = "--to=lightmap" },
        { .name = "--density",
            .kind = CLI_REAL,
            .value = &s->bake.density,
            .max = 1e6,
            .goes_with = "--to=lightmap" },
        { .name = "--padding",
            .kind = CLI_COUNT,
            .value = &s->bake.padding,
            .min = 1,
            .max = 16,
            .goes_with = "--to=lightmap" },
        { .name = "--spacing",
            .kind = CLI_REAL,
            .value = &s->bake.probe_spacing,
            .max = 1e6,
            .goes_with = "--to=probes" },
        { .name = "--probe-samples",
            .kind = CLI_COUNT,
            .value = &s->bake.probe_samples,
            .min = 32,
            .max = 65536,
            .goes_with = "--to=probes" },
        { .name = "--directional",
            .kind = CLI_FLAG,
            .value = &s->bake.directional,
            .goes_with = "--to=lightmap" },
        { .name = "--new-uv", .kind = CLI_FLAG, .value = &s->new_uv, .goes_with = "--to=lightmap" },
        { .name = "--threads", .kind = CLI_COUNT, .value = &s->threads, .max = 1024 },
        CLI_MESH_OPTION(&s->mesh),
        CLI_SOLVE_OPTIONS(&s->solve),
        CLI_CHECKPOINT_OPTIONS(&s->checkpoint),
        CLI_ENVIRONMENT_OPTIONS(&s->environment),
        { .name = "--stats", .kind = CLI_TEXT, .value = &s->stats },
        { .name = NULL },
    };
    const cli_usage usage = { "bake", help, options, "SCENE", 1, 1 };
    if (!cli_parse(&usage, argc, argv, &s->scene, exit_status)) return false;
    if (s->target < 0)
        *exit_status = cli_usage_error("bake", "--to vertex, lightmap or probes is missing");
    else if (!s->output)
        *exit_status = cli_usage_error("bake", "-o OUT.glb is missing");
    else if (!cli_ends_in(s->output, s->target == TO_PROBES ? ".json" : ".glb"))
        *exit_status = cli_usage_error("bake", "-o '%s' does not end in %s", s->output,
            s->target == TO_PROBES ? ".json" : ".glb");
    else if (s->target == TO_PROBES && s->bake.operator_file)
        *exit_status = cli_usage_error("bake", "--operator goes with --to vertex or lightmap");
    else
        return true;
    return false;
}

/// A scene that is no glTF file, written as one and opened again. The file has no name once it is open, so that
/// nothing of it is left, however this ends.
/// @param path out: what it can be read by @param descriptor out: to be closed
static rsv_scene *open_as_gltf(
    cli_session *session, const settings *s, rsv_scene *scene, char path[64], int *descriptor)
{
    char name[4096];
    snprintf(name, sizeof name, "%s.%ld.glb", s->output, (long)getpid());
    rsv_status status = rsv_scene_save(scene, name);
    rsv_scene_destroy(scene);
    if (status != RSV_OK) {
        cli_report_failure(session, status);
        return NULL;
    }
    *descriptor = open(name, O_RDONLY | O_CLOEXEC);
    int error = errno;
    unlink(name);
    if (*descriptor < 0) {
        cli_error("%s: cannot be opened again: %s", name, strerror(error));
        return NULL;
    }
    snprintf(path, 64, "/proc/self/fd/%d", *descriptor);
    return cli_open_scene(session, path, &s->environment);
}

static void print_report(const settings *s, const rsv_bake_report *r)
{
    if (s->target == TO_VERTEX)
        printf("vertices    %zu, %zu triangles (of %zu)\n", r->vertices, r->triangles,
            r->input_triangles);
    if (s->target == TO_LIGHTMAP)
        printf("map         %u x %u texels, %.4g per metre, %zu charts\n"
               "coverage    %.1f %%\n"
               "seams       %.2f %% at most\n",
            r->map_width, r->map_height, (double)r->density, r->charts, 100 * r->coverage,
            100 * r->largest_seam);
    if (s->target == TO_PROBES)
        printf("probes      %u x %u x %u, %zu valid\n", r->probe_count[0], r->probe_count[1],
            r->probe_count[2], r->valid_probes);
    else
        printf("light scale %.4g\n", (double)r->light_scale);
    if (r->lights) printf("lights      %zu\n", r->lights);
}

/// What came out, for the statistics.
static cJSON *describe(const settings *s, const rsv_bake_report *r)
{
    cJSON *root = cJSON_CreateObject();
    cJSON_AddStringToObject(root, "to", target_names[s->target]);
    cJSON_AddNumberToObject(root, "light_scale", (double)r->light_scale);
    if (s->target == TO_VERTEX) {
        cJSON_AddNumberToObject(root, "vertices", (double)r->vertices);
        cJSON_AddNumberToObject(root, "triangles", (double)r->triangles);
    }
    if (s->target == TO_PROBES)
        cJSON_AddNumberToObject(root, "valid_probes", (double)r->valid_probes);
    if (s->target == TO_LIGHTMAP) {
        cJSON_AddNumberToObject(root, "map_width", r->map_width);
        cJSON_AddNumberToObject(root, "map_height", r->map_height);
        cJSON_AddNumberToObject(root, "density", (double)r->density);
        cJSON_AddNumberToObject(root, "charts", (double)r->charts);
        cJSON_AddNumberToObject(root, "coverage", r->coverage);
        cJSON_AddNumberToObject(root, "largest_seam", r->largest_seam);
    }
    return root;
}

static bool write_stats(const cli_session *session, const settings *s, const rsv_solution *solution,
    const rsv_bake_report *report, double time_bake)
{
    cli_stats stats = { .command = "bake",
        .scene = s->scene,
        .mode = "bake",
        .quality = (rsv_quality)s->solve.quality,
        .threads = cli_thread_count(s->threads),
        .seed = s->solve.seed,
        .report = rsv_solution_report(solution),
        .order_count = rsv_solution_order_count(solution),
        .standard_error = NAN,
        .time_render = time_bake,
        .more = describe(s, report) };
    return cli_write_stats(s->stats, session, &stats);
}

/// Before it is solved: what would fail only afterwards.
static bool can_turn(const settings *s, const rsv_scene *scene)
{
    if (s->bake.turns == 1 || rsv_scene_get_view(scene)->environment) return true;
    cli_error("--env-turns: there are no surroundings to be turned; give them by --env");
    return false;
}

/// Solves and bakes. @param input the scene's glTF file
static int bake(cli_session *session, settings *s, const rsv_scene *scene, const char *input)
{
    rsv_solution *solution = NULL;
    rsv_bake_report report = { 0 };
    rsv_solve_desc desc = cli_describe_solve(&s->solve);
    if (!can_turn(s, scene) || !cli_checkpoint_prepare(session, &s->checkpoint, scene, &desc))
        return CLI_FAILURE;
    rsv_status status = rsv_solution_create(scene, &desc, &solution);
    double solved = cli_seconds();
    if (status == RSV_OK)
        status = bake_to[s->target](solution, input, s->output, &s->bake, &report);
    bool written = status == RSV_OK;
    if (written) {
        cli_checkpoint_prune(&s->checkpoint);
        cli_progress_clear(&session->progress);
        print_report(s, &report);
        written = !s->stats || write_stats(session, s, solution, &report, cli_seconds() - solved);
    }
    rsv_solution_destroy(solution);
    if (status != RSV_OK) return cli_report_failure(session, status);
    return written ? CLI_SUCCESS : CLI_FAILURE;
}

static int run(cli_session *session, settings *s)
{
    char nameless[64] = "";
    int descriptor = -1;
    bool gltf =
        cli_ends_in(s->scene, ".gltf") || cli_ends_in(s->scene, ".glb") || s->target == TO_PROBES;
    rsv_scene *scene = cli_open_scene(session, s->scene, &s->environment);
    if (scene && !gltf) scene = open_as_gltf(session, s, scene, nameless, &descriptor);
    int exit_status = scene ? bake(session, s, scene, gltf ? s->scene : nameless) : CLI_FAILURE;
    rsv_scene_destroy(scene);
    if (descriptor >= 0) close(descriptor);
    return exit_status;
}

/// Whether none of the files beside the output (docs/bake.md) is one of those that the user gave.
static bool keeps_inputs(const settings *s)
{
    static const char *const sides[] = { ".lightmap.exr", ".lightmap-x.exr", ".lightmap-y.exr",
        ".lightmap-z.exr", ".light.safetensors", ".operator.safetensors", ".probes.bin" };
    const char *const given[] = { s->scene, s->mesh, s->environment.path, s->stats };
    size_t stem = strlen(s->output) - strlen(strrchr(s->output, '.'));
    char side[4096];
    for (size_t k = 0; k < sizeof sides / sizeof sides[0]; k++) {
        snprintf(side, sizeof side, "%.*s%s", (int)stem, s->output, sides[k]);
        for (size_t n = 0; n < sizeof given / sizeof given[0]; n++)
            if (!cli_check_apart(side, given[n])) return false;
    }
    return cli_check_apart(s->output, s->scene) && cli_check_apart(s->stats, s->output) &&
           cli_check_apart(s->stats, s->scene) && cli_check_apart(s->output, s->environment.path);
}

int cli_bake(int argc, char **argv)
{
    settings s = { .target = -1,
        .solve = CLI_DEFAULT_SOLVE,
        .environment = CLI_DEFAULT_ENVIRONMENT,
        .bake = rsv_default_bake_desc() };
    int exit_status;
    if (!parse_settings(&s, argc, argv, &exit_status)) return exit_status;
    s.bake.keep_uv = !s.new_uv;
    if (!cli_check_output(s.output) || (s.stats && !cli_check_output(s.stats)) || !keeps_inputs(&s))
        return CLI_FAILURE;
    cli_session session;
    if (!cli_prepare_solve(&s.solve) || !cli_session_begin(&session, s.threads)) return CLI_FAILURE;
    session.mesh = s.mesh;
    exit_status = run(&session, &s);
    cli_session_end(&session);
    return exit_status;
}
