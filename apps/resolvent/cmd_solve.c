#include "checkpoint.h"
#include "command.h"
#include "device.h"
#include "moment.h"
#include "options.h"
#include "output_file.h"
#include "points_csv.h"
#include "stats.h"
#include "subject.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const char help[] =
    "usage: resolvent solve SCENE -o FILE.safetensors [options]\n"
    "\n"
    "Solves the light of SCENE (a file or a built-in scene) and saves it. The file holds the scene, the\n"
    "operator and the solution. `render`, `probe`, `relight`, `bake`, `view`, `certify` and `info` accept\n"
    "it in place of a scene, and NumPy can read it (docs/operator-files.md).\n"
    "\n"
    "  -o FILE.safetensors  the operator file\n" CLI_MESH_HELP CLI_READING_HELP CLI_MOMENT_HELP
        CLI_ENVIRONMENT_HELP CLI_FOG_HELP CLI_SOLVE_HELP CLI_ERROR_TARGET_HELP
    "  --goal             refine the surfaces that the camera sees, directly or through reflected light\n"
    "  --camera NAME      with --goal: a camera listed by `resolvent info SCENE` (default: the first)\n"
    "  --points FILE.csv  refine for the irradiance at these points instead (x,y,z,nx,ny,nz, as for\n"
    "                     `resolvent probe`)\n" CLI_CHECKPOINT_HELP
    "  --no-document      leave out the glTF file of SCENE, which `bake` needs\n"
    "  --eigenvalues N    print the N largest eigenvalues of the operator, computed by SLEPc\n"
    "  --threads N        default: one per core; the file does not depend on it\n" CLI_DEVICE_HELP
    "  --stats FILE.json  what was done, time of each phase, norms and residuals (docs/stats.md)\n"
    "\n"
    "examples:\n"
    "  resolvent solve room.glb -o room.safetensors --quality high\n"
    "  resolvent render room.safetensors -o room.png\n"
    "  resolvent relight room.safetensors --light lamp=0.5 -o dim.png\n";

enum { MOST_EIGENVALUES = 256 };

typedef struct settings {
    const char *scene, *output, *stats, *mesh, *camera, *points;
    bool goal, no_document;
    cli_points sensors; ///< of --points
    cli_environment environment;
    cli_moment moment;
    cli_reading reading;
    cli_error_target target;
    cli_solve_choice solve;
    cli_checkpoint checkpoint;
    uint32_t eigenvalues;
    uint32_t threads;
    int device;
} settings;

static bool parse_settings(settings *s, int argc, char **argv, int *exit_status)
{
    const cli_option options[] = {
        { .name = "-o", .kind = CLI_TEXT, .value = &s->output },
        CLI_CHECKPOINT_OPTIONS(&s->checkpoint),
        { .name = "--eigenvalues",
            .kind = CLI_COUNT,
            .value = &s->eigenvalues,
            .max = MOST_EIGENVALUES },
        { .name = "--threads", .kind = CLI_COUNT, .value = &s->threads, .max = 1024 },
        CLI_DEVICE_OPTION(&s->device),
        CLI_MESH_OPTION(&s->mesh),
        CLI_MOMENT_OPTIONS(&s->moment),
        CLI_SOLVE_OPTIONS(&s->solve),
        CLI_ENVIRONMENT_OPTIONS(&s->environment),
        CLI_READING_OPTIONS(&s->reading),
        CLI_FOG_OPTIONS(&s->environment),
        CLI_ERROR_TARGET_OPTIONS(&s->target),
        { .name = "--stats", .kind = CLI_TEXT, .value = &s->stats },
        { .name = "--goal", .kind = CLI_FLAG, .value = &s->goal },
        { .name = "--no-document", .kind = CLI_FLAG, .value = &s->no_document },
        { .name = "--camera", .kind = CLI_TEXT, .value = &s->camera, .goes_with = "--goal" },
        { .name = "--points", .kind = CLI_TEXT, .value = &s->points },
        { .name = NULL },
    };
    const cli_usage usage = {
        "solve", help, options, "SCENE", 1, 1,
        "-o --quality --error --max-time --env --light-units --checkpoint --max-memory --goal --stats"
    };
    if (!cli_parse(&usage, argc, argv, &s->scene, exit_status)) return false;
    if (s->goal && s->points) {
        *exit_status =
            cli_usage_error("solve", "--goal and --points exclude each other; leave out one");
        return false;
    }
    if (s->output && cli_ends_in(s->output, ".safetensors")) return true;
    *exit_status = s->output
                       ? cli_usage_error("solve", "-o '%s' does not end in .safetensors", s->output)
                       : cli_usage_error("solve", "-o FILE.safetensors is missing");
    return false;
}

