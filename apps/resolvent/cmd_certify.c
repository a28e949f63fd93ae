#include "command.h"
#include "error_target.h"
#include "moment.h"
#include "options.h"
#include "output_file.h"
#include "points_csv.h"
#include "stats.h"
#include "subject.h"

#include <math.h>
#include <stdio.h>

static const char help[] =
    "usage: resolvent certify SCENE [options]\n"
    "\n"
    "Solves SCENE (a file or a built-in scene) and measures how accurate the solution is. A file from\n"
    "`resolvent solve` is not solved again. At random points on the surfaces, `certify` compares the\n"
    "irradiance of the solution with the irradiance that new rays gather there. Prints root mean squares\n"
    "over the surfaces, of luminance, in W/m2 and as a percentage of the irradiance:\n"
    "\n"
    "  irradiance  of the solution\n"
    "  residual    difference between the solution and the new rays, with a 95 % interval\n"
    "  bound       with 95 % confidence, the error is not larger than this\n"
    "  estimate    the probable error, with a 95 % interval\n"
    "\n"
    "  --samples N        points, 16 to 16777216 (default 2048)\n"
    "  --rays N           gather rays for each of two estimates per point (default 512)\n" CLI_MESH_HELP
        CLI_READING_HELP CLI_MOMENT_HELP CLI_ENVIRONMENT_HELP CLI_FOG_HELP CLI_SOLVE_HELP
            CLI_ERROR_TARGET_HELP
    "  --threads N        default: one per core; the figures do not depend on it\n"
    "  --stats FILE.json  what was done, time of each phase, and the certificate (docs/stats.md)\n"
    "  --heatmap FILE     a picture of the error (.png; .exr also holds the numbers), from 0.1 % of the\n"
    "                     irradiance (black) to 100 % (white), with ticks at 1 % and 10 %\n"
    "  --split            split the error into solver, noise of rays and size of elements; solves once\n"
    "                     more\n"
    "  --goal             refine what the camera sees, and certify the mean luminance of its picture too\n"
    "  --points FILE.csv  refine for the mean irradiance at these points (x,y,z,nx,ny,nz, as for\n"
    "                     `resolvent probe`), and certify that too\n"
    "  --camera NAME      camera of the picture, as listed by `resolvent info SCENE` (default: the first)\n"
    "  --size WxH         its size (default 256x256)\n"
    "\n"
    "examples:\n"
    "  resolvent certify room.safetensors\n"
    "  resolvent certify room.glb --quality draft --error 2%\n"
    "  resolvent certify cornell-blocks --quality draft --heatmap error.png\n"
    "  resolvent certify room.glb --quality high --samples 20000 --stats room.json\n";

typedef struct settings {
    const char *scene, *stats, *mesh, *heat_map, *camera, *points;
    cli_points sensors; ///< of --points
    cli_size size;
    cli_error_target target;
    cli_environment environment;
    cli_moment moment;
    cli_reading reading;
    cli_solve_choice solve;
    rsv_certify_desc certify;
    uint32_t threads;
    bool goal, split;
} settings;

/// Results of a run.
typedef struct findings {
    rsv_certificate certificate;
    rsv_goal_certificate goal;
    rsv_error_split split;
} findings;

