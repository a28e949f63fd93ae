/// Figures of readings, and how certain they are.
#ifndef RSV_DAYLIGHT_FIGURES_H
#define RSV_DAYLIGHT_FIGURES_H

#include "year.h"

/// Variants of a figure: without each group in turn, with all groups, and with the shared error added.
#define RSV_VARIANT_ALL RSV_DAYLIGHT_GROUPS
#define RSV_VARIANT_SHIFTED (RSV_DAYLIGHT_GROUPS + 1)
#define RSV_VARIANTS (RSV_DAYLIGHT_GROUPS + 2)

typedef double rsv_sensor_variants[RSV_VARIANTS][RSV_SENSOR_FIGURES];

/// Readings of a sensor, as rsv_year_read_sensor fills them, and scratch.
typedef struct rsv_sensor_readings {
    float (*reading)[RSV_DAYLIGHT_COLUMNS]; ///< [lit_count]
    float *sun;                             ///< [lit_count]
    float *value;                           ///< [daylight_count] scratch
    double stored_error;                    ///< of the sensor
} rsv_sensor_readings;

void rsv_sensor_figures(const rsv_daylight *daylight, const rsv_year *year, size_t sensor,
    const rsv_sensor_readings *readings, rsv_sensor_variants figures);

/// @param figures [count] @param value scratch, [count]
void rsv_space_figures(
    const rsv_sensor_variants *figures, size_t count, float *value, rsv_figure *space);

/// A column of readings that stands for the variant.
float rsv_variant_reading(
    const float reading[RSV_DAYLIGHT_COLUMNS], int variant, double stored_error);

/// @param variant [RSV_VARIANTS] values, `step` apart
rsv_figure rsv_figure_of(const double *variant, size_t step);

#endif
