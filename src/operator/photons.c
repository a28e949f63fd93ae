#include "photons.h"

#include "../core/alias_table.h"

#include <stdlib.h>
#include <string.h>

#define GUIDE_SIDE 64     ///< bins of a source's guide along each side of its unit square
#define GUIDE_RAYS 4      ///< pilot rays per bin
#define GUIDED_SHARE 0.9f ///< the rest goes everywhere alike, as the source would by itself
#define PHOTONS_PER_CHUNK 4096
/// The strongest lights have a guide each; all others share one.
#define OWN_GUIDES 63

typedef enum origin_kind { ORIGIN_GROUP, ORIGIN_LIGHT, ORIGIN_SUN } origin_kind;

/// A group of emitters, a punctual light or a sun.
typedef struct photon_origin {
    origin_kind kind;
    uint32_t index;
    double flux; ///< luminance, W
    rsv_medium medium;
} photon_origin;

/// Origins of light paths with one guide over the unit square that their directions come from.
typedef struct photon_source {
    uint32_t first, count; ///< origins
    double flux;           ///< of all of them: luminance, W
    double share;          ///< of all photons
    float useful;          ///< share of pilot rays that met specular surfaces
    float *row_cdf;        ///< [GUIDE_SIDE]
    float *cell_cdf;       ///< [GUIDE_SIDE * GUIDE_SIDE], per row
    float *density;        ///< [GUIDE_SIDE * GUIDE_SIDE] of the guided distribution over the square
} photon_source;

typedef struct photon_job {
    const rsv_transport_scene *scene;
    const rsv_lights *lights;
    photon_origin *origin;          ///< the strongest first
    rsv_alias_entry *origin_table;  ///< [origin_count] by flux within each source
    rsv_alias_entry *emitter_table; ///< [emitter_count] by power within each group
    size_t origin_count;
    photon_source *source;
    size_t source_count;
    rsv_vec3 centre; ///< of the scene's bounding sphere
    float radius;
    uint32_t seed;
    rsv_photon_map *maps;
    size_t map_count;
} photon_job;

/// A photon as it leaves its source.
typedef struct emission {
    rsv_vec3 origin, direction;
    rsv_rgb flux; ///< of the whole source if it all left like this: W
    const rsv_medium *medium;
} emission;

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

// ---- emission -----------------------------------------------------------------------------------

static rsv_vec3 to_world(rsv_vec3 local, rsv_vec3 axis)
{
    rsv_vec3 t, b;
    v3_frame(axis, &t, &b);
    return v3_mad(v3_mad(v3_scale(t, local.x), local.y, b), local.z, axis);
}

static emission emit_from_group(
    const photon_job *job, uint32_t group, float x, float y, rsv_random *random)
{
    const rsv_emitter_group *g = &job->lights->group[group];
    uint32_t index = g->first + rsv_alias_table_draw(job->emitter_table + g->first, g->count,
                                    rsv_random_float(random));
    const rsv_emitter *e = &job->lights->emitter[index];
    float u, v;
    rsv_square_to_triangle(rsv_random_float(random), rsv_random_float(random), &u, &v);
    bool back = e->double_sided && (rsv_random_bits(random) & 1u);
    rsv_vec3 normal = back ? v3_neg(e->normal) : e->normal;
    rsv_vec3 point = v3_barycentric(e->corner[0], e->corner[1], e->corner[2], u, v);
    emission out;
    out.origin =
        rsv_offset_origin(point, normal, rsv_triangle_extent(job->scene->view, e->triangle));
    out.direction = to_world(rsv_square_to_cosine_hemisphere(x, y), normal);
    double probability = rsv_emitter_power(e) / g->power;
    out.flux = rgb_scale(rsv_emitter_radiance(job->lights, index, u, v),
        (float)(M_PI * e->area * (e->double_sided ? 2 : 1) / probability));
    return out;
}

