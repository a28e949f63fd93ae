#include "checkpoint.h"
#include "command.h"
#include "moment.h"
#include "options.h"
#include "output_file.h"
#include "photometry.h"
#include "stats.h"
#include "subject.h"

#include "resolvent/bake.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static const char help[] =
    "usage: resolvent bake SCENE|OPERATOR -o OUT.glb --to TARGET [options]\n"
    "\n"
    "Solves the light of SCENE and writes it into a copy of its glTF file, for engines and web pages.\n"
    "Everything else in the file is kept: nodes, animations, cameras, extras, extensions. Other scenes\n"
    "become a new glTF file. A file from `solve` or `relight` is baked with its lights and colours,\n"
    "without solving again. docs/bake-reference.md describes the output.\n"
    "\n"
    "  --to TARGET        one of {--to}\n"
    "  --to vertex        light in COLOR_0; surfaces are subdivided where the light requires it\n"
    "  --to lightmap      irradiance in a texture (MOZ_lightmap), and in OUT.lightmap.exr\n"
    "  --to probes        a grid of spherical harmonics for moving objects: OUT.json, OUT.probes.bin\n"
    "  --to fog           light in fog, a 3-D texture of fluence: OUT.json, OUT.fog.ktx2\n"
    "  -o OUT             the output file: .glb; for probes and fog .json\n"
    "  --basis            also write the contribution of each light to OUT.light.safetensors, for\n"
    "                     relighting at run time (docs/runtime.md)\n"
    "  --packed           with --basis: write it in about a tenth of the bytes, for downloads\n"
    "  --operator         vertex, lightmap: also write OUT.operator.safetensors, for lights at run time\n"
    "                     that were not baked (docs/runtime.md)\n"
    "  --env-turns N      with --basis: store the environment at N angles of a full turn (1 to 64), so\n"
    "                     that it can be rotated at run time (default 1: fixed)\n"
    "  --sky              also write the environment to OUT.hdr, as it is at --env-rotate 0\n"
    "  --error SHARE      vertex, lightmap: target error of direct light for the median texel or vertex\n"
    "                     (default 1%); penumbrae get more shadow rays. With it, `bake` ends by measuring\n"
    "                     the error of 256 texels or vertices\n"
    "  --light-scale L    vertex, lightmap: the value that 1 stands for in colours and 8-bit maps, as the\n"
    "                     radiance of a white surface, W/(m2 sr). Brighter light is clipped, with a note\n"
    "                     (default: lightmaps clip at most 0.1 %, vertices nothing, vertices with --unlit\n"
    "                     above four times the mean)\n"
    "  --photometric      vertex, lightmap: report lux and cd/m2, and write lux (683 lm/W) to\n"
    "                     OUT.lightmap.exr and .ktx2; the .glb stays in W/m2\n"
    "  --dry-run          report the result, write nothing\n"
    "  --tolerance SHARE  vertex: error of interpolation between vertices (default 2%)\n"
    "  --unlit            vertex: mark diffuse materials as KHR_materials_unlit, for viewers\n"
    "  --map-size N       lightmap: largest side in texels (default 1024; up to 4096 for many small\n"
    "                     surfaces)\n"
    "  --density D        lightmap: texels per metre (default: as many as fit)\n"
    "  --padding N        lightmap: texels between charts (default 2)\n"
    "  --ktx2             lightmap: also write OUT.lightmap.ktx2 (RGB9E5)\n"
    "  --directional      lightmap: also store the light's direction, for normal maps:\n"
    "                     OUT.lightmap-x.exr, -y and -z\n"
    "  --new-uv           lightmap: replace the second texture coordinates of the file\n"
    "  --spacing M        probes: distance in metres (default: a sixteenth of the longest side)\n"
    "  --probe-samples N  probes: rays for each of 32 directions (default 64)\n" CLI_MESH_HELP
        CLI_READING_HELP CLI_MOMENT_HELP CLI_ENVIRONMENT_HELP CLI_FOG_HELP CLI_SOLVE_HELP
            CLI_CHECKPOINT_HELP
    "  --threads N        default: one per core; the files do not depend on it\n"
    "  --stats FILE.json  results, and how long it took (docs/stats.md)\n"
    "\n"
    "examples:\n"
    "  resolvent bake room.glb -o room-lit.glb --to vertex --unlit\n"
    "  resolvent bake room.glb -o room-map.glb --to lightmap --map-size 2048\n"
    "  resolvent bake cornell-blocks -o box.glb --to vertex --basis --quality high\n"
    "  resolvent bake evening.safetensors -o evening.glb --to vertex\n";

