#include "daylight_report.h"

#include "output_file.h"
#include "session.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

const char *cli_daylight_class_name(const rsv_figure *figures, bool rooflit)
{
    static const char *const names[] = { "none", "minimum", "medium", "high" };
    double minimum = figures[RSV_SPACE_MINIMUM].value;
    return names[rooflit ? rsv_daylight_class_rooflit(minimum)
                         : rsv_daylight_class(figures[RSV_SPACE_TARGET].value, minimum)];
}

bool cli_daylight_is_rooflit(const bool *rooflit, size_t room_count)
{
    size_t count = 0;
    while (count < room_count && rooflit[count])
        count++;
    return room_count > 0 && count == room_count;
}

/// Text that grows in memory and is then written at once.
typedef struct text_file {
    FILE *stream;
    char *text;
    size_t length;
} text_file;

static bool write_text(text_file *file, const char *path)
{
    bool complete = file->stream && !ferror(file->stream);
    if (file->stream && fclose(file->stream) != 0) complete = false;
    if (!complete) cli_error("%s: out of memory writing the report", path);
    bool written = complete && cli_write_file(path, file->text, file->length);
    free(file->text);
    return written;
}

static void print_place(FILE *stream, const double p[6])
{
    for (int k = 0; k < 6; k++)
        fprintf(stream, "%s%.*g", k ? "," : "", k < 3 && fabs(p[k]) >= 1e4 ? 15 : 9, p[k]);
}

bool cli_write_daylight_csv(const char *path, const cli_daylight_result *r)
{
    text_file file = { 0 };
    file.stream = open_memstream(&file.text, &file.length);
    if (file.stream) fputs("x,y,z,nx,ny,nz", file.stream);
    for (int f = 0; file.stream && f < RSV_SENSOR_FIGURES; f++) {
        const char *name = rsv_sensor_figure_facts((rsv_sensor_figure)f).name;
        fprintf(file.stream, ",%s,err_%s", name, name);
    }
    for (size_t k = 0; file.stream && k < r->points->count; k++) {
        fputc('\n', file.stream);
        print_place(file.stream, r->points->given[k]);
        for (int f = 0; f < RSV_SENSOR_FIGURES; f++)
            fprintf(file.stream, ",%.6g,%.3g", r->report->sensor[k][f].value,
                r->report->sensor[k][f].standard_error);
    }
    if (file.stream) fputc('\n', file.stream);
    return write_text(&file, path);
}

bool cli_write_daylight_hours(const char *path, const cli_daylight_result *r)
{
    text_file file = { 0 };
    size_t sensors = r->points->count;
    file.stream = open_memstream(&file.text, &file.length);
    if (file.stream) fputs("month,day,hour", file.stream);
    for (size_t k = 0; file.stream && k < sensors; k++)
        fprintf(file.stream, ",p%zu", k);
    if (file.stream) fputc('\n', file.stream);
    for (size_t h = 0; file.stream && h < r->weather->count; h++) {
        const rsv_moment *m = &r->weather->hour[h].moment;
        fprintf(file.stream, "%d,%d,%.6g", m->month, m->day, m->hour);
        for (size_t k = 0; k < sensors; k++)
            fprintf(file.stream, ",%.5g", (double)r->hourly[h * sensors + k]);
        fputc('\n', file.stream);
    }
    return write_text(&file, path);
}

static void add_figure(cJSON *object, rsv_figure_facts facts, rsv_figure figure)
{
    cJSON *node = cJSON_AddObjectToObject(object, facts.name);
    cJSON_AddNumberToObject(node, "value", figure.value);
    cJSON_AddNumberToObject(node, "standard_error", figure.standard_error);
    cJSON_AddStringToObject(node, "unit", facts.unit);
}