/// Parallel light that fills the scene's bounding sphere.
static emission emit_from_afar(
    const photon_job *job, rsv_vec3 travels, rsv_rgb irradiance, float x, float y)
{
    float dx, dy;
    rsv_square_to_disk(x, y, &dx, &dy);
    rsv_vec3 offset = to_world(v3(dx * job->radius, dy * job->radius, -2 * job->radius), travels);
    return (emission){ .origin = v3_add(job->centre, offset),
        .direction = travels,
        .flux = rgb_scale(irradiance, RSV_PI * job->radius * job->radius) };
}

static emission emit_from_sun(
    const photon_job *job, uint32_t index, float x, float y, rsv_random *random)
{
    const rsv_sun *sun = &job->lights->environment->sun[index];
    float u = rsv_random_float(random);
    rsv_vec3 towards = rsv_sun_sample(sun, u, rsv_random_float(random));
    return emit_from_afar(job, v3_neg(towards), rgb_scale(sun->radiance, sun->solid_angle), x, y);
}

static emission emit_from_light(const photon_job *job, uint32_t light_index, float x, float y)
{
    const rsv_light *light = &job->scene->view->light[light_index];
    emission out = { .origin = light->position };
    if (light->kind == RSV_LIGHT_DIRECTIONAL)
        return emit_from_afar(job, light->direction, light->intensity, x, y);
    float solid_angle = 4 * RSV_PI;
    if (light->kind == RSV_LIGHT_POINT) {
        out.direction = rsv_square_to_sphere(x, y);
    } else {
        float cos_outer = cosf(light->outer_cone_angle);
        float cos = 1 - x * (1 - cos_outer), sin = sqrtf(f_max(0, 1 - cos * cos));
        float phi = 2 * RSV_PI * y;
        out.direction = to_world(v3(sin * cosf(phi), sin * sinf(phi), cos), light->direction);
        solid_angle = 2 * RSV_PI * (1 - cos_outer);
    }
    rsv_vec3 back;
    float distance;
    rsv_rgb intensity; // the irradiance one metre away
    if (rsv_punctual_light(
            light, v3_add(light->position, out.direction), &back, &distance, &intensity))
        out.flux = rgb_scale(intensity, solid_angle);
    return out;
}

static emission emit(
    const photon_job *job, const photon_source *source, float x, float y, rsv_random *random)
{
    uint32_t drawn = 0;
    if (source->count > 1)
        drawn = rsv_alias_table_draw(
            job->origin_table + source->first, source->count, rsv_random_float(random));
    const photon_origin *origin = &job->origin[source->first + drawn];
    emission out = origin->kind == ORIGIN_GROUP ? emit_from_group(job, origin->index, x, y, random)
                   : origin->kind == ORIGIN_SUN ? emit_from_sun(job, origin->index, x, y, random)
                                                : emit_from_light(job, origin->index, x, y);
    out.medium = &origin->medium;
    if (source->count > 1) out.flux = rgb_scale(out.flux, (float)(source->flux / origin->flux));
    return out;
}

// ---- guides -------------------------------------------------------------------------------------

static bool first_hit(const photon_job *job, const emission *e, rsv_chain *chain)
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

/// Cumulative sums of a row or column of weights, normalised; returns the sum.
static float accumulate(const float *weight, float *cdf, int count)
{
    float sum = 0;
    for (int k = 0; k < count; k++)
        cdf[k] = sum += weight[k];
    for (int k = 0; k < count; k++)
        cdf[k] = sum > 0 ? cdf[k] / sum : (float)(k + 1) / (float)count;
    return sum;
}

static void finish_guide(photon_source *source, const float *useful)
{
    const int bins = GUIDE_SIDE * GUIDE_SIDE;
    float row_sum[GUIDE_SIDE], total = 0;
    for (int k = 0; k < bins; k++)
        total += useful[k];
    source->useful = total / ((float)bins * GUIDE_RAYS);
    for (int k = 0; k < bins; k++)
        source->density[k] =
            total > 0 ? GUIDED_SHARE * useful[k] * (float)bins / total + (1 - GUIDED_SHARE) : 1;
    for (int row = 0; row < GUIDE_SIDE; row++) {
        int first = row * GUIDE_SIDE;
        row_sum[row] = accumulate(source->density + first, source->cell_cdf + first, GUIDE_SIDE);
    }
    accumulate(row_sum, source->row_cdf, GUIDE_SIDE);
}

