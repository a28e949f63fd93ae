#include "photons.h"

#include <string.h>

#define GUIDE_SIDE 64     ///< bins of a source's guide along each side of its unit square
#define GUIDE_RAYS 4      ///< pilot rays per bin
#define GUIDED_SHARE 0.9f ///< the rest is emitted as the source would by itself
#define PHOTONS_PER_CHUNK 4096

/// One source of light paths, with a guide over the unit square that its directions come from.
typedef struct photon_source {
    uint32_t group;  ///< emitter group, or
    uint32_t light;  ///< punctual light; the other is RSV_NONE
    double flux;     ///< luminance, W
    double share;    ///< of all photons
    float useful;    ///< share of pilot rays that met specular surfaces
    float *row_cdf;  ///< [GUIDE_SIDE]
    float *cell_cdf; ///< [GUIDE_SIDE * GUIDE_SIDE], per row
    float *density;  ///< [GUIDE_SIDE * GUIDE_SIDE] of the guided distribution over the square
} photon_source;

typedef struct photon_job {
    const rsv_transport_scene *scene;
    const rsv_lights *lights;
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
    double target = rsv_random_float(random) * g->area;
    uint32_t index = g->first;
    while (index + 1 < g->first + g->count && target >= job->lights->emitter[index].area)
        target -= job->lights->emitter[index++].area;
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
    out.flux = rgb_scale(rsv_emitter_radiance(job->lights, index, u, v),
        RSV_PI * (float)g->area * (e->double_sided ? 2.0f : 1.0f));
    return out;
}

static emission emit_from_light(const photon_job *job, uint32_t light_index, float x, float y)
{
    const rsv_light *light = &job->scene->view->light[light_index];
    emission out = { .origin = light->position };
    if (light->kind == RSV_LIGHT_DIRECTIONAL) {
        float dx, dy;
        rsv_square_to_disk(x, y, &dx, &dy);
        rsv_vec3 offset =
            to_world(v3(dx * job->radius, dy * job->radius, -2 * job->radius), light->direction);
        out.origin = v3_add(job->centre, offset);
        out.direction = light->direction;
        out.flux = rgb_scale(light->intensity, RSV_PI * job->radius * job->radius);
        return out;
    }
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
    return source->group != RSV_NONE ? emit_from_group(job, source->group, x, y, random)
                                     : emit_from_light(job, source->light, x, y);
}

// ---- guides -------------------------------------------------------------------------------------

static bool first_hit(const photon_job *job, const emission *e, rsv_chain *chain)
{
    rsv_ray ray = { e->origin, e->direction, INFINITY };
    rsv_hit hit;
    if (!rsv_tracer_closest(job->scene->tracer, &ray, &hit)) return false;
    *chain = rsv_chain_begin(job->scene, e->direction, hit.triangle, hit.u, hit.v, hit.t);
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
    float row_sum[GUIDE_SIDE], total = 0;
    for (int row = 0; row < GUIDE_SIDE; row++) {
        row_sum[row] =
            accumulate(useful + row * GUIDE_SIDE, source->cell_cdf + row * GUIDE_SIDE, GUIDE_SIDE);
        total += row_sum[row];
    }
    accumulate(row_sum, source->row_cdf, GUIDE_SIDE);
    const float bins = GUIDE_SIDE * GUIDE_SIDE;
    source->useful = total / (bins * GUIDE_RAYS);
    for (int k = 0; k < GUIDE_SIDE * GUIDE_SIDE; k++)
        source->density[k] = total > 0 ? useful[k] * bins / total : 1;
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

static int invert(const float *cdf, int count, float *x)
{
    int k = 0;
    while (k + 1 < count && *x >= cdf[k])
        k++;
    float low = k ? cdf[k - 1] : 0, width = cdf[k] - low;
    *x = width > 0 ? f_min((*x - low) / width, 0x1.fffffep-1f) : 0.5f;
    return k;
}

/// Warps a uniform point of the unit square by the guide; returns the density there.
static float guide(const photon_source *source, float choice, float *x, float *y)
{
    if (choice < GUIDED_SHARE) {
        int row = invert(source->row_cdf, GUIDE_SIDE, y);
        int column = invert(source->cell_cdf + row * GUIDE_SIDE, GUIDE_SIDE, x);
        *x = f_min(((float)column + *x) / GUIDE_SIDE, 0x1.fffffep-1f);
        *y = f_min(((float)row + *y) / GUIDE_SIDE, 0x1.fffffep-1f);
    }
    int bin = (int)(*y * GUIDE_SIDE) * GUIDE_SIDE + (int)(*x * GUIDE_SIDE);
    return GUIDED_SHARE * source->density[bin] + (1 - GUIDED_SHARE);
}

// ---- sources ------------------------------------------------------------------------------------

static double light_flux(const photon_job *job, const rsv_light *light)
{
    double intensity = rgb_luminance(light->intensity);
    if (light->kind == RSV_LIGHT_DIRECTIONAL) return intensity * RSV_PI * job->radius * job->radius;
    double cos_outer = light->kind == RSV_LIGHT_SPOT ? cos(light->outer_cone_angle) : -1;
    return intensity * 2 * RSV_PI * (1 - cos_outer);
}

static rsv_status create_sources(photon_job *job, uint64_t *rays)
{
    const rsv_lights *lights = job->lights;
    const rsv_scene_view *view = job->scene->view;
    job->source =
        rsv_alloc(lights->context, lights->group_count + view->light_count, sizeof *job->source);
    if (!job->source) return RSV_ERROR_MEMORY;
    for (uint32_t g = 0; g < lights->group_count; g++)
        if (!lights->group[g].gathered)
            job->source[job->source_count++] =
                (photon_source){ .group = g, .light = RSV_NONE, .flux = lights->group[g].power };
    for (uint32_t l = 0; l < view->light_count; l++)
        job->source[job->source_count++] = (photon_source){
            .group = RSV_NONE, .light = l, .flux = light_flux(job, &view->light[l])
        };

    double total = 0;
    for (size_t s = 0; s < job->source_count; s++) {
        photon_source *source = &job->source[s];
        rsv_status status = create_guide(job, source, (uint32_t)s, rays);
        if (status != RSV_OK) return status;
        source->share = source->flux * (source->useful + 1e-3);
        total += source->share;
    }
    for (size_t s = 0; s < job->source_count && total > 0; s++)
        job->source[s].share /= total;
    return RSV_OK;
}

static void destroy_sources(photon_job *job)
{
    for (size_t s = 0; s < job->source_count; s++) {
        rsv_free(job->lights->context, job->source[s].row_cdf);
        rsv_free(job->lights->context, job->source[s].cell_cdf);
        rsv_free(job->lights->context, job->source[s].density);
    }
    rsv_free(job->lights->context, job->source);
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
    float density = guide(source, rsv_random_float(&random), &x, &y);
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