static bool write_stats(const cli_session *session, const settings *s, const rsv_light *solution)
{
    cli_stats stats = { .command = "solve",
        .scene = s->scene,
        .mode = "solve",
        .quality = (rsv_quality)s->solve.quality,
        .threads = cli_thread_count(s->threads),
        .seed = s->solve.seed,
        .report = rsv_light_report(solution),
        .order_count = rsv_light_order_count(solution),
        .standard_error = NAN };
    return cli_write_stats(s->stats, session, &stats);
}

static rsv_status print_eigenvalues(const settings *s, const rsv_light *solution)
{
    double value[2 * MOST_EIGENVALUES];
    size_t count = s->eigenvalues;
    if (count == 0) return RSV_OK;
    rsv_status status = rsv_leading_eigenvalues(solution, &count, value);
    for (size_t k = 0; status == RSV_OK && k < count; k++)
        printf("eigenvalue %zu: %.6f%+.6fi\n", k + 1, value[2 * k], value[2 * k + 1]);
    return status;
}

static bool choose_goal(const settings *s, const rsv_scene *scene, rsv_solve_desc *desc)
{
    cli_place_points(&s->sensors, scene);
    desc->goal_points = s->sensors.probe;
    desc->goal_point_count = s->sensors.count;
    if (!s->goal) return true;
    desc->goal_camera = rsv_scene_find_camera(scene, s->camera);
    if (desc->goal_camera == RSV_NONE)
        cli_error("--camera: %s has no camera '%s'; `resolvent info %s` lists them", s->scene,
            s->camera ? s->camera : "", s->scene);
    return desc->goal_camera != RSV_NONE;
}

static int run(cli_session *session, settings *s)
{
    int exit_status = CLI_FAILURE;
    cli_subject subject = { .scene = cli_open_scene(session, s->scene, &s->environment) };
    if (!subject.scene) return CLI_FAILURE;
    rsv_solve_desc desc = cli_describe_solve(&s->solve);
    rsv_certificate certificate;
    if (!choose_goal(s, subject.scene, &desc) ||
        !cli_checkpoint_prepare(session, &s->checkpoint, subject.scene, &desc))
        goto cleanup;
    rsv_status status = cli_solve_subject(session, &desc, &s->target, &subject, &certificate);
    if (status == RSV_OK) status = print_eigenvalues(s, subject.solution);
    if (status == RSV_OK) status = rsv_light_save(subject.solution, s->scene, s->output);
    if (status == RSV_OK) cli_checkpoint_prune(&s->checkpoint);
    if (status != RSV_OK)
        cli_report_failure(session, status);
    else if (!s->stats || write_stats(session, s, subject.solution))
        exit_status = CLI_SUCCESS;
cleanup:
    cli_close_subject(&subject);
    return exit_status;
}

int cli_solve(int argc, char **argv)
{
    settings s = {
        .solve = CLI_DEFAULT_SOLVE, .environment = CLI_DEFAULT_ENVIRONMENT, .moment = CLI_AT_REST
    };
    int exit_status;
    if (!parse_settings(&s, argc, argv, &exit_status)) return exit_status;
    if (!cli_check_output(s.output) || (s.stats && !cli_check_output(s.stats)) ||
        !cli_check_apart(s.output, s.scene) || !cli_check_apart(s.stats, s.output) ||
        !cli_check_apart(s.output, s.points) || !cli_check_apart(s.stats, s.points) ||
        (s.points && !cli_read_points(s.points, &s.sensors)))
        return CLI_FAILURE;
    cli_session session;
    if (s.eigenvalues && !s.solve.petsc) s.solve.petsc = "";
    if (!cli_prepare_solve(&s.solve) || !cli_device_open(s.device) ||
        !cli_session_begin(&session, s.threads))
        return CLI_FAILURE;
    session.mesh = s.mesh;
    session.moment = s.moment;
    session.reading = s.reading;
    session.max_bytes = s.solve.max_bytes;
    session.keep_document = !s.no_document;
    exit_status = run(&session, &s);
    cli_session_end(&session);
    cli_free_points(&s.sensors);
    return exit_status;
}
