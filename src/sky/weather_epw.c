/// EnergyPlus weather: eight lines of header, then one line per interval with 35 columns, of which a few matter here.
#include "weather_text.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { header_lines = 8, date_columns = 5 };

/// Where values stand, counted from the one behind the column of flags.
enum { dew_point = 1, global_horizontal = 7, direct_normal = 8, diffuse_horizontal = 9 };

/// The cell with that number of a line, to its comma; NULL = there are fewer.
static char *cell_of(char *line, int index)
{
    for (; index > 0 && line; index--) {
        line = strchr(line, ',');
        if (line) line++;
    }
    return line;
}

static rsv_status read_location(rsv_weather_text *text)
{
    static const char *const wrong = "LOCATION: latitude, longitude, time zone and elevation are "
                                     "expected as the columns 7 to 10";
    rsv_weather *w = text->weather;
    char *name = cell_of(text->line, 1), *cursor = cell_of(text->line, 6);
    double *const value[] = { &w->site.latitude, &w->site.longitude, &w->site.time_zone,
        &w->site.elevation };
    if (!name || !cursor) return rsv_weather_complain(text, wrong);
    snprintf(w->name, sizeof w->name, "%.*s", (int)strcspn(name, ","), name);
    for (int k = 0; k < 4; k++)
        if (!rsv_weather_number(&cursor, ',', value[k])) return rsv_weather_complain(text, wrong);
    return rsv_weather_check_site(text);
}

/// Intervals per hour, of the line DATA PERIODS.
static rsv_status read_periods(rsv_weather_text *text, double *per_hour)
{
    char *cursor = cell_of(text->line, 2);
    if (!cursor || !rsv_weather_number(&cursor, ',', per_hour) ||
        !(*per_hour >= 1 && *per_hour <= 60))
        return rsv_weather_complain(
            text, "DATA PERIODS: records per hour, 1 to 60, are expected as the third column");
    return RSV_OK;
}

static rsv_status read_header(rsv_weather_text *text, double *per_hour)
{
    bool located = false;
    *per_hour = 1;
    for (int k = 0; k < header_lines; k++) {
        rsv_status status = RSV_OK;
        if (k > 0 && !rsv_weather_next_line(text))
            return rsv_weather_complain(text, "the file ends in its header of eight lines");
        if (strncmp(text->line, "LOCATION,", 9) == 0) status = read_location(text), located = true;
        if (strncmp(text->line, "DATA PERIODS,", 13) == 0) status = read_periods(text, per_hour);
        if (status != RSV_OK) return status;
    }
    return located ? RSV_OK : rsv_weather_complain(text, "the header has no line LOCATION");
}

/// Irradiances from 9999 on and below 0 are missing. Instruments may show a little less than none at night.
static double irradiance_of(double value)
{
    if (value < 0 && value > -20) return 0;
    return value >= 0 && value < 2000 ? value : NAN;
}

/// The date, and in which interval of its hour this is.
static rsv_status read_date(rsv_weather_text *text, char **cursor, int date[4])
{
    double value[date_columns];
    for (int k = 0; k < date_columns; k++)
        if (!rsv_weather_number(cursor, ',', &value[k]))
            return rsv_weather_complain(
                text, "year, month, day, hour and minute are expected as the first columns");
    for (int k = 0; k < 4; k++)
        date[k] = fabs(value[k]) < 1e4 ? (int)value[k] : -1;
    return date[3] >= 0 && date[3] <= 24
               ? RSV_OK
               : rsv_weather_complain(text, "the hour is not within 1 to 24");
}

/// Intervals are identified by their order within the hour, because files disagree on whether minutes give the start or
/// the end.
static double middle_of(
    const rsv_weather_text *text, const int date[4], double per_hour, int *in_hour)
{
    const rsv_weather *w = text->weather;
    const rsv_moment *last = w->count ? &w->hour[w->count - 1].moment : NULL;
    bool again =
        last && last->month == date[1] && last->day == date[2] && (int)last->hour == date[3] - 1;
    *in_hour = again ? *in_hour + 1 : 0;
    if (date[3] == 0) return 0.5 / per_hour; // some count hours from 0 on
    return date[3] - 1 + fmin(*in_hour + 0.5, per_hour - 0.5) / per_hour;
}

