#include "photon_log.h"

#include "../core/parallel.h"
#include "photons_internal.h"

#include <math.h>
#include <string.h>

/// Where a photon landed, and what entered the surface there.
typedef struct landing {
    uint32_t triangle; ///< times 2, plus 1 at its back
    float u, v;
    rsv_rgb flux;
} landing;

/// Numbers of points and landings of a photon.
typedef struct photon_entry {
    uint32_t points, landings;
} photon_entry;

/// The photons of one portion of work.
typedef struct photon_chunk {
    uint32_t source, first, count; ///< photons [first, first + count) of a source
    photon_entry *photon;          ///< [count]; NULL = they have not been shot
    rsv_vec3 *point;               ///< [point_count] where rays begin and end
    landing *landed;               ///< [landed_count]
    size_t point_count, point_room, landed_count, landed_room;
} photon_chunk;

struct rsv_photon_log {
    rsv_photon_shooter *shooter;
    uint32_t photons, seed;
    rsv_vec3 low, high; ///< the scene's bounds
    photon_chunk *chunk;
    size_t chunk_count;
};

static void free_chunk(rsv_context *context, photon_chunk *c)
{
    rsv_free(context, c->photon);
    rsv_free(context, c->point);
    rsv_free(context, c->landed);
}

// ---- one photon -----------------------------------------------------------------------------------

typedef struct deposit_job {
    rsv_photon_log *log;
    const rsv_scene_change *change;
    const rsv_photon_targets *targets;
    atomic_uint_least64_t rays;
    atomic_bool failed;
} deposit_job;

/// A photon that is shot.
typedef struct flight {
    rsv_context *context;
    const rsv_transport_scene *scene;
    photon_chunk *to;
    bool complete; ///< there was memory for all of it
} flight;

static void add_point(flight *f, rsv_vec3 at)
{
    photon_chunk *c = f->to;
    f->complete = f->complete && rsv_grow(f->context, (void **)&c->point, &c->point_room,
                                     c->point_count + 1, sizeof *c->point) == RSV_OK;
    if (f->complete) c->point[c->point_count++] = at;
}

static void add_landing(flight *f, landing at)
{
    photon_chunk *c = f->to;
    f->complete = f->complete && rsv_grow(f->context, (void **)&c->landed, &c->landed_room,
                                     c->landed_count + 1, sizeof *c->landed) == RSV_OK;
    if (f->complete) c->landed[c->landed_count++] = at;
}

static landing landing_of(const flight *f, const rsv_photon *photon)
{
    const rsv_specular_path *path = &photon->path;
    rsv_rgb flux = rgb_mul(photon->flux, path->weight);
    return (landing){ 2 * path->triangle + path->back, path->u, path->v,
        rsv_photon_enter(f->scene, path, flux) };
}

static rsv_vec3 point_of(const rsv_transport_scene *scene, const rsv_specular_path *path)
{
    return rsv_surface_point_at(scene->view, path->triangle, path->u, path->v, path->back).position;
}

/// A point on a ray that leaves the scene, outside it.
static rsv_vec3 point_outside(const rsv_transport_scene *scene, rsv_vec3 from, rsv_vec3 direction)
{
    const rsv_scene_view *view = scene->view;
    rsv_vec3 middle = v3_scale(v3_add(view->bounds_min, view->bounds_max), 0.5f);
    float size = v3_length(v3_sub(view->bounds_max, view->bounds_min));
    return v3_add(from, v3_scale(direction, v3_length(v3_sub(from, middle)) + size));
}

/// Goes on to the next surface, and notes where that is. @return as rsv_photon_step
static bool step(flight *f, rsv_photon *photon)
{
    const rsv_specular_path before = photon->path;
    rsv_specular_path *path = &photon->path;
    bool goes_on = rsv_photon_step(f->scene, path, &photon->level, &photon->random, NULL);
    if (path->rays == before.rays) return false; // it ended where it was
    bool met = path->triangle != before.triangle || path->u != before.u || path->v != before.v;
    add_point(f, met ? point_of(f->scene, path)
                     : point_outside(f->scene, point_of(f->scene, path), path->direction));
    return goes_on;
}

