#include "photometry.h"

#include "output_file.h"
#include "session.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

double cli_luminous(rsv_rgb c)
{
    return CLI_LUMINOUS_EFFICACY *
           (0.2126 * (double)c.r + 0.7152 * (double)c.g + 0.0722 * (double)c.b);
}

static rsv_status scale_layer(const rsv_image *image, uint32_t layer, rsv_image *scaled)
{
    size_t count = (size_t)rsv_image_width(image) * rsv_image_height(image);
    const rsv_rgb *from = rsv_image_const_pixels(image, layer);
    rsv_rgb *to = rsv_image_pixels(scaled, layer);
    const float efficacy = (float)CLI_LUMINOUS_EFFICACY;
    for (size_t k = 0; k < count; k++)
        to[k] = (rsv_rgb){ efficacy * from[k].r, efficacy * from[k].g, efficacy * from[k].b };
    if (!layer) return RSV_OK;
    return rsv_image_set_layer_name(scaled, layer, rsv_image_layer_name(image, layer));
}

rsv_status cli_photometric_picture(
    rsv_context *context, const rsv_image *image, rsv_image **photometric)
{
    uint32_t layers = rsv_image_layer_count(image);
    rsv_status status = rsv_image_create(
        context, rsv_image_width(image), rsv_image_height(image), layers, photometric);
    for (uint32_t k = 0; k < layers && status == RSV_OK; k++)
        status = scale_layer(image, k, *photometric);
    return status;
}

cli_lux cli_lux_of(const rsv_probe_reading *reading)
{
    return (cli_lux){ cli_luminous(reading->irradiance), cli_luminous(reading->standard_error) };
}

void cli_cylinder_points(const cli_points *points, rsv_probe *side)
{
    for (size_t k = 0; k < points->count; k++)
        for (int j = 0; j < CLI_CYLINDER_SIDES; j++) {
            double turn = 2 * M_PI * (j + 0.5) / CLI_CYLINDER_SIDES;
            side[k * CLI_CYLINDER_SIDES + (size_t)j] =
                (rsv_probe){ points->probe[k].position, { (float)cos(turn), 0, (float)sin(turn) } };
        }
}

cli_lux cli_cylindrical(const rsv_probe_reading side[CLI_CYLINDER_SIDES])
{
    cli_lux mean = { 0, 0 };
    for (int j = 0; j < CLI_CYLINDER_SIDES; j++) {
        cli_lux one = cli_lux_of(&side[j]);
        mean.value += one.value / CLI_CYLINDER_SIDES;
        mean.error +=
            one.error / CLI_CYLINDER_SIDES; // their errors are correlated through the stored light
    }
    return mean;
}

bool cli_write_lux(const char *path, const cli_points *points, const rsv_probe_reading *readings,
    const cli_lux *cylindrical)
{
    char *text = NULL;
    size_t length = 0;
    FILE *stream = open_memstream(&text, &length);
    if (stream)
        fprintf(stream, "x,y,z,nx,ny,nz,lux,err_lux%s\n",
            cylindrical ? ",cylindrical,err_cylindrical" : "");
    for (size_t k = 0; stream && k < points->count; k++) {
        const double *p = points->given[k];
        cli_lux lux = cli_lux_of(&readings[k]);
        for (int i = 0; i < 6; i++)
            fprintf(stream, "%.*g,", i < 3 && fabs(p[i]) >= 1e4 ? 15 : 9, p[i]);
        fprintf(stream, "%.9g,%.4g", lux.value, lux.error);
        if (cylindrical) fprintf(stream, ",%.9g,%.4g", cylindrical[k].value, cylindrical[k].error);
        fputc('\n', stream);
    }
    bool complete = stream && !ferror(stream);
    if (stream && fclose(stream) != 0) complete = false;
    if (!complete) cli_error("%s: out of memory writing the readings", path);
    bool written = complete && cli_write_file(path, text, length);
    free(text);
    return written;
}

/// Mean, minimum and uniformity of a grid's values.
typedef struct grid_figures {
    cli_lux mean, least;
} grid_figures;

/// Adds a reading to the mean and least value. As readings share errors, the mean's error is at most the mean of
/// theirs.
static void add_value(grid_figures *g, cli_lux lux, size_t count)
{
    g->mean.value += lux.value / (double)count;
    g->mean.error += lux.error / (double)count;
    if (lux.value < g->least.value) g->least = lux;
}

static void print_figures(const char *what, const grid_figures *g)
{
    double uniformity = g->mean.value > 0 ? g->least.value / g->mean.value : 0;
    printf("%-26s mean %.4g +- %.2g lux, minimum %.4g +- %.2g lux, uniformity %.3f\n", what,
        g->mean.value, g->mean.error, g->least.value, g->least.error, uniformity);
}

void cli_print_lux(
    const cli_points *points, const rsv_probe_reading *readings, const cli_lux *cylindrical)
{
    grid_figures flat = { { 0, 0 }, { INFINITY, 0 } }, round = flat;
    for (size_t k = 0; k < points->count; k++) {
        add_value(&flat, cli_lux_of(&readings[k]), points->count);
        if (cylindrical) add_value(&round, cylindrical[k], points->count);
    }
    print_figures("illuminance:", &flat);
    if (cylindrical) print_figures("cylindrical illuminance:", &round);
}
