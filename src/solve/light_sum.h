/// A weighted sum of irradiance at many points, of any of the lights that share an operator: places are found
/// once. Set `added` to 0 to begin anew.
#ifndef RSV_LIGHT_SUM_H
#define RSV_LIGHT_SUM_H

#include "light.h"

/// Levels of elements: those of the operator, of caustics and of fine direct light.
#define RSV_LIGHT_LEVELS 3

typedef struct rsv_light_sum_term {
    uint32_t node;
    rsv_rgb weight;
} rsv_light_sum_term;

typedef struct rsv_light_sum {
    rsv_light_sum_term *term[RSV_LIGHT_LEVELS]; ///< [3 * points]
    size_t added;                               ///< terms of each level before rsv_light_sum_close
    size_t count[RSV_LIGHT_LEVELS];             ///< after it
} rsv_light_sum;

/// @param points that are added at most
rsv_status rsv_light_sum_create(rsv_context *context, size_t points, rsv_light_sum *sum);
void rsv_light_sum_destroy(rsv_context *context, rsv_light_sum *sum);

/// Adds irradiance at a point, as rsv_light_view_irradiance of all orders. @param light any of them
void rsv_light_sum_add(rsv_light_sum *sum, const rsv_light_view *light,
    const rsv_triangle_point *point, rsv_rgb weight);

/// Adds up terms of the same node, in the order of nodes. Call it after the last point.
void rsv_light_sum_close(rsv_light_sum *sum, const rsv_light_view *light);

/// The sum, of one light.
rsv_rgb rsv_light_sum_of(const rsv_light_sum *sum, const rsv_light_view *light);

#endif