static bool parse_settings(settings *s, int argc, char **argv, int *exit_status)
{
    const cli_option options[] = {
        { .name = "--samples",
            .kind = CLI_COUNT,
            .value = &s->certify.samples,
            .min = 16,
            .max = 1 << 24 },
        { .name = "--rays",
            .kind = CLI_COUNT,
            .value = &s->certify.gather_rays,
            .min = 1,
            .max = 1 << 16 },
        { .name = "--threads", .kind = CLI_COUNT, .value = &s->threads, .max = 1024 },
        CLI_MESH_OPTION(&s->mesh),
        CLI_MOMENT_OPTIONS(&s->moment),
        CLI_SOLVE_OPTIONS(&s->solve),
        CLI_ENVIRONMENT_OPTIONS(&s->environment),
        CLI_READING_OPTIONS(&s->reading),
        CLI_FOG_OPTIONS(&s->environment),
        CLI_ERROR_TARGET_OPTIONS(&s->target),
        { .name = "--stats", .kind = CLI_TEXT, .value = &s->stats },
        { .name = "--heatmap", .kind = CLI_TEXT, .value = &s->heat_map },
        { .name = "--goal", .kind = CLI_FLAG, .value = &s->goal },
        { .name = "--points", .kind = CLI_TEXT, .value = &s->points },
        { .name = "--split", .kind = CLI_FLAG, .value = &s->split },
        { .name = "--camera", .kind = CLI_TEXT, .value = &s->camera },
        { .name = "--size",
            .kind = CLI_SIZE,
            .value = &s->size,
            .min = 32,
            .max = 16384,
            .goes_with = "--heatmap" },
        { .name = NULL },
    };
    const cli_usage usage = { "certify", help, options, "SCENE", 1, 1,
        "--heatmap --split --error --max-time --quality --samples --goal --stats --env" };
    if (!cli_parse(&usage, argc, argv, &s->scene, exit_status)) return false;
    if (!s->goal || !s->points) return true;
    *exit_status =
        cli_usage_error("certify", "--goal and --points exclude each other; leave out one");
    return false;
}

/// Computes the certificate and, if wanted, the picture of the error.
static rsv_status certify(
    const settings *s, const rsv_light *solution, rsv_certificate *certificate)
{
    rsv_certify_desc desc = s->certify;
    desc.seed = s->solve.seed;
    if (!s->heat_map) return rsv_certify(solution, &desc, certificate);
    rsv_image *image = NULL;
    rsv_heat_map_desc map = rsv_default_heat_map_desc();
    map.camera = rsv_scene_find_camera(rsv_light_scene(solution), s->camera);
    if (s->size.width) map.width = s->size.width, map.height = s->size.height;
    rsv_status status = rsv_certify_picture(solution, &desc, &map, certificate, &image);
    if (status == RSV_OK) status = rsv_image_write(image, s->heat_map, 0);
    rsv_image_destroy(image);
    return status;
}

static rsv_status certify_goal(
    const settings *s, const rsv_light *solution, uint32_t camera, rsv_goal_certificate *goal)
{
    rsv_certify_desc desc = s->certify;
    desc.seed = s->solve.seed;
    if (s->points)
        return rsv_certify_points(solution, &desc, s->sensors.probe, s->sensors.count, goal);
    return s->goal ? rsv_certify_goal(solution, &desc, camera, goal) : RSV_OK;
}

static rsv_status solve_and_certify(
    cli_session *session, const settings *s, cli_subject *subject, findings *found)
{
    rsv_solve_desc desc = cli_describe_solve(&s->solve);
    uint32_t camera = rsv_scene_find_camera(subject->scene, s->camera);
    if (s->goal) desc.goal_camera = camera;
    cli_place_points(&s->sensors, subject->scene);
    desc.goal_points = s->sensors.probe;
    desc.goal_point_count = s->sensors.count;
    rsv_status status = cli_solve_subject(session, &desc, &s->target, subject, &found->certificate);
    if (status == RSV_OK) status = certify(s, subject->solution, &found->certificate);
    if (status == RSV_OK) status = certify_goal(s, subject->solution, camera, &found->goal);
    if (status == RSV_OK && s->split)
        status = rsv_split_error(subject->solution, &found->certificate, &found->split);
    return status;
}

/// A value, relative to the irradiance; and an interval where there is one.
static void print_row(
    const rsv_certificate *c, const char *name, double value, const double interval[2])
{
    double percent = c->irradiance_rms > 0 ? 100 / c->irradiance_rms : 0;
    printf("%-11s %11.4g W/m2", name, value);
    if (value != c->irradiance_rms) printf(" %9.3f %%", percent * value);
    if (interval)
        printf("   (95 %%: %.3f .. %.3f %%)", percent * interval[0], percent * interval[1]);
    putchar('\n');
}

static void print_certificate(const rsv_certificate *c)
{
    printf("%u points on surfaces with an albedo of up to %.3f\n", c->samples, c->max_albedo);
    print_row(c, "irradiance", c->irradiance_rms, NULL);
    print_row(c, "residual", c->residual_rms, c->residual_ci95);
    print_row(c, "bound", c->error_bound_rms, NULL);
    print_row(c, "estimate", c->error_estimate_rms, c->error_estimate_ci95);
}

