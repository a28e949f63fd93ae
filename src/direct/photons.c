#include "photons_internal.h"

#include "../core/parallel.h"
#include "shooting_device.h"

#include <string.h>

typedef rsv_photon_shooter photon_job;

bool rsv_photons_wanted(const rsv_transport_scene *scene, const rsv_lights *lights)
{
    bool specular = false, source = scene->view->light_count > 0;
    for (size_t m = 0; m < scene->view->material_count; m++)
        specular = specular || (rsv_is_specular(&scene->bsdf[m]) &&
                                   (scene->bsdf[m].coated || scene->bsdf[m].diffuse < 1));
    for (size_t g = 0; g < lights->group_count; g++)
        source = source || !lights->group[g].gathered;
    source = source || (lights->environment && lights->environment->sun_count > 0);
    return specular && source;
}

// ---- sources ------------------------------------------------------------------------------------

/// Usefulness of a photon that has hit a specular surface: the fraction of its flux that reaches another surface where
/// it counts.
static float worth(const photon_job *job, rsv_specular_path *path, rsv_random *random)
{
    float level = 0;
    if (!rsv_photon_scatter(job->scene, path, &level, random, NULL)) return 0;
    bool wanted = !job->sink->wants || job->sink->wants(job->sink->user, path);
    return f_min(level, 1) * (wanted ? 1 : RSV_UNWANTED_PHOTON);
}

/// A round of pilot rays from one source.
typedef struct pilot_job {
    const photon_job *job;
    const rsv_photon_source *source;
    uint32_t id;
    rsv_guide_grid grid;
    float *useful; ///< [bins] out
} pilot_job;

static void pilot_bin(const pilot_job *pilot, int bin)
{
    const rsv_shooting *shooting = &pilot->job->shooting;
    rsv_random random = rsv_pilot_numbers(shooting, pilot->id, bin);
    float useful = 0;
    for (int k = 0; k < RSV_GUIDE_RAYS; k++) {
        rsv_specular_path path;
        if (rsv_photon_pilot(shooting, pilot->source, &pilot->grid, bin, &random, &path))
            useful += worth(pilot->job, &path, &random);
    }
    pilot->useful[bin] = useful;
}

static void pilot_bins(void *data, rsv_span span)
{
    const pilot_job *pilot = data;
    for (size_t bin = span.begin; bin < span.end; bin++)
        pilot_bin(pilot, (int)bin);
}

static rsv_status create_guide(
    const photon_job *job, rsv_photon_source *source, uint32_t id, uint64_t *rays)
{
    rsv_context *context = job->lights->context;
    const size_t bins = RSV_GUIDE_SIDE * RSV_GUIDE_SIDE;
    pilot_job pilot = { job, source, id, rsv_guide_grid_even(), NULL };
    pilot.useful = rsv_alloc(context, bins, sizeof *pilot.useful);
    if (!pilot.useful) return RSV_ERROR_MEMORY;
    uint64_t rounds = 1;
    rsv_parallel_for(context, bins, 64, pilot_bins, &pilot);
    for (; rounds < MOST_PILOTS && rsv_guide_grid_zoom(&pilot.grid, pilot.useful); rounds++)
        rsv_parallel_for(context, bins, 64, pilot_bins, &pilot);
    *rays += rounds * (uint64_t)bins * RSV_GUIDE_RAYS;
    rsv_status status = rsv_photon_guide_create(context, &pilot.grid, pilot.useful, &source->guide);
    rsv_free(context, pilot.useful);
    return status;
}

static void share_out(photon_job *job)
{
    for (uint32_t k = 0; k < job->origins.count; k++) {
        bool own = k <= OWN_GUIDES;
        rsv_photon_source *source = &job->source[own ? job->source_count++ : OWN_GUIDES];
        if (own) source->first = k;
        source->count++;
        source->flux += job->origins.origin[k].flux;
    }
}

static rsv_status create_sources(photon_job *job, uint64_t *rays)
{
    rsv_status status;
    double total = 0;
    RSV_TRY(rsv_photon_origins_create(job->scene, job->lights, OWN_GUIDES, &job->origins));
    job->shooting.origins = &job->origins;
    share_out(job);
    for (size_t s = 0; s < job->source_count; s++) {
        rsv_photon_source *source = &job->source[s];
        RSV_TRY(create_guide(job, source, (uint32_t)s, rays));
        source->share = source->flux * (source->guide.useful + 1e-3);
        total += source->share;
    }
    for (size_t s = 0; s < job->source_count && total > 0; s++)
        job->source[s].share /= total;
cleanup:
    return status;
}

static void destroy_sources(photon_job *job)
{
    for (size_t s = 0; s < job->source_count; s++)
        rsv_photon_guide_destroy(job->lights->context, &job->source[s].guide);
    rsv_photon_origins_destroy(&job->origins);
}

// ---- paths --------------------------------------------------------------------------------------

