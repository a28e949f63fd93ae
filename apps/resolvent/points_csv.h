/// Probe points from, and readings to, comma-separated text.
#ifndef CLI_POINTS_CSV_H
#define CLI_POINTS_CSV_H

#include "resolvent/render.h"

/// Columns that give the light wanted at a point.
typedef enum cli_wanted {
    CLI_WANTED_LUX,
    CLI_WANTED_R,
    CLI_WANTED_G,
    CLI_WANTED_B,
    CLI_WANTED_WEIGHT,
    CLI_WANTED_COLUMNS
} cli_wanted;

/// The points of a file, as probes and with the digits they came in.
typedef struct cli_points {
    rsv_probe *probe;   ///< [count]
    double (*given)[6]; ///< [count] x, y, z, nx, ny, nz
    size_t count, capacity;
    double (*wanted)[CLI_WANTED_COLUMNS]; ///< [count] of the columns that there are
    bool has[CLI_WANTED_COLUMNS];
    bool needs_wanted; ///< set before reading: whether invalid values in those columns are errors
} cli_points;

/// Reads lines of x,y,z,nx,ny,nz. A first line of names may order the columns differently and name
/// others, which are skipped; empty lines and lines that start with '#' are skipped. Says on standard
/// error which line is wrong, and why. Of other columns, those of cli_wanted are kept: lux, r, g, b, weight.
bool cli_read_points(const char *path, cli_points *points);
void cli_free_points(cli_points *points);

/// Lays grids of points above the floors of a scene (rsv_daylight_sensors), in place of a file's. @param points zero
rsv_status cli_lay_grids(const rsv_scene *scene, double height, double spacing, cli_points *points);

/// Makes probes of points of the scene's file: less the origin that was taken out of the scene.
void cli_place_points(const cli_points *points, const rsv_scene *scene);

/// Writes the points with r,g,b,err_r,err_g,err_b. Prints errors on standard error.
bool cli_write_readings(
    const char *path, const cli_points *points, const rsv_probe_reading *readings);

#endif
