#include "command.h"
#include "moment.h"
#include "options.h"
#include "output_file.h"
#include "points_csv.h"
#include "stats.h"
#include "subject.h"

#include "resolvent/fit.h"
#include "resolvent/relight.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char help[] =
    "usage: resolvent fit SCENE --wanted IN.csv -o OUT.csv [options]\n"
    "\n"
    "Finds how far to dim each light so that points reach target readings with the least power, and\n"
    "prints by how much a target is missed. SCENE is a file, a built-in scene, or a file from `resolvent\n"
    "solve`. IN.csv has a header with x,y,z,nx,ny,nz,lux and, optionally, weight. With r,g,b (W/m2, as\n"
    "written by `probe`) in place of lux, lights also get colours. OUT.csv holds name,r,g,b,lumens, with\n"
    "factors for `relight --light NAME=R,G,B`.\n"
    "\n"
    "  --wanted FILE      the points and their target readings\n"
    "  -o FILE            the factor of each light, and its lumens after dimming\n"
    "  --readings FILE    the readings reached: x,y,z,nx,ny,nz,wanted,lux (or r,g,b)\n"
    "  --relit FILE       the solution with these factors, as an operator file\n"
    "  --at-least         readings may exceed their targets\n"
    "  --most F           highest factor (default 1)\n"
    "  --least F          lowest factor (default 0)\n"
    "  --keep NAME        do not change this light; repeat it for more; * matches any text\n"
    "  --samples N        rays per point (default 512)\n"
    "  --threads N        default: one per core; the result does not depend on it\n" CLI_MESH_HELP
        CLI_READING_HELP CLI_MOMENT_HELP CLI_ENVIRONMENT_HELP CLI_SOLVE_HELP "\n"
    "examples:\n"
    "  resolvent fit office.safetensors --wanted desks.csv --at-least -o dimming.csv\n"
    "  resolvent fit office.safetensors --wanted desks.csv -o dimming.csv --relit dimmed.safetensors\n"
    "  resolvent fit office.glb --luminaire 'panel*=panel.ies' --wanted desks.csv --least 0.1 \\\n"
    "      -o dimming.csv\n";

typedef struct settings {
    const char *scene, *wanted, *output, *readings, *relit, *mesh;
    cli_environment environment;
    cli_moment moment;
    cli_reading reading;
    cli_solve_choice solve;
    cli_list keep;
    bool at_least;
    float most, least;
    uint32_t samples, threads;
} settings;

static bool parse_settings(settings *s, int argc, char **argv, int *exit_status)
{
    const cli_option options[] = {
        { .name = "--wanted", .kind = CLI_TEXT, .value = &s->wanted },
        { .name = "-o", .kind = CLI_TEXT, .value = &s->output },
        { .name = "--readings", .kind = CLI_TEXT, .value = &s->readings },
        { .name = "--relit", .kind = CLI_TEXT, .value = &s->relit },
        { .name = "--at-least", .kind = CLI_FLAG, .value = &s->at_least },
        { .name = "--most", .kind = CLI_REAL, .value = &s->most, .max = 1e6 },
        { .name = "--least", .kind = CLI_REAL, .value = &s->least, .max = 1e6 },
        { .name = "--keep", .kind = CLI_LIST, .value = &s->keep },
        { .name = "--samples", .kind = CLI_COUNT, .value = &s->samples, .min = 1, .max = 1 << 24 },
        { .name = "--threads", .kind = CLI_COUNT, .value = &s->threads, .max = 1024 },
        CLI_MESH_OPTION(&s->mesh),
        CLI_MOMENT_OPTIONS(&s->moment),
        CLI_SOLVE_OPTIONS(&s->solve),
        CLI_ENVIRONMENT_OPTIONS(&s->environment),
        CLI_READING_OPTIONS(&s->reading),
        { .name = NULL },
    };
    const cli_usage usage = { "fit", help, options, "SCENE", 1, 1,
        "--wanted -o --at-least --most --keep --relit --readings --luminaire --quality" };
    if (!cli_parse(&usage, argc, argv, &s->scene, exit_status)) return false;
    if (!s->wanted || !s->output)
        *exit_status =
            cli_usage_error("fit", "%s is missing", s->wanted ? "-o OUT.csv" : "--wanted IN.csv");
    else if (s->least > s->most)
        *exit_status = cli_usage_error(
            "fit", "--least %g is above --most %g", (double)s->least, (double)s->most);
    else
        return true;
    return false;
}

// ---- targets ----------------------------------------------------------------------------------------

static bool has_colors(const cli_points *p)
{
    return p->has[CLI_WANTED_R] && p->has[CLI_WANTED_G] && p->has[CLI_WANTED_B];
}

