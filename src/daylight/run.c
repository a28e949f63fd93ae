/// A weather file's hours at all sensors.
#include "../core/core.h"
#include "figures.h"

rsv_daylight_run_desc rsv_default_daylight_run_desc(void)
{
    return (rsv_daylight_run_desc){ .from = 8, .to = 18 };
}

/// What one thread reads a sensor into.
typedef struct sensor_scratch {
    rsv_sensor_readings readings;
    rsv_seen_patches seen;
} sensor_scratch;

static bool create_scratch(const rsv_daylight *d, const rsv_year *year, sensor_scratch *s)
{
    rsv_context *context = d->context;
    s->seen.patch = rsv_alloc(context, d->patches.count, sizeof *s->seen.patch);
    s->seen.share = rsv_alloc(context, d->patches.count, sizeof *s->seen.share);
    s->readings.reading = rsv_alloc(context, year->lit_count, sizeof *s->readings.reading);
    s->readings.sun = rsv_alloc(context, year->lit_count, sizeof *s->readings.sun);
    s->readings.value = rsv_alloc(context, year->daylight_count, sizeof *s->readings.value);
    return s->readings.reading && s->readings.sun && s->readings.value && s->seen.patch &&
           s->seen.share;
}

static void destroy_scratch(rsv_context *context, sensor_scratch *s)
{
    rsv_free(context, s->readings.reading);
    rsv_free(context, s->readings.sun);
    rsv_free(context, s->readings.value);
    rsv_free(context, s->seen.patch);
    rsv_free(context, s->seen.share);
}

static void write_hours(const rsv_daylight *d, const rsv_year *year, size_t sensor,
    const sensor_scratch *s, float *hourly)
{
    for (size_t k = 0; k < year->lit_count; k++)
        hourly[year->lit[k].index * d->sensor_count + sensor] =
            rsv_variant_reading(s->readings.reading[k], RSV_VARIANT_ALL, 0);
}

/// @param hourly all zero before; NULL = not wanted
static bool read_sensors(
    const rsv_daylight *d, const rsv_year *year, float *hourly, rsv_sensor_variants *figures)
{
    bool complete = true;
#pragma omp parallel num_threads(rsv_threads(d->context)) reduction(&& : complete)
    {
        sensor_scratch s = { 0 };
        complete = create_scratch(d, year, &s);
#pragma omp for schedule(dynamic, 1)
        for (size_t k = 0; k < d->sensor_count; k++) {
            if (!complete || rsv_cancelled(d->context)) continue;
            rsv_year_read_sensor(d, year, k, &s.seen, s.readings.reading, s.readings.sun);
            s.readings.stored_error = d->stored_error[k];
            rsv_sensor_figures(d, year, k, &s.readings, figures[k]);
            if (hourly) write_hours(d, year, k, &s, hourly);
        }
        destroy_scratch(d->context, &s);
    }
    return complete;
}

static void report_figures(const rsv_daylight *d, const rsv_year *year,
    const rsv_sensor_variants *figures, float *value, rsv_daylight_report *report)
{
    report->hours = year->hours;
    report->occupied_hours = year->occupied_hours;
    report->daylight_hours = year->daylight_hours;
    for (size_t k = 0; k < d->sensor_count; k++)
        for (int f = 0; f < RSV_SENSOR_FIGURES; f++)
            report->sensor[k][f] = rsv_figure_of(&figures[k][0][f], RSV_SENSOR_FIGURES);
    rsv_space_figures(figures, d->sensor_count, value, report->space);
}

rsv_status rsv_daylight_run(const rsv_daylight *d, const rsv_weather *weather,
    const rsv_daylight_run_desc *desc, rsv_daylight_report *report)
{
    rsv_year year = { 0 };
    float *value = NULL;
    rsv_sensor_variants *figures = NULL;
    rsv_status status;
    *report = (rsv_daylight_report){ .sensor_count = d->sensor_count };
    for (size_t k = 0; desc->hourly && k < weather->count * d->sensor_count; k++)
        desc->hourly[k] = 0;
    RSV_TRY(rsv_year_create(d, weather, desc, &year));
    figures = rsv_alloc(d->context, d->sensor_count, sizeof *figures);
    value = rsv_alloc(d->context, d->sensor_count, sizeof *value);
    report->sensor = rsv_alloc(d->context, d->sensor_count, sizeof *report->sensor);
    RSV_TRY(figures && value && report->sensor ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(read_sensors(d, &year, desc->hourly, figures) ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_progress(d->context, "year", 1));
    report_figures(d, &year, (const rsv_sensor_variants *)figures, value, report);
cleanup:
    rsv_year_destroy(d->context, &year);
    rsv_free(d->context, figures);
    rsv_free(d->context, value);
    return status;
}

void rsv_daylight_report_free(const rsv_daylight *d, rsv_daylight_report *report)
{
    rsv_free(d->context, report->sensor);
    *report = (rsv_daylight_report){ 0 };
}
