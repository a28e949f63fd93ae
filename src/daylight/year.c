#include "year.h"

#include "../core/parallel.h"
#include "../core/sampling.h"

#include <string.h>

#define COLUMNS RSV_DAYLIGHT_COLUMNS
#define MOST_LUMINANCES ((size_t)1 << 28) ///< of patches at all hours: 1 GiB
#define SUN_REACH 1.5 ///< heights of a patch within which the sun's reflected light is averaged

/// Directions and solid angles of all patches.
typedef struct patch_table {
    rsv_vec3 *direction;
    float *solid_angle;
    float least_cos; ///< of patches that the sun is spread over
} patch_table;

static rsv_status create_table(const rsv_daylight *d, patch_table *table)
{
    const rsv_sky_patches *p = &d->patches;
    table->direction = rsv_alloc(d->context, p->count, sizeof *table->direction);
    table->solid_angle = rsv_alloc(d->context, p->count, sizeof *table->solid_angle);
    if (!table->direction || !table->solid_angle) return RSV_ERROR_MEMORY;
    for (uint32_t k = 0; k < p->count; k++) {
        table->direction[k] = rsv_sky_patch_direction(p, k);
        table->solid_angle[k] = (float)rsv_sky_patch_solid_angle(p, k);
    }
    table->least_cos = (float)cos(SUN_REACH * M_PI / 2 / (7 * p->subdivision + 0.5));
    return RSV_OK;
}

static void destroy_table(rsv_context *context, patch_table *table)
{
    rsv_free(context, table->direction);
    rsv_free(context, table->solid_angle);
}

/// Patches around the sun, weighted towards it: their luminances give the sun's illuminance together.
static void spread_sun(
    const rsv_daylight *d, const patch_table *table, rsv_vec3 sun, rsv_lit_hour *hour)
{
    float sum = 0;
    for (uint32_t k = 1; k < d->patches.count && hour->spread_count < RSV_SUN_SPREAD; k++) {
        float near = v3_dot(table->direction[k], sun) - table->least_cos;
        if (near <= 0) continue;
        hour->spread_patch[hour->spread_count] = k;
        hour->spread_luminance[hour->spread_count++] = near;
        sum += near * table->solid_angle[k];
    }
    for (uint32_t k = 0; k < hour->spread_count; k++)
        hour->spread_luminance[k] *= (float)hour->direct / sum;
}

/// A place on the sun's disk, another one each hour.
static rsv_vec3 place_on_sun(rsv_vec3 middle, size_t index)
{
    rsv_vec3 t, b;
    float turn = 2 * RSV_PI * rsv_unit_float(rsv_hash2(0x50bu, (uint32_t)index));
    float radius =
        (float)RSV_SUN_RADIUS * sqrtf(rsv_unit_float(rsv_hash2(0x50cu, (uint32_t)index)));
    v3_frame(middle, &t, &b);
    return v3_normalize(v3_mad(v3_mad(middle, radius * cosf(turn), t), radius * sinf(turn), b));
}

static void fill_hour(const rsv_daylight *d, const patch_table *table, const rsv_weather *weather,
    const rsv_daylight_run_desc *desc, rsv_lit_hour *hour, float *luminance)
{
    rsv_solar_position sun;
    rsv_perez_sky sky = rsv_weather_sky(weather, hour->index, &sun);
    double up = fmax((double)sun.direction.y, 0);
    hour->sun = rsv_daylight_to_scene(d, place_on_sun(sun.direction, hour->index));
    hour->direct = desc->sky_only || sun.elevation <= 0 ? 0 : sky.direct_illuminance;
    rsv_sky_patch_luminances(&d->patches, &sky.shape, sky.diffuse_illuminance, luminance);
    luminance[0] = (float)((double)d->desc.ground_albedo / M_PI *
                           (sky.diffuse_illuminance + up * sky.direct_illuminance));
    if (hour->direct > 0) spread_sun(d, table, sun.direction, hour);
}

/// Skies of the lit hours.
typedef struct sky_job {
    const rsv_daylight *daylight;
    const patch_table *table;
    const rsv_weather *weather;
    const rsv_daylight_run_desc *desc;
    const rsv_year *year;
} sky_job;

static void fill_hours(void *data, rsv_span span)
{
    const sky_job *job = data;
    const rsv_year *year = job->year;
    for (size_t k = span.begin; k < span.end; k++)
        fill_hour(job->daylight, job->table, job->weather, job->desc, &year->lit[k],
            year->luminance + k * job->daylight->patches.count);
}

/// Counts hours and picks those that have light.
static void pick_lit(const rsv_weather *w, const rsv_daylight_run_desc *desc, rsv_year *year)
{
    for (size_t k = 0; k < w->count; k++) {
        const rsv_weather_hour *h = &w->hour[k];
        bool occupied = h->moment.hour >= desc->from && h->moment.hour < desc->to;
        bool daylight = rsv_sun_position(&w->site, &h->moment).elevation > 0;
        year->hours += h->hours;
        year->occupied_hours += occupied ? h->hours : 0;
        year->daylight_hours += daylight ? h->hours : 0;
        year->daylight_count += daylight;
        bool measured = isfinite(h->diffuse_illuminance);
        double light = measured ? h->diffuse_illuminance + h->direct_illuminance
                                : h->record.diffuse_horizontal + h->record.direct_normal;
        if (!(light > 1e-4)) continue;
        year->lit[year->lit_count++] = (rsv_lit_hour){
            .index = k, .hours = h->hours, .occupied = occupied, .daylight = daylight
        };
    }
}