#define PI 3.14159265358979323846

typedef struct settings {
    const char *scene, *output, *stats, *mesh;
    int target_index; ///< into rsv_bake_target_names(); -1 = missing
    const char *target;
    cli_environment environment;
    cli_moment moment;
    cli_reading reading;
    cli_solve_choice solve;
    cli_checkpoint checkpoint;
    uint32_t threads;
    bool new_uv;
    float error; ///< 0 = not given
    rsv_bake_desc bake;
} settings;

// clang-format off
#define VERTEX_OPTIONS(bake)                                                                       \
    { .name = "--tolerance", .kind = CLI_SHARE, .value = &(bake)->tolerance,                       \
        .min = 0.002, .max = 1, .goes_with = "--to=vertex" },                                      \
    { .name = "--unlit", .kind = CLI_FLAG, .value = &(bake)->unlit, .goes_with = "--to=vertex" }

#define LIGHTMAP_OPTIONS(bake)                                                                     \
    { .name = "--map-size", .kind = CLI_COUNT, .value = &(bake)->map_size,                         \
        .min = 16, .max = 8192, .goes_with = "--to=lightmap" },                                    \
    { .name = "--density", .kind = CLI_REAL, .value = &(bake)->density,                            \
        .max = 1e6, .goes_with = "--to=lightmap" },                                                \
    { .name = "--padding", .kind = CLI_COUNT, .value = &(bake)->padding,                           \
        .min = 1, .max = 16, .goes_with = "--to=lightmap" },                                       \
    { .name = "--ktx2", .kind = CLI_FLAG, .value = &(bake)->ktx2, .goes_with = "--to=lightmap" }, \
    { .name = "--directional", .kind = CLI_FLAG, .value = &(bake)->directional,                    \
        .goes_with = "--to=lightmap" }

#define PROBE_OPTIONS(bake)                                                                        \
    { .name = "--spacing", .kind = CLI_REAL, .value = &(bake)->probe_spacing,                      \
        .max = 1e6, .goes_with = "--to=probes" },                                                  \
    { .name = "--probe-samples", .kind = CLI_COUNT, .value = &(bake)->probe_samples,               \
        .min = 32, .max = 65536, .goes_with = "--to=probes" }
// clang-format on

/// Of the whole space, not of surfaces.
static bool is_volume(const char *target)
{
    return strcmp(target, "probes") == 0 || strcmp(target, "fog") == 0;
}

/// Checks the output's name and the other options against the target.
static bool check_target(const settings *s, int *exit_status)
{
    const char *extension = rsv_bake_target_extension(s->target);
    if (!s->output)
        *exit_status = cli_usage_error("bake", "-o OUT%s is missing", extension);
    else if (!cli_ends_in(s->output, extension))
        *exit_status = cli_usage_error("bake", "-o '%s' does not end in %s", s->output, extension);
    else if (is_volume(s->target) && s->bake.operator_file)
        *exit_status = cli_usage_error("bake", "--operator requires --to vertex or lightmap");
    else if (is_volume(s->target) && (s->bake.light_scale > 0 || s->error > 0))
        *exit_status =
            cli_usage_error("bake", "--error and --light-scale require --to vertex or lightmap");
    else if (is_volume(s->target) && s->bake.photometric)
        *exit_status = cli_usage_error("bake", "--photometric requires --to vertex or lightmap");
    else
        return true;
    return false;
}

