/// A weather file's hours at all sensors.
#include "../core/descriptor.h"
#include "../core/parallel.h"
#include "figures.h"
#include "shades.h"

#include <string.h>

void rsv_daylight_run_desc_init(rsv_daylight_run_desc *desc, size_t size)
{
    const rsv_daylight_run_desc defaults = {
        .size = sizeof defaults, .from = 8, .to = 18, .shade_lux = 1000, .shade_share = 0.02
    };
    rsv_desc_fill(desc, size, &defaults);
}

/// A run of one weather file.
typedef struct run_job {
    const rsv_daylight *daylight;
    const rsv_daylight_run_desc *desc;
    rsv_year year;
    uint8_t *down; ///< [rooms][lit_count] 1 = shades are down; NULL = there are none
    rsv_sensor_variants *figures;
    rsv_share sensors;
    _Atomic rsv_status result;
} run_job;

/// Readings of a sensor, one for each worker.
typedef struct sensor_scratch {
    rsv_sensor_readings readings;
    rsv_seen_patches seen;
    float (*shaded)[RSV_DAYLIGHT_COLUMNS]; ///< [lit_count] with the shades down
    float *shaded_sun;                     ///< [lit_count]
} sensor_scratch;

static bool create_scratch(const run_job *job, sensor_scratch *s)
{
    const rsv_daylight *d = job->daylight;
    const rsv_year *year = &job->year;
    rsv_context *context = d->context;
    size_t shaded = job->down ? year->lit_count : 0;
    s->shaded = rsv_alloc(context, shaded, sizeof *s->shaded);
    s->shaded_sun = rsv_alloc(context, shaded, sizeof *s->shaded_sun);
    s->seen.patch = rsv_alloc(context, d->patches.count, sizeof *s->seen.patch);
    s->seen.share = rsv_alloc(context, d->patches.count, sizeof *s->seen.share);
    s->readings.reading = rsv_alloc(context, year->lit_count, sizeof *s->readings.reading);
    s->readings.sun = rsv_alloc(context, year->lit_count, sizeof *s->readings.sun);
    s->readings.value = rsv_alloc(context, year->daylight_count, sizeof *s->readings.value);
    return s->readings.reading && s->readings.sun && s->readings.value && s->seen.patch &&
           s->seen.share && s->shaded && s->shaded_sun;
}

static void destroy_scratch(rsv_context *context, sensor_scratch *s)
{
    rsv_free(context, s->readings.reading);
    rsv_free(context, s->readings.sun);
    rsv_free(context, s->readings.value);
    rsv_free(context, s->seen.patch);
    rsv_free(context, s->seen.share);
    rsv_free(context, s->shaded);
    rsv_free(context, s->shaded_sun);
}

static void write_hours(const rsv_daylight *d, const rsv_year *year, size_t sensor,
    const sensor_scratch *s, float *hourly)
{
    for (size_t k = 0; k < year->lit_count; k++)
        hourly[year->lit[k].index * d->sensor_count + sensor] =
            rsv_variant_reading(s->readings.reading[k], RSV_VARIANT_ALL, 0);
}

/// Replaces the readings of hours with the shades down.
static void read_shaded(const run_job *job, size_t sensor, sensor_scratch *s)
{
    const rsv_daylight *shaded = job->desc->shaded;
    if (!job->down) return;
    rsv_year_read_sensor(shaded, &job->year, sensor, &s->seen, s->shaded, s->shaded_sun);
    const uint8_t *down = job->down + rsv_shades_room_of(job->desc, sensor) * job->year.lit_count;
    for (size_t k = 0; k < job->year.lit_count; k++)
        if (down[k]) memcpy(s->readings.reading[k], s->shaded[k], sizeof s->shaded[k]);
    if (shaded->stored_error[sensor] > s->readings.stored_error)
        s->readings.stored_error = shaded->stored_error[sensor];
}

static void read_sensor(const run_job *job, size_t sensor, sensor_scratch *s)
{
    const rsv_daylight *d = job->daylight;
    rsv_year_read_sensor(d, &job->year, sensor, &s->seen, s->readings.reading, s->readings.sun);
    s->readings.stored_error = d->stored_error[sensor];
    read_shaded(job, sensor, s);
    rsv_sensor_figures(d, &job->year, sensor, &s->readings, job->figures[sensor]);
    if (job->desc->hourly) write_hours(d, &job->year, sensor, s, job->desc->hourly);
}

static void read_share(void *data, int worker)
{
    run_job *job = data;
    rsv_context *context = job->daylight->context;
    sensor_scratch s = { 0 };
    if (!create_scratch(job, &s)) rsv_keep_failure(&job->result, RSV_ERROR_MEMORY);
    for (rsv_span span; job->result == RSV_OK && rsv_share_take(&job->sensors, worker, &span);)
        if (!rsv_cancelled(context)) read_sensor(job, span.begin, &s);
    destroy_scratch(context, &s);
}

static rsv_status read_sensors(run_job *job)
{
    size_t count = job->daylight->sensor_count;
    job->sensors = rsv_share_of(count, 1);
    rsv_parallel_workers(job->daylight->context, count, read_share, job);
    return job->result;
}

