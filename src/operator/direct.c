#include "direct.h"

#include "../core/stratified.h"
#include "../core/team.h"
#include "../light/punctual_light.h"
#include "../trace/packet.h"

#include <string.h>

#define LANES 16
/// Points that are looked at first where `samples` is less than LANES.
#define GLANCE_POINTS 4

/// The receiver points of one node.
typedef struct node_points {
    rsv_surface_point point[LANES];
    rsv_vec3 origin[LANES];
    rsv_medium medium; ///< of the first of them that is not buried
    uint32_t count;
    uint32_t samples, lanes; ///< all of them, and how many at a time
    uint16_t valid;
} node_points;

typedef struct direct_job {
    const rsv_transport_scene *scene;
    const rsv_lights *lights;
    const rsv_elements *elements;
    uint32_t points, samples, seed;
} direct_job;

static const rsv_bsdf *node_bsdf(const direct_job *job, uint32_t node)
{
    uint32_t triangle = job->elements->face_triangle[job->elements->node_face[node]];
    return &job->scene->bsdf[job->scene->view->triangle_material[triangle]];
}

/// @param valid points wanted
static void set_up_points(const direct_job *job, uint32_t node, uint16_t valid, node_points *p)
{
    const rsv_elements *e = job->elements;
    p->count = job->points;
    p->valid = valid;
    rsv_support_point sample[LANES];
    rsv_elements_sample_support(e, node, p->count, job->seed, sample);
    for (uint32_t k = 0; k < p->count; k++) {
        if (!(valid >> k & 1)) continue;
        uint32_t face = e->cell[sample[k].support / 4].face;
        p->point[k] = rsv_surface_point_at(
            job->scene->view, e->face_triangle[face], sample[k].u, sample[k].v, e->face_back[face]);
        p->origin[k] =
            rsv_offset_origin(p->point[k].position, p->point[k].geometric, p->point[k].extent);
    }
    uint32_t speaks = (uint32_t)__builtin_ctz(valid);
    p->medium = rsv_medium_above(&job->scene->media, p->origin[speaks], p->point[speaks].geometric);
}

/// What is left of light that crosses the medium of the points, and then their coat.
static rsv_rgb entering(const direct_job *job, const node_points *p, const rsv_bsdf *bsdf,
    rsv_rgb light, float distance, float cos)
{
    rsv_rgb passed = rsv_medium_transmittance(&p->medium, job->scene->bsdf, distance);
    return rgb_mul(rgb_mul(light, passed), rsv_bsdf_entry(bsdf, cos));
}

static void clear_packet(rsv_ray_packet *packet)
{
    for (int k = 0; k < LANES; k++)
        packet->t_max[k] = -1;
}

/// Sums over the samples of one node.
typedef struct emitter_sums {
    rsv_rgb open;          ///< f / p, visible or not
    rsv_rgb visible;       ///< f / p of the visible ones that enters the surface
    float visible_squared; ///< luminance
    uint32_t seen, hidden; ///< how many
} emitter_sums;

/// Up to sixteen shadow rays: lane = point + points * repetition.
static void sample_emitters(const direct_job *job, uint32_t node, uint32_t first_sample,
    const node_points *p, const rsv_local_lights *local, const rsv_bsdf *bsdf, emitter_sums *sums)
{
    rsv_ray_packet packet;
    rsv_rgb contribution[LANES], entered[LANES];
    memset(&packet, 0, sizeof packet);
    memset(packet.mask, 0xff, sizeof packet.mask);
    clear_packet(&packet);
    for (uint32_t k = 0; k < p->lanes; k++) {
        uint32_t at = k % p->count, index = first_sample + k;
        contribution[k] = entered[k] = rgb_gray(0);
        if (!(p->valid >> at & 1)) continue;
        float x, y;
        rsv_sobol_2d(index, rsv_hash3(job->seed, node, 1), &x, &y);
        float select = rsv_sobol_1d(index, rsv_hash3(job->seed, node, 2));
        rsv_light_sample sample;
        if (!rsv_local_lights_sample(&local[at], select, x, y, &sample)) continue;
        float cos = v3_dot(p->point[at].normal, sample.direction);
        contribution[k] = rgb_scale(sample.mean_radiance, cos / sample.pdf_solid_angle);
        // what the geometry hides from the shading normal is blocked like anything else
        if (!rsv_surface_faces(&p->point[at], sample.direction)) continue;
        entered[k] = rgb_scale(sample.radiance, cos / sample.pdf_solid_angle);
        entered[k] = entering(job, p, bsdf, entered[k], sample.distance, cos);
        rsv_packet_set_ray(
            &packet, k, rsv_shadow_ray(job->lights, &sample, p->point[at].position, p->origin[at]));
    }
    rsv_tracer_occluded_packet(job->scene->tracer, &packet, true);
    for (uint32_t k = 0; k < p->lanes; k++) {
        bool seen = packet.t_max[k] > 0;
        sums->open = rgb_add(sums->open, contribution[k]);
        sums->seen += seen;
        sums->hidden += !seen && !rgb_is_black(contribution[k]);
        if (!seen) continue;
        float luminance = rgb_luminance(entered[k]);
        sums->visible = rgb_add(sums->visible, entered[k]);
        sums->visible_squared += luminance * luminance;
    }
}