/// A photon's way through fog, and the receiver of its segments.
typedef struct air_way {
    const rsv_photon_sink *sink;
    const rsv_photon *photon;
} air_way;

static void cross_air(void *user, const rsv_ray *ray, rsv_rgb weight)
{
    const air_way *way = user;
    way->sink->cross(way->sink->user, ray, rgb_mul(way->photon->flux, weight));
}

/// The photons of one source, in chunks.
typedef struct source_job {
    const photon_job *job;
    uint32_t id, count;
    double done, share; ///< of all work: before this source, and of it
    size_t chunks;      ///< of this process
    size_t first;       ///< chunk of the wave that is traced
    atomic_uint_least64_t rays;
} source_job;

static uint64_t shoot_one(const source_job *s, size_t slot, uint32_t index)
{
    const photon_job *job = s->job;
    rsv_photon photon;
    air_way way = { job->sink, &photon };
    const rsv_fog_witness witness = { &way, cross_air };
    const rsv_fog_witness *air = job->sink->cross ? &witness : NULL;
    if (!rsv_photon_begin(&job->shooting, &job->source[s->id], s->id, index, s->count, &photon))
        return 1;
    while (rsv_photon_scatter(job->scene, &photon.path, &photon.level, &photon.random, air))
        job->sink->land(
            job->sink->user, slot, &photon.path, rgb_mul(photon.flux, photon.path.weight));
    return 1 + photon.path.rays;
}

/// The processes of a team take turns with chunks.
static uint64_t shoot_chunk(const source_job *s, size_t slot)
{
    const rsv_team_place *place = &s->job->place;
    size_t begin = ((s->first + slot) * place->size + place->rank) * PHOTONS_PER_CHUNK;
    size_t end = begin + PHOTONS_PER_CHUNK < s->count ? begin + PHOTONS_PER_CHUNK : s->count;
    uint64_t traced = 0;
    for (size_t i = begin; i < end; i++)
        traced += shoot_one(s, slot, (uint32_t)i);
    return traced;
}

static void shoot_chunks(void *data, rsv_span span)
{
    source_job *s = data;
    rsv_context *context = s->job->lights->context;
    for (size_t slot = span.begin; slot < span.end && !rsv_cancelled(context); slot++) {
        atomic_fetch_add(&s->rays, shoot_chunk(s, slot));
        double part = (double)(s->first + slot) / (double)s->chunks;
        if (span.worker == 0) rsv_progress(context, "caustics", s->done + s->share * part);
    }
}

size_t rsv_photon_slots(const rsv_context *context)
{
    return CHUNKS_PER_WAVE * (size_t)rsv_threads(context);
}

static rsv_status shoot_source(
    const photon_job *job, uint32_t id, uint32_t count, double done, uint64_t *rays)
{
    rsv_context *context = job->lights->context;
    const rsv_photon_sink *sink = job->sink;
    source_job s = { .job = job, .id = id, .count = count, .done = done };
    s.share = job->source[id].share;
    s.chunks =
        rsv_team_turns(job->place, ((size_t)count + PHOTONS_PER_CHUNK - 1) / PHOTONS_PER_CHUNK);
    size_t most = sink->collect ? rsv_photon_slots(context) : s.chunks;
    for (; s.first < s.chunks && !rsv_cancelled(context); s.first += most) {
        size_t left = s.chunks - s.first, slots = left < most ? left : most;
        rsv_parallel_for(context, slots, 1, shoot_chunks, &s);
        if (sink->collect) sink->collect(sink->user, slots);
    }
    *rays += job->place.size > 1 ? rsv_team_total(context, s.rays) : s.rays;
    return rsv_progress(context, "caustics", fmin(done + s.share, 1));
}

static double total_flux(const photon_job *job)
{
    double total = 0;
    for (size_t s = 0; s < job->source_count; s++)
        total += job->source[s].flux;
    return total;
}

static rsv_status shoot_all(const photon_job *job, uint32_t count, uint64_t *rays)
{
    rsv_status status = RSV_OK;
    double done = 0;
    for (size_t s = 0; s < job->source_count; s++) {
        uint32_t share = rsv_photons_of_source(&job->source[s], count);
        if (share) RSV_TRY(shoot_source(job, (uint32_t)s, share, done, rays));
        done += job->source[s].share;
    }
cleanup:
    return status;
}

static photon_job begin_job(const rsv_transport_scene *scene, const rsv_lights *lights,
    uint32_t seed, const rsv_photon_sink *sink)
{
    return (photon_job){ .scene = scene,
        .lights = lights,
        .shooting = { scene, NULL, seed },
        .sink = sink,
        .place = rsv_team_place_of(lights->context) };
}

/// Any sink without wishes.
static const rsv_photon_sink takes_all = { 0 };

