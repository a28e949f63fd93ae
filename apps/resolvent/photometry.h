/// From W to lumens: the luminance of linear RGB, CIE 1931 Y, times 683 lm/W.
#ifndef CLI_PHOTOMETRY_H
#define CLI_PHOTOMETRY_H

#include "points_csv.h"

#include "resolvent/image.h"

/// Of one watt of linear RGB of luminance 1: that of light at 555 nm, by which exporters turn lumens into watts.
#define CLI_LUMINOUS_EFFICACY 683.0

/// lux of W/m2, cd/m2 of W/(sr m2).
double cli_luminous(rsv_rgb radiometric);

/// The same for all layers of a picture, whose channels then have luminances in cd/m2. @param photometric out, to be
/// destroyed
rsv_status cli_photometric_picture(
    rsv_context *context, const rsv_image *image, rsv_image **photometric);

/// A photometric reading and its standard error; errors of channels add up as if they were one.
typedef struct cli_lux {
    double value, error;
} cli_lux;

cli_lux cli_lux_of(const rsv_probe_reading *reading);

#define CLI_CYLINDER_SIDES 12

/// Vertical receivers all around each point, CLI_CYLINDER_SIDES of them one after the other. @param side out: [12 *
/// points->count]
void cli_cylinder_points(const cli_points *points, rsv_probe *side);
/// Cylindrical illuminance at a point: the mean over its vertical receivers.
cli_lux cli_cylindrical(const rsv_probe_reading side[CLI_CYLINDER_SIDES]);

/// Writes the points with lux,err_lux and, if given, cylindrical,err_cylindrical. Prints errors on standard error.
/// @param cylindrical [points->count] NULL = none
bool cli_write_lux(const char *path, const cli_points *points, const rsv_probe_reading *readings,
    const cli_lux *cylindrical);

/// Prints the figures of EN 12464-1 for the points as a grid: mean, minimum and uniformity, of both illuminances.
void cli_print_lux(
    const cli_points *points, const rsv_probe_reading *readings, const cli_lux *cylindrical);

#endif