static bool parse_settings(settings *s, int argc, char **argv, int *exit_status)
{
    const cli_option options[] = {
        { .name = "-o", .kind = CLI_TEXT, .value = &s->output },
        { .name = "--to",
            .kind = CLI_CHOICE,
            .value = &s->target_index,
            .choices = rsv_bake_target_names() },
        { .name = "--basis", .kind = CLI_FLAG, .value = &s->bake.basis },
        { .name = "--packed", .kind = CLI_FLAG, .value = &s->bake.packed, .goes_with = "--basis" },
        { .name = "--operator", .kind = CLI_FLAG, .value = &s->bake.operator_file },
        { .name = "--env-turns",
            .kind = CLI_COUNT,
            .value = &s->bake.turns,
            .min = 1,
            .max = 64,
            .goes_with = "--basis" },
        { .name = "--error", .kind = CLI_SHARE, .value = &s->error, .min = 0.001, .max = 0.5 },
        { .name = "--light-scale", .kind = CLI_REAL, .value = &s->bake.light_scale, .max = 1e12 },
        { .name = "--sky", .kind = CLI_FLAG, .value = &s->bake.sky },
        { .name = "--photometric", .kind = CLI_FLAG, .value = &s->bake.photometric },
        { .name = "--dry-run", .kind = CLI_FLAG, .value = &s->bake.dry_run },
        VERTEX_OPTIONS(&s->bake),
        LIGHTMAP_OPTIONS(&s->bake),
        { .name = "--new-uv", .kind = CLI_FLAG, .value = &s->new_uv, .goes_with = "--to=lightmap" },
        PROBE_OPTIONS(&s->bake),
        { .name = "--threads", .kind = CLI_COUNT, .value = &s->threads, .max = 1024 },
        CLI_MESH_OPTION(&s->mesh),
        CLI_MOMENT_OPTIONS(&s->moment),
        CLI_SOLVE_OPTIONS(&s->solve),
        CLI_CHECKPOINT_OPTIONS(&s->checkpoint),
        CLI_ENVIRONMENT_OPTIONS(&s->environment),
        CLI_READING_OPTIONS(&s->reading),
        CLI_FOG_OPTIONS(&s->environment),
        { .name = "--stats", .kind = CLI_TEXT, .value = &s->stats },
        { .name = NULL },
    };
    const cli_usage usage = { "bake", help, options, "SCENE", 1, 1,
        "-o --to --basis --unlit --map-size --quality --error --env --checkpoint --dry-run" };
    if (!cli_parse(&usage, argc, argv, &s->scene, exit_status)) return false;
    if (s->target_index < 0) {
        *exit_status = cli_usage_error("bake", "--to vertex, lightmap, probes or fog is missing");
        return false;
    }
    s->target = rsv_bake_target_names()[s->target_index];
    return check_target(s, exit_status);
}

static void print_light_scale(double scale, bool photometric)
{
    if (photometric)
        printf("light scale %.4g cd/m2: 1 in the file is an illuminance of %.4g lux\n",
            scale * CLI_LUMINOUS_EFFICACY, scale * CLI_LUMINOUS_EFFICACY * PI);
    else
        printf("light scale %.4g W/(m2 sr): 1 in the file is an irradiance of %.4g W/m2\n", scale,
            scale * PI);
}

/// Prints figures of a bake; those that a target does not have are 0.
static void print_report(const char *target, const rsv_bake_report *r, bool photometric)
{
    if (r->vertices)
        printf("vertices    %zu, %zu triangles (of %zu)\n", r->vertices, r->triangles,
            r->input_triangles);
    if (r->map_width)
        printf("map         %u x %u texels, %.4g per metre, %zu charts\n"
               "coverage    %.1f %%\n"
               "seams       %.2f %% at most\n",
            r->map_width, r->map_height, (double)r->density, r->charts, 100 * r->coverage,
            100 * r->largest_seam);
    if (r->probe_count[0])
        printf("%-11s %u x %u x %u, %zu valid\n", target, r->probe_count[0], r->probe_count[1],
            r->probe_count[2], r->valid_probes);
    else if (r->light_scale > 0)
        print_light_scale((double)r->light_scale, photometric);
    if (r->saturated > 0)
        printf("clipped     %.3g %% of the %s are brighter than that%s\n", 100 * r->saturated,
            r->map_width ? "texels" : "vertices",
            r->map_width ? "; the .lightmap.exr is not clipped"
                         : "; a larger --light-scale avoids this");
    if (r->judged)
        printf("error       median %.2g %%, 99th percentile %.2g %%: %zu %s, compared "
               "with estimates with a noise of %.2g %%\n",
            100 * r->error_median, 100 * r->error_99, r->judged,
            r->map_width ? "texels" : "vertices", 100 * r->error_noise);
    if (r->lights) printf("lights      %zu\n", r->lights);
}

