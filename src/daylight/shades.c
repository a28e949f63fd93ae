#include "shades.h"

#include "../core/parallel.h"

rsv_status rsv_shades_check(const rsv_daylight *d, const rsv_daylight_run_desc *desc)
{
    const rsv_daylight *s = desc->shaded;
    if (!s) return RSV_OK;
    if (s->sensor_count != d->sensor_count || s->patches.count != d->patches.count ||
        s->desc.north != d->desc.north)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "daylight: the scene with its shades down must have the same sensors, patches and "
            "north");
    if (desc->shade_lux > 0 && desc->shade_share >= 0 && desc->shade_share <= 1) return RSV_OK;
    return rsv_fail(RSV_ERROR_ARGUMENT,
        "daylight: shades need an illuminance above 0, and a share from 0 to 1");
}

/// Whether the sun shines on enough of the sensors.
static bool is_sunny(const rsv_daylight *d, const rsv_sensor_place *place, const rsv_lit_hour *hour,
    const rsv_daylight_run_desc *desc)
{
    size_t needed = (size_t)ceil(desc->shade_share * (double)d->sensor_count - 1e-9), found = 0;
    if (needed < 1) needed = 1;
    for (size_t s = 0; s < d->sensor_count && found < needed; s++)
        found += (double)rsv_year_sun_at(d, &place[s], hour) >= desc->shade_lux;
    return found >= needed;
}

/// Hours in which shades may go down.
typedef struct shade_job {
    const rsv_daylight *daylight;
    const rsv_sensor_place *place; ///< [sensor_count]
    const rsv_year *year;
    const rsv_daylight_run_desc *desc;
    uint8_t *down; ///< [lit_count] out
} shade_job;

static void judge_hours(void *data, rsv_span span)
{
    const shade_job *job = data;
    const rsv_lit_hour *lit = job->year->lit;
    for (size_t k = span.begin; k < span.end; k++)
        if (lit[k].direct > 0 && !rsv_cancelled(job->daylight->context))
            job->down[k] = is_sunny(job->daylight, job->place, &lit[k], job->desc);
}

rsv_status rsv_shades_lower(
    const rsv_daylight *d, const rsv_year *year, const rsv_daylight_run_desc *desc, uint8_t *down)
{
    rsv_sensor_place *place = rsv_alloc(d->context, d->sensor_count, sizeof *place);
    if (!place) return RSV_ERROR_MEMORY;
    for (size_t s = 0; s < d->sensor_count; s++)
        place[s] = rsv_sensor_place_of(d, s);
    shade_job job = { d, place, year, desc, down };
    rsv_parallel_for(d->context, year->lit_count, 16, judge_hours, &job);
    rsv_free(d->context, place);
    return rsv_progress(d->context, "shades", 1);
}