static void print_split(const rsv_certificate *c, const rsv_error_split *split)
{
    print_row(c, "truncation", split->truncation, NULL);
    print_row(c, "sampling", split->sampling, NULL);
    print_row(c, "elements", split->discretisation, NULL);
}

static void print_goal(const char *name, const char *unit, const rsv_goal_certificate *g)
{
    double percent = g->reading > 0 ? 100 / g->reading : 0;
    printf("%-11s %11.4g %s, %.3f %% missing   (95 %%: %.3f .. %.3f %%)\n", name, g->reading, unit,
        percent * g->error, percent * g->error_ci95[0], percent * g->error_ci95[1]);
}

static bool write_stats(
    const cli_session *session, const settings *s, const rsv_light *solution, const findings *found)
{
    cli_stats stats = { .command = "certify",
        .scene = s->scene,
        .mode = "operator",
        .quality = (rsv_quality)s->solve.quality,
        .samples = s->certify.samples,
        .threads = cli_thread_count(s->threads),
        .seed = s->solve.seed,
        .report = rsv_light_report(solution),
        .certificate = &found->certificate,
        .goal = s->goal || s->points ? &found->goal : NULL,
        .split = s->split ? &found->split : NULL,
        .order_count = rsv_light_order_count(solution),
        .standard_error = NAN };
    return cli_write_stats(s->stats, session, &stats);
}

static int run(cli_session *session, const settings *s)
{
    int exit_status = CLI_FAILURE;
    findings found;
    cli_subject subject;
    if (!cli_open_subject(session, s->scene, &s->environment, &subject)) return CLI_FAILURE;
    if (rsv_scene_find_camera(subject.scene, s->camera) == RSV_NONE) {
        cli_error("--camera: %s has no camera '%s'; `resolvent info %s` lists them", s->scene,
            s->camera ? s->camera : "", s->scene);
        cli_close_subject(&subject);
        return CLI_FAILURE;
    }
    rsv_status status = solve_and_certify(session, s, &subject, &found);
    if (status == RSV_OK && cli_interrupted()) status = RSV_ERROR_CANCELLED;
    if (status != RSV_OK) {
        cli_report_failure(session, status);
    } else {
        cli_progress_clear(&session->progress);
        print_certificate(&found.certificate);
        if (s->split) print_split(&found.certificate, &found.split);
        if (s->goal) print_goal("picture", "W/(sr m2)", &found.goal);
        if (s->points) print_goal("points", "W/m2", &found.goal);
        if (!s->stats || write_stats(session, s, subject.solution, &found))
            exit_status = CLI_SUCCESS;
    }
    cli_close_subject(&subject);
    return exit_status;
}

static bool check_files(settings *s)
{
    if (s->points && !cli_read_points(s->points, &s->sensors)) return false;
    if (!cli_check_apart(s->stats, s->points)) return false;
    if (s->heat_map && rsv_image_check_output(s->heat_map) != RSV_OK) {
        cli_error("%s", rsv_last_error());
        return false;
    }
    return !s->stats || cli_check_output(s->stats);
}

int cli_certify(int argc, char **argv)
{
    settings s = { .solve = CLI_DEFAULT_SOLVE,
        .certify = rsv_default_certify_desc(),
        .environment = CLI_DEFAULT_ENVIRONMENT,
        .moment = CLI_AT_REST };
    int exit_status;
    if (!parse_settings(&s, argc, argv, &exit_status)) return exit_status;
    cli_session session;
    exit_status = CLI_FAILURE;
    if (check_files(&s) && cli_prepare_solve(&s.solve) && cli_session_begin(&session, s.threads)) {
        session.mesh = s.mesh;
        session.moment = s.moment;
        session.reading = s.reading;
        session.max_bytes = s.solve.max_bytes;
        exit_status = run(&session, &s);
        cli_session_end(&session);
    }
    cli_free_points(&s.sensors);
    return exit_status;
}
