/// Direct light of one node: the rays that ask for it, and what they tell. For device code too.
#ifndef RSV_DIRECT_SAMPLE_H
#define RSV_DIRECT_SAMPLE_H

#include "../core/bits.h"
#include "../core/stratified.h"
#include "../sources/punctual_light.h"
#include "../surface/entry.h"
#include "../surface/lift.h"
#include "../surface/medium.h"

/// Receiver points of a node at most, and shadow rays at a time.
#define RSV_DIRECT_LANES 16

/// What all nodes have in common. On a device, all it points to lies there.
typedef struct rsv_direct_setting {
    const rsv_lights *lights;
    const rsv_bsdf *bsdf; ///< [material_count]
    uint32_t points;      ///< of a node
    uint32_t seed;
} rsv_direct_setting;

/// The receiver points of one node.
typedef struct rsv_direct_receiver {
    rsv_surface_point point[RSV_DIRECT_LANES];
    rsv_vec3 origin[RSV_DIRECT_LANES]; ///< off the surface
    rsv_medium medium;                 ///< of the first of them that is not buried
    rsv_surface_entry entry;           ///< of all of them
    uint32_t node;
    uint32_t valid; ///< bit k = point k counts
} rsv_direct_receiver;

/// Shadow rays of a look, of which `lanes` are traced at a time.
typedef struct rsv_direct_rays {
    uint32_t samples, lanes;
} rsv_direct_rays;

/// A shadow ray and what it asks for.
typedef struct rsv_direct_ray {
    rsv_ray ray;      ///< t_max -1 = nothing to ask for
    rsv_rgb open;     ///< f / p, visible or not, as the closed form knows it
    rsv_rgb entering; ///< f / p that enters the surface if the way is free
} rsv_direct_ray;

RSV_INLINE rsv_direct_ray rsv_direct_no_ray(void)
{
    rsv_direct_ray r;
    r.ray.origin = r.ray.direction = v3(0, 0, 0);
    r.ray.t_max = -1;
    r.open = r.entering = rgb_gray(0);
    return r;
}

/// What is left of light that crosses the medium of the points, and then their coat.
RSV_INLINE rsv_rgb rsv_direct_entering(const rsv_direct_setting *s,
    const rsv_direct_receiver *receiver, rsv_rgb light, float distance, float cos)
{
    rsv_rgb passed = rsv_medium_transmittance(&receiver->medium, s->bsdf, distance);
    return rgb_mul(rgb_mul(light, passed), rsv_surface_entry_at(&receiver->entry, s->bsdf, cos));
}

// ---- emitters, suns and the sky -----------------------------------------------------------------

/// The point that sample `index` starts from: they take turns, which keeps the samples of each one stratified. Where a tree has
/// its share of the samples, points that do not count leave theirs to the others, or too few might be left for what closed
/// forms know. @param valid of a receiver, not 0
RSV_INLINE uint32_t rsv_direct_turn(const rsv_direct_setting *s, uint32_t valid, uint32_t index)
{
    uint32_t point = index % s->points, left;
    if ((valid >> point & 1) || !s->lights->emitter_tree) return point;
    left = (index + index / s->points) % rsv_count_bits(valid);
    for (point = 0; left > 0 || !(valid >> point & 1); point++)
        left -= valid >> point & 1;
    return point;
}

/// How many of the samples are drawn.
RSV_INLINE float rsv_direct_drawn(const rsv_direct_setting *s, uint32_t valid, uint32_t samples)
{
    if (s->lights->emitter_tree) return (float)samples;
    return (float)samples * (float)rsv_count_bits(valid) / (float)s->points;
}

/// Random numbers of sample `index` of a node: which source, and where on it.
RSV_INLINE void rsv_direct_numbers(
    const rsv_direct_setting *s, uint32_t node, uint32_t index, float *select, float *x, float *y)
{
    rsv_sobol_2d(index, rsv_hash3(s->seed, node, 1), x, y);
    *select = rsv_sobol_1d(index, rsv_hash3(s->seed, node, 2));
}

