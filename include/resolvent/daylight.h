/// @file daylight.h
/// Daylight at sensors, hour by hour. Coefficients of the sky's patches are computed once, and applied to any weather file.
///
/// Steps: surround a scene with the mean sky of a year (rsv_daylight_surround), solve it (rsv_light_create, preferably with
/// the sensors as its goal), compute the sensors' coefficients (rsv_daylight_create), then evaluate any weather file
/// (rsv_daylight_run). The lamps of the scene are off. All illuminances are in lux, for a white sky.
#ifndef RESOLVENT_DAYLIGHT_H
#define RESOLVENT_DAYLIGHT_H

#include "resolvent/sky.h"
#include "resolvent/solve.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Start from rsv_default_daylight_desc().
typedef struct rsv_daylight_desc {
    size_t size;  ///< of this structure; rsv_default_daylight_desc() sets it
    double north; ///< degrees by which north lies clockwise from -z, seen from above; default 0
    float ground_albedo;  ///< of what is below the horizon, outside the scene; default 0.2
    uint32_t subdivision; ///< of the sky's patches, default 4: 2305 of them
    uint32_t sensor_rays; ///< of each sensor
    uint32_t node_rays;   ///< of each element
    uint32_t seed;
} rsv_daylight_desc;

/// Defaults, for a descriptor of `size` bytes: what rsv_default_daylight_desc() is made of.
RSV_API void rsv_daylight_desc_init(rsv_daylight_desc *desc, size_t size, rsv_quality quality);
static inline rsv_daylight_desc rsv_default_daylight_desc(rsv_quality quality)
{
    rsv_daylight_desc desc;
    rsv_daylight_desc_init(&desc, sizeof desc, quality);
    return desc;
}

/// Replaces the scene's surroundings by the mean sky of a weather file, suns included: what elements and errors are judged by.
RSV_API rsv_status rsv_daylight_surround(
    rsv_scene *scene, const rsv_weather *weather, const rsv_daylight_desc *desc);

// ---- sensors --------------------------------------------------------------------------------------

/// Sensors on regular grids above the floors: surfaces that face up, roofed over, of those heights that have a quarter of the
/// area of the largest. None nearer to walls or furniture than 0.3 m.
/// @param height of sensors above the floor, m
/// @param spacing m; made wider where there would be more than 4000
/// @param sensors out: to be freed by rsv_daylight_free_sensors; facing up
RSV_API rsv_status rsv_daylight_sensors(
    const rsv_scene *scene, double height, double spacing, rsv_probe **sensors, size_t *count);
/// Tells rooms apart: sensors next to each other with nothing between them are in one. Next to each other means within 1.45
/// times the median distance of sensors to their nearest.
/// @param room out, [count]: 0, 1, ... in the order of the sensors @param room_count out
RSV_API rsv_status rsv_daylight_rooms(const rsv_scene *scene, const rsv_probe *sensors,
    size_t count, uint32_t *room, size_t *room_count);
RSV_API void rsv_daylight_free_sensors(const rsv_scene *scene, rsv_probe *sensors);

// ---- coefficients ---------------------------------------------------------------------------------

/// What sensors get from the sky: immutable, thread-safe.
typedef struct rsv_daylight rsv_daylight;

/// @param light of the scene; its operator carries the light on, its own light tells errors; must outlive the result
/// @param sensors [count], copied
/// RSV_ERROR_UNSUPPORTED for scenes with fog
RSV_API rsv_status rsv_daylight_create(const rsv_light *light, const rsv_probe *sensors,
    size_t count, const rsv_daylight_desc *desc, rsv_daylight **daylight);
RSV_API void rsv_daylight_destroy(rsv_daylight *daylight);

RSV_API size_t rsv_daylight_sensor_count(const rsv_daylight *daylight);
/// Whether most of what a sensor sees are backs of walls: it lies within something.
RSV_API bool rsv_daylight_is_buried(const rsv_daylight *daylight, size_t sensor);
/// Lux by cd/m2 of a patch, all reflections included.
RSV_API double rsv_daylight_coefficient(
    const rsv_daylight *daylight, size_t sensor, uint32_t patch);

// ---- a year ---------------------------------------------------------------------------------------

typedef struct rsv_figure {
    double value, standard_error;
} rsv_figure;

