#include "command.h"
#include "daylight_page.h"
#include "options.h"
#include "output_file.h"
#include "subject.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const char help[] =
    "usage: resolvent daylight SCENE --weather FILE.epw -o REPORT.{html,json,csv} [options]\n"
    "\n"
    "Daylight at sensors over a year of weather: mean illuminance, daylight autonomy, useful daylight,\n"
    "sDA, ASE, daylight factors and EN 17037, each with its standard error. Metres, y up; the lights of\n"
    "the scene are off. See docs/daylight.md.\n"
    "\n"
    "  --weather FILE     weather file of EnergyPlus (.epw) or Daysim (.wea). May be repeated: each file\n"
    "                     then has its own -o options, in the same order, and adds about a second\n"
    "  -o FILE            the report: a self-contained page (.html), .json or .csv; repeat it for more\n"
    "                     formats\n"
    "  --points FILE      sensors, one per line: x,y,z,nx,ny,nz (default: grids above the floors)\n"
    "  --height M         height of these grids above the floor (default 0.8)\n"
    "  --spacing M        spacing of these grids (default 0.5)\n"
    "  --north DEG        direction of north, degrees clockwise from -z, seen from above (default 0)\n"
    "  --ground ALBEDO    albedo of the ground outside the scene (default 0.2)\n"
    "  --sky-only         leave out the sun's direct light; it still lights the ground outside\n"
    "  --shaded SCENE     the same scene with its shades down, used in each room while --shade-lux\n"
    "                     (default 1000) or more of direct sun reach more than --shade-share\n"
    "                     (default 2 %) of the room's sensors, as in IES LM-83\n"
    "  --openings KIND    vertical or horizontal: which values of EN 17037 apply to all rooms (default\n"
    "                     auto: horizontal where a room sees the sky through horizontal panes only)\n"
    "  --from H, --to H   occupied hours, standard time (default 8 to 18)\n"
    "  --hourly FILE      a row per record of the weather file, a column per sensor, in lux\n" CLI_MESH_HELP
        CLI_READING_HELP CLI_SOLVE_HELP
    "  --samples N        rays per sensor (default by quality: 15360, 61440, 245760)\n"
    "  --threads N        default: one per core; the figures do not depend on it\n"
    "\n"
    "examples:\n"
    "  resolvent daylight office.glb --weather chicago.epw -o office.html\n"
    "  resolvent daylight office.glb --weather chicago.epw --points desks.csv --north 30 \\\n"
    "      --hourly desks-hours.csv -o desks.json\n"
    "  resolvent daylight office.glb --weather chicago.epw --shaded office-shaded.glb -o office.html\n";

typedef struct settings {
    const char *scene, *shaded, *points, *mesh;
    cli_reading reading;
    cli_list weather, outputs, hourly; ///< the latter as many as the first, or none
    cli_solve_choice solve;
    float north, ground, height, spacing, from, to, shade_lux, shade_share;
    uint32_t samples, threads;
    bool sky_only;
    int openings; ///< index of opening_names
} settings;

static const char *const opening_names[] = { "auto", "vertical", "horizontal", NULL };

/// Reports of each weather file: one or, in other formats, more. 0 = they do not come out even
static size_t reports_per_weather(const settings *s)
{
    return s->outputs.count % s->weather.count == 0 ? s->outputs.count / s->weather.count : 0;
}

/// Checks that there are as many reports as weather files, and that their extensions are known. @return the exit status
static int check_lists(const settings *s)
{
    if (!s->weather.count || !s->outputs.count)
        return cli_usage_error(
            "daylight", "%s is missing", s->weather.count ? "-o FILE" : "--weather FILE");
    if (reports_per_weather(s) == 0 || (s->hourly.count && s->hourly.count != s->weather.count))
        return cli_usage_error("daylight",
            "give each --weather the same number of -o and, with --hourly, one --hourly");
    for (size_t k = 0; k < s->outputs.count; k++) {
        const char *name = s->outputs.item[k];
        if (!cli_ends_in(name, ".html") && !cli_ends_in(name, ".json") &&
            !cli_ends_in(name, ".csv"))
            return cli_usage_error("daylight", "-o %s: reports are .html, .json or .csv", name);
    }
    return CLI_SUCCESS;
}

