/// Glare in a fisheye picture: daylight glare probability and unified glare rating.
#ifndef CLI_GLARE_H
#define CLI_GLARE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// Neighbouring pixels above the threshold.
typedef struct cli_glare_source {
    double luminance;    ///< mean over its solid angle, cd/m2
    double solid_angle;  ///< sr
    double illuminance;  ///< at the eye, lux
    double direction[3]; ///< unit: right, up, ahead; its centre by luminance
    double position;     ///< Guth's position index there; below the line of sight Iwata's
} cli_glare_source;

typedef struct cli_glare {
    double vertical;   ///< illuminance at the eye, lux
    double mean;       ///< luminance over the whole view, cd/m2
    double threshold;  ///< above which a pixel glares, cd/m2
    double background; ///< luminance that would give the light that is not of glare sources, cd/m2
    double dgp, ugr;   ///< ugr -INFINITY = no glare source
    cli_glare_source *source; ///< [count] the brightest first
    size_t count;
} cli_glare;

/// Position index of a direction (right, up, ahead).
double cli_position_index(const double direction[3]);

/// @param luminance [height * width] cd/m2, an equidistant picture of the half space ahead, top row first
/// @param threshold cd/m2; 0 = five times the mean @param glare to be freed by cli_glare_free
/// @return false when out of memory
bool cli_find_glare(
    const float *luminance, uint32_t width, uint32_t height, double threshold, cli_glare *glare);
void cli_glare_free(cli_glare *glare);

#endif