/// From point k to a place that was drawn for it.
RSV_INLINE rsv_direct_ray rsv_direct_to_sample(const rsv_direct_setting *s,
    const rsv_direct_receiver *receiver, uint32_t k, const rsv_light_sample *sample)
{
    const rsv_surface_point *point = &receiver->point[k];
    rsv_direct_ray r = rsv_direct_no_ray();
    float cos = v3_dot(point->normal, sample->direction);
    r.open = rgb_scale(sample->mean_radiance, cos / sample->pdf_solid_angle);
    // what the geometry hides from the shading normal is blocked like anything else
    if (!rsv_surface_faces(point, sample->direction)) return r;
    r.entering = rsv_direct_entering(s, receiver,
        rgb_scale(sample->radiance, cos / sample->pdf_solid_angle), sample->distance, cos);
    r.ray = rsv_shadow_ray(s->lights, sample, point->position,
        rsv_lifted_origin(point, receiver->origin[k], sample->direction));
    return r;
}

/// Sums over the samples of one node. What passes blended surfaces in part counts as seen, by as much as passes.
typedef struct rsv_direct_sums {
    rsv_rgb open;          ///< f / p of what closed forms know, visible or not
    rsv_rgb visible;       ///< f / p of those of them that are visible, as it enters the surface
    rsv_rgb further;       ///< the same of emitters that a tree chose: `open` knows nothing of them
    float further_squared; ///< luminance
    /// Luminance of `visible` that is sure of not being all or nothing: times what is lost.
    float veiled;
    uint32_t seen, hidden; ///< how many of those that `open` knows
} rsv_direct_sums;

RSV_INLINE rsv_direct_sums rsv_direct_no_sums(void)
{
    rsv_direct_sums sums;
    sums.open = sums.visible = sums.further = rgb_gray(0);
    sums.further_squared = sums.veiled = 0;
    sums.seen = sums.hidden = 0;
    return sums;
}

/// @param passed share of the ray's light that arrives
RSV_INLINE void rsv_direct_count(rsv_direct_sums *sums, const rsv_direct_ray *r, float passed)
{
    bool seen = passed > 0;
    sums->open = rgb_add(sums->open, r->open);
    sums->seen += seen && !rgb_is_black(r->open);
    sums->hidden += !seen && !rgb_is_black(r->open);
    if (!seen) return;
    rsv_rgb arriving = rgb_scale(r->entering, passed);
    if (!rgb_is_black(r->open)) {
        sums->visible = rgb_add(sums->visible, arriving);
        sums->veiled += (1 - passed) * rgb_luminance(arriving);
        return;
    }
    float luminance = rgb_luminance(arriving);
    sums->further = rgb_add(sums->further, arriving);
    sums->further_squared += luminance * luminance;
}

/// An estimate and the standard deviation of its luminance.
typedef struct rsv_direct_estimate {
    rsv_rgb irradiance;
    float deviation;
    uint32_t rays;
    uint32_t partial; ///< some of the points are in the shadow, others are not
} rsv_direct_estimate;

RSV_INLINE rsv_direct_estimate rsv_direct_no_estimate(void)
{
    rsv_direct_estimate e;
    e.irradiance = rgb_gray(0);
    e.deviation = 0;
    e.rays = 0;
    e.partial = 0;
    return e;
}

RSV_INLINE float rsv_direct_ratio(float unshadowed, float visible, float open)
{
    return open > 0 ? unshadowed * (visible / open) : 0;
}

/// Stratified samples of one visibility boundary scatter less than independent ones, by about this factor.
#define RSV_DIRECT_STRATIFIED 0.4f

