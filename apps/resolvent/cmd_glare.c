#include "command.h"
#include "glare.h"
#include "options.h"
#include "photometry.h"
#include "session.h"

#include "resolvent/image.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const char help[] =
    "usage: resolvent glare IN.{exr,hdr} [options]\n"
    "\n"
    "Daylight glare probability (DGP) and unified glare rating (UGR) of a view: a picture of the "
    "half\n"
    "space ahead as `render --projection fisheye` makes it, with the observer as its camera. "
    "Pixels\n"
    "above a threshold are glare sources; those that touch are one. Luminances are 683 lm/W times "
    "the\n"
    "luminance of radiance, CIE 1931 Y.\n"
    "\n"
    "  --threshold CD     luminance above which a pixel glares (default: five times the mean)\n"
    "  --efficacy LM/W    other than 683, such as 179 for pictures made with that\n"
    "  --json             print JSON\n"
    "\n"
    "examples:\n"
    "  resolvent render office.glb --camera desk --projection fisheye --size 1000x1000 -o "
    "view.exr\n"
    "  resolvent glare view.exr\n";

typedef struct settings {
    const char *input;
    float threshold, efficacy;
    bool json;
} settings;

/// What DGP says of a view (Wienold 2009).
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
    bool good = luminance &&
                cli_find_glare(luminance, width, height, (double)s->threshold, &glare);
    if (!good) cli_error("out of memory for %zu pixels", count);
    if (good && s->json) good = print_json(&glare);
    if (good && !s->json) print_text(&glare);
    cli_glare_free(&glare);
    free(luminance);
    return good;
}

int cli_glare_command(int argc, char **argv)
{
    settings s = { .efficacy = (float)CLI_LUMINOUS_EFFICACY };
    const cli_option options[] = {
        { .name = "--threshold", .kind = CLI_REAL, .value = &s.threshold, .max = 1e9 },
        { .name = "--efficacy", .kind = CLI_REAL, .value = &s.efficacy, .min = 1, .max = 1e4 },
        { .name = "--json", .kind = CLI_FLAG, .value = &s.json },
        { .name = NULL },
    };
    const cli_usage usage = { "glare", help, options, "IN", 1, 1 };
    int exit_status;
    cli_session session;
    rsv_image *image = NULL;
    if (!cli_parse(&usage, argc, argv, &s.input, &exit_status)) return exit_status;
    if (!cli_session_begin(&session, 1)) return CLI_FAILURE;
    rsv_status status = rsv_image_read(session.context, s.input, &image);
    exit_status = CLI_FAILURE;
    if (status != RSV_OK)
        cli_report_failure(&session, status);
    else if (judge(&s, image))
        exit_status = CLI_SUCCESS;
    rsv_image_destroy(image);
    cli_session_end(&session);
    return exit_status;
}
