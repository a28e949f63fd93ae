/// Rays of a sensor: the sky that it sees, and the surfaces whose light it gathers.
#ifndef RSV_SENSOR_RAYS_H
#define RSV_SENSOR_RAYS_H

#include "../render/stored_noise.h"
#include "daylight.h"

/// Results of the rays of one sensor.
typedef struct rsv_sensor_rays {
    rsv_patch_share *straight, *bent; ///< [patches.count] the groups' columns; zero before
    rsv_rgb *weight;                  ///< [node_count] w before rsv_goal_enter; zero before
    /// Light from surfaces under the sky that defines errors: of each group, divided by the mean of all; 1 if there is
    /// none
    double reflected[RSV_DAYLIGHT_GROUPS];
    double stored_error; ///< relative error of light from surfaces
    bool buried;
} rsv_sensor_rays;

void rsv_sensor_rays_trace(const rsv_daylight *daylight, const rsv_stored_noise *noise,
    size_t sensor, rsv_sensor_rays *rays);

/// A sensor as rays leave it.
typedef struct rsv_sensor_place {
    rsv_vec3 origin, normal;
    rsv_medium medium;
} rsv_sensor_place;

rsv_sensor_place rsv_sensor_place_of(const rsv_daylight *daylight, size_t sensor);

/// Share of the sun's light that reaches a sensor straight, by luminance: 0 where anything is in its way that is not
/// clear.
/// @param direction unit, to the sun, in the scene
double rsv_sun_passed(
    const rsv_daylight *daylight, const rsv_sensor_place *place, rsv_vec3 direction);

#endif