/// Shoots a photon; its path goes to the end of a chunk. @return rays
static uint64_t shoot(flight *f, const rsv_photon_log *log, uint32_t source, uint32_t index)
{
    const rsv_photon_shooter *s = log->shooter;
    uint32_t count = rsv_photons_of_source(&s->source[source], log->photons);
    rsv_photon photon;
    rsv_photon_emission e =
        rsv_photon_set_out(&s->shooting, &s->source[source], source, index, count, &photon);
    photon.path.triangle = RSV_NONE;
    bool goes_on = rsv_photon_arrive(f->scene, &e, &photon.path);
    bool met = photon.path.triangle != RSV_NONE;
    add_point(f, e.origin);
    add_point(
        f, met ? point_of(f->scene, &photon.path) : point_outside(f->scene, e.origin, e.direction));
    while (goes_on && step(f, &photon)) {
        if (photon.path.turns > 0)
            add_landing(f, landing_of(f, &photon));
        else
            goes_on =
                rsv_is_specular(&f->scene->bsdf[rsv_specular_material(f->scene, &photon.path)]);
    }
    return 1 + (met ? photon.path.rays : 0);
}

// ---- what moved -----------------------------------------------------------------------------------

/// Narrows the part [t0, t1] of a segment that lies between two planes.
static void narrow(float from, float to, float low, float high, float *t0, float *t1)
{
    float way = to - from;
    if (way == 0) {
        if (from < low || from > high) *t1 = -1;
        return;
    }
    float a = (low - from) / way, b = (high - from) / way;
    *t0 = f_max(*t0, f_min(a, b));
    *t1 = f_min(*t1, f_max(a, b));
}

static bool meets_box(rsv_vec3 a, rsv_vec3 b, rsv_vec3 low, rsv_vec3 high)
{
    float t0 = 0, t1 = 1;
    narrow(a.x, b.x, low.x, high.x, &t0, &t1);
    narrow(a.y, b.y, low.y, high.y, &t0, &t1);
    narrow(a.z, b.z, low.z, high.z, &t0, &t1);
    return t0 <= t1;
}

static bool is_met(const rsv_vec3 *point, uint32_t points, const rsv_scene_change *change)
{
    for (uint32_t k = 0; k + 1 < points; k++)
        for (uint32_t b = 0; b < change->count; b++)
            if (meets_box(point[k], point[k + 1], change->low[b], change->high[b])) return true;
    return false;
}

// ---- portions of work -----------------------------------------------------------------------------

static void copy_photon(
    flight *f, const photon_chunk *from, size_t point, size_t landed, photon_entry entry)
{
    for (uint32_t k = 0; k < entry.points; k++)
        add_point(f, from->point[point + k]);
    for (uint32_t k = 0; k < entry.landings; k++)
        add_landing(f, from->landed[landed + k]);
}

/// Photons as they are now. @param then as they were, and which photons they are @return rays
static uint64_t renew(const deposit_job *job, const photon_chunk *then, flight *f)
{
    uint64_t rays = 0;
    size_t point = 0, landed = 0;
    photon_chunk *now = f->to;
    for (uint32_t k = 0; k < then->count && f->complete; k++) {
        size_t points = now->point_count, landings = now->landed_count;
        photon_entry entry = then->photon ? then->photon[k] : (photon_entry){ 0, 0 };
        if (then->photon && !is_met(then->point + point, entry.points, job->change))
            copy_photon(f, then, point, landed, entry);
        else
            rays += shoot(f, job->log, then->source, then->first + k);
        point += entry.points;
        landed += entry.landings;
        now->photon[k] = (photon_entry){ (uint32_t)(now->point_count - points),
            (uint32_t)(now->landed_count - landings) };
    }
    return rays;
}

static bool is_met_anywhere(const photon_chunk *c, const rsv_scene_change *change)
{
    size_t point = 0;
    for (uint32_t k = 0; k < c->count; k++) {
        if (is_met(c->point + point, c->photon[k].points, change)) return true;
        point += c->photon[k].points;
    }
    return false;
}

static bool renew_chunk(deposit_job *job, photon_chunk *c)
{
    rsv_context *context = job->log->shooter->lights->context;
    if (c->photon && !is_met_anywhere(c, job->change)) return true;
    photon_chunk now = { .source = c->source, .first = c->first, .count = c->count };
    now.photon = rsv_reserve(context, c->count, sizeof *now.photon);
    flight f = { context, job->log->shooter->scene, &now, now.photon != NULL };
    if (f.complete) atomic_fetch_add(&job->rays, renew(job, c, &f));
    free_chunk(context, f.complete ? c : &now);
    if (f.complete) *c = now;
    return f.complete;
}

static void deposit(const photon_chunk *c, const rsv_photon_targets *targets)
{
    for (size_t k = 0; k < c->landed_count; k++) {
        const landing *l = &c->landed[k];
        for (size_t m = 0; m < targets->count; m++)
            rsv_photon_map_deposit(
                &targets->map[m], l->triangle & 1, l->triangle / 2, l->u, l->v, l->flux);
    }
}