rsv_status rsv_photon_shooter_create(const rsv_transport_scene *scene, const rsv_lights *lights,
    uint32_t seed, const rsv_photon_sink *sink, rsv_photon_shooter **shooter, uint64_t *rays)
{
    photon_job *job = rsv_alloc(lights->context, 1, sizeof *job);
    if (!job) return RSV_ERROR_MEMORY;
    *job = begin_job(scene, lights, seed, sink ? sink : &takes_all);
    rsv_status status = create_sources(job, rays);
    job->sink = NULL; // those to come have their own
    if (status == RSV_OK)
        *shooter = job;
    else
        rsv_photon_shooter_destroy(job);
    return status;
}

void rsv_photon_shooter_destroy(rsv_photon_shooter *shooter)
{
    if (!shooter) return;
    destroy_sources(shooter);
    rsv_free(shooter->lights->context, shooter);
}

rsv_status rsv_photons_send(const rsv_photon_shooter *shooter, uint32_t count, uint32_t seed,
    const rsv_photon_sink *sink, uint64_t *rays)
{
    photon_job job = *shooter;
    job.place = (rsv_team_place){ 0, 1 };
    job.shooting.seed = seed;
    job.sink = sink;
    return shoot_all(&job, count, rays);
}

rsv_status rsv_photons_trace(const rsv_transport_scene *scene, const rsv_lights *lights,
    uint32_t count, uint32_t seed, const rsv_photon_sink *sink, uint64_t *rays)
{
    rsv_photon_shooter *shooter = NULL;
    rsv_status status = rsv_photon_shooter_create(scene, lights, seed, sink, &shooter, rays);
    if (status == RSV_OK) status = rsv_photons_send(shooter, count, seed, sink, rays);
    rsv_photon_shooter_destroy(shooter);
    return status;
}

// ---- maps ---------------------------------------------------------------------------------------

typedef struct map_set {
    const rsv_transport_scene *scene;
    const rsv_photon_targets *targets;
} map_set;

static void deposit(void *user, size_t slot, const rsv_specular_path *path, rsv_rgb flux)
{
    const map_set *maps = user;
    (void)slot; // sums of whole numbers are the same in any order
    rsv_photon_land(maps->scene, path, flux, maps->targets->map, maps->targets->count);
}

static void light_air(void *user, const rsv_ray *ray, rsv_rgb flux)
{
    const map_set *maps = user;
    for (size_t m = 0; m < maps->targets->count; m++)
        if (maps->targets->elements[m]->voxels)
            rsv_photon_map_light_air(&maps->targets->map[m], maps->scene->tracer, ray, flux);
}

rsv_status rsv_photon_maps_create(
    const rsv_photon_shooter *shooter, const rsv_photon_targets *targets)
{
    rsv_status status = RSV_OK;
    double unit = fmax(total_flux(shooter), 1e-30) * 0x1p-44;
    for (size_t m = 0; m < targets->count && status == RSV_OK; m++)
        status = rsv_photon_map_create(
            shooter->lights->context, targets->elements[m], unit, &targets->map[m]);
    return status;
}

void rsv_photon_maps_finish(const rsv_photon_targets *targets)
{
    for (size_t m = 0; m < targets->count; m++) {
        rsv_photon_map_unite(&targets->map[m]);
        rsv_photon_map_settle(&targets->map[m]);
    }
}

rsv_status rsv_photons_deposit(const rsv_photon_shooter *shooter, uint32_t count,
    const rsv_photon_targets *targets, uint64_t *rays)
{
    rsv_status status = RSV_OK;
    rsv_photon_map *maps = targets->map;
    map_set set = { shooter->scene, targets };
    const rsv_photon_sink sink = { &set, deposit, .cross = light_air };
    photon_job job = *shooter;
    job.sink = &sink;
    memset(maps, 0, targets->count * sizeof *maps);
    RSV_TRY(rsv_photon_maps_create(&job, targets));
    const rsv_device_shooting_desc deal = { .shooting = job.shooting,
        .lights = job.lights,
        .source = job.source,
        .source_count = job.source_count,
        .map = maps,
        .map_count = targets->count };
    bool done;
    RSV_TRY(rsv_photons_by_device(&deal, count, rays, &done));
    for (size_t m = 0; !done && m < targets->count; m++)
        rsv_photon_map_clear(&maps[m]); // removes photons of a device that failed
    if (!done) RSV_TRY(shoot_all(&job, count, rays));
    rsv_photon_maps_finish(targets);
cleanup:
    return status;
}

rsv_status rsv_photons_shoot(const rsv_transport_scene *scene, const rsv_lights *lights,
    uint32_t count, uint32_t seed, const rsv_photon_targets *targets, uint64_t *rays)
{
    rsv_photon_shooter *shooter = NULL;
    memset(targets->map, 0, targets->count * sizeof *targets->map);
    rsv_status status = rsv_photon_shooter_create(scene, lights, seed, NULL, &shooter, rays);
    if (status == RSV_OK) status = rsv_photons_deposit(shooter, count, targets, rays);
    rsv_photon_shooter_destroy(shooter);
    return status;
}
