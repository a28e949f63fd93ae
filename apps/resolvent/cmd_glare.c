#include "command.h"
#include "glare.h"
#include "moment.h"
#include "observer_glare.h"
#include "options.h"
#include "output_file.h"
#include "photometry.h"
#include "points_csv.h"
#include "subject.h"

#include "resolvent/image.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const char help[] =
    "usage: resolvent glare IN.{exr,hdr} [options]\n"
    "       resolvent glare SCENE --observers IN.csv -o OUT.csv [options]\n"
    "\n"
    "Computes daylight glare probability (DGP) and unified glare rating (UGR) of a view. The picture must\n"
    "show the half space ahead of the observer, as from `render --projection fisheye`. Pixels above a\n"
    "threshold are glare sources; adjacent ones form one source. Luminance is 683 lm/W times CIE 1931 Y\n"
    "of the radiance.\n"
    "\n"
    "With --observers, computes UGR at points x,y,z looking along nx,ny,nz, due to emissive surfaces and\n"
    "luminaires with an opening (--luminaire). OUT.csv: x,y,z,nx,ny,nz,ugr,background,lux,sources.\n"
    "\n"
    "  --observers FILE   the points\n"
    "  -o FILE            with --observers: the results\n"
    "  --samples N        rays per observer (default 4096)\n"
    "  --threads N        default: one per core; the result does not depend on it\n"
    "  --threshold CD     luminance above which a pixel is a glare source (default: five times the mean)\n"
    "  --efficacy LM/W    use this instead of 683, such as 179 for pictures from Radiance\n"
    "  --json             print JSON\n" CLI_MESH_HELP CLI_READING_HELP CLI_MOMENT_HELP
        CLI_ENVIRONMENT_HELP CLI_SOLVE_HELP "\n"
    "examples:\n"
    "  resolvent render office.glb --camera desk --projection fisheye --size 1000x1000 -o view.exr\n"
    "  resolvent glare view.exr\n"
    "  resolvent glare office.glb --luminaire 'panel*=panel.ies' --observers seats.csv -o glare.csv\n";

typedef struct settings {
    const char *input, *observers, *output, *mesh;
    float threshold, efficacy;
    bool json;
    uint32_t samples, threads;
    cli_environment environment;
    cli_moment moment;
    cli_reading reading;
    cli_solve_choice solve;
} settings;

/// How DGP rates a view (Wienold 2009).
static const char *verdict_of(double dgp)
{
    return dgp < 0.35   ? "imperceptible"
           : dgp < 0.40 ? "perceptible"
           : dgp < 0.45 ? "disturbing"
                        : "intolerable";
}

static void print_text(const cli_glare *g)
{
    printf("DGP        %.4f  %s\n", g->dgp, verdict_of(g->dgp));
    if (g->count)
        printf("UGR        %.2f\n", g->ugr);
    else
        printf("UGR        none: no glare source\n");
    printf("at the eye %.5g lux, background %.4g cd/m2, mean %.4g cd/m2, threshold %.4g cd/m2\n",
        g->vertical, g->background, g->mean, g->threshold);
    printf("sources    %zu\n", g->count);
    for (size_t k = 0; k < g->count && k < 10; k++)
        printf("  %.5g cd/m2, %.3g sr, position index %.3g, at %.3g %.3g %.3g (right, up, ahead)\n",
            g->source[k].luminance, g->source[k].solid_angle, g->source[k].position,
            g->source[k].direction[0], g->source[k].direction[1], g->source[k].direction[2]);
}

static bool print_json(const cli_glare *g)
{
    cJSON *root = cJSON_CreateObject(), *list = cJSON_AddArrayToObject(root, "sources");
    cJSON_AddNumberToObject(root, "dgp", g->dgp);
    if (g->count)
        cJSON_AddNumberToObject(root, "ugr", g->ugr);
    else
        cJSON_AddNullToObject(root, "ugr");
    cJSON_AddNumberToObject(root, "vertical_lux", g->vertical);
    cJSON_AddNumberToObject(root, "background", g->background);
    cJSON_AddNumberToObject(root, "mean", g->mean);
    cJSON_AddNumberToObject(root, "threshold", g->threshold);
    for (size_t k = 0; k < g->count; k++) {
        cJSON *item = cJSON_CreateObject();
        cJSON_AddItemToArray(list, item);
        cJSON_AddNumberToObject(item, "luminance", g->source[k].luminance);
        cJSON_AddNumberToObject(item, "solid_angle", g->source[k].solid_angle);
        cJSON_AddNumberToObject(item, "position_index", g->source[k].position);
        cJSON_AddItemToObject(
            item, "direction", cJSON_CreateDoubleArray(g->source[k].direction, 3));
    }
    char *text = cJSON_Print(root);
    if (text)
        puts(text);
    else
        cli_error("out of memory");
    cJSON_free(text);
    cJSON_Delete(root);
    return text != NULL;
}

/// @return whether all went well
static bool judge(const settings *s, const rsv_image *image)
{
    uint32_t width = rsv_image_width(image), height = rsv_image_height(image);
    size_t count = (size_t)width * height;
    const rsv_rgb *pixel = rsv_image_const_pixels(image, 0);
    float *luminance = malloc(count * sizeof *luminance);
    cli_glare glare = { 0 };
    for (size_t k = 0; luminance && k < count; k++) {
        double value = cli_luminous(pixel[k]) * (double)s->efficacy / CLI_LUMINOUS_EFFICACY;
        luminance[k] = isfinite(value) && value > 0 ? (float)fmin(value, 1e12) : 0;
    }
    bool good = luminance && cli_find_glare(luminance, width, height, (double)s->threshold, &glare);
    if (!good) cli_error("out of memory for %zu pixels", count);
    if (good && s->json) good = print_json(&glare);
    if (good && !s->json) print_text(&glare);
    cli_glare_free(&glare);
    free(luminance);
    return good;
}

