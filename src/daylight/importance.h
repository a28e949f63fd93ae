/// Effect of light at elements on sensors, and so of each patch of the sky through them.
#ifndef RSV_DAYLIGHT_IMPORTANCE_H
#define RSV_DAYLIGHT_IMPORTANCE_H

#include "node_escapes.h"
#include "sensor_rays.h"

#define RSV_SENSOR_FIELDS 16 ///< fields of the adjoint that are solved at once, one for each sensor
#define RSV_SENSOR_BLOCK                                                                           \
    (3 * RSV_SENSOR_FIELDS) ///< sensors at once if nothing has a colour: one for each channel

/// Of some sensors.
typedef struct rsv_importance {
    size_t sensors;
    size_t fields;   ///< as many, or a third: three sensors share a field, one in each channel
    rsv_rgb *weight; ///< [sensors][node_count] w, as sensors' rays left it
    rsv_rgb *source; ///< [node_count][fields] the same, of irradiance that enters
    rsv_rgb *worth;  ///< [node_count][fields] z
} rsv_importance;

rsv_status rsv_importance_create(
    const rsv_daylight *daylight, size_t sensors, rsv_importance *importance);
void rsv_importance_destroy(const rsv_daylight *daylight, rsv_importance *importance);

/// From `weight` to `worth`. @param map of the operator, transposed, for as many fields as sensors
/// @param gray rsv_operator_is_gray
rsv_status rsv_importance_solve(
    const rsv_daylight *daylight, rsv_transport_map *map, bool gray, rsv_importance *importance);

/// Adds light that reaches a sensor from surfaces. @param sensor index in the block @param share [patches.count]
/// columns of groups
void rsv_importance_add(const rsv_importance *importance, const rsv_node_escapes *escapes,
    size_t sensor, const rsv_sensor_rays *rays, rsv_patch_share *share);

#endif
