#include "command.h"
#include "options.h"
#include "session.h"
#include "sheet.h"

#include "resolvent/image.h"

#include <math.h>
#include <stdio.h>

static const char help[] =
    "usage: resolvent layers IN.exr -o SHEET.{png,hdr,exr} [options]\n"
    "\n"
    "Arranges the layers of a picture (see `resolvent render --layers`) side by side, in reading order.\n"
    "Brightens each by its own power of two, and prints their names with that exposure in stops.\n"
    "\n"
    "  -o FILE            the sheet\n"
    "  --count N          at most N layers (default 6)\n"
    "  --columns N        pictures per row (default 3)\n"
    "  --exposure STOPS   brighten the whole sheet by 2^STOPS (default 0)\n"
    "\n"
    "examples:\n"
    "  resolvent render cornell-spheres -o orders.exr --layers\n"
    "  resolvent layers orders.exr -o orders.png\n"
    "  resolvent layers orders.exr -o first.png --count 2 --columns 2 --exposure 1\n";

/// Mean luminance that every layer is brought to, within a quarter of a stop.
static const double mean_luminance = 0.18;

enum { max_count = 64 };

typedef struct settings {
    const char *input, *output;
    uint32_t count, columns;
    float exposure;
} settings;

/// Half stops that bring the mean luminance of a layer to a middle grey; 0 for a black one.
static float layer_exposure(const rsv_image *image, uint32_t layer)
{
    const rsv_rgb *pixel = rsv_image_const_pixels(image, layer);
    size_t count = (size_t)rsv_image_width(image) * rsv_image_height(image);
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum +=
            0.2126 * (double)pixel[i].r + 0.7152 * (double)pixel[i].g + 0.0722 * (double)pixel[i].b;
    if (!(sum > 0)) return 0;
    return (float)(round(2 * log2(mean_luminance * (double)count / sum)) / 2);
}

/// The layers of the first orders of light, as they follow upon each other: files keep them by name.
static uint32_t find_orders(const rsv_image *image, uint32_t capacity, uint32_t *layers)
{
    uint32_t count = 0;
    for (uint32_t order = 0; count < capacity; order++) {
        char name[32] = "emission";
        if (order == 1) snprintf(name, sizeof name, "direct");
        if (order > 1) snprintf(name, sizeof name, "bounce%u", order - 1);
        uint32_t layer = rsv_image_find_layer(image, name);
        if (layer == UINT32_MAX) break;
        layers[count++] = layer;
    }
    return count;
}

static rsv_status make_sheet(rsv_context *context, const settings *s, const rsv_image *image,
    const uint32_t *layers, uint32_t count, rsv_image **sheet)
{
    rsv_status status = cli_sheet_create(context, image, count, s->columns, sheet);
    if (status != RSV_OK) return status;
    for (uint32_t i = 0; i < count; i++) {
        float stops = layer_exposure(image, layers[i]);
        cli_sheet_paste(*sheet, image, layers[i], exp2f(stops), i, s->columns);
        printf("%-10s %+.1f\n", rsv_image_layer_name(image, layers[i]), (double)stops);
    }
    return RSV_OK;
}

static int run(cli_session *session, const settings *s)
{
    int exit_status = CLI_FAILURE;
    rsv_image *image = NULL, *sheet = NULL;
    rsv_status status = rsv_image_read(session->context, s->input, &image);
    uint32_t layers[max_count], count = 0;
    if (status == RSV_OK) count = find_orders(image, s->count, layers);
    if (status == RSV_OK && count == 0) {
        cli_error("%s: has no layers of orders; `resolvent render --layers` writes them", s->input);
        goto cleanup;
    }
    if (status == RSV_OK) status = make_sheet(session->context, s, image, layers, count, &sheet);
    if (status == RSV_OK) status = rsv_image_write(sheet, s->output, s->exposure);
    if (status == RSV_OK)
        exit_status = CLI_SUCCESS;
    else
        cli_report_failure(session, status);

cleanup:
    rsv_image_destroy(image);
    rsv_image_destroy(sheet);
    return exit_status;
}

int cli_layers(int argc, char **argv)
{
    settings s = { .count = 6, .columns = 3 };
    const cli_option options[] = {
        { .name = "-o", .kind = CLI_TEXT, .value = &s.output },
        { .name = "--count", .kind = CLI_COUNT, .value = &s.count, .min = 1, .max = max_count },
        { .name = "--columns", .kind = CLI_COUNT, .value = &s.columns, .min = 1, .max = 64 },
        { .name = "--exposure", .kind = CLI_REAL, .value = &s.exposure, .min = -64, .max = 64 },
        { .name = NULL },
    };
    const cli_usage usage = { "layers", help, options, "IN.exr", 1, 1, NULL };
    int exit_status;
    if (!cli_parse(&usage, argc, argv, &s.input, &exit_status)) return exit_status;
    if (!s.output) return cli_usage_error("layers", "-o SHEET.{png,hdr,exr} is missing");
    if (rsv_image_check_output(s.output) != RSV_OK) {
        cli_error("%s", rsv_last_error());
        return CLI_FAILURE;
    }
    cli_session session;
    if (!cli_session_begin(&session, 0)) return CLI_FAILURE;
    exit_status = run(&session, &s);
    cli_session_end(&session);
    return exit_status;
}