static float ratio(float unshadowed, float visible, float open)
{
    return open > 0 ? unshadowed * (visible / open) : 0;
}

/// An estimate and the standard deviation of its luminance.
typedef struct direct_estimate {
    rsv_rgb irradiance;
    float deviation;
    bool partial; ///< some of the points are in the shadow, others are not
} direct_estimate;

/// Stratified samples of one visibility boundary scatter less than independent ones, by about this factor.
#define STRATIFIED 0.4f

/// Visibility sampled, everything else known: the noise is that of a share of visible samples.
static direct_estimate from_ratio(const emitter_sums *sums, rsv_rgb unshadowed, float count)
{
    direct_estimate e = { rgb(ratio(unshadowed.r, sums->visible.r, sums->open.r),
                              ratio(unshadowed.g, sums->visible.g, sums->open.g),
                              ratio(unshadowed.b, sums->visible.b, sums->open.b)),
        0, sums->seen > 0 && sums->hidden > 0 };
    float open = rgb_luminance(sums->open), share = rgb_luminance(sums->visible) / open;
    if (open > 0)
        e.deviation =
            STRATIFIED * rgb_luminance(unshadowed) * sqrtf(f_max(share * (1 - share), 0) / count);
    return e;
}

static direct_estimate from_mean(const emitter_sums *sums, float count)
{
    direct_estimate e = { rgb_scale(sums->visible, 1 / count), 0, true };
    float mean = rgb_luminance(e.irradiance);
    e.deviation = sqrtf(f_max(sums->visible_squared / count - mean * mean, 0) / count);
    return e;
}

static direct_estimate from_emitters(
    const direct_job *job, uint32_t node, const node_points *p, uint64_t *rays)
{
    direct_estimate none = { rgb_gray(0), 0, false };
    if (!rsv_lights_any_sampled(job->lights)) return none;
    rsv_local_lights local[LANES];
    rsv_rgb unshadowed = rgb_gray(0);
    float valid = (float)__builtin_popcount(p->valid);
    bool by_tree = false;
    for (uint32_t k = 0; k < p->count; k++) {
        if (!(p->valid >> k & 1)) continue;
        rsv_lights_at(job->lights, p->point[k].position, p->point[k].normal, &local[k]);
        unshadowed = rgb_mad(unshadowed, 1 / valid, local[k].unshadowed);
        by_tree = by_tree || local[k].by_tree;
    }
    if (!by_tree && rgb_is_black(unshadowed)) return none;
    emitter_sums sums = { 0 };
    for (uint32_t first = 0; first < p->samples; first += p->lanes)
        sample_emitters(job, node, first, p, local, node_bsdf(job, node), &sums);
    *rays += p->samples;
    float count = (float)p->samples * valid / (float)p->count;
    return by_tree ? from_mean(&sums, count) : from_ratio(&sums, unshadowed, count);
}

