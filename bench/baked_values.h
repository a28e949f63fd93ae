/// Compares values of a bake with path-traced ones: some at random, and all texels in small windows of a map.
#ifndef CLI_BAKED_VALUES_H
#define CLI_BAKED_VALUES_H

#include "resolvent/bake.h"

#define CLI_WINDOW_SIDE 16 ///< texels

typedef struct cli_baked_value {
    uint32_t at[2];
    bool in_window; ///< else at random
    rsv_rgb light;  ///< as baked
    size_t first;   ///< of its places
    uint32_t place_count;
    double reference, deviation; ///< luminance; of its mean
} cli_baked_value;

/// The values to be compared, and their results.
typedef struct cli_baked_values {
    uint32_t random_count, window_count; ///< approximate numbers wanted
    cli_baked_value *value;
    size_t count, capacity;
    rsv_surface_place *place;
    size_t place_count, place_capacity;
    bool exhausted;
} cli_baked_values;

/// Errors of a bake, relative to the light at each place, or to a twentieth of the mean if that is more.
typedef struct cli_bake_judgement {
    size_t values; ///< at random
    size_t
        buried; ///< of these, those that no light reaches, as within walls: invisible, and not judged
    double median, ninety, ninety_nine; ///< percentiles of the errors of values at random
    double noise;      ///< of the reference: the median error that it would find in a perfect bake
    double mean_ratio; ///< of all light, as baked, over path-traced
    /// Texels of the largest connected part of a window whose error exceeds a twentieth: in means over three by three
    /// texels, and beyond what noise explains (three standard deviations).
    size_t blotch;
} cli_bake_judgement;

/// Collects values during a bake. @param values borrowed, zero but for the counts
rsv_bake_visitor cli_baked_values_visitor(cli_baked_values *values);

/// Path traces them.
/// @param paths of each value at random; those of windows get an eighth
rsv_status cli_judge_baked_values(const rsv_scene *scene, cli_baked_values *values, uint32_t paths,
    cli_bake_judgement *judgement);

void cli_baked_values_free(cli_baked_values *values);

#endif
