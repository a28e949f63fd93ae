#include "points_csv.h"

#include "output_file.h"
#include "session.h"

#include "resolvent/daylight.h"

#include <errno.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { value_count = 6, column_limit = 64 };

static const char *const value_names[value_count] = { "x", "y", "z", "nx", "ny", "nz" };
static const char *const wanted_names[CLI_WANTED_COLUMNS] = { "lux", "r", "g", "b", "weight" };

/// Where a line comes from, for messages.
typedef struct csv_line {
    const char *path;
    size_t number;
    char *text; ///< cut at the line's end; cells are cut out of it
} csv_line;

/// Which column holds which value.
typedef struct csv_columns {
    size_t of_value[value_count];
    size_t of_wanted[CLI_WANTED_COLUMNS]; ///< where there is such a column
    size_t count;
    bool named; ///< by a header: further columns are allowed
} csv_columns;

static bool complain(const csv_line *line, const char *problem, const char *detail)
{
    cli_error("%s:%zu: %s%s", line->path, line->number, problem, detail);
    return false;
}

static char *trim(char *text)
{
    text += strspn(text, " \t");
    size_t length = strlen(text);
    while (length > 0 && strchr(" \t\r", text[length - 1]))
        text[--length] = '\0';
    return text;
}

/// Cuts a line at its commas; returns the number of cells, at most column_limit.
static size_t split_cells(char *text, char *cells[column_limit])
{
    size_t count = 0;
    for (char *rest = text; rest && count < column_limit; count++)
        cells[count] = trim(strsep(&rest, ","));
    return count;
}

/// Finite and within float's range. The program never calls setlocale, so the decimal separator is a
/// point everywhere.
static bool read_value(const char *cell, double *value)
{
    char *end;
    *value = strtod(cell, &end);
    return end != cell && *end == '\0' && fabs(*value) <= FLT_MAX;
}

static bool is_header(char *const cells[], size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (cells[i][0] && strcmp(cells[i], "x") == 0) return true;
    return false;
}

static bool read_header(const csv_line *line, char *const cells[], size_t count,
    csv_columns *columns, cli_points *points)
{
    for (size_t wanted = 0; wanted < CLI_WANTED_COLUMNS; wanted++)
        for (size_t i = 0; i < count; i++) {
            if (strcmp(cells[i], wanted_names[wanted]) != 0) continue;
            columns->of_wanted[wanted] = i;
            points->has[wanted] = true;
        }
    columns->named = true;
    columns->count = count;
    for (size_t value = 0; value < value_count; value++) {
        size_t i = 0;
        while (i < count && strcmp(cells[i], value_names[value]) != 0)
            i++;
        if (i == count) return complain(line, "the header has no column ", value_names[value]);
        columns->of_value[value] = i;
    }
    return true;
}

static bool append_point(
    cli_points *points, const double given[value_count], const double wanted[CLI_WANTED_COLUMNS])
{
    if (points->count == points->capacity) {
        size_t capacity = points->capacity ? 2 * points->capacity : 1024;
        void *probe = realloc(points->probe, capacity * sizeof *points->probe);
        if (probe) points->probe = probe;
        void *values = realloc(points->given, capacity * sizeof *points->given);
        if (values) points->given = values;
        void *extra = realloc(points->wanted, capacity * sizeof *points->wanted);
        if (extra) points->wanted = extra;
        if (!probe || !values || !extra) return false;
        points->capacity = capacity;
    }
    points->probe[points->count] =
        (rsv_probe){ { (float)given[0], (float)given[1], (float)given[2] },
            { (float)given[3], (float)given[4], (float)given[5] } };
    memcpy(points->wanted[points->count], wanted, CLI_WANTED_COLUMNS * sizeof *wanted);
    memcpy(points->given[points->count++], given, value_count * sizeof *given);
    return true;
}

static bool read_point(const csv_line *line, char *const cells[], size_t count,
    const csv_columns *columns, cli_points *points)
{
    double given[value_count], wanted[CLI_WANTED_COLUMNS] = { 0 };
    if (count < columns->count || (count > columns->count && !columns->named)) {
        char detail[64];
        snprintf(detail, sizeof detail, "%zu columns, expected %zu", count, columns->count);
        return complain(line, detail, columns->named ? " as in the header" : " (x,y,z,nx,ny,nz)");
    }
    for (size_t value = 0; value < value_count; value++) {
        if (read_value(cells[columns->of_value[value]], &given[value])) continue;
        complain(line, value_names[value], " is not a finite number");
        return false;
    }
    for (size_t k = 0; k < CLI_WANTED_COLUMNS; k++) {
        if (!points->has[k] || read_value(cells[columns->of_wanted[k]], &wanted[k])) continue;
        if (!points->needs_wanted) continue;
        complain(line, wanted_names[k], " is not a finite number");
        return false;
    }
    // the length is taken in float, as the library will: it must neither vanish nor overflow there
    float nx = (float)given[3], ny = (float)given[4], nz = (float)given[5];
    float squared_length = nx * nx + ny * ny + nz * nz;
    if (!(squared_length >= FLT_MIN && squared_length <= FLT_MAX))
        return complain(line, "the normal nx,ny,nz has no usable length; ", "give a direction");
    return append_point(points, given, wanted) || complain(line, "out of memory", "");
}

