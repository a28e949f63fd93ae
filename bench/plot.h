/// Curves on logarithmic axes, as SVG.
#ifndef CLI_PLOT_H
#define CLI_PLOT_H

#include <stdio.h>

/// A range of values between two places of the picture.
typedef struct cli_axis {
    double low, high;   ///< powers of ten
    double from, to;    ///< pixels
    const char *format; ///< of a number: "%g s"
    double unit;        ///< value of one unit on the axis: 0.01 for percent
} cli_axis;

typedef struct cli_plot {
    FILE *svg;
    cli_axis x, y;
} cli_plot;

/// Widens a range to whole decades.
void cli_axis_cover(cli_axis *axis, double low, double high);

/// The pixel of a value.
double cli_axis_place(const cli_axis *axis, double value);

/// @param style class of the path
void cli_plot_line(
    const cli_plot *plot, const double from[2], const double to[2], const char *style);

/// Lines at 1 to 9 of each decade, and their numbers. Classes: decade, grid.
void cli_plot_grid(const cli_plot *plot);

#endif
