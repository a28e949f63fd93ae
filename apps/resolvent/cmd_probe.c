#include "command.h"
#include "moment.h"
#include "options.h"
#include "output_file.h"
#include "photometry.h"
#include "points_csv.h"
#include "stats.h"
#include "subject.h"

#include <math.h>
#include <stdlib.h>

static const char help[] =
    "usage: resolvent probe SCENE --points IN.csv|--grid M -o OUT.csv [options]\n"
    "\n"
    "Reads irradiance (W/m2, linear RGB; lux with --photometric) at points. SCENE is a file, a built-in\n"
    "scene, or a file from `resolvent solve`. Each line of IN.csv is a point and a direction:\n"
    "x,y,z,nx,ny,nz (metres, y up). A header may name the columns in another order, and # starts a\n"
    "comment. OUT.csv repeats these columns and adds r,g,b,err_r,err_g,err_b: irradiance and its standard\n"
    "error. Points cast no shadow. A point on a surface is on the side that its normal points to.\n"
    "\n"
    "  --points FILE      the points\n"
    "  --grid M           instead of --points: points M metres apart on a grid above each floor. They\n"
    "                     face up, and keep 0.3 m away from walls and furniture\n"
    "  --height M         height of the grid above the floor (default 0.8)\n"
    "  -o FILE            the readings\n"
    "  --mode MODE        operator   one gather of rays through the solution (default)\n"
    "                     lookup     the stored solution at the nearest surface point\n"
    "                     reference  path traced; needs no solution\n" CLI_MESH_HELP
        CLI_READING_HELP CLI_MOMENT_HELP CLI_ENVIRONMENT_HELP CLI_FOG_HELP CLI_FOG_HEIGHT_HELP
            CLI_SOLVE_HELP
    "  --goal             refine the surfaces that these points see, directly or through reflected light\n"
    "  --photometric      lux instead of W/m2 (683 lm/W times luminance). OUT.csv holds lux,err_lux; mean,\n"
    "                     minimum and uniformity (EN 12464-1) are printed\n"
    "  --cylindrical      also cylindrical illuminance: the mean of 12 vertical receivers at each point\n"
    "  --samples N        rays or paths per point (default by quality: 4096, 16384, 65536)\n"
    "  --threads N        default: one per core; the readings do not depend on it\n"
    "  --stats FILE.json  what was done, time of each phase, norms and residuals (docs/stats.md)\n"
    "\n"
    "examples:\n"
    "  resolvent probe room.glb --points desk.csv -o desk-light.csv\n"
    "  resolvent probe room.safetensors --points desk.csv -o desk-lux.csv --photometric\n"
    "  resolvent probe room.safetensors --grid 0.5 -o floor-lux.csv --photometric\n"
    "  resolvent probe room.glb --points desk.csv -o judge.csv --mode reference --samples 1000000\n";

static const char *const mode_names[] = { [RSV_PROBE_LOOKUP] = "lookup",
    [RSV_PROBE_OPERATOR] = "operator",
    [RSV_PROBE_REFERENCE] = "reference",
    NULL };

typedef struct settings {
    const char *scene, *points, *output, *stats, *mesh;
    cli_environment environment;
    cli_moment moment;
    cli_reading reading;
    cli_solve_choice solve;
    int mode;
    uint32_t samples; ///< 0 = by quality
    uint32_t threads;
    float grid, height; ///< m; grid: 0 = points from a file
    bool goal, photometric, cylindrical;
} settings;