static void pilot_bin(
    const photon_job *job, const photon_source *source, uint32_t id, int bin, float *useful)
{
    rsv_random random = rsv_random_from(job->seed ^ 0x9107u, id, (uint32_t)bin);
    for (int k = 0; k < GUIDE_RAYS; k++) {
        float x = ((float)(bin % GUIDE_SIDE) + rsv_random_float(&random)) / GUIDE_SIDE;
        float y = ((float)(bin / GUIDE_SIDE) + rsv_random_float(&random)) / GUIDE_SIDE;
        emission e = emit(job, source, x, y, &random);
        rsv_chain chain;
        if (first_hit(job, &e, &chain) && hits_specular(job, &chain)) useful[bin] += 1;
    }
}

/// Neighbouring bins get part of a bin's weight: what the few pilot rays missed at an object's rim.
static void blur(const float *in, float *out)
{
    for (int y = 0; y < GUIDE_SIDE; y++) {
        for (int x = 0; x < GUIDE_SIDE; x++) {
            float sum = in[y * GUIDE_SIDE + x];
            for (int n = 0; n < 9; n++) {
                int nx = x + n % 3 - 1, ny = y + n / 3 - 1;
                if (nx < 0 || ny < 0 || nx >= GUIDE_SIDE || ny >= GUIDE_SIDE) continue;
                sum += 0.25f * in[ny * GUIDE_SIDE + nx];
            }
            out[y * GUIDE_SIDE + x] = sum;
        }
    }
}

static rsv_status create_guide(
    const photon_job *job, photon_source *source, uint32_t id, uint64_t *rays)
{
    rsv_context *context = job->lights->context;
    const size_t bins = GUIDE_SIDE * GUIDE_SIDE;
    source->row_cdf = rsv_alloc(context, GUIDE_SIDE, sizeof(float));
    source->cell_cdf = rsv_alloc(context, bins, sizeof(float));
    source->density = rsv_alloc(context, bins, sizeof(float));
    float *useful = rsv_alloc(context, bins, sizeof *useful);
    float *blurred = rsv_alloc(context, bins, sizeof *blurred);
    rsv_status status = RSV_ERROR_MEMORY;
    if (source->row_cdf && source->cell_cdf && source->density && useful && blurred) {
#pragma omp parallel for schedule(dynamic, 64) num_threads(rsv_threads(context))
        for (int bin = 0; bin < GUIDE_SIDE * GUIDE_SIDE; bin++)
            pilot_bin(job, source, id, bin, useful);
        blur(useful, blurred);
        finish_guide(source, blurred);
        *rays += bins * GUIDE_RAYS;
        status = RSV_OK;
    }
    rsv_free(context, useful);
    rsv_free(context, blurred);
    return status;
}

/// Entry of a cumulative table that holds x, which becomes its place within it.
static int invert(const float *cdf, int count, float *x)
{
    int k = 0, last = count - 1;
    while (k < last) {
        int middle = (k + last) / 2;
        if (*x < cdf[middle])
            last = middle;
        else
            k = middle + 1;
    }
    float low = k ? cdf[k - 1] : 0, width = cdf[k] - low;
    *x = width > 0 ? f_min((*x - low) / width, 0x1.fffffep-1f) : 0.5f;
    return k;
}

/// Warps a uniform point of the unit square by the guide, neighbours to neighbours, so that points of a
/// quasi-random set stay spread out. Returns the density there.
static float guide(const photon_source *source, float *x, float *y)
{
    int row = invert(source->row_cdf, GUIDE_SIDE, y);
    int column = invert(source->cell_cdf + row * GUIDE_SIDE, GUIDE_SIDE, x);
    *x = f_min(((float)column + *x) / GUIDE_SIDE, 0x1.fffffep-1f);
    *y = f_min(((float)row + *y) / GUIDE_SIDE, 0x1.fffffep-1f);
    return source->density[row * GUIDE_SIDE + column];
}

// ---- sources ------------------------------------------------------------------------------------