static int judge_picture(const settings *s)
{
    cli_session session;
    rsv_image *image = NULL;
    int exit_status = CLI_FAILURE;
    if (!cli_session_begin(&session, 1)) return CLI_FAILURE;
    rsv_status status = rsv_image_read(session.context, s->input, &image);
    if (status != RSV_OK)
        cli_report_failure(&session, status);
    else if (judge(s, image))
        exit_status = CLI_SUCCESS;
    rsv_image_destroy(image);
    cli_session_end(&session);
    return exit_status;
}

// ---- observers --------------------------------------------------------------------------------------

static bool write_observers(
    const settings *s, const cli_points *points, const cli_observer *observer)
{
    char *text = NULL;
    size_t length = 0;
    FILE *stream = open_memstream(&text, &length);
    if (stream) fputs("x,y,z,nx,ny,nz,ugr,background,lux,sources\n", stream);
    for (size_t k = 0; stream && k < points->count; k++) {
        const double *g = points->given[k];
        const cli_observer *o = &observer[k];
        fprintf(stream, "%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,", g[0], g[1], g[2], g[3], g[4], g[5]);
        if (isfinite(o->ugr)) fprintf(stream, "%.4f", o->ugr);
        fprintf(stream, ",%.6g,%.6g,%u\n", o->background, o->vertical, o->sources);
    }
    bool complete = stream && !ferror(stream);
    if (stream && fclose(stream) != 0) complete = false;
    if (!complete) cli_error("%s: out of memory writing it", s->output);
    bool written = complete && cli_write_file(s->output, text, length);
    free(text);
    return written;
}

static int rate(cli_session *session, const settings *s, const cli_points *points)
{
    cli_subject subject = { 0 };
    cli_observer *observer = calloc(points->count, sizeof *observer);
    bool good = observer && cli_open_subject(session, s->input, &s->environment, &subject);
    if (good) {
        rsv_solve_desc desc = cli_describe_solve(&s->solve);
        cli_place_points(points, subject.scene);
        rsv_status status = cli_solve_subject(session, &desc, NULL, &subject, NULL);
        if (status == RSV_OK)
            status = cli_rate_observers(
                subject.solution, points->probe, points->count, s->samples, observer);
        if (status != RSV_OK) cli_report_failure(session, status);
        good = status == RSV_OK && write_observers(s, points, observer);
    }
    free(observer);
    cli_close_subject(&subject);
    return good ? CLI_SUCCESS : CLI_FAILURE;
}

static int judge_observers(const settings *s)
{
    cli_points points = { 0 };
    cli_session session;
    int exit_status = CLI_FAILURE;
    if (cli_check_output(s->output) && cli_check_apart(s->output, s->observers) &&
        cli_read_points(s->observers, &points) && cli_prepare_solve(&s->solve) &&
        cli_session_begin(&session, s->threads)) {
        session.mesh = s->mesh;
        session.moment = s->moment;
        session.reading = s->reading;
        session.max_bytes = s->solve.max_bytes;
        exit_status = rate(&session, s, &points);
        cli_session_end(&session);
    }
    cli_free_points(&points);
    return exit_status;
}

int cli_glare_command(int argc, char **argv)
{
    settings s = { .efficacy = (float)CLI_LUMINOUS_EFFICACY,
        .samples = 4096,
        .solve = CLI_DEFAULT_SOLVE,
        .environment = CLI_DEFAULT_ENVIRONMENT,
        .moment = CLI_AT_REST };
    const cli_option options[] = {
        { .name = "--threshold", .kind = CLI_REAL, .value = &s.threshold, .max = 1e9 },
        { .name = "--efficacy", .kind = CLI_REAL, .value = &s.efficacy, .min = 1, .max = 1e4 },
        { .name = "--json", .kind = CLI_FLAG, .value = &s.json },
        { .name = "--observers", .kind = CLI_TEXT, .value = &s.observers },
        { .name = "-o", .kind = CLI_TEXT, .value = &s.output, .goes_with = "--observers" },
        { .name = "--samples",
            .kind = CLI_COUNT,
            .value = &s.samples,
            .min = 1,
            .max = 1 << 30,
            .goes_with = "--observers" },
        { .name = "--threads", .kind = CLI_COUNT, .value = &s.threads, .max = 1024 },
        CLI_MESH_OPTION(&s.mesh),
        CLI_MOMENT_OPTIONS(&s.moment),
        CLI_SOLVE_OPTIONS(&s.solve),
        CLI_ENVIRONMENT_OPTIONS(&s.environment),
        CLI_READING_OPTIONS(&s.reading),
        { .name = NULL },
    };
    const cli_usage usage = { "glare", help, options, "IN", 1, 1,
        "--observers -o --threshold --efficacy --samples --json --luminaire" };
    int exit_status;
    if (!cli_parse(&usage, argc, argv, &s.input, &exit_status)) return exit_status;
    if (s.observers && !s.output) return cli_usage_error("glare", "-o OUT.csv is missing");
    return s.observers ? judge_observers(&s) : judge_picture(&s);
}