static bool parse_settings(settings *s, int argc, char **argv, int *exit_status)
{
    const cli_option options[] = {
        { .name = "--points", .kind = CLI_TEXT, .value = &s->points },
        { .name = "--grid", .kind = CLI_REAL, .value = &s->grid, .min = 0.01, .max = 100 },
        { .name = "--height",
            .kind = CLI_REAL,
            .value = &s->height,
            .min = 0.001,
            .max = 100,
            .goes_with = "--grid" },
        { .name = "-o", .kind = CLI_TEXT, .value = &s->output },
        { .name = "--mode", .kind = CLI_CHOICE, .value = &s->mode, .choices = mode_names },
        { .name = "--goal", .kind = CLI_FLAG, .value = &s->goal },
        { .name = "--photometric", .kind = CLI_FLAG, .value = &s->photometric },
        { .name = "--cylindrical",
            .kind = CLI_FLAG,
            .value = &s->cylindrical,
            .goes_with = "--photometric" },
        { .name = "--samples", .kind = CLI_COUNT, .value = &s->samples, .min = 1, .max = 1 << 30 },
        { .name = "--threads", .kind = CLI_COUNT, .value = &s->threads, .max = 1024 },
        CLI_MESH_OPTION(&s->mesh),
        CLI_MOMENT_OPTIONS(&s->moment),
        CLI_SOLVE_OPTIONS(&s->solve),
        CLI_ENVIRONMENT_OPTIONS(&s->environment),
        CLI_READING_OPTIONS(&s->reading),
        CLI_FOG_OPTIONS(&s->environment),
        CLI_FOG_HEIGHT_OPTION(&s->environment),
        { .name = "--stats", .kind = CLI_TEXT, .value = &s->stats },
        { .name = NULL },
    };
    const cli_usage usage = {
        "probe", help, options, "SCENE", 1, 1,
        "--points --grid -o --mode --photometric --samples --quality --env --light-units --luminaire"
    };
    if (!cli_parse(&usage, argc, argv, &s->scene, exit_status)) return false;
    if (!s->output)
        *exit_status = cli_usage_error("probe", "-o OUT.csv is missing");
    else if (!s->points == (s->grid == 0))
        *exit_status = cli_usage_error(
            "probe", s->points ? "--points and --grid exclude each other; leave out one"
                               : "--points IN.csv or --grid M is missing");
    else if (s->goal && s->mode == RSV_PROBE_REFERENCE)
        *exit_status =
            cli_usage_error("probe", "--mode reference solves nothing: leave out --goal");
    else
        return true;
    return false;
}

static rsv_status solve(cli_session *session, const settings *s, const cli_points *points,
    cli_subject *subject, rsv_certificate *certificate)
{
    if (s->mode == RSV_PROBE_REFERENCE) return RSV_OK;
    rsv_solve_desc desc = cli_describe_solve(&s->solve);
    if (s->goal) desc.goal_points = points->probe, desc.goal_point_count = points->count;
    rsv_status status = cli_solve_subject(session, &desc, NULL, subject, certificate);
    if (status != RSV_OK) return status;
    return cli_certify_briefly(s->stats, subject->solution, s->solve.seed, certificate);
}

/// Reads receivers in the mode that was chosen. @param subject solved, unless the mode is reference
static rsv_status read_probes(const settings *s, const cli_subject *subject, const rsv_probe *probe,
    size_t count, rsv_probe_reading *readings)
{
    const rsv_probe_desc desc = {
        .size = sizeof desc, (rsv_probe_mode)s->mode, s->samples, s->solve.seed
    };
    if (s->mode == RSV_PROBE_REFERENCE)
        return rsv_probe_reference(
            subject->scene, probe, count, s->samples, s->solve.seed, readings);
    return rsv_probe_irradiance(subject->solution, &desc, probe, count, readings);
}

static rsv_status read_light(const settings *s, const cli_points *points,
    const cli_subject *subject, rsv_probe_reading *readings, double *time_render)
{
    double started = cli_seconds();
    rsv_status status = read_probes(s, subject, points->probe, points->count, readings);
    *time_render = cli_seconds() - started;
    return status == RSV_OK && cli_interrupted() ? RSV_ERROR_CANCELLED : status;
}

static bool write_stats(const cli_session *session, const settings *s, const rsv_light *solution,
    const rsv_certificate *certificate, double time_render)
{
    cli_stats stats = { .command = "probe",
        .scene = s->scene,
        .mode = mode_names[s->mode],
        .quality = (rsv_quality)s->solve.quality,
        .samples = s->samples,
        .threads = cli_thread_count(s->threads),
        .seed = s->solve.seed,
        .report = solution ? rsv_light_report(solution) : NULL,
        .certificate = solution ? certificate : NULL,
        .order_count = solution ? rsv_light_order_count(solution) : 0,
        .standard_error = NAN,
        .time_render = time_render };
    return cli_write_stats(s->stats, session, &stats);
}

