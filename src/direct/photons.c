#include "photons.h"

#include "../core/team.h"
#include "photon_guide.h"
#include "photon_origin.h"
#include "photon_turn.h"

#include <string.h>

#define PHOTONS_PER_CHUNK 4096
/// The strongest origins have a guide each; all others share one.
#define OWN_GUIDES 63
/// Rounds of pilot rays, each on bins that are finer where the last ones found something.
#define MOST_PILOTS 4
/// Worth of photons whose first landing is of no use; later ones may be.
#define UNWANTED 0.1f

/// Origins of light paths that share one guide.
typedef struct photon_source {
    uint32_t first, count;  ///< origins
    double flux;            ///< of all of them: luminance, W
    double share;           ///< of all photons
    rsv_photon_guide guide; ///< towards specular surfaces
} photon_source;

typedef struct photon_job {
    const rsv_transport_scene *scene;
    const rsv_lights *lights;
    rsv_photon_origins origins;
    photon_source source[OWN_GUIDES + 1];
    size_t source_count;
    uint32_t seed;
    const rsv_photon_sink *sink;
    rsv_team_place place; ///< in the team whose processes take turns with chunks
} photon_job;

static bool is_specular(const rsv_bsdf *bsdf)
{
    return (!bsdf->lambert && !bsdf->unlit) || bsdf->opacity < 1;
}

bool rsv_photons_wanted(const rsv_transport_scene *scene, const rsv_lights *lights)
{
    bool specular = false, source = scene->view->light_count > 0;
    for (size_t m = 0; m < scene->view->material_count; m++)
        specular = specular || (is_specular(&scene->bsdf[m]) &&
                                   (scene->bsdf[m].coated || scene->bsdf[m].diffuse < 1 ||
                                       scene->bsdf[m].opacity < 1));
    for (size_t g = 0; g < lights->group_count; g++)
        source = source || !lights->group[g].gathered;
    source = source || (lights->environment && lights->environment->sun_count > 0);
    return specular && source;
}

static bool first_hit(const photon_job *job, const rsv_photon_emission *e, rsv_chain *chain)
{
    rsv_ray ray = { e->origin, e->direction, INFINITY };
    rsv_hit hit;
    if (!rsv_tracer_closest(job->scene->tracer, &ray, &hit)) return false;
    *chain =
        rsv_chain_begin(job->scene, e->medium, e->direction, hit.triangle, hit.u, hit.v, hit.t);
    return true;
}

static bool hits_specular(const photon_job *job, const rsv_chain *chain)
{
    return is_specular(&job->scene->bsdf[job->scene->view->triangle_material[chain->triangle]]);
}

// ---- sources ------------------------------------------------------------------------------------

/// Draws a specular event of a photon. At its first surface it always leaves, with less flux, so that faint coats have
/// as many photons as their light is worth.
static rsv_bsdf_event draw(const photon_job *job, const rsv_chain *chain, rsv_random *random)
{
    rsv_bsdf storage;
    bool covered = rsv_chain_bsdf(job->scene, chain, &storage)->opacity >= 1;
    if (!covered || chain->events > 0) return rsv_chain_draw_event(job->scene, chain, random);
    float u[3];
    for (int k = 0; k < 3; k++)
        u[k] = rsv_random_float(random);
    return rsv_chain_draw_specular(job->scene, chain, u);
}

/// Leaves a surface by one of its specular lobes. False if the photon ends.
/// @param level weight that photons keep: what the first surface leaves of them
static bool scatter(const photon_job *job, rsv_chain *chain, float *level, rsv_random *random)
{
    rsv_bsdf_event event = draw(job, chain, random);
    bool specular = event.lobe == RSV_LOBE_REFLECT || event.lobe == RSV_LOBE_TRANSMIT;
    if (!specular || chain->events >= RSV_CHAIN_MAX_EVENTS) return false;
    bool transmit = event.lobe == RSV_LOBE_TRANSMIT;
    rsv_rgb weight = rgb_mul(event.weight, rsv_photon_turn(job->scene, chain, &event));
    if (rsv_chain_step(job->scene, chain, transmit, event.direction, weight) != RSV_CHAIN_MOVED)
        return false;
    float left = rgb_max(chain->weight);
    if (chain->events == 1) *level = left;
    if (left >= *level) return left > 0;
    if (rsv_random_float(random) * *level >= left) return false;
    chain->weight = rgb_scale(chain->weight, *level / left);
    return true;
}