static void add_settings(cJSON *root, const cli_daylight_result *r)
{
    cJSON_AddStringToObject(root, "version", rsv_version());
    cJSON_AddStringToObject(root, "scene", r->scene);
    cJSON_AddStringToObject(root, "weather", r->weather_path);
    cJSON_AddStringToObject(root, "place", r->weather->name);
    cJSON_AddNumberToObject(root, "latitude", r->weather->site.latitude);
    cJSON_AddNumberToObject(root, "longitude", r->weather->site.longitude);
    cJSON_AddNumberToObject(root, "north", r->desc->north);
    cJSON_AddNumberToObject(root, "ground_albedo", (double)r->desc->ground_albedo);
    cJSON_AddBoolToObject(root, "sky_only", r->run->sky_only);
    cJSON_AddNumberToObject(root, "occupied_from", r->run->from);
    cJSON_AddNumberToObject(root, "occupied_to", r->run->to);
    cJSON_AddNumberToObject(root, "hours", r->report->hours);
    cJSON_AddNumberToObject(root, "occupied_hours", r->report->occupied_hours);
    cJSON_AddNumberToObject(root, "daylight_hours", r->report->daylight_hours);
    cJSON_AddNumberToObject(root, "shaded_hours", r->run->shaded ? r->report->shaded_hours : NAN);
    cJSON_AddNumberToObject(root, "filled_records", (double)r->weather->filled);
    cJSON_AddNumberToObject(root, "missing_hours", (double)r->weather->missing);
    cJSON_AddNumberToObject(root, "buried_sensors", (double)r->buried);
}

static void add_space(cJSON *object, const rsv_figure *figures, bool rooflit)
{
    for (int f = 0; f < RSV_SPACE_FIGURES; f++)
        add_figure(object, rsv_space_figure_facts((rsv_space_figure)f), figures[f]);
    cJSON_AddStringToObject(object, "openings", rooflit ? "horizontal" : "vertical");
    cJSON_AddStringToObject(object, "en_17037", cli_daylight_class_name(figures, rooflit));
}

/// Which sensors a room has, and their figures.
static void add_rooms(cJSON *root, const cli_daylight_result *r)
{
    cJSON *rooms = cJSON_AddArrayToObject(root, "rooms");
    for (size_t k = 0; k < r->run->room_count; k++) {
        cJSON *room = cJSON_CreateObject();
        cJSON_AddItemToArray(rooms, room);
        cJSON *sensors = cJSON_AddArrayToObject(room, "sensors");
        for (size_t s = 0; s < r->points->count; s++)
            if (r->run->room[s] == k) cJSON_AddItemToArray(sensors, cJSON_CreateNumber((double)s));
        if (r->report->room_shaded_hours)
            cJSON_AddNumberToObject(room, "shaded_hours", r->report->room_shaded_hours[k]);
        add_space(room, r->report->room[k], r->rooflit[k]);
    }
}

bool cli_write_daylight_json(const char *path, const cli_daylight_result *r)
{
    cJSON *root = cJSON_CreateObject();
    add_settings(root, r);
    add_space(cJSON_AddObjectToObject(root, "space"), r->report->space,
        cli_daylight_is_rooflit(r->rooflit, r->run->room_count));
    add_rooms(root, r);
    cJSON *sensors = cJSON_AddArrayToObject(root, "sensors");
    for (size_t k = 0; k < r->points->count; k++) {
        cJSON *sensor = cJSON_CreateObject();
        cJSON_AddItemToArray(sensors, sensor);
        cJSON_AddItemToObject(sensor, "position", cJSON_CreateDoubleArray(r->points->given[k], 3));
        cJSON_AddItemToObject(
            sensor, "normal", cJSON_CreateDoubleArray(r->points->given[k] + 3, 3));
        for (int f = 0; f < RSV_SENSOR_FIGURES; f++)
            add_figure(
                sensor, rsv_sensor_figure_facts((rsv_sensor_figure)f), r->report->sensor[k][f]);
    }
    bool written = root && cli_write_json(path, root);
    cJSON_Delete(root);
    return written;
}
