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

/// Hours in which shades may go down.
typedef struct shade_job {
    const rsv_daylight *daylight;
    const rsv_year *year;
    const rsv_daylight_run_desc *desc;
    size_t rooms;
    rsv_sensor_place *place; ///< [sensor_count] room by room
    size_t *first;           ///< [rooms + 1] place of each room
    uint8_t *down;           ///< [rooms][lit_count] out
} shade_job;

/// Places of sensors, sorted by room (counting sort).
static void sort_places(shade_job *job)
{
    size_t sensors = job->daylight->sensor_count;
    for (size_t s = 0; s < sensors; s++)
        job->first[rsv_shades_room_of(job->desc, s) + 1]++;
    for (size_t r = 0; r < job->rooms; r++)
        job->first[r + 1] += job->first[r];
    for (size_t s = sensors; s-- > 0;) { // the ends move down to the beginnings
        size_t *end = &job->first[rsv_shades_room_of(job->desc, s) + 1];
        job->place[--*end] = rsv_sensor_place_of(job->daylight, s);
    }
    for (size_t r = 0; r < job->rooms; r++)
        job->first[r] = job->first[r + 1];
    job->first[job->rooms] = sensors;
}

/// Whether the sun shines on more of a room's sensors than its shades allow.
static bool is_sunny(const shade_job *job, size_t room, const rsv_lit_hour *hour)
{
    size_t begin = job->first[room], end = job->first[room + 1], found = 0;
    double allowed = job->desc->shade_share * (double)(end - begin) + 1e-9;
    for (size_t s = begin; s < end && (double)found <= allowed; s++)
        found +=
            (double)rsv_year_sun_at(job->daylight, &job->place[s], hour) >= job->desc->shade_lux;
    return (double)found > allowed;
}

static void judge_hours(void *data, rsv_span span)
{
    const shade_job *job = data;
    const rsv_lit_hour *lit = job->year->lit;
    for (size_t k = span.begin; k < span.end; k++)
        for (size_t r = 0; r < job->rooms && lit[k].direct > 0; r++)
            if (!rsv_cancelled(job->daylight->context))
                job->down[r * job->year->lit_count + k] = is_sunny(job, r, &lit[k]);
}

rsv_status rsv_shades_lower(
    const rsv_daylight *d, const rsv_year *year, const rsv_daylight_run_desc *desc, uint8_t *down)
{
    shade_job job = { d, year, desc, .rooms = rsv_shades_rooms(desc), .down = down };
    job.place = rsv_alloc(d->context, d->sensor_count, sizeof *job.place);
    job.first = rsv_alloc(d->context, job.rooms + 1, sizeof *job.first);
    bool reserved = job.place && job.first;
    if (reserved) {
        sort_places(&job);
        rsv_parallel_for(d->context, year->lit_count, 16, judge_hours, &job);
    }
    rsv_free(d->context, job.place);
    rsv_free(d->context, job.first);
    return reserved ? rsv_progress(d->context, "shades", 1) : RSV_ERROR_MEMORY;
}
