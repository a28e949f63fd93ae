/// @file daylight.h
/// Daylight at sensors, hour by hour. The coefficients of the sky's patches are computed once, and then applied to any
/// weather file.
///
/// 1. Give the scene the mean sky of a year as its environment (rsv_daylight_surround).
/// 2. Solve it (rsv_light_create), preferably with the sensors as its goal.
/// 3. Compute the sensors' coefficients (rsv_daylight_create).
/// 4. Evaluate any weather file (rsv_daylight_run).
///
/// The lamps of the scene are off. All illuminances are in lux, for a white sky.
#ifndef RESOLVENT_DAYLIGHT_H
#define RESOLVENT_DAYLIGHT_H

#include "resolvent/sky.h"
#include "resolvent/solve.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Options of daylight coefficients. Start from rsv_default_daylight_desc().
typedef struct rsv_daylight_desc {
    size_t size;          ///< sizeof this structure; rsv_default_daylight_desc() sets it
    double north;         ///< degrees from -z to north, clockwise seen from above; default 0
    float ground_albedo;  ///< of the ground outside the scene, below the horizon; default 0.2
    uint32_t subdivision; ///< of the sky's patches, default 4: 2305 patches
    uint32_t sensor_rays; ///< rays of each sensor
    uint32_t node_rays;   ///< rays of each element
    uint32_t seed;
} rsv_daylight_desc;

/// Writes defaults to a descriptor of `size` bytes. Usually called through rsv_default_daylight_desc().
RSV_API void rsv_daylight_desc_init(rsv_daylight_desc *desc, size_t size, rsv_quality quality);
static inline rsv_daylight_desc rsv_default_daylight_desc(rsv_quality quality)
{
    rsv_daylight_desc desc;
    rsv_daylight_desc_init(&desc, sizeof desc, quality);
    return desc;
}

/// Replaces the scene's environment by the mean sky of a weather file, including suns. Elements and errors follow from
/// it.
RSV_API rsv_status rsv_daylight_surround(
    rsv_scene *scene, const rsv_weather *weather, const rsv_daylight_desc *desc);

// ---- sensors --------------------------------------------------------------------------------------

/// Places sensors on regular grids above the floors. Floors are roofed surfaces that face up, at heights whose area is
/// at least a quarter of the largest. Sensors keep 0.3 m away from walls and furniture. Groups of up to three sensors
/// apart from the others but in sight of them, as in a doorway through a thick wall, are left out.
/// @param height of sensors above the floor, m
/// @param spacing m; increased if there would be more than 4000 sensors
/// @param sensors out: facing up; free it with rsv_daylight_free_sensors
RSV_API rsv_status rsv_daylight_sensors(
    const rsv_scene *scene, double height, double spacing, rsv_probe **sensors, size_t *count);
/// Groups sensors into rooms: neighbouring sensors are in one room if nothing is between them, and no passage narrower
/// than 1.2 m. Neighbours are closer than 1.45 times the median distance of sensors to their nearest. Narrow corridors
/// are rooms; sensors in a doorway join one of its rooms.
/// @param room out, [count]: 0, 1, ... in the order of the sensors
/// @param room_count out
RSV_API rsv_status rsv_daylight_rooms(const rsv_scene *scene, const rsv_probe *sensors,
    size_t count, uint32_t *room, size_t *room_count);
/// Whether the sensors of a room see the sky through horizontal panes, and at most 5 % of it another way. Horizontal:
/// within 15 degrees, as rooflights are. Openings without a pane count as vertical.
/// @param room [count] of each sensor, below room_count
/// @param rooflit out, [room_count]
RSV_API rsv_status rsv_daylight_rooflit(const rsv_scene *scene, const rsv_probe *sensors,
    size_t count, const uint32_t *room, size_t room_count, bool *rooflit);
RSV_API void rsv_daylight_free_sensors(const rsv_scene *scene, rsv_probe *sensors);

// ---- coefficients ---------------------------------------------------------------------------------

/// Daylight coefficients of sensors. Immutable, thread-safe.
typedef struct rsv_daylight rsv_daylight;

/// @param light of the scene. Its operator propagates the light of patches, its own light gives errors. It must outlive
/// the result
/// @param sensors [count], copied
/// @return RSV_ERROR_UNSUPPORTED for scenes with fog
RSV_API rsv_status rsv_daylight_create(const rsv_light *light, const rsv_probe *sensors,
    size_t count, const rsv_daylight_desc *desc, rsv_daylight **daylight);
RSV_API void rsv_daylight_destroy(rsv_daylight *daylight);