/// Visibility sampled, everything else known: the noise is that of a share of visible samples. Emitters that a tree chose
/// come on top of it, as the mean of what their samples found.
/// @param by_tree there are such emitters @param count of samples
RSV_INLINE rsv_direct_estimate rsv_direct_from_sums(
    const rsv_direct_sums *sums, rsv_rgb unshadowed, bool by_tree, float count)
{
    rsv_direct_estimate e = rsv_direct_no_estimate();
    e.irradiance = rgb(rsv_direct_ratio(unshadowed.r, sums->visible.r, sums->open.r),
        rsv_direct_ratio(unshadowed.g, sums->visible.g, sums->open.g),
        rsv_direct_ratio(unshadowed.b, sums->visible.b, sums->open.b));
    e.partial = by_tree || sums->veiled > 0 || (sums->seen > 0 && sums->hidden > 0);
    float open = rgb_luminance(sums->open), share = rgb_luminance(sums->visible) / open;
    float spread = share * (1 - share) - sums->veiled / open;
    // the tree took some of the samples; if it took all, nothing is known
    float known = by_tree ? (float)(sums->seen + sums->hidden) : count;
    if (open > 0)
        e.deviation =
            RSV_DIRECT_STRATIFIED * rgb_luminance(unshadowed) * sqrtf(f_max(spread, 0) / known);
    if (!by_tree) return e;
    if (!(open > 0)) e.deviation = rgb_luminance(unshadowed);
    e.irradiance = rgb_mad(e.irradiance, 1 / count, sums->further);
    float mean = rgb_luminance(sums->further) / count;
    float variance = f_max(sums->further_squared / count - mean * mean, 0) / count;
    e.deviation = sqrtf(e.deviation * e.deviation + variance);
    return e;
}

/// What all points would receive without occlusion but for emitters in the tree; whether there are such.
/// @param local [points] of those that are valid
RSV_INLINE bool rsv_direct_unshadowed(const rsv_direct_setting *s,
    const rsv_direct_receiver *receiver, const rsv_local_lights *local, float valid,
    rsv_rgb *unshadowed)
{
    bool by_tree = false;
    *unshadowed = rgb_gray(0);
    for (uint32_t k = 0; k < s->points; k++) {
        if (!(receiver->valid >> k & 1)) continue;
        *unshadowed = rgb_mad(*unshadowed, 1 / valid, local[k].unshadowed);
        by_tree = by_tree || local[k].tree_share > 0;
    }
    return by_tree;
}

// ---- punctual lights ----------------------------------------------------------------------------

/// From point k to a punctual light.
RSV_INLINE rsv_direct_ray rsv_direct_to_punctual(
    const rsv_direct_setting *s, const rsv_direct_receiver *receiver, uint32_t k, uint32_t light)
{
    const rsv_surface_point *point = &receiver->point[k];
    rsv_direct_ray r = rsv_direct_no_ray();
    rsv_punctual_sample sample;
    float u = rsv_stratified_1d(k, s->points, rsv_hash3(s->seed, receiver->node, 3));
    if (!rsv_punctual_at(s->lights, point->position, point->normal, light, u, &sample) ||
        !rsv_surface_faces(point, sample.direction))
        return r;
    float cos = v3_dot(point->normal, sample.direction);
    r.open = rgb_scale(sample.irradiance, cos);
    r.entering = rsv_direct_entering(s, receiver, r.open, sample.distance, cos);
    r.ray =
        rsv_punctual_ray(&sample, rsv_lifted_origin(point, receiver->origin[k], sample.direction));
    return r;
}

/// Sums of one punctual light over the points.
typedef struct rsv_direct_punctual {
    rsv_rgb sum;
    uint32_t seen, hidden; ///< what arrives in part is both
} rsv_direct_punctual;

/// @param passed share of the ray's light that arrives
RSV_INLINE void rsv_direct_count_punctual(
    rsv_direct_punctual *p, const rsv_direct_ray *r, float passed)
{
    if (passed > 0) p->sum = rgb_mad(p->sum, passed, r->entering);
    p->seen += passed > 0;
    p->hidden += passed < 1 && !rgb_is_black(r->entering);
}

#endif