/// @param partial set where some points are in the shadow of a light and others are not
static rsv_rgb from_punctual(
    const direct_job *job, uint32_t node, const node_points *p, bool *partial, uint64_t *rays)
{
    rsv_rgb sum = rgb_gray(0);
    const rsv_bsdf *bsdf = node_bsdf(job, node);
    for (uint32_t l = 0; l < rsv_punctual_count(job->lights); l++) {
        rsv_ray_packet packet;
        rsv_rgb arriving[LANES];
        memset(&packet, 0, sizeof packet);
        memset(packet.mask, 0xff, sizeof packet.mask);
        clear_packet(&packet);
        for (uint32_t k = 0; k < p->count; k++) {
            const rsv_surface_point *point = &p->point[k];
            rsv_punctual_sample light;
            float u = rsv_stratified_1d(k, p->count, rsv_hash3(job->seed, node, 3));
            arriving[k] = rgb_gray(0);
            if (!(p->valid >> k & 1) ||
                !rsv_punctual_at(job->lights, point->position, point->normal, l, u, &light) ||
                !rsv_surface_faces(point, light.direction))
                continue;
            float cos = v3_dot(point->normal, light.direction);
            arriving[k] =
                entering(job, p, bsdf, rgb_scale(light.irradiance, cos), light.distance, cos);
            rsv_packet_set_ray(&packet, k, rsv_punctual_ray(&light, p->origin[k]));
        }
        rsv_tracer_occluded_packet(job->scene->tracer, &packet, true);
        uint32_t seen = 0, hidden = 0;
        for (uint32_t k = 0; k < p->count; k++) {
            bool passes = packet.t_max[k] > 0;
            if (passes) sum = rgb_add(sum, arriving[k]);
            seen += passes;
            hidden += !passes && !rgb_is_black(arriving[k]);
        }
        *partial = *partial || (seen > 0 && hidden > 0);
        *rays += p->count;
    }
    return rgb_scale(sum, 1 / (float)__builtin_popcount(p->valid));
}

static direct_estimate estimate(
    const direct_job *job, uint32_t node, node_points *p, uint16_t valid, uint64_t *rays)
{
    set_up_points(job, node, valid, p);
    direct_estimate e = from_emitters(job, node, p, rays);
    rsv_rgb punctual = from_punctual(job, node, p, &e.partial, rays);
    e.irradiance = rgb_add(e.irradiance, punctual);
    return e;
}

/// The first few of the points, one ray to the emitters each.
static direct_estimate glance(const direct_job *job, uint32_t node, uint16_t valid, uint64_t *rays)
{
    node_points p = { .samples = job->points, .lanes = job->points };
    uint32_t few = 0;
    for (uint32_t k = 0; k < GLANCE_POINTS && valid; k++, valid &= (uint16_t)(valid - 1))
        few |= valid & -(uint32_t)valid;
    return estimate(job, node, &p, (uint16_t)few, rays);
}

static direct_estimate look(const direct_job *job, uint32_t node, uint16_t valid, uint64_t *rays)
{
    node_points p = { .samples = job->samples < LANES ? LANES : job->samples, .lanes = LANES };
    return estimate(job, node, &p, valid, rays);
}

rsv_status rsv_direct_irradiance(const rsv_transport_scene *scene, const rsv_lights *lights,
    const rsv_elements *elements, uint32_t points, uint32_t samples, uint32_t seed,
    const uint16_t *valid_points, const uint8_t *known, rsv_rgb *irradiance, float *deviation,
    uint64_t *rays)
{
    rsv_context *context = elements->context;
    direct_job job = { scene, lights, elements, points, samples, seed };
    bool glances = samples < LANES && !lights->emitter_tree;
    rsv_team_place place = rsv_team_place_of(context);
    uint64_t traced = 0;
    size_t done = 0;
#pragma omp parallel for schedule(dynamic, 64) num_threads(rsv_threads(context)) reduction(+ : traced)
    for (size_t node = 0; node < elements->node_count; node++) {
        if (!rsv_team_owns(place, node, RSV_TEAM_BLOCK) || (known && known[node]) ||
            rsv_cancelled(context))
            continue;
        irradiance[node] = rgb_gray(0);
        if (deviation) deviation[node] = 0;
        if (!valid_points[node]) continue;
        direct_estimate e = { .partial = true };
        if (glances) e = glance(&job, (uint32_t)node, valid_points[node], &traced);
        if (e.partial) e = look(&job, (uint32_t)node, valid_points[node], &traced);
        irradiance[node] = e.irradiance;
        if (deviation) deviation[node] = e.deviation;
        if (rsv_thread_index() == 0 && (++done & 1023) == 0)
            rsv_progress(context, "direct",
                fmin((double)(done * place.size * (size_t)rsv_threads(context)) /
                         (double)elements->node_count,
                    1));
    }
    *rays += rsv_team_total(context, traced);
    rsv_team_merge(context, irradiance, sizeof *irradiance, elements->node_count, RSV_TEAM_BLOCK);
    if (deviation)
        rsv_team_merge(context, deviation, sizeof *deviation, elements->node_count, RSV_TEAM_BLOCK);
    rsv_elements_constrain(elements, irradiance);
    return rsv_progress(context, "direct", 1);
}