/// What a photon that has met a specular surface is worth: the share of its flux that goes on to another surface where
/// it is wanted.
static float worth(const photon_job *job, rsv_chain *chain, rsv_random *random)
{
    float level;
    if (!scatter(job, chain, &level, random)) return 0;
    bool wanted = !job->sink->wants || job->sink->wants(job->sink->user, chain);
    return f_min(level, 1) * (wanted ? 1 : UNWANTED);
}

static void pilot_bin(const photon_job *job, const photon_source *source, uint32_t id,
    const rsv_guide_grid *grid, int bin, float *useful)
{
    rsv_random random = rsv_random_from(job->seed ^ 0x9107u, id, (uint32_t)bin);
    const float *across = grid->x + bin % RSV_GUIDE_SIDE, *down = grid->y + bin / RSV_GUIDE_SIDE;
    useful[bin] = 0;
    for (int k = 0; k < RSV_GUIDE_RAYS; k++) {
        float x = across[0] + (across[1] - across[0]) * rsv_random_float(&random);
        float y = down[0] + (down[1] - down[0]) * rsv_random_float(&random);
        rsv_photon_emission e =
            rsv_photon_emit(&job->origins, source->first, source->count, x, y, &random);
        rsv_chain chain;
        if (first_hit(job, &e, &chain) && hits_specular(job, &chain))
            useful[bin] += worth(job, &chain, &random);
    }
}

static void pilot(const photon_job *job, const photon_source *source, uint32_t id,
    const rsv_guide_grid *grid, float *useful)
{
#pragma omp parallel for schedule(dynamic, 64) num_threads(rsv_threads(job->lights->context))
    for (int bin = 0; bin < RSV_GUIDE_SIDE * RSV_GUIDE_SIDE; bin++)
        pilot_bin(job, source, id, grid, bin, useful);
}

static rsv_status create_guide(
    const photon_job *job, photon_source *source, uint32_t id, uint64_t *rays)
{
    rsv_context *context = job->lights->context;
    const int bins = RSV_GUIDE_SIDE * RSV_GUIDE_SIDE;
    rsv_guide_grid grid = rsv_guide_grid_even();
    float *useful = rsv_alloc(context, (size_t)bins, sizeof *useful);
    if (!useful) return RSV_ERROR_MEMORY;
    uint64_t rounds = 1;
    pilot(job, source, id, &grid, useful);
    for (; rounds < MOST_PILOTS && rsv_guide_grid_zoom(&grid, useful); rounds++)
        pilot(job, source, id, &grid, useful);
    *rays += rounds * (uint64_t)bins * RSV_GUIDE_RAYS;
    rsv_status status = rsv_photon_guide_create(context, &grid, useful, &source->guide);
    rsv_free(context, useful);
    return status;
}

