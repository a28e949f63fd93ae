/// Daysim's weather: six lines of header, then month, day, hour of the middle, and two values.
#include "weather_text.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/// A header keyword and the factor of its number: longitudes and meridians are positive westwards in this format.
typedef struct header_word {
    const char *word;
    double factor;
} header_word;

enum { word_latitude, word_longitude, word_time_zone, word_elevation, word_units, word_count };
static const header_word words[word_count] = { { "latitude", 1 }, { "longitude", -1 },
    { "time_zone", -1.0 / 15 }, { "site_elevation", 1 }, { "weather_data_file_units", 1 } };

enum { units_normal = 1, units_illuminance = 2, units_horizontal = 3 };

/// @return whether the line belongs to the header
static bool read_header_line(
    rsv_weather_text *text, double value[word_count], bool known[word_count])
{
    for (int k = 0; k < word_count; k++) {
        size_t length = strlen(words[k].word);
        if (strncmp(text->line, words[k].word, length) != 0) continue;
        char *cursor = text->line + length;
        known[k] = rsv_weather_number(&cursor, ' ', &value[k]);
        value[k] *= words[k].factor;
        return true;
    }
    return strncmp(text->line, "place", 5) == 0;
}

static rsv_status take_header(
    rsv_weather_text *text, const double value[word_count], const bool known[word_count])
{
    char what[96];
    for (int k = 0; k < word_count; k++) {
        if (known[k] || k == word_elevation) continue;
        snprintf(what, sizeof what, "the header has no line %s with a number", words[k].word);
        return rsv_weather_complain(text, what);
    }
    if (value[word_units] < units_normal || value[word_units] > units_horizontal)
        return rsv_weather_complain(text, "weather_data_file_units is not 1, 2 or 3");
    rsv_site *site = &text->weather->site;
    *site = (rsv_site){ value[word_latitude], value[word_longitude], value[word_time_zone],
        known[word_elevation] ? value[word_elevation] : 0 };
    return rsv_weather_check_site(text);
}

/// @param most beyond which a value is none
static double value_within(double value, double most)
{
    if (value < 0 && value > -20) return 0;
    return value >= 0 && value < most ? value : NAN;
}

static rsv_status read_record(rsv_weather_text *text, int units)
{
    double v[5];
    char *cursor = text->line;
    for (int k = 0; k < 5; k++)
        if (!rsv_weather_number(&cursor, ' ', &v[k]))
            return rsv_weather_complain(
                text, "month, day, hour, direct and diffuse light are expected");
    if (!(v[2] >= 0 && v[2] <= 24))
        return rsv_weather_complain(text, "the hour is not within 0 to 24");
    int month = fabs(v[0]) < 1e3 ? (int)v[0] : 0, day = fabs(v[1]) < 1e3 ? (int)v[1] : 0;
    rsv_weather_hour hour = { .moment = { 2001, month, day, v[2] },
        .hours = 1,
        .record = { NAN, NAN, NAN, 0 },
        .direct_illuminance = NAN,
        .diffuse_illuminance = NAN };
    if (month == 2 && day == 29) hour.moment.year = 2000;
    if (units == units_illuminance) {
        hour.direct_illuminance = value_within(v[3], 3e5);
        hour.diffuse_illuminance = value_within(v[4], 3e5);
        if (isfinite(hour.direct_illuminance + hour.diffuse_illuminance))
            hour.record.direct_normal = hour.record.diffuse_horizontal = 0;
        return rsv_weather_append(text, &hour);
    }
    hour.record.direct_normal = value_within(v[3], 2000);
    hour.record.diffuse_horizontal = value_within(v[4], 2000);
    if (units == units_horizontal) {
        double up = sin(rsv_sun_position(&text->weather->site, &hour.moment).elevation);
        hour.record.direct_normal = up > 0.02 ? fmin(hour.record.direct_normal / up, 1400) : 0;
    }
    return rsv_weather_append(text, &hour);
}

/// The files say nothing of it: the commonest distance between records of one day.
static void find_intervals(rsv_weather *w)
{
    double least = 1;
    for (size_t k = 1; k < w->count; k++) {
        double step = w->hour[k].moment.hour - w->hour[k - 1].moment.hour;
        if (step > 1.0 / 61 && step < least) least = step;
    }
    for (size_t k = 0; k < w->count; k++)
        w->hour[k].hours = 1 / round(1 / least);
}

rsv_status rsv_weather_read_wea(rsv_weather_text *text)
{
    double value[word_count] = { 0 };
    bool known[word_count] = { 0 }, more = true;
    char *name = text->line + strcspn(text->line, " \t");
    snprintf(text->weather->name, sizeof text->weather->name, "%s", name + strspn(name, " \t"));
    while (more && read_header_line(text, value, known))
        more = rsv_weather_next_line(text);
    rsv_status status = take_header(text, value, known);
    for (; status == RSV_OK && more; more = rsv_weather_next_line(text))
        if (text->line[0]) status = read_record(text, (int)value[word_units]);
    find_intervals(text->weather);
    return status;
}