static bool check_wanted(const settings *s, const cli_points *p)
{
    if (p->has[CLI_WANTED_LUX] || has_colors(p)) return true;
    cli_error("%s: it has no target readings: the header needs a column lux, or columns r, g and b",
        s->wanted);
    return false;
}

static rsv_fit_wanted *list_wanted(const cli_points *p)
{
    rsv_fit_wanted *wanted = calloc(p->count, sizeof *wanted);
    for (size_t k = 0; wanted && k < p->count; k++) {
        const double *v = p->wanted[k];
        wanted[k].probe = p->probe[k];
        wanted[k].weight = p->has[CLI_WANTED_WEIGHT] ? (float)v[CLI_WANTED_WEIGHT] : 1;
        wanted[k].reading = p->has[CLI_WANTED_LUX]
                                ? (rsv_rgb){ (float)v[CLI_WANTED_LUX], 0, 0 }
                                : (rsv_rgb){ (float)v[CLI_WANTED_R], (float)v[CLI_WANTED_G],
                                      (float)v[CLI_WANTED_B] };
    }
    return wanted;
}

// ---- results ----------------------------------------------------------------------------------------

/// A name as a cell: in quotes where it holds a comma or quotes.
static void print_cell(FILE *to, const char *name)
{
    if (!strpbrk(name, ",\"\n")) {
        fputs(name, to);
        return;
    }
    putc('"', to);
    for (; *name; name++) {
        if (*name == '"') putc('"', to);
        putc(*name, to);
    }
    putc('"', to);
}

static void print_factors(FILE *to, const rsv_fit *fit)
{
    fputs("name,r,g,b,lumens\n", to);
    for (size_t k = 0; k < rsv_fit_light_count(fit); k++) {
        rsv_fit_light l = rsv_fit_get_light(fit, k);
        double share =
            0.2126 * (double)l.factor.r + 0.7152 * (double)l.factor.g + 0.0722 * (double)l.factor.b;
        print_cell(to, l.name);
        fprintf(to, ",%.7g,%.7g,%.7g,%.6g\n", (double)l.scale.r, (double)l.scale.g,
            (double)l.scale.b, l.lumens * share);
    }
}

static void print_readings(FILE *to, const rsv_fit *fit, const cli_points *p)
{
    bool lux = p->has[CLI_WANTED_LUX];
    fputs(lux ? "x,y,z,nx,ny,nz,wanted,lux\n" : "x,y,z,nx,ny,nz,wanted_r,wanted_g,wanted_b,r,g,b\n",
        to);
    for (size_t k = 0; k < p->count; k++) {
        const double *g = p->given[k], *v = p->wanted[k];
        rsv_rgb r = rsv_fit_reading(fit, k);
        fprintf(to, "%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,", g[0], g[1], g[2], g[3], g[4], g[5]);
        if (lux)
            fprintf(to, "%.9g,%.7g\n", v[CLI_WANTED_LUX], (double)r.r);
        else
            fprintf(to, "%.9g,%.9g,%.9g,%.7g,%.7g,%.7g\n", v[CLI_WANTED_R], v[CLI_WANTED_G],
                v[CLI_WANTED_B], (double)r.r, (double)r.g, (double)r.b);
    }
}

/// @param points NULL = writes the factors
static bool write_csv(const char *path, const rsv_fit *fit, const cli_points *points)
{
    char *text = NULL;
    size_t length = 0;
    FILE *stream = open_memstream(&text, &length);
    if (stream && points) print_readings(stream, fit, points);
    if (stream && !points) print_factors(stream, fit);
    bool complete = stream && !ferror(stream);
    if (stream && fclose(stream) != 0) complete = false;
    if (!complete) cli_error("%s: out of memory writing it", path);
    bool written = complete && cli_write_file(path, text, length);
    free(text);
    return written;
}

static void print_report(const rsv_fit *fit, const cli_points *p, bool at_least)
{
    rsv_fit_report r = rsv_fit_get_report(fit);
    const double *worst = p->given[r.worst];
    printf("lights %zu, points %zu, %.4g of %.4g lm\n", rsv_fit_light_count(fit), p->count,
        r.lumens, r.lumens_before);
    printf("readings miss their targets by %.3g %% (RMS, of the mean)", 100 * r.error_rms);
    if (r.error_largest > 0)
        printf("; most by %.4g %s%s at (%.4g %.4g %.4g)", r.error_largest,
            p->has[CLI_WANTED_LUX] ? "lux" : "W/m2", at_least ? " too little" : "", worst[0],
            worst[1], worst[2]);
    printf("\nKKT residual %.2g after %u steps; readings %.2f s, fit %.3f s\n", r.kkt_residual,
        r.iterations, r.time_readings, r.time_fit);
}

