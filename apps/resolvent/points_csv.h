/// Probe points from, and readings to, comma-separated text.
#ifndef CLI_POINTS_CSV_H
#define CLI_POINTS_CSV_H

#include "resolvent/render.h"

/// The points of a file, as probes and with the digits they came in.
typedef struct cli_points {
    rsv_probe *probe;   ///< [count]
    double (*given)[6]; ///< [count] x, y, z, nx, ny, nz
    size_t count, capacity;
} cli_points;

/// Reads lines of x,y,z,nx,ny,nz. A first line of names may order the columns differently and name
/// others, which are skipped; empty lines and lines that start with '#' are skipped. Says on standard
/// error which line is wrong, and why.
bool cli_read_points(const char *path, cli_points *points);
void cli_free_points(cli_points *points);

/// Makes probes of points of the scene's file: less the origin that was taken out of the scene.
void cli_place_points(const cli_points *points, const rsv_scene *scene);

/// Writes the points with r,g,b,err_r,err_g,err_b. Says what went wrong on standard error.
bool cli_write_readings(
    const char *path, const cli_points *points, const rsv_probe_reading *readings);

#endif
