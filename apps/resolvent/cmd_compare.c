#include "command.h"
#include "options.h"
#include "output_file.h"
#include "session.h"

#include "resolvent/image.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>

static const char help[] =
    "usage: resolvent compare A B [options]\n"
    "\n"
    "Measures how picture B differs from the reference A (.exr, .hdr, .png, .jpg of the same size), over\n"
    "three channels in linear RGB:\n"
    "\n"
    "  rmse                   root mean square of B - A\n"
    "  relative_mse           mean of (B - A)^2 / (A^2 + 0.01 mean(A)^2)\n"
    "  psnr                   dB, relative to the largest value of A\n"
    "  mean_ratio             mean(B) / mean(A), and the same per channel\n"
    "  median_relative_error  median over the pixels, of luminance\n"
    "\n"
    "  -o FILE            write |B - A| as a picture\n"
    "  --gain X           multiply that picture by X (default 1)\n"
    "  --twin FILE        A rendered with another --seed: the reference is then the mean of the two. Their\n"
    "                     noise does not correlate, so it can be separated from the error of B:\n"
    "                       without_noise  relative MSE of B against the truth, and its standard error;\n"
    "                                      A^2 is that of the mean over 5 x 5 pixels\n"
    "                       noise_of_a     relative MSE of A against the truth\n"
    "  --layer NAME       compare the layers of this name (see `resolvent render --layers`)\n"
    "  --json             print JSON\n"
    "\n"
    "examples:\n"
    "  resolvent compare reference.exr operator.exr\n"
    "  resolvent compare a.exr b.exr --layer bounce1 --json\n"
    "  resolvent compare seed1.exr final.exr --twin seed2.exr\n";

typedef struct settings {
    const char *path[3]; ///< A, B and A's twin, or NULL
    const char *layer, *output;
    float gain;
    bool json;
} settings;

/// Reads a picture and finds the layer in it; prints errors.
static bool read_layer(
    cli_session *session, const char *path, const char *name, rsv_image **image, uint32_t *layer)
{
    rsv_status status = rsv_image_read(session->context, path, image);
    *layer = 0;
    if (status != RSV_OK) {
        cli_report_failure(session, status);
        return false;
    }
    if (!name) return true;
    *layer = rsv_image_find_layer(*image, name);
    if (*layer != RSV_NONE) return true;
    cli_error("%s: has no layer '%s'", path, name);
    return false;
}

/// Results of a comparison; `judgement` only with a twin.
typedef struct findings {
    rsv_image_difference difference;
    rsv_image_judgement judgement;
    bool judged;
} findings;

static void print_text(const findings *f)
{
    const rsv_image_difference *d = &f->difference;
    const double *ratio = d->channel_mean_ratio;
    printf("rmse                   %.6g\n", d->rmse);
    printf("relative_mse           %.6g\n", d->relative_mse);
    printf("psnr                   %.2f dB\n", d->psnr);
    printf("mean_ratio             %.6f  (r %.6f, g %.6f, b %.6f)\n", d->mean_ratio, ratio[0],
        ratio[1], ratio[2]);
    printf("median_relative_error  %.6g\n", d->median_relative_error);
    if (!f->judged) return;
    printf("without_noise          %.6g  (+- %.2g)\n", f->judgement.relative_mse,
        f->judgement.relative_mse_error);
    printf("noise_of_a             %.6g\n", f->judgement.reference_mse);
}

static bool print_json(const findings *f)
{
    const rsv_image_difference *d = &f->difference;
    cJSON *root = cJSON_CreateObject();
    cJSON_AddNumberToObject(root, "rmse", d->rmse);
    cJSON_AddNumberToObject(root, "relative_mse", d->relative_mse);
    cJSON_AddNumberToObject(root, "psnr", d->psnr);
    cJSON_AddNumberToObject(root, "mean_ratio", d->mean_ratio);
    cJSON_AddItemToObject(
        root, "channel_mean_ratio", cJSON_CreateDoubleArray(d->channel_mean_ratio, 3));
    cJSON_AddNumberToObject(root, "median_relative_error", d->median_relative_error);
    if (f->judged) {
        cJSON_AddNumberToObject(root, "without_noise", f->judgement.relative_mse);
        cJSON_AddNumberToObject(root, "without_noise_error", f->judgement.relative_mse_error);
        cJSON_AddNumberToObject(root, "noise_of_a", f->judgement.reference_mse);
    }
    bool printed = cli_write_json(NULL, root);
    cJSON_Delete(root);
    return printed;
}

