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
    "Says how picture B differs from A, the one taken for true (.exr, .hdr, .png, .jpg, same "
    "size),\n"
    "over the three channels in linear RGB:\n"
    "\n"
    "  rmse                   root mean square of B - A\n"
    "  relative_mse           mean of (B - A)^2 / (A^2 + 0.01 mean(A)^2)\n"
    "  psnr                   dB, below the largest value of A\n"
    "  mean_ratio             mean(B) / mean(A), and the same per channel\n"
    "  median_relative_error  median over the pixels, of luminance\n"
    "\n"
    "  -o FILE       write |B - A| as a picture\n"
    "  --gain X      that many times as bright (default 1)\n"
    "  --layer NAME  compare the layers of that name (see `resolvent render --layers`)\n"
    "  --json        print JSON\n"
    "\n"
    "examples:\n"
    "  resolvent compare reference.exr operator.exr\n"
    "  resolvent compare a.exr b.exr --layer bounce1 --json\n";

typedef struct settings {
    const char *path[2];
    const char *layer, *output;
    float gain;
    bool json;
} settings;

/// Reads one picture and finds the layer in it; says what went wrong.
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

static void print_text(const rsv_image_difference *d)
{
    const double *ratio = d->channel_mean_ratio;
    printf("rmse                   %.6g\n", d->rmse);
    printf("relative_mse           %.6g\n", d->relative_mse);
    printf("psnr                   %.2f dB\n", d->psnr);
    printf("mean_ratio             %.6f  (r %.6f, g %.6f, b %.6f)\n", d->mean_ratio, ratio[0],
        ratio[1], ratio[2]);
    printf("median_relative_error  %.6g\n", d->median_relative_error);
}

static bool print_json(const rsv_image_difference *d)
{
    cJSON *root = cJSON_CreateObject();
    cJSON_AddNumberToObject(root, "rmse", d->rmse);
    cJSON_AddNumberToObject(root, "relative_mse", d->relative_mse);
    cJSON_AddNumberToObject(root, "psnr", d->psnr);
    cJSON_AddNumberToObject(root, "mean_ratio", d->mean_ratio);
    cJSON_AddItemToObject(
        root, "channel_mean_ratio", cJSON_CreateDoubleArray(d->channel_mean_ratio, 3));
    cJSON_AddNumberToObject(root, "median_relative_error", d->median_relative_error);
    bool printed = cli_write_json(NULL, root);
    cJSON_Delete(root);
    return printed;
}

static rsv_status write_difference(
    cli_session *session, const settings *s, rsv_image *const image[2], const uint32_t layer[2])
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

static int run(cli_session *session, const settings *s)
{
    int exit_status = CLI_FAILURE;
    rsv_image *image[2] = { NULL, NULL };
    uint32_t layer[2];
    for (int i = 0; i < 2; i++)
        if (!read_layer(session, s->path[i], s->layer, &image[i], &layer[i])) goto cleanup;

    rsv_image_difference difference;
    rsv_status status = rsv_image_compare(image[0], layer[0], image[1], layer[1], &difference);
    if (status == RSV_OK && s->output) status = write_difference(session, s, image, layer);
    if (status != RSV_OK) {
        cli_report_failure(session, status);
    } else if (!s->json) {
        print_text(&difference);
        exit_status = CLI_SUCCESS;
    } else if (print_json(&difference)) {
        exit_status = CLI_SUCCESS;
    }

cleanup:
    rsv_image_destroy(image[0]);
    rsv_image_destroy(image[1]);
    return exit_status;
}

int cli_compare(int argc, char **argv)
{
    settings s = { .gain = 1 };
    const cli_option options[] = {
        { .name = "-o", .kind = CLI_TEXT, .value = &s.output },
        { .name = "--gain", .kind = CLI_REAL, .value = &s.gain, .min = 0, .max = 1e6 },
        { .name = "--layer", .kind = CLI_TEXT, .value = &s.layer },
        { .name = "--json", .kind = CLI_FLAG, .value = &s.json },
        { .name = NULL },
    };
    const cli_usage usage = { "compare", help, options, "A B", 2, 2 };
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