static bool read_line(csv_line *line, csv_columns *columns, bool *first, cli_points *points)
{
    char *cells[column_limit];
    line->text = trim(line->text);
    if (line->text[0] == '\0' || line->text[0] == '#') return true;
    size_t count = split_cells(line->text, cells);
    bool header = *first && is_header(cells, count);
    *first = false;
    return header ? read_header(line, cells, count, columns, points)
                  : read_point(line, cells, count, columns, points);
}

/// The file with a closing zero; NULL after a message.
static char *read_text(const char *path, size_t *length)
{
    char *text = NULL;
    size_t capacity = 0;
    FILE *file = fopen(path, "rb");
    *length = 0;
    while (file && !ferror(file) && !feof(file)) {
        if (capacity - *length < 2) {
            capacity = capacity ? 2 * capacity : 1 << 16;
            char *grown = realloc(text, capacity);
            if (!grown) break;
            text = grown;
        }
        *length += fread(text + *length, 1, capacity - *length - 1, file);
    }
    bool complete = text && feof(file) && !ferror(file);
    if (!complete) cli_error("%s: cannot be read: %s", path, strerror(errno));
    if (file) fclose(file);
    if (complete) text[*length] = '\0';
    if (complete && memchr(text, '\0', *length)) {
        cli_error("%s: is not a text file", path);
        complete = false;
    }
    if (complete) return text;
    free(text);
    return NULL;
}

bool cli_read_points(const char *path, cli_points *points)
{
    size_t length;
    char *text = read_text(path, &length);
    if (!text) return false;
    static const char byte_order_mark[] = "\xef\xbb\xbf";
    char *rest = strncmp(text, byte_order_mark, 3) == 0 ? text + 3 : text;
    csv_line line = { .path = path };
    csv_columns columns = { .of_value = { 0, 1, 2, 3, 4, 5 }, .count = value_count };
    bool first = true, good = true;
    while (good && rest) {
        line.text = strsep(&rest, "\n");
        line.number++;
        good = read_line(&line, &columns, &first, points);
    }
    if (good && points->count == 0) {
        cli_error("%s: holds no points; each line is x,y,z,nx,ny,nz", path);
        good = false;
    }
    free(text);
    return good;
}

void cli_place_points(const cli_points *points, const rsv_scene *scene)
{
    const double *origin = rsv_scene_get_view(scene)->origin;
    for (size_t i = 0; i < points->count; i++) {
        const double *given = points->given[i];
        points->probe[i].position = (rsv_vec3){ (float)(given[0] - origin[0]),
            (float)(given[1] - origin[1]), (float)(given[2] - origin[2]) };
    }
}

rsv_status cli_lay_grids(const rsv_scene *scene, double height, double spacing, cli_points *points)
{
    size_t count = 0;
    rsv_probe *laid = NULL;
    rsv_status status = rsv_daylight_sensors(scene, height, spacing, &laid, &count);
    if (status != RSV_OK) return status;
    const double *origin = rsv_scene_get_view(scene)->origin;
    points->probe = calloc(count, sizeof *points->probe);
    points->given = calloc(count, sizeof *points->given);
    if (!points->probe || !points->given) status = RSV_ERROR_MEMORY;
    for (size_t k = 0; status == RSV_OK && k < count; k++) {
        const float *p = &laid[k].position.x;
        points->probe[k] = laid[k];
        for (int axis = 0; axis < 3; axis++)
            points->given[k][axis] = (double)p[axis] + origin[axis];
        points->given[k][4] = 1;
    }
    if (status == RSV_OK) points->count = count;
    rsv_daylight_free_sensors(scene, laid);
    return status;
}

void cli_free_points(cli_points *points)
{
    free(points->probe);
    free(points->given);
    free(points->wanted);
    *points = (cli_points){ 0 };
}

/// As many digits as a coordinate may have come with: far from the origin those behind the point count, too.
static int digits_of(double value) { return fabs(value) < 1e4 ? 9 : 15; }

bool cli_write_readings(
    const char *path, const cli_points *points, const rsv_probe_reading *readings)
{
    char *text = NULL;
    size_t length = 0;
    FILE *stream = open_memstream(&text, &length);
    if (stream) fputs("x,y,z,nx,ny,nz,r,g,b,err_r,err_g,err_b\n", stream);
    for (size_t i = 0; stream && i < points->count; i++) {
        const double *p = points->given[i];
        rsv_rgb e = readings[i].irradiance, d = readings[i].standard_error;
        fprintf(stream, "%.*g,%.*g,%.*g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n",
            digits_of(p[0]), p[0], digits_of(p[1]), p[1], digits_of(p[2]), p[2], p[3], p[4], p[5],
            e.r, e.g, e.b, d.r, d.g, d.b);
    }
    bool complete = stream && !ferror(stream);
    if (stream && fclose(stream) != 0) complete = false;
    if (!complete) cli_error("%s: out of memory writing the readings", path);
    bool written = complete && cli_write_file(path, text, length);
    free(text);
    return written;
}