/// Cylindrical illuminances: [points->count], to be freed; NULL = none, or an error in `status`.
static cli_lux *read_cylinders(
    const settings *s, const cli_subject *subject, const cli_points *points, rsv_status *status)
{
    size_t count = points->count * CLI_CYLINDER_SIDES;
    rsv_probe *side = calloc(count, sizeof *side);
    rsv_probe_reading *reading = calloc(count, sizeof *reading);
    cli_lux *mean = calloc(points->count, sizeof *mean);
    bool ready = side && reading && mean;
    *status = ready ? RSV_OK : RSV_ERROR_MEMORY;
    if (ready) {
        cli_cylinder_points(points, side);
        *status = read_probes(s, subject, side, count, reading);
    }
    for (size_t k = 0; *status == RSV_OK && k < points->count; k++)
        mean[k] = cli_cylindrical(reading + k * CLI_CYLINDER_SIDES);
    free(side);
    free(reading);
    if (*status == RSV_OK) return mean;
    free(mean);
    return NULL;
}

static bool write_photometric(cli_session *session, const settings *s, const cli_subject *subject,
    const cli_points *points, const rsv_probe_reading *readings)
{
    rsv_status status = RSV_OK;
    cli_lux *cylindrical = s->cylindrical ? read_cylinders(s, subject, points, &status) : NULL;
    if (status != RSV_OK) cli_report_failure(session, status);
    bool written = status == RSV_OK && cli_write_lux(s->output, points, readings, cylindrical);
    if (written) cli_print_lux(points, readings, cylindrical);
    free(cylindrical);
    return written;
}

static bool write_readings(cli_session *session, const settings *s, const cli_subject *subject,
    const cli_points *points, const rsv_probe_reading *readings)
{
    return s->photometric ? write_photometric(session, s, subject, points, readings)
                          : cli_write_readings(s->output, points, readings);
}

/// The points in the scene: those of the file, or grids. Prints errors.
static bool place_points(
    cli_session *session, const settings *s, const rsv_scene *scene, cli_points *points)
{
    if (s->points) {
        cli_place_points(points, scene);
        return true;
    }
    rsv_status status = cli_lay_grids(scene, (double)s->height, (double)s->grid, points);
    if (status != RSV_OK) cli_report_failure(session, status);
    return status == RSV_OK;
}

static int run(cli_session *session, const settings *s, cli_points *points)
{
    int exit_status = CLI_FAILURE;
    double time_render = 0;
    rsv_certificate certificate;
    cli_subject subject = { 0 };
    rsv_probe_reading *readings = NULL;
    if (!cli_open_subject(session, s->scene, &s->environment, &subject) ||
        !place_points(session, s, subject.scene, points))
        goto cleanup;
    readings = calloc(points->count, sizeof *readings);
    if (!readings) {
        cli_error("out of memory for %zu points", points->count);
        goto cleanup;
    }
    rsv_status status = solve(session, s, points, &subject, &certificate);
    if (status == RSV_OK) status = read_light(s, points, &subject, readings, &time_render);
    if (status != RSV_OK)
        cli_report_failure(session, status);
    else if (write_readings(session, s, &subject, points, readings) &&
             (!s->stats ||
                 write_stats(session, s, s->mode == RSV_PROBE_REFERENCE ? NULL : subject.solution,
                     &certificate, time_render)))
        exit_status = CLI_SUCCESS;

cleanup:
    free(readings);
    cli_close_subject(&subject);
    return exit_status;
}

int cli_probe(int argc, char **argv)
{
    static const uint32_t samples_by_quality[] = { 4096, 16384, 65536 };
    settings s = { .mode = RSV_PROBE_OPERATOR,
        .height = 0.8f,
        .solve = CLI_DEFAULT_SOLVE,
        .environment = CLI_DEFAULT_ENVIRONMENT,
        .moment = CLI_AT_REST };
    int exit_status;
    if (!parse_settings(&s, argc, argv, &exit_status)) return exit_status;
    if (s.samples == 0) s.samples = samples_by_quality[s.solve.quality];
    cli_points points = { 0 };
    cli_session session;
    exit_status = CLI_FAILURE;
    if (cli_check_output(s.output) && (!s.stats || cli_check_output(s.stats)) &&
        cli_check_apart(s.output, s.points) && cli_check_apart(s.stats, s.points) &&
        cli_check_apart(s.stats, s.output) && (!s.points || cli_read_points(s.points, &points)) &&
        cli_prepare_solve(&s.solve) && cli_session_begin(&session, s.threads)) {
        session.mesh = s.mesh;
        session.moment = s.moment;
        session.reading = s.reading;
        session.max_bytes = s.solve.max_bytes;
        exit_status = run(&session, &s, &points);
        cli_session_end(&session);
    }
    cli_free_points(&points);
    return exit_status;
}