static rsv_status write_difference(
    cli_session *session, const settings *s, rsv_image *const *image, const uint32_t *layer)
{
    uint32_t width = rsv_image_width(image[0]), height = rsv_image_height(image[0]);
    rsv_image *difference;
    rsv_status status = rsv_image_create(session->context, width, height, 1, &difference);
    if (status != RSV_OK) return status;
    const rsv_rgb *a = rsv_image_const_pixels(image[0], layer[0]);
    const rsv_rgb *b = rsv_image_const_pixels(image[1], layer[1]);
    rsv_rgb *out = rsv_image_pixels(difference, 0);
    for (size_t i = 0; i < (size_t)width * height; i++)
        out[i] = (rsv_rgb){ s->gain * fabsf(b[i].r - a[i].r), s->gain * fabsf(b[i].g - a[i].g),
            s->gain * fabsf(b[i].b - a[i].b) };
    status = rsv_image_write(difference, s->output, 0);
    rsv_image_destroy(difference);
    return status;
}

/// Judges B by A and its twin, and leaves their mean in A.
static rsv_status judge(
    rsv_image *const image[3], const uint32_t layer[3], rsv_image_judgement *judgement)
{
    const rsv_image *const reference[2] = { image[0], image[2] };
    const uint32_t reference_layer[2] = { layer[0], layer[2] };
    rsv_status status = rsv_image_judge(reference, reference_layer, image[1], layer[1], judgement);
    if (status != RSV_OK) return status;
    rsv_rgb *a = rsv_image_pixels(image[0], layer[0]);
    const rsv_rgb *twin = rsv_image_const_pixels(image[2], layer[2]);
    size_t count = (size_t)rsv_image_width(image[0]) * rsv_image_height(image[0]);
    for (size_t i = 0; i < count; i++)
        a[i] = (rsv_rgb){ 0.5f * (a[i].r + twin[i].r), 0.5f * (a[i].g + twin[i].g),
            0.5f * (a[i].b + twin[i].b) };
    return RSV_OK;
}

static int run(cli_session *session, const settings *s)
{
    int exit_status = CLI_FAILURE;
    rsv_image *image[3] = { NULL, NULL, NULL };
    uint32_t layer[3] = { 0 };
    findings found = { .judged = s->path[2] != NULL };
    rsv_status status = RSV_OK;
    for (int i = 0; i < 3; i++)
        if (s->path[i] && !read_layer(session, s->path[i], s->layer, &image[i], &layer[i]))
            goto cleanup;
    if (found.judged) status = judge(image, layer, &found.judgement);
    if (status == RSV_OK)
        status = rsv_image_compare(image[0], layer[0], image[1], layer[1], &found.difference);
    if (status == RSV_OK && s->output) status = write_difference(session, s, image, layer);
    if (status != RSV_OK) {
        cli_report_failure(session, status);
    } else if (!s->json) {
        print_text(&found);
        exit_status = CLI_SUCCESS;
    } else if (print_json(&found)) {
        exit_status = CLI_SUCCESS;
    }

cleanup:
    for (int i = 0; i < 3; i++)
        rsv_image_destroy(image[i]);
    return exit_status;
}

int cli_compare(int argc, char **argv)
{
    settings s = { .gain = 1 };
    const cli_option options[] = {
        { .name = "-o", .kind = CLI_TEXT, .value = &s.output },
        { .name = "--gain", .kind = CLI_REAL, .value = &s.gain, .min = 0, .max = 1e6 },
        { .name = "--layer", .kind = CLI_TEXT, .value = &s.layer },
        { .name = "--twin", .kind = CLI_TEXT, .value = &s.path[2] },
        { .name = "--json", .kind = CLI_FLAG, .value = &s.json },
        { .name = NULL },
    };
    const cli_usage usage = { "compare", help, options, "A B", 2, 2, NULL };
    int exit_status;
    if (!cli_parse(&usage, argc, argv, s.path, &exit_status)) return exit_status;
    if (s.output && rsv_image_check_output(s.output) != RSV_OK) {
        cli_error("%s", rsv_last_error());
        return CLI_FAILURE;
    }
    cli_session session;
    if (!cli_session_begin(&session, 0)) return CLI_FAILURE;
    exit_status = run(&session, &s);
    cli_session_end(&session);
    return exit_status;
}
