#include "../core/number_text.h"
#include "../core/text_file.h"
#include "weather_text.h"

#include <math.h>
#include <string.h>

#define MOST_BYTES ((size_t)1 << 28)
#define MOST_RECORDS ((size_t)366 * 24 * 60)

bool rsv_weather_next_line(rsv_weather_text *t)
{
    if (!t->rest || !*t->rest) return false;
    t->line = strsep(&t->rest, "\n");
    t->number++;
    size_t length = strlen(t->line);
    while (length > 0 && strchr(" \t\r", t->line[length - 1]))
        t->line[--length] = '\0';
    t->line += strspn(t->line, " \t");
    return true;
}

rsv_status rsv_weather_complain(const rsv_weather_text *t, const char *what)
{
    return rsv_fail(RSV_ERROR_FORMAT, "%s:%zu: %s", t->path, t->number, what);
}

bool rsv_weather_number(char **cursor, char separator, double *value)
{
    char *end = NULL;
    *value = rsv_number_value(*cursor, &end);
    if (end == *cursor || !isfinite(*value)) return false;
    end += strspn(end, " \t");
    if (*end && *end != separator && separator == ',') return false;
    *cursor = *end == ',' ? end + 1 : end;
    return true;
}

rsv_status rsv_weather_check_site(const rsv_weather_text *t)
{
    const rsv_site *s = &t->weather->site;
    if (fabs(s->latitude) > 90)
        return rsv_weather_complain(t, "the latitude is not within -90 to 90 degrees");
    if (fabs(s->longitude) > 360)
        return rsv_weather_complain(t, "the longitude is not within -360 to 360 degrees");
    if (fabs(s->time_zone) > 14.5)
        return rsv_weather_complain(t, "the time zone is not within -14 to 14 hours");
    if (!(fabs(s->elevation) < 1e4))
        return rsv_weather_complain(t, "the elevation is not within 10 km");
    return RSV_OK;
}

static int days_in_month(int month)
{
    return month == 2 ? 29 : month == 4 || month == 6 || month == 9 || month == 11 ? 30 : 31;
}

rsv_status rsv_weather_append(rsv_weather_text *t, const rsv_weather_hour *hour)
{
    rsv_weather *w = t->weather;
    rsv_moment m = hour->moment;
    if (m.month < 1 || m.month > 12 || m.day < 1 || m.day > days_in_month(m.month))
        return rsv_weather_complain(t, "there is no such date");
    if (w->count >= MOST_RECORDS)
        return rsv_weather_complain(t, "more records than a year has minutes");
    rsv_status status =
        rsv_grow(t->context, (void **)&w->hour, &t->capacity, w->count + 1, sizeof *w->hour);
    if (status != RSV_OK) return status;
    if (m.year < 1900 || m.year > 2200) m.year = 2001; // some write 0
    // a typical year's 29 February stands for that of a leap year
    if (m.month == 2 && m.day == 29 && !rsv_is_leap_year(m.year)) m.year = 2000;
    if (m.month == 2 && m.day == 29) w->leap = true;
    w->hour[w->count] = *hour;
    w->hour[w->count].moment = m;
    w->hour[w->count++].record.day_of_year = rsv_day_of_year(m.year, m.month, m.day);
    return RSV_OK;
}

static bool is_known(const rsv_weather_hour *h)
{
    return isfinite(h->record.direct_normal) && isfinite(h->record.diffuse_horizontal);
}

/// The record nearest in time that is known and of the same hour of the day.
static const rsv_weather_hour *nearest_like(const rsv_weather *w, size_t k)
{
    for (size_t distance = 1; distance < w->count; distance++) {
        for (int way = 0; way < 2; way++) {
            size_t other = way ? k + distance : k - distance;
            if (way ? other >= w->count : distance > k) continue;
            bool alike = fabs(w->hour[other].moment.hour - w->hour[k].moment.hour) < 1e-3;
            if (alike && is_known(&w->hour[other])) return &w->hour[other];
        }
    }
    return NULL;
}

/// Marks gaps first, so that none is filled from a filled one.
static rsv_status fill_gaps(rsv_weather_text *t)
{
    rsv_weather *w = t->weather;
    for (size_t k = 0; k < w->count; k++)
        w->filled += w->hour[k].filled = !is_known(&w->hour[k]);
    if (w->filled == w->count)
        return rsv_fail(RSV_ERROR_FORMAT,
            "%s: no record has direct normal and diffuse horizontal light", t->path);
    for (size_t k = 0; w->filled && k < w->count; k++) {
        if (!w->hour[k].filled) continue;
        const rsv_weather_hour *like = NULL;
        if (is_known(&w->hour[k])) continue;
        like = nearest_like(w, k);
        rsv_irradiance_record *r = &w->hour[k].record;
        r->direct_normal = like ? like->record.direct_normal : 0;
        r->diffuse_horizontal = like ? like->record.diffuse_horizontal : 0;
        w->hour[k].direct_illuminance = like ? like->direct_illuminance : NAN;
        w->hour[k].diffuse_illuminance = like ? like->diffuse_illuminance : NAN;
    }
    return RSV_OK;
}