static double light_flux(const photon_job *job, const rsv_light *light)
{
    double intensity = rgb_luminance(light->intensity);
    if (light->kind == RSV_LIGHT_DIRECTIONAL) return intensity * RSV_PI * job->radius * job->radius;
    double cos_outer = light->kind == RSV_LIGHT_SPOT ? cos(light->outer_cone_angle) : -1;
    return intensity * 2 * RSV_PI * (1 - cos_outer);
}

static double sun_flux(const photon_job *job, const rsv_sun *sun)
{
    return (double)rgb_luminance(sun->radiance) * sun->solid_angle * M_PI * job->radius *
           job->radius;
}

/// One point of a group speaks for all.
static rsv_medium group_medium(const photon_job *job, uint32_t group)
{
    const rsv_emitter *e = &job->lights->emitter[job->lights->group[group].first];
    rsv_vec3 centre = v3_barycentric(e->corner[0], e->corner[1], e->corner[2], 1.0f / 3, 1.0f / 3);
    float extent = rsv_triangle_extent(job->scene->view, e->triangle);
    return rsv_medium_above(
        &job->scene->media, rsv_offset_origin(centre, e->normal, extent), e->normal);
}

static rsv_medium origin_medium(const photon_job *job, origin_kind kind, uint32_t index)
{
    if (kind == ORIGIN_GROUP) return group_medium(job, index);
    const rsv_light *light = &job->scene->view->light[index];
    if (kind == ORIGIN_SUN || light->kind == RSV_LIGHT_DIRECTIONAL)
        return (rsv_medium){ .depth = 0 };
    return rsv_medium_above(&job->scene->media, light->position, v3(0, 1, 0));
}

static void add_origin(photon_job *job, origin_kind kind, uint32_t index, double flux)
{
    if (!(flux > 0)) return;
    job->origin[job->origin_count++] =
        (photon_origin){ kind, index, flux, origin_medium(job, kind, index) };
}

static int compare_origins(const void *left, const void *right)
{
    const photon_origin *a = left, *b = right;
    if (a->flux != b->flux) return a->flux < b->flux ? 1 : -1;
    if (a->kind != b->kind) return a->kind < b->kind ? -1 : 1;
    return (a->index > b->index) - (a->index < b->index);
}

/// Everything that photons start from, the strongest first.
static rsv_status list_origins(photon_job *job)
{
    const rsv_lights *lights = job->lights;
    const rsv_scene_view *view = job->scene->view;
    uint32_t suns = lights->environment ? lights->environment->sun_count : 0;
    size_t capacity = lights->group_count + view->light_count + suns;
    job->origin = rsv_alloc(lights->context, capacity, sizeof *job->origin);
    if (!job->origin) return RSV_ERROR_MEMORY;
    for (uint32_t g = 0; g < lights->group_count; g++)
        if (!lights->group[g].gathered) add_origin(job, ORIGIN_GROUP, g, lights->group[g].power);
    for (uint32_t l = 0; l < view->light_count; l++)
        add_origin(job, ORIGIN_LIGHT, l, light_flux(job, &view->light[l]));
    for (uint32_t k = 0; k < suns; k++)
        add_origin(job, ORIGIN_SUN, k, sun_flux(job, &lights->environment->sun[k]));
    qsort(job->origin, job->origin_count, sizeof *job->origin, compare_origins);
    return RSV_OK;
}

/// Tables to draw an emitter of a group, and an origin among those that share a guide.
static rsv_status create_tables(photon_job *job)
{
    const rsv_lights *lights = job->lights;
    rsv_context *context = lights->context;
    rsv_status status = RSV_OK;
    size_t count =
        lights->emitter_count > job->origin_count ? lights->emitter_count : job->origin_count;
    double *weight = rsv_alloc(context, count, sizeof *weight);
    job->emitter_table = rsv_alloc(context, lights->emitter_count, sizeof *job->emitter_table);
    job->origin_table = rsv_alloc(context, job->origin_count, sizeof *job->origin_table);
    if (!weight || !job->emitter_table || !job->origin_table) RSV_TRY(RSV_ERROR_MEMORY);
    for (size_t i = 0; i < lights->emitter_count; i++)
        weight[i] = rsv_emitter_power(&lights->emitter[i]);
    for (size_t g = 0; g < lights->group_count; g++) {
        uint32_t first = lights->group[g].first;
        RSV_TRY(rsv_alias_table_fill(
            context, weight + first, lights->group[g].count, job->emitter_table + first));
    }
    for (size_t k = 0; k < job->origin_count; k++)
        weight[k] = job->origin[k].flux;
    for (size_t s = 0; s < job->source_count; s++) {
        uint32_t first = job->source[s].first;
        RSV_TRY(rsv_alias_table_fill(
            context, weight + first, job->source[s].count, job->origin_table + first));
    }
cleanup:
    rsv_free(context, weight);
    return status;
}