/// One of the values behind the flags; an empty cell is a missing one.
static rsv_status read_cell(const rsv_weather_text *text, int index, double *value)
{
    char *cell = cell_of(text->line, date_columns + 1 + index);
    *value = NAN;
    if (cell) cell += strspn(cell, " \t");
    if (cell && (*cell == ',' || *cell == '\0')) return RSV_OK;
    if (cell && rsv_weather_number(&cell, ',', value)) return RSV_OK;
    return rsv_weather_complain(text, "16 columns are expected, with numbers as dew point and as "
                                      "global, direct normal and diffuse horizontal irradiance");
}

static rsv_status read_record(rsv_weather_text *text, double per_hour, int *in_hour)
{
    int date[4] = { 0 };
    double dew, global, direct, diffuse;
    char *cursor = text->line;
    rsv_status status;
    RSV_TRY(read_date(text, &cursor, date));
    RSV_TRY(read_cell(text, dew_point, &dew));
    RSV_TRY(read_cell(text, global_horizontal, &global));
    RSV_TRY(read_cell(text, direct_normal, &direct));
    RSV_TRY(read_cell(text, diffuse_horizontal, &diffuse));
    rsv_weather_hour hour = { .moment = { date[0], date[1], date[2], 0 },
        .hours = 1 / per_hour,
        .record = { irradiance_of(direct), irradiance_of(diffuse), fabs(dew) < 80 ? dew : NAN, 0 },
        .direct_illuminance = irradiance_of(global), // for the time being
        .diffuse_illuminance = NAN };
    hour.moment.hour = middle_of(text, date, per_hour, in_hour);
    status = rsv_weather_append(text, &hour);
cleanup:
    return status;
}

/// One of the two irradiances, where the other and their sum on the ground are known.
static void complete_record(const rsv_weather *w, rsv_weather_hour *hour)
{
    double global = hour->direct_illuminance;
    rsv_irradiance_record *r = &hour->record;
    hour->direct_illuminance = NAN;
    if (!isfinite(global)) return;
    double up = sin(rsv_sun_position(&w->site, &hour->moment).elevation);
    if (global == 0 && !isfinite(r->diffuse_horizontal)) r->diffuse_horizontal = 0;
    if (global == 0 && !isfinite(r->direct_normal)) r->direct_normal = 0;
    if (!isfinite(r->diffuse_horizontal) && isfinite(r->direct_normal))
        r->diffuse_horizontal = fmax(global - r->direct_normal * fmax(up, 0), 0);
    if (!isfinite(r->direct_normal) && isfinite(r->diffuse_horizontal) && up > 0.02)
        r->direct_normal = fmin(fmax(global - r->diffuse_horizontal, 0) / up, 1400);
}

/// Luminous efficacies were fitted to dew points of three hours' means: of a record and those of the two hours before.
static void average_dew_points(rsv_weather *w, double per_hour)
{
    size_t reach = (size_t)(3 * per_hour);
    for (size_t k = w->count; k-- > 0;) {
        double sum = 0, count = 0;
        for (size_t j = k; j + reach > k && j < w->count; j--) {
            double dew = w->hour[j].record.dew_point;
            if (isfinite(dew)) sum += dew, count++;
        }
        w->hour[k].record.dew_point = count > 0 ? sum / count : NAN;
    }
}

rsv_status rsv_weather_read_epw(rsv_weather_text *text)
{
    double per_hour;
    int in_hour = 0;
    rsv_status status = read_header(text, &per_hour);
    while (status == RSV_OK && rsv_weather_next_line(text))
        if (text->line[0]) status = read_record(text, per_hour, &in_hour);
    for (size_t k = 0; status == RSV_OK && k < text->weather->count; k++)
        complete_record(text->weather, &text->weather->hour[k]);
    if (status == RSV_OK) average_dew_points(text->weather, per_hour);
    return status;
}
