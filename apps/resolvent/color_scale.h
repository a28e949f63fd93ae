/// Colours for numbers.
#ifndef CLI_COLOR_SCALE_H
#define CLI_COLOR_SCALE_H

/// From dark violet by green to yellow for 0 to 1, in even steps of lightness: viridis (Smith and van der Walt) at nine
/// places.
/// @param srgb out: 0 to 255
void cli_scale_color(double t, double srgb[3]);

#endif