static rsv_status create_sources(photon_job *job, uint64_t *rays)
{
    rsv_status status;
    RSV_TRY(list_origins(job));
    job->source = rsv_alloc(job->lights->context, OWN_GUIDES + 1, sizeof *job->source);
    if (!job->source) return RSV_ERROR_MEMORY;
    for (uint32_t k = 0; k < job->origin_count; k++) {
        bool own = k <= OWN_GUIDES;
        photon_source *source = &job->source[own ? job->source_count++ : OWN_GUIDES];
        if (own) source->first = k;
        source->count++;
        source->flux += job->origin[k].flux;
    }
    RSV_TRY(create_tables(job));
    double total = 0;
    for (size_t s = 0; s < job->source_count; s++) {
        photon_source *source = &job->source[s];
        RSV_TRY(create_guide(job, source, (uint32_t)s, rays));
        source->share = source->flux * (source->useful + 1e-3);
        total += source->share;
    }
    for (size_t s = 0; s < job->source_count && total > 0; s++)
        job->source[s].share /= total;
cleanup:
    return status;
}

static void destroy_sources(photon_job *job)
{
    for (size_t s = 0; s < job->source_count; s++) {
        rsv_free(job->lights->context, job->source[s].row_cdf);
        rsv_free(job->lights->context, job->source[s].cell_cdf);
        rsv_free(job->lights->context, job->source[s].density);
    }
    rsv_free(job->lights->context, job->source);
    rsv_free(job->lights->context, job->origin);
    rsv_free(job->lights->context, job->origin_table);
    rsv_free(job->lights->context, job->emitter_table);
}

// ---- paths --------------------------------------------------------------------------------------

static void add_fixed(int64_t *sum, double value)
{
    int64_t amount = (int64_t)llrint(value);
#pragma omp atomic
    *sum += amount;
}

static void deposit_on(rsv_photon_map *map, const rsv_chain *chain, rsv_rgb flux)
{
    const rsv_elements *e = map->elements;
    uint32_t face = e->face_of[chain->back][chain->triangle];
    if (face == RSV_NONE) return;
    float weight[3];
    uint32_t cell = rsv_elements_locate(e, face, chain->u, chain->v, weight);
    for (int k = 0; k < 3; k++) {
        uint32_t node = e->cell_node[cell][k];
        double scale = weight[k] / map->unit;
        add_fixed(&map->flux[node][0], flux.r * scale);
        add_fixed(&map->flux[node][1], flux.g * scale);
        add_fixed(&map->flux[node][2], flux.b * scale);
        uint64_t share = (uint64_t)(weight[k] * 65536.0f);
#pragma omp atomic
        map->hits[node] += share;
    }
}

static void deposit(const photon_job *job, const rsv_chain *chain, rsv_rgb flux)
{
    rsv_vec3 shading, geometric;
    rsv_chain_normals(job->scene, chain, &shading, &geometric);
    rsv_bsdf storage;
    const rsv_bsdf *bsdf = rsv_chain_bsdf(job->scene, chain, &storage);
    rsv_rgb entered = rgb_mul(flux, rsv_bsdf_entry(bsdf, -v3_dot(shading, chain->direction)));
    for (size_t m = 0; m < job->map_count; m++)
        deposit_on(&job->maps[m], chain, entered);
}