/// Figures of one sensor. Shares are of the occupied hours.
typedef enum rsv_sensor_figure {
    RSV_SENSOR_MEAN,          ///< lux, over all hours of the file
    RSV_SENSOR_OCCUPIED_MEAN, ///< lux
    RSV_SENSOR_DA,            ///< daylight autonomy: share of at least 300 lux
    RSV_SENSOR_CDA,       ///< continuous: hours below 300 lux count by as much of it as there is
    RSV_SENSOR_UDI_BELOW, ///< useful daylight illuminance: share below 100 lux
    RSV_SENSOR_UDI_SUPPLEMENTARY, ///< 100 to 300 lux
    RSV_SENSOR_UDI_AUTONOMOUS,    ///< 300 to 3000 lux
    RSV_SENSOR_UDI_EXCEEDED,      ///< above 3000 lux
    RSV_SENSOR_SUN_HOURS,         ///< hours with 1000 lux or more straight from the sun
    RSV_SENSOR_DAYLIGHT_FACTOR, ///< share of the illuminance outdoors under the traditional overcast sky
    RSV_SENSOR_MEDIAN, ///< lux that are exceeded in half of the hours with the sun above the horizon
    RSV_SENSOR_FIGURES
} rsv_sensor_figure;

/// Figures of all sensors together.
typedef enum rsv_space_figure {
    RSV_SPACE_MEAN, ///< lux, over all hours of the file
    RSV_SPACE_SDA,  ///< sDA 300/50 %: share of sensors with DA of at least 0.5
    RSV_SPACE_ASE,  ///< ASE 1000, 250: share of sensors with more than 250 hours of sun
    RSV_SPACE_DA,
    RSV_SPACE_CDA,
    RSV_SPACE_UDI_AUTONOMOUS,  ///< means over sensors
    RSV_SPACE_DAYLIGHT_FACTOR, ///< mean over sensors
    RSV_SPACE_MEDIAN_DAYLIGHT_FACTOR,
    RSV_SPACE_TARGET, ///< EN 17037: lux exceeded on half of the sensors in half of the daylight hours
    RSV_SPACE_MINIMUM, ///< EN 17037: the same on 95 % of the sensors
    RSV_SPACE_FIGURES
} rsv_space_figure;

typedef struct rsv_figure_facts {
    const char *name, *unit,
        *title; ///< "da", "1", "daylight autonomy, 300 lux"; unit "1", "lux" or "h"
} rsv_figure_facts;

RSV_API rsv_figure_facts rsv_sensor_figure_facts(rsv_sensor_figure figure);
RSV_API rsv_figure_facts rsv_space_figure_facts(rsv_space_figure figure);

/// EN 17037's recommendation for daylight provision that figures meet: 0 none, 1 minimum, 2 medium, 3 high.
RSV_API int rsv_daylight_class(double target, double minimum);

/// Start from rsv_default_daylight_run_desc().
typedef struct rsv_daylight_run_desc {
    size_t size;     ///< of this structure; rsv_default_daylight_run_desc() sets it
    bool sky_only;   ///< leave the sun out
    double from, to; ///< occupied hours of every day, standard time; default 8 to 18
    float *hourly;   ///< out, [weather->count][sensor count] lux; NULL = not wanted
    /// The same sensors, patches and north in the scene with its shades down, NULL = there are none: it counts while at least
    /// `shade_lux` (default 1000) come straight from the sun on `shade_share` (0.02) of the sensors, were the shades up.
    /// Hours of sun and daylight factors are those of shades that stay up.
    const rsv_daylight *shaded;
    double shade_lux, shade_share;
    /// [sensor count] room of each sensor, below room_count, for figures room by room; NULL = not wanted
    const uint32_t *room;
    size_t room_count;
} rsv_daylight_run_desc;

/// Defaults, for a descriptor of `size` bytes: what rsv_default_daylight_run_desc() is made of.
RSV_API void rsv_daylight_run_desc_init(rsv_daylight_run_desc *desc, size_t size);
static inline rsv_daylight_run_desc rsv_default_daylight_run_desc(void)
{
    rsv_daylight_run_desc desc;
    rsv_daylight_run_desc_init(&desc, sizeof desc);
    return desc;
}

typedef struct rsv_daylight_report {
    size_t sensor_count;
    rsv_figure (*sensor)[RSV_SENSOR_FIGURES]; ///< [sensor_count]
    rsv_figure space[RSV_SPACE_FIGURES];
    rsv_figure (*room)
        [RSV_SPACE_FIGURES]; ///< [room_count] the same of the sensors in each room; NULL = not wanted
    double hours, occupied_hours, daylight_hours; ///< in the file
    double shaded_hours;                          ///< with the shades down
} rsv_daylight_report;

/// Standard errors come from independent randomisations (jackknife), and from the noise and interpolation of stored light.
/// @param report to be freed by rsv_daylight_report_free
RSV_API rsv_status rsv_daylight_run(const rsv_daylight *daylight, const rsv_weather *weather,
    const rsv_daylight_run_desc *desc, rsv_daylight_report *report);
RSV_API void rsv_daylight_report_free(const rsv_daylight *daylight, rsv_daylight_report *report);

#ifdef __cplusplus
}
#endif

#endif
