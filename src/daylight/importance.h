/// Effect of light at elements on sensors, and so of each patch of the sky through them.
#ifndef RSV_DAYLIGHT_IMPORTANCE_H
#define RSV_DAYLIGHT_IMPORTANCE_H

#include "node_escapes.h"
#include "sensor_rays.h"

#define RSV_SENSOR_BLOCK 16 ///< sensors whose adjoint is solved at once

/// Of some sensors.
typedef struct rsv_importance {
    size_t fields;   ///< sensors
    rsv_rgb *weight; ///< [fields][node_count] w, as sensors' rays left it
    rsv_rgb *source; ///< [node_count][fields] the same, of irradiance that enters
    rsv_rgb *worth;  ///< [node_count][fields] z
} rsv_importance;

rsv_status rsv_importance_create(
    const rsv_daylight *daylight, size_t fields, rsv_importance *importance);
void rsv_importance_destroy(const rsv_daylight *daylight, rsv_importance *importance);

/// From `weight` to `worth`. @param map of the operator, transposed, for that many fields
rsv_status rsv_importance_solve(
    const rsv_daylight *daylight, rsv_transport_map *map, rsv_importance *importance);

/// Adds light that reaches a sensor from surfaces. @param field index of the sensor @param share [patches.count]
/// columns of groups
void rsv_importance_add(const rsv_importance *importance, const rsv_node_escapes *escapes,
    size_t field, const rsv_sensor_rays *rays, rsv_patch_share *share);

#endif