static bool parse_settings(settings *s, int argc, char **argv, int *exit_status)
{
    const cli_option options[] = {
        { .name = "--weather", .kind = CLI_LIST, .value = &s->weather },
        { .name = "--points", .kind = CLI_TEXT, .value = &s->points },
        { .name = "-o", .kind = CLI_LIST, .value = &s->outputs },
        { .name = "--hourly", .kind = CLI_LIST, .value = &s->hourly },
        { .name = "--height", .kind = CLI_REAL, .value = &s->height, .min = 0.001, .max = 100 },
        { .name = "--spacing", .kind = CLI_REAL, .value = &s->spacing, .min = 0.01, .max = 100 },
        { .name = "--north", .kind = CLI_REAL, .value = &s->north, .min = -360, .max = 360 },
        { .name = "--ground", .kind = CLI_REAL, .value = &s->ground, .min = 0, .max = 1 },
        { .name = "--sky-only", .kind = CLI_FLAG, .value = &s->sky_only },
        { .name = "--shaded", .kind = CLI_TEXT, .value = &s->shaded },
        { .name = "--shade-lux",
            .kind = CLI_REAL,
            .value = &s->shade_lux,
            .min = 1,
            .max = 1e6,
            .goes_with = "--shaded" },
        { .name = "--shade-share",
            .kind = CLI_SHARE,
            .value = &s->shade_share,
            .max = 1,
            .goes_with = "--shaded" },
        { .name = "--openings",
            .kind = CLI_CHOICE,
            .value = &s->openings,
            .choices = opening_names },
        { .name = "--from", .kind = CLI_REAL, .value = &s->from, .min = 0, .max = 24 },
        { .name = "--to", .kind = CLI_REAL, .value = &s->to, .min = 0, .max = 24 },
        { .name = "--samples", .kind = CLI_COUNT, .value = &s->samples, .min = 1, .max = 1 << 30 },
        { .name = "--threads", .kind = CLI_COUNT, .value = &s->threads, .max = 1024 },
        CLI_MESH_OPTION(&s->mesh),
        CLI_READING_OPTIONS(&s->reading),
        CLI_SOLVE_OPTIONS(&s->solve),
        { .name = NULL },
    };
    const cli_usage usage = { "daylight", help, options, "SCENE", 1, 1,
        "--weather -o --points --height --spacing --north --from --shaded --hourly --quality" };
    if (!cli_parse(&usage, argc, argv, &s->scene, exit_status)) return false;
    *exit_status = check_lists(s);
    if (*exit_status == CLI_SUCCESS && s->from >= s->to)
        *exit_status = cli_usage_error("daylight", "--from must be before --to");
    return *exit_status == CLI_SUCCESS;
}

/// Input of a run.
typedef struct daylight_job {
    cli_session *session;
    const settings *s;
    rsv_scene *scene[2]; ///< as it is, and with its shades down; NULL = there are none
    cli_points points;
    rsv_weather weather[CLI_LIST_CAPACITY];
    rsv_daylight_desc desc;
    rsv_daylight_run_desc run;
    rsv_light *light[2];
    rsv_daylight *daylight[2];
    rsv_daylight_report report;
    uint32_t *room; ///< [points.count]
    bool *rooflit;  ///< [run.room_count]
} daylight_job;

/// @param state 0 = shades up, 1 = down
static rsv_status solve_state(daylight_job *job, int state)
{
    rsv_solve_desc desc = cli_describe_solve(&job->s->solve);
    desc.goal_points = job->points.probe;
    desc.goal_point_count = job->points.count;
    desc.photon_count = 0; // photons come only from lamps, which are off
    desc.direct_level = false;
    rsv_status status = rsv_daylight_surround(job->scene[state], &job->weather[0], &job->desc);
    if (status == RSV_OK) status = rsv_light_create(job->scene[state], &desc, &job->light[state]);
    if (status == RSV_OK)
        status = rsv_daylight_create(job->light[state], job->points.probe, job->points.count,
            &job->desc, &job->daylight[state]);
    return status;
}

static rsv_status solve(daylight_job *job)
{
    rsv_status status = solve_state(job, 0);
    if (status != RSV_OK || !job->scene[1]) return status;
    status = solve_state(job, 1);
    job->run.shaded = job->daylight[1];
    return status;
}

static size_t count_buried(const daylight_job *job)
{
    size_t count = 0;
    for (size_t k = 0; k < job->points.count; k++)
        count += rsv_daylight_is_buried(job->daylight[0], k);
    if (count) {
        char text[128];
        snprintf(text, sizeof text,
            "%zu of %zu sensors mostly see backs of walls: they are inside something", count,
            job->points.count);
        cli_warn(job->session, text);
    }
    return count;
}

static bool write_report(const char *path, const cli_daylight_result *result)
{
    return cli_ends_in(path, ".html")   ? cli_write_daylight_page(path, result)
           : cli_ends_in(path, ".json") ? cli_write_daylight_json(path, result)
                                        : cli_write_daylight_csv(path, result);
}

