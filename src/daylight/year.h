/// The skies of a weather file, patch by patch.
#ifndef RSV_DAYLIGHT_YEAR_H
#define RSV_DAYLIGHT_YEAR_H

#include "sensor_rays.h"

#define RSV_SUN_SPREAD 24 ///< patches that the sun's reflected light is looked up in, at most

/// An interval with light.
typedef struct rsv_lit_hour {
    size_t index;  ///< in the weather file
    rsv_vec3 sun;  ///< direction in the scene
    double direct; ///< lux, on a plane that faces the sun; 0 = it is not up
    double hours;
    bool occupied, daylight; ///< daylight: the sun is above the horizon
    uint32_t spread_count;
    uint32_t spread_patch[RSV_SUN_SPREAD];
    float spread_luminance[RSV_SUN_SPREAD]; ///< cd/m2 that stand for the sun
} rsv_lit_hour;

typedef struct rsv_year {
    rsv_lit_hour *lit; ///< [lit_count]
    float *luminance;  ///< [lit_count][patches.count]
    size_t lit_count;
    size_t daylight_count; ///< intervals with the sun above the horizon, lit or not
    double hours, occupied_hours, daylight_hours; ///< all, lit or not
} rsv_year;

rsv_status rsv_year_create(const rsv_daylight *daylight, const rsv_weather *weather,
    const rsv_daylight_run_desc *desc, rsv_year *year);
void rsv_year_destroy(rsv_context *context, rsv_year *year);

/// Patches of which something reaches a sensor: scratch for [patches.count].
typedef struct rsv_seen_patches {
    uint32_t *patch;
    rsv_patch_share *share;
    size_t count;
} rsv_seen_patches;

/// Lux of a sensor at each lit hour: [lit_count][RSV_DAYLIGHT_COLUMNS], and straight from the sun: [lit_count].
void rsv_year_read_sensor(const rsv_daylight *daylight, const rsv_year *year, size_t sensor,
    rsv_seen_patches *seen, float (*reading)[RSV_DAYLIGHT_COLUMNS], float *sun);

/// Lux straight from the sun.
float rsv_year_sun_at(
    const rsv_daylight *daylight, const rsv_sensor_place *place, const rsv_lit_hour *hour);

#endif
