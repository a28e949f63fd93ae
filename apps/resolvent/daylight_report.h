/// Output of `resolvent daylight`: CSV, JSON, the hourly values of all sensors, and a page (daylight_page.h).
#ifndef CLI_DAYLIGHT_REPORT_H
#define CLI_DAYLIGHT_REPORT_H

#include "points_csv.h"

#include "resolvent/daylight.h"

typedef struct cli_daylight_result {
    const char *scene, *weather_path;
    const cli_points *points; ///< the sensors
    const rsv_weather *weather;
    const rsv_daylight_desc *desc;
    const rsv_daylight_run_desc *run;
    const rsv_daylight_report *report;
    const float *hourly; ///< [weather->count][points->count] lux; NULL = not kept
    size_t buried;       ///< sensors that lie within something
    const bool *rooflit; ///< [run->room_count] rooms with horizontal openings only
} cli_daylight_result;

/// Writes one line per sensor: position, normal, each figure with its standard error. Like the functions below, it
/// prints errors on standard error.
bool cli_write_daylight_csv(const char *path, const cli_daylight_result *result);
/// Figures of the space and of each sensor.
bool cli_write_daylight_json(const char *path, const cli_daylight_result *result);
/// One line per record of the weather file: month, day, hour, and the lux of each sensor.
bool cli_write_daylight_hours(const char *path, const cli_daylight_result *result);

/// "minimum", ... of the recommendation that the space meets.
/// @param figures [RSV_SPACE_FIGURES] of the space or of a room @param rooflit by horizontal openings only
const char *cli_daylight_class_name(const rsv_figure *figures, bool rooflit);
/// Whether all rooms have horizontal openings only.
bool cli_daylight_is_rooflit(const bool *rooflit, size_t room_count);

#endif
