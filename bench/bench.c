#include "bench.h"

#include "benchmarks.h"
#include "command.h"
#include "crew.h"
#include "device.h"
#include "flown_frames.h"
#include "output_file.h"
#include "stats.h"

#include "resolvent/frame.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char help[] =
    "usage: resolvent bench NAME [SCENE] [options]\n"
    "\n"
    "Measures this machine on SCENE, or on a built-in scene that suits the benchmark. docs/benchmarks.md\n"
    "explains each benchmark and has results.\n"
    "\n"
    "  trace        millions of camera, cosine-distributed and occlusion rays per second; one at a time\n"
    "               and in packets of sixteen\n"
    "  assemble     assembly of the operator, compared with tracing the same rays and nothing else. All\n"
    "               materials of SCENE must be Lambertian\n"
    "  quality      error over time of modes final, operator and reference, against one path-traced\n"
    "               reference\n"
    "  media        the same for scenes with fog; then frames, and a light that changes\n"
    "  pictures     time to relative MSEs of 0.02, 0.005 and 0.001, compared with mode reference: first\n"
    "               picture, second view, relit view\n"
    "  bake         lightmaps and vertices compared with path tracing: time, errors, blotches, seams,\n"
    "               bytes\n"
    "  rooms        frames in furnished rooms (--assets): time by stage, error moving and at rest, flicker\n"
    "  fps          frame times of a flight through SCENE, compared with bare ray tracing. With --repeat:\n"
    "               also the cost of a second eye, and what 10,000 frames leave behind\n"
    "  fig8         frames per second against ambient occlusion, for four mesh sizes\n"
    "  move         milliseconds until the scene is fully lit again after one light moved\n"
    "  moving       an object that moves frame by frame: following it, updating, and solving from scratch\n"
    "  rebake       one object moved: solving with the rows that --checkpoint keeps, and from scratch\n"
    "  relight      the runtime for engines: 100,000 receivers, 4 lights, one thread, no scene\n"
    "  solvers      residual over applications of the operator and over time, for all solvers\n"
    "  certificate  bounds and estimates of `certify` compared with true errors\n"
    "  goal         error of a picture over number of elements, with and without --goal\n"
    "  levels       rays for 1 % error of indirect light: with its own elements, or as many as direct light\n"
    "  cluster      how evenly 2 to 64 processes share the rows; with mpirun, how fast a few of them are\n"
    "  gpu          the device given by --device: operator, solvers, relighting, frames; as Markdown\n"
    "  scale        time and memory by scene size, 1e4 to 1e7 triangles: 6 GB, a quarter of an hour\n"
    "\n"
    "  --threads N        default: one per core\n"
    "  --repeat N         assemble, cluster, fig8, fps, gpu, media, move, quality, solvers: repeat N\n"
    "                     times (default 1 to 21)\n"
    "  --frames N         fps, media, rooms: frames of the flight (default: 3 seconds, 3 to 120 frames);\n"
    "                     moving: default 8\n"
    "  --size N           bake: largest side of the map (default 512); quality, media: pixels along each\n"
    "                     side (default 256, 128); fig8: rows of pixels, at 16:9 (default 720)\n"
    "  --size WxH         fps, rooms: pixels of a frame (default 1280x720; rooms compares frames of half\n"
    "                     the size); pictures: default 640x360\n"
    "  --gloss G          fps, rooms: rough reflections: reused (default) or paths\n"
    "  --assets FOLDER    bake, rooms, pictures: folder of the scenes (default: RSV_ASSETS)\n"
    "  --cache FOLDER     rooms: keep operators and references for the next run; pictures: references.\n"
    "                     Empty it when they should change\n"
    "  --strips FOLDER    rooms: a picture of each scene: four frames of the flight, one at rest, and the\n"
    "                     reference\n"
    "  --quick            rooms, pictures: draft quality, smaller frames, references of 16 rays per pixel\n"
    "  --spp N            rays per pixel of each of the two references (default: quality 1024; rooms and\n"
    "                     pictures 64)\n"
    "  --reference FILE   quality: use the mean of these pictures, rendered with different seeds, as the\n"
    "                     reference; repeat it, an even number of times\n" CLI_MESH_HELP
        CLI_READING_HELP CLI_ENVIRONMENT_HELP
    "  --quality Q        draft, medium or high. Default: draft for moving and fps, high for quality (the\n"
    "                     best compared) and gpu, draft and medium for assemble, medium for the others\n"
    "  --max-elements N   fig8, move, and those with --quality: solve with at most N elements, for a quick\n"
    "                     look\n"
    "  --max-time S       pictures: seconds per scene, with fewer pictures and coarser references if that\n"
    "                     is too little (default 300)\n"
    "  --paths N          certificate: paths at each of 2000 points, twice (default 2048); bake: paths at\n"
    "                     each of 256 texels (default 4096)\n"
    "  --csv FILE         all but trace and assemble: the table as comma-separated values\n"
    "  --plot FILE.svg    the curves, for the same benchmarks as --csv\n"
    "  --json             print JSON\n"
    "  --stats FILE.json  write that JSON to a file\n" CLI_DEVICE_HELP "\n"
    "examples:\n"
    "  resolvent bench trace room.glb --threads 1 --json\n"
    "  resolvent bench fps room.safetensors --frames 60 --json\n"
    "  resolvent bench quality --spp 4096 --plot quality.svg\n";