static void take_chunks(void *data, rsv_span span)
{
    deposit_job *job = data;
    rsv_context *context = job->log->shooter->lights->context;
    for (size_t k = span.begin; k < span.end && !rsv_cancelled(context); k++) {
        if (renew_chunk(job, &job->log->chunk[k]))
            deposit(&job->log->chunk[k], job->targets);
        else
            job->failed = true;
    }
}

// ---- all of them ----------------------------------------------------------------------------------

/// Whether most of a body's light goes on, as that of glass and metal does.
static bool is_all_specular(const rsv_bsdf *bsdf)
{
    return rsv_is_specular(bsdf) && (bsdf->diffuse < 1 || bsdf->opacity < 1);
}

static bool same_place(rsv_vec3 a, rsv_vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

bool rsv_photons_can_be_kept(const rsv_transport_scene *scene, const uint8_t *moved)
{
    const rsv_scene_view *view = scene->view;
    for (size_t t = 0; t < view->triangle_count; t++)
        if (moved[t] && is_all_specular(&scene->bsdf[view->triangle_material[t]])) return false;
    return !view->fog;
}

bool rsv_photon_log_fits(
    const rsv_photon_log *log, const rsv_transport_scene *scene, uint32_t count, uint32_t seed)
{
    const rsv_scene_view *view = scene->view;
    return log && log->photons == count && log->seed == seed &&
           same_place(log->low, view->bounds_min) && same_place(log->high, view->bounds_max);
}

static void take_source(rsv_photon_log *log, uint32_t source, photon_chunk *chunk)
{
    uint32_t count = rsv_photons_of_source(&log->shooter->source[source], log->photons);
    for (uint32_t first = 0; first < count; first += PHOTONS_PER_CHUNK) {
        uint32_t left = count - first;
        if (chunk)
            chunk[log->chunk_count] = (photon_chunk){ .source = source,
                .first = first,
                .count = left < PHOTONS_PER_CHUNK ? left : PHOTONS_PER_CHUNK };
        log->chunk_count++;
    }
}

/// @param chunk NULL = they are only counted
static void take_sources(rsv_photon_log *log, photon_chunk *chunk)
{
    log->chunk_count = 0;
    for (uint32_t s = 0; s < log->shooter->source_count; s++)
        take_source(log, s, chunk);
}

rsv_status rsv_photon_log_create(const rsv_transport_scene *scene, const rsv_lights *lights,
    uint32_t count, uint32_t seed, rsv_photon_log **created, uint64_t *rays)
{
    rsv_status status;
    rsv_photon_log *log = rsv_alloc(lights->context, 1, sizeof *log);
    if (!log) return RSV_ERROR_MEMORY;
    RSV_TRY(rsv_photon_shooter_create(scene, lights, seed, NULL, &log->shooter, rays));
    log->photons = count;
    log->seed = seed;
    log->low = scene->view->bounds_min;
    log->high = scene->view->bounds_max;
    take_sources(log, NULL);
    log->chunk = rsv_alloc(lights->context, log->chunk_count, sizeof *log->chunk);
    RSV_TRY(log->chunk ? RSV_OK : RSV_ERROR_MEMORY);
    take_sources(log, log->chunk);
    *created = log;
    return RSV_OK;
cleanup:
    if (!log->shooter)
        rsv_free(lights->context, log);
    else
        rsv_photon_log_destroy(log);
    return status;
}

rsv_status rsv_photon_log_deposit(rsv_photon_log *log, const rsv_transport_scene *scene,
    const rsv_lights *lights, const rsv_scene_change *change, const rsv_photon_targets *targets,
    uint64_t *rays)
{
    rsv_status status;
    deposit_job job = { .log = log, .change = change, .targets = targets };
    rsv_photon_shooter *shooter = log->shooter;
    shooter->scene = shooter->shooting.scene = shooter->origins.scene = scene;
    shooter->lights = shooter->origins.lights = lights;
    memset(targets->map, 0, targets->count * sizeof *targets->map);
    RSV_TRY(rsv_photon_maps_create(shooter, targets));
    rsv_parallel_for(lights->context, log->chunk_count, 1, take_chunks, &job);
    *rays += job.rays;
    RSV_TRY(job.failed ? RSV_ERROR_MEMORY : RSV_OK);
    RSV_TRY(rsv_progress(lights->context, "caustics", 1));
    rsv_photon_maps_finish(targets);
cleanup:
    return status;
}

void rsv_photon_log_destroy(rsv_photon_log *log)
{
    if (!log) return;
    rsv_context *context = log->shooter->lights->context;
    for (size_t k = 0; log->chunk && k < log->chunk_count; k++)
        free_chunk(context, &log->chunk[k]);
    rsv_free(context, log->chunk);
    rsv_photon_shooter_destroy(log->shooter);
    rsv_free(context, log);
}