/// Leaves a surface by one of its specular lobes. False if the photon ends.
static bool scatter(const photon_job *job, rsv_chain *chain, rsv_random *random)
{
    rsv_bsdf_event event = rsv_chain_draw_event(job->scene, chain, random);
    bool specular = event.lobe == RSV_LOBE_REFLECT || event.lobe == RSV_LOBE_TRANSMIT;
    if (!specular || chain->events >= RSV_CHAIN_MAX_EVENTS) return false;
    bool transmit = event.lobe == RSV_LOBE_TRANSMIT;
    if (rsv_chain_step(job->scene, chain, transmit, event.direction, event.weight) !=
        RSV_CHAIN_MOVED)
        return false;
    float survival = f_min(rgb_max(chain->weight), 1);
    if (rsv_random_float(random) >= survival) return false;
    chain->weight = rgb_scale(chain->weight, 1 / survival);
    return true;
}

static uint64_t shoot_one(
    const photon_job *job, const photon_source *source, uint32_t id, uint32_t index, uint32_t count)
{
    rsv_random random = rsv_random_from(job->seed ^ 0x3c6ef35fu, id, index);
    float x, y;
    rsv_sobol_2d(index, rsv_hash2(job->seed, id), &x, &y);
    float density = guide(source, &x, &y);
    emission e = emit(job, source, x, y, &random);
    rsv_chain chain;
    if (!first_hit(job, &e, &chain) || !hits_specular(job, &chain)) return 1;
    rsv_rgb flux = rgb_scale(e.flux, 1 / (density * (float)count));
    while (scatter(job, &chain, &random))
        deposit(job, &chain, rgb_mul(flux, chain.weight));
    return 1 + chain.rays;
}

static rsv_status shoot_source(const photon_job *job, const photon_source *source, uint32_t id,
    uint32_t count, double done, uint64_t *rays)
{
    rsv_context *context = job->lights->context;
    uint64_t traced = 0;
    uint32_t chunks = (count + PHOTONS_PER_CHUNK - 1) / PHOTONS_PER_CHUNK;
#pragma omp parallel for schedule(dynamic, 1) num_threads(rsv_threads(context)) reduction(+ : traced)
    for (uint32_t chunk = 0; chunk < chunks; chunk++) {
        if (rsv_cancelled(context)) continue;
        uint32_t begin = chunk * PHOTONS_PER_CHUNK, end = begin + PHOTONS_PER_CHUNK;
        for (uint32_t i = begin; i < (end < count ? end : count); i++)
            traced += shoot_one(job, source, id, i, count);
        if (rsv_thread_index() == 0)
            rsv_progress(context, "caustics", done + source->share * chunk / chunks);
    }
    *rays += traced;
    return rsv_progress(context, "caustics", fmin(done + source->share, 1));
}

static rsv_status create_map(
    rsv_context *context, const rsv_elements *elements, double unit, rsv_photon_map *map)
{
    map->context = context;
    map->elements = elements;
    map->unit = unit;
    map->flux = rsv_alloc(context, elements->node_count, sizeof *map->flux);
    map->hits = rsv_alloc(context, elements->node_count, sizeof *map->hits);
    return map->flux && map->hits ? RSV_OK : RSV_ERROR_MEMORY;
}

/// Hanging nodes own no area: what landed on them belongs to their parents.
static void settle_hanging(rsv_photon_map *map)
{
    const rsv_elements *e = map->elements;
    for (size_t h = e->hanging_count; h-- > 0;) {
        const rsv_hanging *hanging = &e->hanging[h];
        for (int p = 0; p < RSV_PARENTS; p++) {
            double share = hanging->weight[p];
            for (int c = 0; c < 3; c++)
                map->flux[hanging->parent[p]][c] +=
                    (int64_t)llrint(share * (double)map->flux[hanging->node][c]);
            map->hits[hanging->parent[p]] += (uint64_t)(share * (double)map->hits[hanging->node]);
        }
    }
}