// ---- the command ------------------------------------------------------------------------------------

/// Relights the solution by the factors and keeps it.
static rsv_status relight(
    cli_session *session, const settings *s, const cli_subject *subject, const rsv_fit *fit)
{
    size_t count = rsv_fit_light_count(fit);
    char name[256] = "";
    rsv_light_scale *scale = calloc(count, sizeof *scale);
    if (!scale) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < count; k++) {
        rsv_fit_light l = rsv_fit_get_light(fit, k);
        scale[k] = (rsv_light_scale){ l.name, l.scale };
    }
    rsv_status status = rsv_light_relight(subject->solution,
        &(rsv_relight_desc){
            .size = sizeof(rsv_relight_desc), .light = scale, .light_count = count });
    free(scale);
    if (status == RSV_OK && rsv_is_operator_file(s->scene))
        status = rsv_operator_scene_name(session->context, s->scene, name, sizeof name);
    if (status != RSV_OK) return status;
    return rsv_light_save(subject->solution, *name ? name : s->scene, s->relit);
}

static rsv_status find_fit(
    const settings *s, const cli_points *points, const cli_subject *subject, rsv_fit **fit)
{
    rsv_fit_desc desc = rsv_default_fit_desc();
    desc.colors = !points->has[CLI_WANTED_LUX];
    desc.at_least = s->at_least;
    desc.lowest = (double)s->least, desc.highest = (double)s->most;
    desc.keep = s->keep.item, desc.keep_count = s->keep.count;
    desc.samples = s->samples, desc.seed = s->solve.seed;
    rsv_fit_wanted *wanted = list_wanted(points);
    if (!wanted) return RSV_ERROR_MEMORY;
    rsv_status status = rsv_fit_create(subject->solution, wanted, points->count, &desc, fit);
    free(wanted);
    return status;
}

static int run(cli_session *session, const settings *s, const cli_points *points)
{
    cli_subject subject = { 0 };
    rsv_certificate certificate;
    rsv_fit *fit = NULL;
    bool good = cli_open_subject(session, s->scene, &s->environment, &subject);
    if (good) {
        rsv_solve_desc desc = cli_describe_solve(&s->solve);
        cli_place_points(points, subject.scene);
        rsv_status status = cli_solve_subject(session, &desc, NULL, &subject, &certificate);
        if (status == RSV_OK) status = find_fit(s, points, &subject, &fit);
        if (status == RSV_OK && s->relit) status = relight(session, s, &subject, fit);
        if (status == RSV_OK && cli_interrupted()) status = RSV_ERROR_CANCELLED;
        if (status != RSV_OK) cli_report_failure(session, status);
        good = status == RSV_OK;
    }
    good = good && write_csv(s->output, fit, NULL) &&
           (!s->readings || write_csv(s->readings, fit, points));
    if (good) print_report(fit, points, s->at_least);
    rsv_fit_destroy(fit);
    cli_close_subject(&subject);
    return good ? CLI_SUCCESS : CLI_FAILURE;
}

static bool check_outputs(const settings *s)
{
    return cli_check_output(s->output) && (!s->readings || cli_check_output(s->readings)) &&
           (!s->relit || cli_check_output(s->relit)) && cli_check_apart(s->output, s->wanted) &&
           cli_check_apart(s->readings, s->wanted) && cli_check_apart(s->readings, s->output) &&
           cli_check_apart(s->relit, s->output);
}

int cli_fit(int argc, char **argv)
{
    settings s = { .solve = CLI_DEFAULT_SOLVE,
        .environment = CLI_DEFAULT_ENVIRONMENT,
        .moment = CLI_AT_REST,
        .most = 1,
        .samples = rsv_default_fit_desc().samples };
    int exit_status;
    if (!parse_settings(&s, argc, argv, &exit_status)) return exit_status;
    cli_points points = { .needs_wanted = true };
    cli_session session;
    exit_status = CLI_FAILURE;
    if (check_outputs(&s) && cli_read_points(s.wanted, &points) && check_wanted(&s, &points) &&
        cli_prepare_solve(&s.solve) && cli_session_begin(&session, s.threads)) {
        session.mesh = s.mesh;
        session.moment = s.moment;
        session.reading = s.reading;
        session.max_bytes = s.solve.max_bytes;
        session.keep_document = s.relit != NULL;
        exit_status = run(&session, &s, &points);
        cli_session_end(&session);
    }
    cli_free_points(&points);
    return exit_status;
}