/// @param k of the weather files
static bool write_reports(const daylight_job *job, size_t k, size_t buried)
{
    const settings *s = job->s;
    cli_daylight_result result = { s->scene, s->weather.item[k], &job->points, &job->weather[k],
        &job->desc, &job->run, &job->report, job->run.hourly, buried, job->rooflit };
    size_t count = reports_per_weather(s);
    for (size_t r = k * count; r < (k + 1) * count; r++)
        if (!write_report(s->outputs.item[r], &result)) return false;
    return !s->hourly.count || cli_write_daylight_hours(s->hourly.item[k], &result);
}

static void print_rooms(const daylight_job *job)
{
    const double *shaded = job->report.room_shaded_hours;
    printf("room sensors  mean lux  sDA %%  ASE %%  DF %%  %sEN 17037\n",
        shaded ? "shades down, h  " : " ");
    for (size_t r = 0; r < job->run.room_count; r++) {
        const rsv_figure *room = job->report.room[r];
        size_t count = 0;
        for (size_t k = 0; k < job->points.count; k++)
            count += job->room[k] == r;
        printf("%4zu %7zu %9.4g %6.1f %6.1f %6.2f  ", r, count, room[RSV_SPACE_MEAN].value,
            100 * room[RSV_SPACE_SDA].value, 100 * room[RSV_SPACE_ASE].value,
            100 * room[RSV_SPACE_DAYLIGHT_FACTOR].value);
        if (shaded) printf("%14.6g  ", shaded[r]);
        printf("%s%s\n", cli_daylight_class_name(room, job->rooflit[r]),
            job->rooflit[r] ? " (rooflights)" : "");
    }
}

static void print_space(const daylight_job *job)
{
    for (int f = 0; f < RSV_SPACE_FIGURES; f++) {
        rsv_figure_facts facts = rsv_space_figure_facts((rsv_space_figure)f);
        rsv_figure figure = job->report.space[f];
        bool share = facts.unit[0] == '1';
        printf("%-42s %8.4g +- %-8.2g %s\n", facts.title, (share ? 100 : 1) * figure.value,
            (share ? 100 : 1) * figure.standard_error, share ? "%" : facts.unit);
    }
    if (job->run.shaded)
        printf("%-42s %8.4g             h\n",
            job->run.room_count > 1 ? "shades down, mean of the sensors" : "shades down",
            job->report.shaded_hours);
    bool rooflit = cli_daylight_is_rooflit(job->rooflit, job->run.room_count);
    printf("%-42s %s%s\n", "EN 17037, daylight provision",
        cli_daylight_class_name(job->report.space, rooflit), rooflit ? " (rooflights)" : "");
    if (job->run.room_count > 1) print_rooms(job);
}

static void close_job(daylight_job *job)
{
    for (int state = 0; state < 2; state++) {
        rsv_daylight_destroy(job->daylight[state]);
        rsv_light_destroy(job->light[state]);
    }
    for (size_t k = 0; k < job->s->weather.count; k++)
        rsv_weather_free(job->session->context, &job->weather[k]);
    cli_free_points(&job->points);
    free(job->room);
    free(job->rooflit);
    rsv_scene_destroy(job->scene[0]);
    rsv_scene_destroy(job->scene[1]);
}

/// Told from the panes, or as the user says.
static rsv_status find_openings(daylight_job *job)
{
    size_t rooms = job->run.room_count;
    job->rooflit = calloc(rooms, sizeof *job->rooflit);
    if (!job->rooflit) return RSV_ERROR_MEMORY;
    if (job->s->openings == 0)
        return rsv_daylight_rooflit(
            job->scene[0], job->points.probe, job->points.count, job->room, rooms, job->rooflit);
    for (size_t r = 0; r < rooms; r++)
        job->rooflit[r] = job->s->openings == 2;
    return RSV_OK;
}

static rsv_status find_rooms(daylight_job *job)
{
    job->room = calloc(job->points.count, sizeof *job->room);
    if (!job->room) return RSV_ERROR_MEMORY;
    job->run.room = job->room;
    rsv_status status = rsv_daylight_rooms(
        job->scene[0], job->points.probe, job->points.count, job->room, &job->run.room_count);
    return status == RSV_OK ? find_openings(job) : status;
}

static rsv_status find_sensors(daylight_job *job)
{
    rsv_status status = RSV_OK;
    if (job->s->points)
        cli_place_points(&job->points, job->scene[0]);
    else
        status = cli_lay_grids(
            job->scene[0], (double)job->s->height, (double)job->s->spacing, &job->points);
    return status == RSV_OK ? find_rooms(job) : status;
}

/// Room for the hours, where a report shows them.
static bool keep_hours(daylight_job *job, size_t k)
{
    size_t count = reports_per_weather(job->s);
    bool wanted = job->s->hourly.count > 0;
    for (size_t r = k * count; r < (k + 1) * count; r++)
        wanted = wanted || cli_ends_in(job->s->outputs.item[r], ".html");
    if (!wanted) return true;
    job->run.hourly = calloc(job->weather[k].count * job->points.count, sizeof *job->run.hourly);
    if (!job->run.hourly)
        cli_error(
            "out of memory for %zu hours of %zu sensors", job->weather[k].count, job->points.count);
    return job->run.hourly;
}