rsv_status rsv_photons_shoot(const rsv_transport_scene *scene, const rsv_lights *lights,
    uint32_t count, uint32_t seed, const rsv_elements *const *elements, rsv_photon_map *maps,
    size_t map_count, uint64_t *rays)
{
    rsv_status status = RSV_OK;
    photon_job job = {
        .scene = scene, .lights = lights, .seed = seed, .maps = maps, .map_count = map_count
    };
    job.centre = v3_scale(v3_add(scene->view->bounds_min, scene->view->bounds_max), 0.5f);
    job.radius = 1.001f * v3_length(v3_sub(scene->view->bounds_max, job.centre));
    RSV_TRY(create_sources(&job, rays));
    double total = 0, done = 0;
    for (size_t s = 0; s < job.source_count; s++)
        total += job.source[s].flux;
    memset(maps, 0, map_count * sizeof *maps);
    for (size_t m = 0; m < map_count; m++)
        RSV_TRY(create_map(lights->context, elements[m], fmax(total, 1e-30) * 0x1p-44, &maps[m]));
    for (size_t s = 0; s < job.source_count; s++) {
        uint32_t share = (uint32_t)ceil(job.source[s].share * count);
        if (share) RSV_TRY(shoot_source(&job, &job.source[s], (uint32_t)s, share, done, rays));
        done += job.source[s].share;
    }
    for (size_t m = 0; m < map_count; m++)
        settle_hanging(&maps[m]);
cleanup:
    destroy_sources(&job);
    return status;
}

void rsv_photon_map_destroy(rsv_photon_map *map)
{
    if (!map->context) return;
    rsv_free(map->context, map->flux);
    rsv_free(map->context, map->hits);
    *map = (rsv_photon_map){ 0 };
}

void rsv_photon_map_irradiance(const rsv_photon_map *map, rsv_rgb *irradiance)
{
    for (size_t node = 0; node < map->elements->node_count; node++) {
        float area = map->elements->node_area[node];
        double scale = area > 0 ? map->unit / area : 0;
        irradiance[node] = rgb((float)((double)map->flux[node][0] * scale),
            (float)((double)map->flux[node][1] * scale),
            (float)((double)map->flux[node][2] * scale));
    }
    rsv_elements_constrain(map->elements, irradiance);
}

static double total_flux(const rsv_elements *e, const rsv_rgb *irradiance)
{
    double flux = 0;
    for (size_t node = 0; node < e->node_count; node++)
        flux += (double)rgb_luminance(irradiance[node]) * e->node_area[node];
    return flux;
}

/// Photons per square metre around the nodes, in all three channels.
static rsv_rgb *photon_density(const rsv_photon_map *map)
{
    rsv_rgb *density = rsv_alloc(map->context, map->elements->node_count, sizeof *density);
    for (size_t node = 0; density && node < map->elements->node_count; node++) {
        float area = map->elements->node_area[node];
        density[node] = rgb_gray(area > 0 ? (float)map->hits[node] / (65536.0f * area) : 0);
    }
    if (density) rsv_elements_constrain(map->elements, density);
    return density;
}

rsv_status rsv_photon_map_shrink(const rsv_photon_map *map, const rsv_photon_map *coarse_map,
    const rsv_rgb *coarse, rsv_rgb *irradiance)
{
    const rsv_elements *e = map->elements;
    rsv_rgb *density = photon_density(coarse_map);
    if (!density) return RSV_ERROR_MEMORY;
    double before = total_flux(e, irradiance);
    for (size_t node = 0; node < e->node_count; node++) {
        uint32_t face;
        float u, v;
        rsv_elements_place_node(e, (uint32_t)node, &face, &u, &v);
        rsv_rgb around = rsv_elements_interpolate(coarse_map->elements, coarse, face, u, v);
        float expected = e->node_area[node] *
                         rsv_elements_interpolate(coarse_map->elements, density, face, u, v).r;
        // none where many were to be expected is as good a measurement as many
        float photons = f_max((float)map->hits[node] / 65536.0f, expected);
        float trust = photons / (photons + RSV_PHOTON_PRIOR);
        irradiance[node] = rgb_mad(rgb_scale(irradiance[node], trust), 1 - trust, around);
    }
    rsv_free(map->context, density);
    double after = total_flux(e, irradiance);
    float keep = after > 0 ? (float)(before / after) : 1;
    for (size_t node = 0; node < e->node_count; node++)
        irradiance[node] = rgb_scale(irradiance[node], keep);
    rsv_elements_constrain(e, irradiance);
    return RSV_OK;
}