enum { BENCH_SCENES = 12 };

typedef struct benchmark {
    const char *name;
    bool (*run)(const cli_bench_task *bench, cJSON *result);
    void (*print)(const cJSON *result);
    bool (*write_csv)(const char *path, const cJSON *scenes); ///< or NULL, as write_plot
    bool (*write_plot)(const char *path, const cJSON *scenes);
    const char *scenes[BENCH_SCENES];           ///< where none is given
    uint32_t repetitions;                       ///< likewise
    uint32_t size;                              ///< likewise, where it is an option
    cli_size frame_size;                        ///< likewise
    bool has_quality;                           ///< --quality is an option
    int quality;                                ///< likewise, where it is
    void (*print_summary)(const cJSON *scenes); ///< of all of them, or NULL
} benchmark;

static const benchmark benchmarks[] = {
    { .name = "trace",
        .run = cli_bench_trace,
        .print = cli_print_trace,
        .scenes = { "cornell-blocks", "cornell-spheres" },
        .repetitions = 1 },
    { .name = "assemble",
        .run = cli_bench_assemble,
        .print = cli_print_assemble,
        .scenes = { "cornell-blocks" },
        .repetitions = 5,
        .has_quality = true,
        .quality = BENCH_DRAFT_AND_MEDIUM },
    { .name = "quality",
        .run = cli_bench_quality,
        .print = cli_print_quality,
        .write_csv = cli_write_quality_csv,
        .write_plot = cli_write_quality_plot,
        .scenes = { "cornell-blocks" },
        .repetitions = 3,
        .size = 256,
        .has_quality = true,
        .quality = RSV_QUALITY_HIGH },
    { .name = "media",
        .run = cli_bench_media,
        .print = cli_print_media,
        .write_csv = cli_write_quality_csv,
        .write_plot = cli_write_quality_plot,
        .scenes = { "fog-rooms", "smoke" },
        .repetitions = 1,
        .size = 128,
        .has_quality = true,
        .quality = RSV_QUALITY_MEDIUM },
    { .name = "relight",
        .run = cli_bench_relight,
        .print = cli_print_relight,
        .scenes = { "100,000 receivers, 4 lights" },
        .repetitions = 1 },
    { .name = "solvers",
        .run = cli_bench_solvers,
        .print = cli_print_solvers,
        .write_csv = cli_write_solvers_csv,
        .write_plot = cli_write_solvers_plot,
        .scenes = { "cornell-blocks", "bright-box" },
        .repetitions = 5,
        .has_quality = true,
        .quality = RSV_QUALITY_MEDIUM },
    { .name = "fps",
        .run = cli_bench_fps,
        .print = cli_print_fps,
        .write_csv = cli_write_fps_csv,
        .write_plot = cli_write_fps_plot,
        .scenes = { "cornell-plaster", "cornell-showcase" },
        .frame_size = { 1280, 720 },
        .has_quality = true,
        .quality = RSV_QUALITY_DRAFT },
    { .name = "rooms",
        .run = cli_bench_rooms,
        .print = cli_print_rooms,
        .print_summary = cli_print_rooms_summary,
        .write_csv = cli_write_rooms_csv,
        .write_plot = cli_write_rooms_plot,
        .scenes = { "modern_hall", "fireplace_room", "white_room", "wooden_staircase",
            "japanese_classroom", "head", "SheenChair", "MetalRoughSpheres",
            "TransmissionRoughness", "ClearCoat" },
        .frame_size = { 1280, 720 },
        .has_quality = true,
        .quality = RSV_QUALITY_MEDIUM },
    { .name = "pictures",
        .run = cli_bench_pictures,
        .print = cli_print_pictures,
        .print_summary = cli_print_pictures_summary,
        .write_csv = cli_write_pictures_csv,
        .scenes = { "modern_hall", "fireplace_room", "white_room", "wooden_staircase",
            "japanese_classroom", "studio", "head", "gallery", "terraces", "cornell-spheres",
            "cornell-glass", "cornell-marble" },
        .repetitions = 1,
        .frame_size = { 640, 360 },
        .has_quality = true,
        .quality = RSV_QUALITY_MEDIUM },
    { .name = "bake",
        .run = cli_bench_bake,
        .print = cli_print_bake,
        .print_summary = cli_print_bake_summary,
        .write_csv = cli_write_bake_csv,
        .scenes = { "cornell-blocks" },
        .repetitions = 1,
        .size = 512,
        .has_quality = true,
        .quality = RSV_QUALITY_MEDIUM },
    { .name = "fig8",
        .run = cli_bench_fig8,
        .print = cli_print_fig8,
        .write_csv = cli_write_fig8_csv,
        .write_plot = cli_write_fig8_plot,
        .scenes = { "cornell-plaster" },
        .repetitions = 21,
        .size = 720 },
    { .name = "move",
        .run = cli_bench_move,
        .print = cli_print_move,
        .write_csv = cli_write_move_csv,
        .scenes = { "cornell-plaster", "cornell-showcase" },
        .repetitions = 9 },
    { .name = "rebake",
        .run = cli_bench_rebake,
        .print = cli_print_rebake,
        .write_csv = cli_write_rebake_csv,
        .scenes = { "gallery" },
        .repetitions = 1,
        .has_quality = true,
        .quality = RSV_QUALITY_MEDIUM },
    { .name = "moving",
        .run = cli_bench_moving,
        .print = cli_print_moving,
        .write_csv = cli_write_moving_csv,
        .scenes = { "cornell-blocks", "two-rooms" },
        .repetitions = 1,
        .has_quality = true,
        .quality = RSV_QUALITY_DRAFT },
    { .name = "goal",
        .run = cli_bench_goal,
        .print = cli_print_goal,
        .write_csv = cli_write_goal_csv,
        .write_plot = cli_write_goal_plot,
        .scenes = { "two-rooms", "gallery:2" },
        .repetitions = 1 },
    { .name = "levels",
        .run = cli_bench_levels,
        .print = cli_print_levels,
        .write_csv = cli_write_levels_csv,
        .write_plot = cli_write_levels_plot,
        .scenes = { "cornell-blocks" },
        .repetitions = 1,
        .has_quality = true,
        .quality = RSV_QUALITY_MEDIUM },
    { .name = "certificate",
        .run = cli_bench_certificate,
        .print = cli_print_certificate,
        .print_summary = cli_print_certificate_summary,
        .write_csv = cli_write_certificate_csv,
        .write_plot = cli_write_certificate_plot,
        .scenes = { "cornell-blocks", "two-rooms", "bright-box", "gallery:2", "cornell-spheres" },
        .repetitions = 1 },
    { .name = "cluster",
        .run = cli_bench_cluster,
        .print = cli_print_cluster,
        .write_csv = cli_write_cluster_csv,
        .write_plot = cli_write_cluster_plot,
        .scenes = { "terraces:1e5", "terraces:1e6", "gallery:1" },
        .repetitions = 3 },
    { .name = "gpu",
        .run = cli_bench_gpu,
        .print = cli_print_gpu,
        .scenes = { "cornell-blocks" },
        .repetitions = 21,
        .has_quality = true,
        .quality = RSV_QUALITY_HIGH },
    { .name = "scale",
        .run = cli_bench_scale,
        .print = cli_print_scale,
        .print_summary = cli_print_scale_summary,
        .write_csv = cli_write_scale_csv,
        .write_plot = cli_write_scale_plot,
        .scenes = { "terraces:1e4", "terraces:1e5", "terraces:1e6", "terraces:1e7" },
        .repetitions = 1 },
};