/// Hours with the shades down: of each room, and of all sensors on average.
static void count_shaded(const run_job *job, rsv_daylight_report *report)
{
    size_t lit = job->year.lit_count, sensors = job->daylight->sensor_count;
    for (size_t s = 0; s < sensors; s++) {
        size_t room = rsv_shades_room_of(job->desc, s);
        double hours = 0;
        for (size_t k = 0; k < lit; k++)
            hours += job->down[room * lit + k] ? job->year.lit[k].hours : 0;
        report->shaded_hours += hours / (double)sensors;
        if (report->room_shaded_hours) report->room_shaded_hours[room] = hours;
    }
}

static rsv_status lower_shades(run_job *job, rsv_daylight_report *report)
{
    rsv_context *context = job->daylight->context;
    size_t rooms = rsv_shades_rooms(job->desc);
    if (!job->desc->shaded) return RSV_OK;
    job->down = rsv_alloc(context, rooms * job->year.lit_count, sizeof *job->down);
    if (job->desc->room)
        report->room_shaded_hours = rsv_alloc(context, rooms, sizeof *report->room_shaded_hours);
    if (!job->down || (job->desc->room && !report->room_shaded_hours)) return RSV_ERROR_MEMORY;
    rsv_status status = rsv_shades_lower(job->daylight, &job->year, job->desc, job->down);
    count_shaded(job, report);
    return status;
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

/// @param chosen, value scratch, [sensor_count]
static void report_rooms(
    const run_job *job, rsv_sensor_variants *chosen, float *value, rsv_daylight_report *report)
{
    for (size_t r = 0; r < job->desc->room_count; r++) {
        size_t count = 0;
        for (size_t k = 0; k < job->daylight->sensor_count; k++)
            if (job->desc->room[k] == r) memcpy(chosen[count++], job->figures[k], sizeof *chosen);
        if (count)
            rsv_space_figures((const rsv_sensor_variants *)chosen, count, value, report->room[r]);
    }
}

static rsv_status find_room_figures(const run_job *job, float *value, rsv_daylight_report *report)
{
    rsv_context *context = job->daylight->context;
    if (!job->desc->room) return RSV_OK;
    rsv_sensor_variants *chosen = rsv_alloc(context, job->daylight->sensor_count, sizeof *chosen);
    report->room = rsv_alloc(context, job->desc->room_count, sizeof *report->room);
    if (chosen && report->room) report_rooms(job, chosen, value, report);
    rsv_free(context, chosen);
    return chosen && report->room ? RSV_OK : RSV_ERROR_MEMORY;
}

static rsv_status check_rooms(const rsv_daylight *d, const rsv_daylight_run_desc *desc)
{
    for (size_t k = 0; desc->room && k < d->sensor_count; k++)
        if (desc->room[k] >= desc->room_count)
            return rsv_fail(RSV_ERROR_ARGUMENT, "daylight: sensor %zu: room %u of %zu", k,
                desc->room[k], desc->room_count);
    return RSV_OK;
}

rsv_status rsv_daylight_run(const rsv_daylight *d, const rsv_weather *weather,
    const rsv_daylight_run_desc *desc, rsv_daylight_report *report)
{
    rsv_daylight_run_desc settings = rsv_default_daylight_run_desc();
    run_job job = { .daylight = d, .desc = &settings };
    float *value = NULL;
    rsv_status status;
    *report = (rsv_daylight_report){ .sensor_count = d->sensor_count };
    RSV_TRY(RSV_READ_DESC(rsv_daylight_run_desc, &settings, desc));
    for (size_t k = 0; settings.hourly && k < weather->count * d->sensor_count; k++)
        settings.hourly[k] = 0;
    RSV_TRY(check_rooms(d, &settings));
    RSV_TRY(rsv_shades_check(d, &settings));
    RSV_TRY(rsv_year_create(d, weather, &settings, &job.year));
    RSV_TRY(lower_shades(&job, report));
    job.figures = rsv_alloc(d->context, d->sensor_count, sizeof *job.figures);
    value = rsv_alloc(d->context, d->sensor_count, sizeof *value);
    report->sensor = rsv_alloc(d->context, d->sensor_count, sizeof *report->sensor);
    RSV_TRY(job.figures && value && report->sensor ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(read_sensors(&job));
    RSV_TRY(rsv_progress(d->context, "year", 1));
    report_figures(d, &job.year, (const rsv_sensor_variants *)job.figures, value, report);
    RSV_TRY(find_room_figures(&job, value, report));
cleanup:
    rsv_year_destroy(d->context, &job.year);
    rsv_free(d->context, job.down);
    rsv_free(d->context, job.figures);
    rsv_free(d->context, value);
    return status;
}

void rsv_daylight_report_free(const rsv_daylight *d, rsv_daylight_report *report)
{
    rsv_free(d->context, report->sensor);
    rsv_free(d->context, report->room);
    rsv_free(d->context, report->room_shaded_hours);
    *report = (rsv_daylight_report){ 0 };
}