rsv_status rsv_year_create(const rsv_daylight *d, const rsv_weather *weather,
    const rsv_daylight_run_desc *desc, rsv_year *year)
{
    patch_table table = { 0 };
    rsv_status status;
    *year = (rsv_year){ 0 };
    RSV_TRY(create_table(d, &table));
    year->lit = rsv_alloc(d->context, weather->count, sizeof *year->lit);
    RSV_TRY(year->lit ? RSV_OK : RSV_ERROR_MEMORY);
    pick_lit(weather, desc, year);
    year->luminance =
        rsv_alloc(d->context, year->lit_count * d->patches.count, sizeof *year->luminance);
    RSV_TRY(year->luminance ? RSV_OK : RSV_ERROR_MEMORY);
    sky_job job = { d, &table, weather, desc, year };
    rsv_parallel_for(d->context, year->lit_count, 0, fill_hours, &job);
cleanup:
    destroy_table(d->context, &table);
    return status;
}

void rsv_year_destroy(rsv_context *context, rsv_year *year)
{
    rsv_free(context, year->lit);
    rsv_free(context, year->luminance);
    *year = (rsv_year){ 0 };
}

// ---- readings -------------------------------------------------------------------------------------

#define HOURS_AT_ONCE 4

/// Products of skies with a sensor's coefficients, for some hours that follow each other.
static void multiply(
    const rsv_seen_patches *seen, const float *luminance, size_t patches, float (*reading)[COLUMNS])
{
    float sum[HOURS_AT_ONCE][COLUMNS] = { { 0 } };
    for (size_t k = 0; k < seen->count; k++)
        for (int h = 0; h < HOURS_AT_ONCE; h++) {
            float l = luminance[(size_t)h * patches + seen->patch[k]];
            for (int c = 0; c < COLUMNS; c++)
                sum[h][c] += l * seen->share[k].column[c];
        }
    memcpy(reading, sum, sizeof sum);
}

/// The same for one hour.
static void multiply_one(
    const rsv_seen_patches *seen, const float *luminance, float reading[COLUMNS])
{
    float sum[COLUMNS] = { 0 };
    for (size_t k = 0; k < seen->count; k++)
        for (int c = 0; c < COLUMNS; c++)
            sum[c] += luminance[seen->patch[k]] * seen->share[k].column[c];
    memcpy(reading, sum, sizeof sum);
}

static bool is_dark(const rsv_patch_share *share)
{
    for (int c = 0; c < COLUMNS; c++)
        if (share->column[c] != 0) return false;
    return true;
}

/// Leaves out patches of which nothing reaches the sensor: a room with one window never sees half of the sky.
static void find_seen(const rsv_daylight *d, size_t sensor, rsv_seen_patches *seen)
{
    const rsv_patch_share *share = d->all + sensor * d->patches.count;
    seen->count = 0;
    for (uint32_t p = 0; p < d->patches.count; p++) {
        if (is_dark(&share[p])) continue;
        seen->patch[seen->count] = p;
        seen->share[seen->count++] = share[p];
    }
}

float rsv_year_sun_at(
    const rsv_daylight *d, const rsv_sensor_place *place, const rsv_lit_hour *hour)
{
    float cosine = v3_dot(place->normal, hour->sun);
    if (!(hour->direct > 0) || cosine <= 0) return 0;
    return (float)(hour->direct * rsv_sun_passed(d, place, hour->sun)) * cosine;
}

/// Adds the sun: light from surfaces, mirrors and refracting panes, and direct light.
static float add_sun(const rsv_daylight *d, const rsv_sensor_place *place, size_t sensor,
    const rsv_lit_hour *hour, float reading[COLUMNS])
{
    const rsv_patch_share *bent = d->bent + sensor * d->patches.count;
    for (uint32_t k = 0; k < hour->spread_count; k++)
        for (int c = 0; c < COLUMNS; c++)
            reading[c] += hour->spread_luminance[k] * bent[hour->spread_patch[k]].column[c];
    float straight = rsv_year_sun_at(d, place, hour);
    for (int c = 0; c < RSV_DAYLIGHT_GROUPS; c++)
        reading[c] += straight;
    return straight;
}

void rsv_year_read_sensor(const rsv_daylight *d, const rsv_year *year, size_t sensor,
    rsv_seen_patches *seen, float (*reading)[COLUMNS], float *sun)
{
    size_t patches = d->patches.count, k = 0;
    find_seen(d, sensor, seen);
    for (; k + HOURS_AT_ONCE <= year->lit_count; k += HOURS_AT_ONCE)
        multiply(seen, year->luminance + k * patches, patches, reading + k);
    for (; k < year->lit_count; k++)
        multiply_one(seen, year->luminance + k * patches, reading[k]);
    rsv_sensor_place place = rsv_sensor_place_of(d, sensor);
    for (k = 0; k < year->lit_count; k++)
        sun[k] = add_sun(d, &place, sensor, &year->lit[k], reading[k]);
}