/// Describes the result for the statistics.
static cJSON *describe(const settings *s, const rsv_bake_report *r)
{
    cJSON *root = cJSON_CreateObject();
    cJSON_AddStringToObject(root, "to", s->target);
    cJSON_AddNumberToObject(root, "light_scale", (double)r->light_scale);
    cJSON_AddNumberToObject(root, "irradiance_scale", (double)r->light_scale * PI);
    cJSON_AddNumberToObject(root, "saturated", r->saturated);
    if (r->judged) {
        cJSON_AddNumberToObject(root, "judged", (double)r->judged);
        cJSON_AddNumberToObject(root, "error_median", r->error_median);
        cJSON_AddNumberToObject(root, "error_99", r->error_99);
        cJSON_AddNumberToObject(root, "error_noise", r->error_noise);
    }
    if (r->vertices) {
        cJSON_AddNumberToObject(root, "vertices", (double)r->vertices);
        cJSON_AddNumberToObject(root, "triangles", (double)r->triangles);
    }
    if (r->probe_count[0]) cJSON_AddNumberToObject(root, "valid_probes", (double)r->valid_probes);
    if (r->map_width) {
        cJSON_AddNumberToObject(root, "map_width", r->map_width);
        cJSON_AddNumberToObject(root, "map_height", r->map_height);
        cJSON_AddNumberToObject(root, "density", (double)r->density);
        cJSON_AddNumberToObject(root, "charts", (double)r->charts);
        cJSON_AddNumberToObject(root, "coverage", r->coverage);
        cJSON_AddNumberToObject(root, "largest_seam", r->largest_seam);
    }
    return root;
}

static bool write_stats(const cli_session *session, const settings *s, const rsv_light *solution,
    const rsv_bake_report *report, double time_bake)
{
    cli_stats stats = { .command = "bake",
        .scene = s->scene,
        .mode = "bake",
        .quality = (rsv_quality)s->solve.quality,
        .threads = cli_thread_count(s->threads),
        .seed = s->solve.seed,
        .report = rsv_light_report(solution),
        .order_count = rsv_light_order_count(solution),
        .standard_error = NAN,
        .time_render = time_bake,
        .more = describe(s, report) };
    return cli_write_stats(s->stats, session, &stats);
}

/// Checks before the solve what would otherwise fail only after it.
static bool has_surroundings(const settings *s, const rsv_scene *scene)
{
    if (rsv_scene_get_view(scene)->environment) return true;
    if (s->bake.turns > 1)
        cli_error("--env-turns: there is no environment to rotate; add one with --env");
    else if (s->bake.sky)
        cli_error("--sky: there is no environment to write; add one with --env");
    return s->bake.turns == 1 && !s->bake.sky;
}

/// Refuses --checkpoint with an operator file: it is already solved, so there are no rows to save.
static bool refuse_checkpoint(const settings *s, const cli_subject *subject)
{
    if (!subject->solution || !s->checkpoint.folder) return false;
    cli_error(
        "--checkpoint: '%s' is already solved, so there are no rows to save; leave out --checkpoint",
        s->scene);
    return true;
}

#define USUAL_MAP_SIZE 1024
#define JUDGED 256 ///< values that --error is checked at

/// Bytes that a lightmap takes in the making.
static size_t map_bytes(const settings *s)
{
    size_t side = s->bake.map_size ? s->bake.map_size : USUAL_MAP_SIZE;
    if (strcmp(s->target, "lightmap") != 0 || s->bake.dry_run) return 0;
    // measured: 97 and 61; counted: 102 of shadow rays and their noise
    return side * side * (s->bake.directional ? 206 : 168);
}