/// The coefficients times one weather file.
static bool run_weather(daylight_job *job, size_t k, size_t buried)
{
    if (!keep_hours(job, k)) return false;
    rsv_status status =
        rsv_daylight_run(job->daylight[0], &job->weather[k], &job->run, &job->report);
    bool done = status == RSV_OK && write_reports(job, k, buried);
    if (status != RSV_OK) cli_report_failure(job->session, status);
    if (done && job->s->weather.count > 1) printf("%s\n", job->s->weather.item[k]);
    if (done) print_space(job);
    rsv_daylight_report_free(job->daylight[0], &job->report);
    free(job->run.hourly);
    job->run.hourly = NULL;
    return done;
}

static int run(daylight_job *job)
{
    const settings *s = job->s;
    rsv_status status = RSV_OK;
    if (s->points && !cli_read_points(s->points, &job->points)) return CLI_FAILURE;
    for (size_t k = 0; status == RSV_OK && k < s->weather.count; k++)
        status = rsv_weather_read(job->session->context, s->weather.item[k], &job->weather[k]);
    if (status != RSV_OK) return cli_report_failure(job->session, status);
    job->scene[0] = cli_open_scene(job->session, s->scene, NULL);
    if (s->shaded) job->scene[1] = cli_open_scene(job->session, s->shaded, NULL);
    if (!job->scene[0] || (s->shaded && !job->scene[1])) return CLI_FAILURE;
    status = find_sensors(job);
    if (status == RSV_OK) status = solve(job);
    if (status != RSV_OK) return cli_report_failure(job->session, status);
    size_t buried = count_buried(job);
    for (size_t k = 0; k < s->weather.count; k++)
        if (!run_weather(job, k, buried)) return CLI_FAILURE;
    return CLI_SUCCESS;
}

static void describe(const settings *s, daylight_job *job)
{
    job->desc = rsv_default_daylight_desc((rsv_quality)s->solve.quality);
    job->desc.north = isnan(s->north) ? 0 : (double)s->north;
    job->desc.ground_albedo = s->ground;
    job->desc.seed = s->solve.seed;
    if (s->samples) job->desc.sensor_rays = s->samples;
    job->run = rsv_default_daylight_run_desc();
    job->run.sky_only = s->sky_only;
    job->run.from = (double)s->from;
    job->run.to = (double)s->to;
    job->run.shade_lux = (double)s->shade_lux;
    job->run.shade_share = (double)s->shade_share;
    if (isnan(s->north))
        cli_note(job->session, "no --north given: north is assumed to be along -z");
}

/// Whether an output file can be written and is not one of the inputs.
static bool check_file(const settings *s, const char *path)
{
    bool good = cli_check_output(path) && cli_check_apart(path, s->points);
    for (size_t k = 0; good && k < s->weather.count; k++)
        good = cli_check_apart(path, s->weather.item[k]);
    return good;
}

static bool check_files(const settings *s)
{
    const cli_list *lists[] = { &s->outputs, &s->hourly };
    for (int l = 0; l < 2; l++)
        for (size_t k = 0; k < lists[l]->count; k++) {
            if (!check_file(s, lists[l]->item[k])) return false;
            for (size_t j = 0; j < lists[l]->count; j++)
                if (j != k && !cli_check_apart(lists[l]->item[k], lists[l]->item[j])) return false;
            for (size_t j = 0; l == 1 && j < s->outputs.count; j++)
                if (!cli_check_apart(lists[l]->item[k], s->outputs.item[j])) return false;
        }
    return true;
}

int cli_daylight(int argc, char **argv)
{
    settings s = { .solve = CLI_DEFAULT_SOLVE,
        .north = NAN,
        .ground = 0.2f,
        .height = 0.8f,
        .spacing = 0.5f,
        .from = 8,
        .to = 18,
        .shade_lux = 1000,
        .shade_share = 0.02f };
    int exit_status;
    if (!parse_settings(&s, argc, argv, &exit_status)) return exit_status;
    cli_session session;
    exit_status = CLI_FAILURE;
    if (check_files(&s) && cli_prepare_solve(&s.solve) && cli_session_begin(&session, s.threads)) {
        session.mesh = s.mesh;
        session.reading = s.reading;
        session.max_bytes = s.solve.max_bytes;
        daylight_job job = { .session = &session, .s = &s };
        describe(&s, &job);
        exit_status = run(&job);
        close_job(&job);
        cli_session_end(&session);
    }
    return exit_status;
}