RSV_API size_t rsv_daylight_sensor_count(const rsv_daylight *daylight);
/// Whether a sensor sees mostly backs of walls, and is therefore inside something.
RSV_API bool rsv_daylight_is_buried(const rsv_daylight *daylight, size_t sensor);
/// Lux per cd/m2 of a patch, including all reflections.
RSV_API double rsv_daylight_coefficient(
    const rsv_daylight *daylight, size_t sensor, uint32_t patch);

// ---- a year ---------------------------------------------------------------------------------------

typedef struct rsv_figure {
    double value, standard_error;
} rsv_figure;

/// Figures of one sensor. Fractions refer to the occupied hours.
typedef enum rsv_sensor_figure {
    RSV_SENSOR_MEAN,              ///< lux, over all hours of the file
    RSV_SENSOR_OCCUPIED_MEAN,     ///< lux
    RSV_SENSOR_DA,                ///< daylight autonomy: fraction with at least 300 lux
    RSV_SENSOR_CDA,               ///< continuous: hours below 300 lux count in proportion
    RSV_SENSOR_UDI_BELOW,         ///< useful daylight illuminance: fraction below 100 lux
    RSV_SENSOR_UDI_SUPPLEMENTARY, ///< 100 to 300 lux
    RSV_SENSOR_UDI_AUTONOMOUS,    ///< 300 to 3000 lux
    RSV_SENSOR_UDI_EXCEEDED,      ///< above 3000 lux
    RSV_SENSOR_SUN_HOURS,         ///< hours with 1000 lux or more directly from the sun
    RSV_SENSOR_DAYLIGHT_FACTOR, ///< fraction of the outdoor illuminance under the traditional overcast sky
    RSV_SENSOR_MEDIAN, ///< lux exceeded in half of the hours with the sun above the horizon
    RSV_SENSOR_FIGURES
} rsv_sensor_figure;

/// Figures of all sensors together.
typedef enum rsv_space_figure {
    RSV_SPACE_MEAN, ///< lux, over all hours of the file
    RSV_SPACE_SDA,  ///< sDA 300/50 %: fraction of sensors with DA of at least 0.5
    RSV_SPACE_ASE,  ///< ASE 1000, 250: fraction of sensors with more than 250 hours of sun
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

/// The level of EN 17037's recommendation for daylight provision that is met, of spaces with vertical or inclined
/// openings (table A.1): 0 none, 1 minimum, 2 medium, 3 high.
RSV_API int rsv_daylight_class(double target, double minimum);
/// The same of spaces with horizontal openings only (table A.2): the target illuminance is required on 95 % of the
/// space, which is what RSV_SPACE_MINIMUM holds.
RSV_API int rsv_daylight_class_rooflit(double minimum);

/// Options of an evaluation. Start from rsv_default_daylight_run_desc().
typedef struct rsv_daylight_run_desc {
    size_t size;     ///< sizeof this structure; rsv_default_daylight_run_desc() sets it
    bool sky_only;   ///< ignore the sun
    double from, to; ///< occupied hours of every day, standard time; default 8 to 18
    float *hourly;   ///< out, [weather->count][sensor count] lux; NULL = not wanted
    /// Coefficients with the shades down, for the same sensors, patches and north; NULL = there are no shades. They are
    /// used, room by room, while with the shades up at least `shade_lux` (default 1000) would come directly from the
    /// sun on more than `shade_share` (0.02) of the room's sensors. Without `room`, all sensors are one room. Hours of
    /// sun and daylight factors are those without shades.
    const rsv_daylight *shaded;
    double shade_lux, shade_share;
    /// [sensor count] room of each sensor, below room_count, for figures by room; NULL = not wanted
    const uint32_t *room;
    size_t room_count;
} rsv_daylight_run_desc;

/// Writes defaults to a descriptor of `size` bytes. Usually called through rsv_default_daylight_run_desc().
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
        [RSV_SPACE_FIGURES]; ///< [room_count] the same for the sensors of each room; NULL = not wanted
    double hours, occupied_hours, daylight_hours; ///< in the file
    double shaded_hours;                          ///< with the shades down, mean of the sensors
    double *room_shaded_hours; ///< [room_count] of each room; NULL = no rooms or no shades
} rsv_daylight_report;

/// Evaluates a weather file. Standard errors come from independent randomisations (jackknife), and from the noise and
/// interpolation of stored light.
/// @param report out; free it with rsv_daylight_report_free

RSV_API rsv_status rsv_daylight_run(const rsv_daylight *daylight, const rsv_weather *weather,
    const rsv_daylight_run_desc *desc, rsv_daylight_report *report);
RSV_API void rsv_daylight_report_free(const rsv_daylight *daylight, rsv_daylight_report *report);

#ifdef __cplusplus
}
#endif

#endif