static const benchmark *find_benchmark(const char *name)
{
    for (size_t i = 0; i < sizeof benchmarks / sizeof benchmarks[0]; i++)
        if (strcmp(benchmarks[i].name, name) == 0) return &benchmarks[i];
    return NULL;
}

typedef struct settings {
    const char *operand[2]; ///< name of the benchmark, scene or NULL
    cli_bench_task bench;   ///< options shared by the benchmarks
    cli_size size;
    const char *csv, *plot, *mesh, *stats;
    cli_reading reading;
    int device;
    bool json, quick;
} settings;

double cli_json_number(const cJSON *object, const char *name)
{
    const cJSON *member = cJSON_GetObjectItem(object, name);
    return cJSON_IsNumber(member) ? member->valuedouble : NAN;
}

static int compare_numbers(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double cli_median(double *values, size_t count)
{
    qsort(values, count, sizeof *values, compare_numbers);
    return (values[(count - 1) / 2] + values[count / 2]) / 2;
}

rsv_solve_desc cli_bench_solve_desc(const cli_bench_task *bench, int quality)
{
    rsv_solve_desc desc = rsv_default_solve_desc((rsv_quality)quality);
    desc.max_elements = bench->max_elements;
    return desc;
}

/// One scene through one benchmark; NULL after a message.
static cJSON *measure(const benchmark *b, const settings *s, const char *scene)
{
    cli_bench_task bench = s->bench;
    bench.scene = scene;
    cJSON *result = cJSON_CreateObject();
    cJSON_AddStringToObject(result, "scene", scene);
    if (b->run(&bench, result)) return result;
    cJSON_Delete(result);
    return NULL;
}

static void report(const benchmark *b, const settings *s, const cJSON *result)
{
    cli_progress_clear(&s->bench.session->progress);
    if (s->json) return;
    printf("%s\n", cJSON_GetStringValue(cJSON_GetObjectItem(result, "scene")));
    b->print(result);
}

/// Writes the files that were asked for.
static bool write_files(const benchmark *b, const settings *s, const cJSON *results)
{
    if (!cli_crew_speaks()) return true;
    return (!s->csv || b->write_csv(s->csv, results)) &&
           (!s->plot || b->write_plot(s->plot, results));
}

static int run(const benchmark *b, const settings *s)
{
    const char *const *scenes = s->operand[1] ? &s->operand[1] : b->scenes;
    size_t scene_count = 1;
    while (!s->operand[1] && scene_count < BENCH_SCENES && b->scenes[scene_count])
        scene_count++;
    int exit_status = CLI_FAILURE;
    cJSON *root = cJSON_CreateObject();
    cJSON_AddStringToObject(root, "bench", b->name);
    cJSON_AddNumberToObject(root, "threads", s->bench.threads);
    cJSON *results = cJSON_AddArrayToObject(root, "scenes");
    for (size_t i = 0; i < scene_count; i++) {
        cJSON *result = measure(b, s, scenes[i]);
        if (!result) goto cleanup;
        cJSON_AddItemToArray(results, result);
        report(b, s, result);
    }
    if (b->print_summary && !s->json) b->print_summary(results);
    if (!write_files(b, s, results)) goto cleanup;
    if (s->stats && !cli_write_json(s->stats, root)) goto cleanup;
    if (!s->json || cli_write_json(NULL, root)) exit_status = CLI_SUCCESS;

cleanup:
    cJSON_Delete(root);
    return exit_status;
}

/// Options that only some benchmarks understand.
static int check_settings(const benchmark *b, const settings *s)
{
    size_t references = s->bench.references.count;
    if (s->operand[1] && b->run == cli_bench_relight)
        return cli_usage_error("bench", "relight takes no scene");
    if (references && b->run != cli_bench_quality && b->run != cli_bench_media)
        return cli_usage_error("bench", "--reference belongs to bench quality and media");
    if ((s->csv && !b->write_csv) || (s->plot && !b->write_plot))
        return cli_usage_error("bench",
            "--csv and --plot belong to bench quality, solvers, "
            "certificate, goal, rebake, moving, levels, fps, fig8 and scale");
    if (s->mesh && b->run == cli_bench_fig8)
        return cli_usage_error(
            "bench", "--mesh does not go with fig8, whose meshes are of given sizes");
    bool flies = b->frame_size.width > 0, is_rooms = b->run == cli_bench_rooms;
    bool bakes = b->run == cli_bench_bake, judges = is_rooms || b->run == cli_bench_pictures;
    if (s->bench.environment.path && b->run != cli_bench_quality && !flies && !bakes)
        return cli_usage_error(
            "bench", "--env belongs to bench bake, quality, fps, rooms and pictures");
    if (s->bench.assets && !judges && !bakes)
        return cli_usage_error("bench", "--assets belongs to bench bake, rooms and pictures");
    if ((s->bench.cache || s->quick) && !judges)
        return cli_usage_error("bench", "--cache and --quick belong to bench rooms and pictures");
    if (s->bench.max_seconds > 0 && b->run != cli_bench_pictures)
        return cli_usage_error("bench", "--max-time belongs to bench pictures");
    if (s->bench.strips && !is_rooms)
        return cli_usage_error("bench", "--strips belongs to bench rooms");
    if (s->bench.quality >= 0 && !b->has_quality)
        return cli_usage_error("bench",
            "--quality belongs to bench assemble, solvers, bake, levels, quality, media, rebake, moving, gpu, "
            "fps, rooms and pictures");
    if (s->bench.max_elements && !b->has_quality && b->run != cli_bench_fig8 &&
        b->run != cli_bench_move)
        return cli_usage_error("bench",
            "--max-elements belongs to bench fig8, move and those that take --quality");
    if (s->bench.gloss >= 0 && !flies)
        return cli_usage_error("bench", "--gloss belongs to bench fps and rooms");
    bool has_frames = (flies && b->run != cli_bench_pictures) || b->run == cli_bench_moving ||
                      b->run == cli_bench_media;
    if (s->bench.frames && !has_frames)
        return cli_usage_error("bench", "--frames belongs to bench fps, media, rooms and moving");
    if (s->size.width && !b->size && !flies)
        return cli_usage_error(
            "bench", "--size belongs to bench bake, quality, media, fig8, fps, rooms and pictures");
    if (b->size && s->size.width != s->size.height)
        return cli_usage_error("bench", "--size of bench %s is one number", b->name);
    if (references % 2)
        return cli_usage_error("bench", "--reference must be given an even number of times");
    if ((s->bench.cache && !cli_make_folder("--cache", s->bench.cache, NULL)) ||
        (s->bench.strips && !cli_make_folder("--strips", s->bench.strips, NULL)))
        return CLI_FAILURE;
    if ((s->csv && !cli_check_output(s->csv)) || (s->plot && !cli_check_output(s->plot)) ||
        (s->stats && !cli_check_output(s->stats)))
        return CLI_FAILURE;
    return CLI_SUCCESS;
}

/// Of bench pictures, for each scene.
#define SCENE_SECONDS 300

/// Sizes and rays where frames are flown and compared.
static void choose_frames(const benchmark *b, settings *s)
{
    cli_bench_task *bench = &s->bench;
    uint32_t share = s->quick ? 4 : 2;
    bool takes_pictures = b->run == cli_bench_pictures;
    bench->frame_size = s->size.width ? s->size : b->frame_size;
    if (takes_pictures && s->quick && !s->size.width) bench->frame_size = (cli_size){ 160, 90 };
    bench->judged_size =
        (cli_size){ bench->frame_size.width / share, bench->frame_size.height / share };
    if (bench->judged_size.width < 8) bench->judged_size.width = 8;
    if (bench->judged_size.height < 8) bench->judged_size.height = 8;
    const char *assets = getenv("RSV_ASSETS");
    if (!bench->assets && assets && *assets) bench->assets = assets;
    if (bench->max_seconds == 0) bench->max_seconds = SCENE_SECONDS;
    if (bench->reference_samples) return;
    bool judges = takes_pictures || b->run == cli_bench_rooms;
    bench->reference_samples = !judges ? 1024 : s->quick ? 16 : 64;
}

static int measure_and_report(settings *s)
{
    const benchmark *b = find_benchmark(s->operand[0]);
    if (!b) return cli_usage_error("bench", "'%s' is not a benchmark", s->operand[0]);
    int exit_status = check_settings(b, s);
    if (exit_status != CLI_SUCCESS) return exit_status;
    cli_session session;
    if (!cli_device_open(s->device) || !cli_session_begin(&session, s->bench.threads))
        return CLI_FAILURE;
    session.mesh = s->mesh;
    session.reading = s->reading;
    s->bench.session = &session;
    s->bench.threads = cli_thread_count(s->bench.threads);
    if (s->bench.repetitions == 0) s->bench.repetitions = b->repetitions;
    s->bench.size = s->size.height ? s->size.height : b->size;
    if (s->bench.quality < 0) s->bench.quality = s->quick ? RSV_QUALITY_DRAFT : b->quality;
    if (s->bench.gloss < 0) s->bench.gloss = RSV_GLOSS_REUSED;
    choose_frames(b, s);
    exit_status = run(b, s);
    cli_session_end(&session);
    return exit_status;
}

/// In the order of rsv_frame_gloss.
static const char *const gloss_names[] = { "paths", "reused", NULL };

int cli_bench(int argc, char **argv)
{
    settings s = { .bench = {
                       .quality = -1, .gloss = -1, .environment = CLI_DEFAULT_ENVIRONMENT } };
    cli_bench_task *bench = &s.bench;
    const cli_option options[] = {
        { .name = "--threads", .kind = CLI_COUNT, .value = &bench->threads, .max = 1024 },
        { .name = "--repeat",
            .kind = CLI_COUNT,
            .value = &bench->repetitions,
            .min = 1,
            .max = 1000 },
        { .name = "--size", .kind = CLI_SIDES, .value = &s.size, .min = 1, .max = 8192 },
        { .name = "--frames",
            .kind = CLI_COUNT,
            .value = &bench->frames,
            .min = 1,
            .max = CLI_MOST_FLOWN },
        { .name = "--gloss", .kind = CLI_CHOICE, .value = &bench->gloss, .choices = gloss_names },
        { .name = "--spp",
            .kind = CLI_COUNT,
            .value = &bench->reference_samples,
            .min = 2,
            .max = 1 << 24 },
        { .name = "--quality",
            .kind = CLI_CHOICE,
            .value = &bench->quality,
            .choices = cli_quality_names },
        { .name = "--paths", .kind = CLI_COUNT, .value = &bench->paths, .min = 32, .max = 1 << 24 },
        { .name = "--max-elements",
            .kind = CLI_COUNT,
            .value = &bench->max_elements,
            .min = 1,
            .max = UINT32_MAX },
        { .name = "--max-time",
            .kind = CLI_REAL,
            .value = &bench->max_seconds,
            .min = 1,
            .max = 1e6 },
        { .name = "--reference", .kind = CLI_LIST, .value = &bench->references },
        { .name = "--assets", .kind = CLI_TEXT, .value = &bench->assets },
        { .name = "--cache", .kind = CLI_TEXT, .value = &bench->cache },
        { .name = "--strips", .kind = CLI_TEXT, .value = &bench->strips },
        { .name = "--quick", .kind = CLI_FLAG, .value = &s.quick },
        CLI_MESH_OPTION(&s.mesh),
        CLI_ENVIRONMENT_OPTIONS(&bench->environment),
        CLI_READING_OPTIONS(&s.reading),
        { .name = "--csv", .kind = CLI_TEXT, .value = &s.csv },
        { .name = "--plot", .kind = CLI_TEXT, .value = &s.plot },
        { .name = "--json", .kind = CLI_FLAG, .value = &s.json },
        { .name = "--stats", .kind = CLI_TEXT, .value = &s.stats },
        CLI_DEVICE_OPTION(&s.device),
        { .name = NULL },
    };
    const cli_usage usage = { "bench", help, options, "NAME of a benchmark", 1, 2,
        "--quality --size --threads --repeat --assets --csv --plot --json --device" };
    int exit_status;
    return cli_parse(&usage, argc, argv, s.operand, &exit_status) ? measure_and_report(&s)
                                                                  : exit_status;
}