/// Warns of the file's gaps.
static void tell_gaps(const rsv_weather_text *t)
{
    const rsv_weather *w = t->weather;
    if (w->filled)
        rsv_log(t->context, RSV_LOG_WARNING,
            "%s: %zu of %zu records have no irradiances; they take those of the nearest day",
            t->path, w->filled, w->count);
    if (w->missing)
        rsv_log(t->context, RSV_LOG_WARNING,
            "%s: %zu hours of the year are missing; results are for the others", t->path,
            w->missing);
}

/// Hours of the year that no record covers, and those that records cover again.
static rsv_status count_hours(rsv_weather_text *t)
{
    enum { days = 366, day_hours = 24 };
    rsv_weather *w = t->weather;
    double missing = 0, again = 0,
           *covered = rsv_alloc(t->context, days * day_hours, sizeof *covered);
    if (!covered) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < w->count; k++) {
        const rsv_moment *m = &w->hour[k].moment; // all years have the days of a leap year here
        int hour = (int)fmin(fmax(m->hour, 0), day_hours - 1);
        covered[(rsv_day_of_year(2000, m->month, m->day) - 1) * day_hours + hour] +=
            w->hour[k].hours;
    }
    int leap_day = (rsv_day_of_year(2000, 2, 29) - 1) * day_hours;
    for (int k = 0; k < days * day_hours; k++) {
        if (k >= leap_day && k < leap_day + day_hours && !w->leap) continue;
        missing += fmax(1 - covered[k], 0);
        again += fmax(covered[k] - 1, 0);
    }
    rsv_free(t->context, covered);
    w->missing = (size_t)(missing + 0.5);
    if (again >= 0.5)
        rsv_log(t->context, RSV_LOG_WARNING,
            "%s: %.0f hours of the year occur more than once; all records count", t->path, again);
    return RSV_OK;
}

static rsv_status finish(rsv_weather_text *t)
{
    rsv_weather *w = t->weather;
    if (w->count == 0)
        return rsv_fail(RSV_ERROR_FORMAT, "%s: holds no records after its header", t->path);
    rsv_status status = count_hours(t);
    if (status == RSV_OK) status = fill_gaps(t);
    if (status == RSV_OK) tell_gaps(t);
    return status;
}

rsv_status rsv_weather_read(rsv_context *context, const char *path, rsv_weather *weather)
{
    char *content = NULL;
    *weather = (rsv_weather){ 0 };
    rsv_weather_text t = { context, path, NULL, NULL, 0, weather, 0 };
    rsv_status status;
    RSV_TRY(rsv_read_text_file(context, path, "a weather file", MOST_BYTES, &content));
    t.rest = strncmp(content, "\xef\xbb\xbf", 3) == 0 ? content + 3 : content;
    bool any = rsv_weather_next_line(&t), epw = any && strncmp(t.line, "LOCATION,", 9) == 0;
    bool wea = any && strncmp(t.line, "place", 5) == 0;
    if (!epw && !wea)
        RSV_TRY(rsv_fail(RSV_ERROR_FORMAT,
            "%s: is neither EPW, which begins with LOCATION, nor WEA, which begins with place",
            path));
    RSV_TRY(epw ? rsv_weather_read_epw(&t) : rsv_weather_read_wea(&t));
    RSV_TRY(finish(&t));
cleanup:
    rsv_free(context, content);
    return status;
}

void rsv_weather_free(rsv_context *context, rsv_weather *weather)
{
    rsv_free(context, weather->hour);
    *weather = (rsv_weather){ 0 };
}

rsv_perez_sky rsv_weather_sky(const rsv_weather *weather, size_t index, rsv_solar_position *sun)
{
    const rsv_weather_hour *hour = &weather->hour[index];
    rsv_solar_position own = rsv_sun_position(&weather->site, &hour->moment);
    if (sun) *sun = own;
    if (isfinite(hour->direct_illuminance) && isfinite(hour->diffuse_illuminance))
        return rsv_perez_sky_of_illuminance(
            hour->diffuse_illuminance, hour->direct_illuminance, &hour->record, own.direction);
    return rsv_perez_sky_of(&hour->record, own.direction);
}