static void share_out(photon_job *job)
{
    for (uint32_t k = 0; k < job->origins.count; k++) {
        bool own = k <= OWN_GUIDES;
        photon_source *source = &job->source[own ? job->source_count++ : OWN_GUIDES];
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
    share_out(job);
    for (size_t s = 0; s < job->source_count; s++) {
        photon_source *source = &job->source[s];
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

static uint64_t shoot_one(
    const photon_job *job, const photon_source *source, uint32_t id, uint32_t index, uint32_t count)
{
    rsv_random random = rsv_random_from(job->seed ^ 0x3c6ef35fu, id, index);
    float x, y;
    rsv_sobol_2d(index, rsv_hash2(job->seed, id), &x, &y);
    float density = rsv_photon_guide_warp(&source->guide, &x, &y);
    rsv_photon_emission e =
        rsv_photon_emit(&job->origins, source->first, source->count, x, y, &random);
    rsv_chain chain;
    if (!first_hit(job, &e, &chain) || !hits_specular(job, &chain)) return 1;
    rsv_rgb flux = rgb_scale(e.flux, 1 / (density * (float)count));
    float level;
    while (scatter(job, &chain, &level, &random))
        job->sink->land(job->sink->user, &chain, rgb_mul(flux, chain.weight));
    return 1 + chain.rays;
}

static rsv_status shoot_source(const photon_job *job, const photon_source *source, uint32_t id,
    uint32_t count, double done, uint64_t *rays)
{
    rsv_context *context = job->lights->context;
    uint64_t traced = 0;
    uint32_t chunks = (count + PHOTONS_PER_CHUNK - 1) / PHOTONS_PER_CHUNK;
#pragma omp parallel for ordered schedule(dynamic, 1) num_threads(rsv_threads(context))            \
    reduction(+ : traced)
    for (uint32_t chunk = job->place.rank; chunk < chunks; chunk += job->place.size) {
        if (rsv_cancelled(context)) continue;
        uint32_t begin = chunk * PHOTONS_PER_CHUNK, end = begin + PHOTONS_PER_CHUNK;
        for (uint32_t i = begin; i < (end < count ? end : count); i++)
            traced += shoot_one(job, source, id, i, count);
#pragma omp ordered
        {
            if (job->sink->collect) job->sink->collect(job->sink->user);
        }
        if (rsv_thread_index() == 0)
            rsv_progress(context, "caustics", done + source->share * chunk / chunks);
    }
    *rays += job->place.size > 1 ? rsv_team_total(context, traced) : traced;
    return rsv_progress(context, "caustics", fmin(done + source->share, 1));
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
        uint32_t share = (uint32_t)ceil(job->source[s].share * count);
        if (share) RSV_TRY(shoot_source(job, &job->source[s], (uint32_t)s, share, done, rays));
        done += job->source[s].share;
    }
cleanup:
    return status;
}

rsv_status rsv_photons_trace(const rsv_transport_scene *scene, const rsv_lights *lights,
    uint32_t count, uint32_t seed, const rsv_photon_sink *sink, uint64_t *rays)
{
    photon_job job = {
        .scene = scene, .lights = lights, .seed = seed, .sink = sink, .place = { 0, 1 }
    };
    rsv_status status = create_sources(&job, rays);
    if (status == RSV_OK) status = shoot_all(&job, count, rays);
    destroy_sources(&job);
    return status;
}

// ---- maps ---------------------------------------------------------------------------------------

typedef struct map_set {
    const rsv_transport_scene *scene;
    rsv_photon_map *map;
    size_t count;
} map_set;

static void deposit(void *user, const rsv_chain *chain, rsv_rgb flux)
{
    const map_set *maps = user;
    rsv_vec3 shading, geometric;
    rsv_chain_normals(maps->scene, chain, &shading, &geometric);
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_chain_bsdf(maps->scene, chain, &storage);
    rsv_rgb entered = rgb_mul(flux, rsv_bsdf_entry(bsdf, -v3_dot(shading, chain->direction)));
    for (size_t m = 0; m < maps->count; m++)
        rsv_photon_map_deposit(
            &maps->map[m], chain->back, chain->triangle, chain->u, chain->v, entered);
}

rsv_status rsv_photons_shoot(const rsv_transport_scene *scene, const rsv_lights *lights,
    uint32_t count, uint32_t seed, const rsv_elements *const *elements, rsv_photon_map *maps,
    size_t map_count, uint64_t *rays)
{
    rsv_status status = RSV_OK;
    map_set set = { scene, maps, map_count };
    const rsv_photon_sink sink = { &set, deposit, NULL, NULL };
    photon_job job = { .scene = scene,
        .lights = lights,
        .seed = seed,
        .sink = &sink,
        .place = rsv_team_place_of(lights->context) };
    memset(maps, 0, map_count * sizeof *maps);
    RSV_TRY(create_sources(&job, rays));
    for (size_t m = 0; m < map_count; m++)
        RSV_TRY(rsv_photon_map_create(
            lights->context, elements[m], fmax(total_flux(&job), 1e-30) * 0x1p-44, &maps[m]));
    RSV_TRY(shoot_all(&job, count, rays));
    for (size_t m = 0; m < map_count; m++) {
        rsv_photon_map_unite(&maps[m]);
        rsv_photon_map_settle(&maps[m]);
    }
cleanup:
    destroy_sources(&job);
    return status;
}