static int bake(cli_session *session, settings *s, cli_subject *subject)
{
    rsv_bake_report report = { 0 };
    rsv_solve_desc desc = cli_describe_solve(&s->solve);
    // maps with many charts grow beyond the usual size by themselves, but not where memory is counted
    if (s->solve.max_bytes && !s->bake.map_size) s->bake.map_size = USUAL_MAP_SIZE;
    desc.reserved_bytes = map_bytes(s);
    if (!has_surroundings(s, subject->scene) || refuse_checkpoint(s, subject) ||
        !cli_checkpoint_prepare(session, &s->checkpoint, subject->scene, &desc))
        return CLI_FAILURE;
    rsv_status status = cli_solve_subject(session, &desc, NULL, subject, NULL);
    double solved = cli_seconds();
    if (status == RSV_OK)
        status = rsv_bake(subject->solution, s->target, s->output, &s->bake, &report);
    if (status != RSV_OK) return cli_report_failure(session, status);
    cli_checkpoint_prune(&s->checkpoint);
    cli_progress_clear(&session->progress);
    print_report(s->target, &report, s->bake.photometric);
    bool written =
        !s->stats || write_stats(session, s, subject->solution, &report, cli_seconds() - solved);
    return written ? CLI_SUCCESS : CLI_FAILURE;
}

static int run(cli_session *session, settings *s)
{
    cli_subject subject;
    session->mesh = s->mesh;
    session->moment = s->moment;
    session->reading = s->reading;
    session->max_bytes = s->solve.max_bytes;
    session->keep_document =
        true; // .glb files are written anew, others keep what it says of itself
    if (!cli_open_subject(session, s->scene, &s->environment, &subject)) return CLI_FAILURE;
    int exit_status = bake(session, s, &subject);
    cli_close_subject(&subject);
    return exit_status;
}

/// Whether none of the files written beside the output (docs/bake-reference.md) would replace an input.
static bool keeps_inputs(const settings *s)
{
    static const char *const sides[] = { ".lightmap.exr", ".lightmap.ktx2", ".lightmap-x.exr",
        ".lightmap-y.exr", ".lightmap-z.exr", ".light.safetensors", ".operator.safetensors",
        ".probes.bin", ".fog.ktx2" };
    const char *const given[] = { s->scene, s->mesh, s->environment.path, s->stats };
    size_t stem = strlen(s->output) - strlen(strrchr(s->output, '.'));
    char side[4096];
    for (size_t k = 0; k < sizeof sides / sizeof sides[0]; k++) {
        snprintf(side, sizeof side, "%.*s%s", (int)stem, s->output, sides[k]);
        for (size_t n = 0; n < sizeof given / sizeof given[0]; n++)
            if (!cli_check_apart(side, given[n])) return false;
    }
    snprintf(side, sizeof side, "%.*s.hdr", (int)stem, s->output);
    if (s->bake.sky && !cli_check_apart(side, s->environment.path)) return false;
    return cli_check_apart(s->output, s->scene) && cli_check_apart(s->stats, s->output) &&
           cli_check_apart(s->stats, s->scene) && cli_check_apart(s->output, s->environment.path);
}

int cli_bake(int argc, char **argv)
{
    settings s = { .target_index = -1,
        .solve = CLI_DEFAULT_SOLVE,
        .environment = CLI_DEFAULT_ENVIRONMENT,
        .moment = CLI_AT_REST,
        .bake = rsv_default_bake_desc() };
    int exit_status;
    if (!parse_settings(&s, argc, argv, &exit_status)) return exit_status;
    s.bake.keep_uv = !s.new_uv;
    if (s.error > 0) s.bake.error = s.error, s.bake.judged = JUDGED;
    if (!cli_check_output(s.output) || (s.stats && !cli_check_output(s.stats)) || !keeps_inputs(&s))
        return CLI_FAILURE;
    cli_session session;
    if (!cli_prepare_solve(&s.solve) || !cli_session_begin(&session, s.threads)) return CLI_FAILURE;
    exit_status = run(&session, &s);
    cli_session_end(&session);
    return exit_status;
}
