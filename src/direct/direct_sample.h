/// Direct light of one node: its shadow rays and the estimate from them. Also for device code.
#ifndef RSV_DIRECT_SAMPLE_H
#define RSV_DIRECT_SAMPLE_H

#include "../core/bits.h"
#include "../core/stratified.h"
#include "../receiver/next_event.h"

/// Receiver points of a node at most, and shadow rays at a time.
#define RSV_DIRECT_LANES 16

/// Data common to all nodes. On a device, all pointers are to device memory.
typedef struct rsv_direct_setting {
    const rsv_lights *lights;
    const rsv_bsdf *bsdf; ///< [material_count]
    uint32_t points;      ///< of a node, 4 or 16
    uint32_t seed;
} rsv_direct_setting;

/// The receiver points of one node, and their common cover.
typedef struct rsv_node_receivers {
    rsv_receiver at[RSV_DIRECT_LANES];
    rsv_medium medium;       ///< of the first of them that is not buried
    rsv_surface_entry entry; ///< of all of them
    uint32_t node; ///< that its random numbers are of
    uint32_t valid; ///< bit k = point k counts
} rsv_node_receivers;

/// Shadow rays of a look, of which `lanes` are traced at a time.
typedef struct rsv_direct_rays {
    uint32_t samples, lanes;
} rsv_direct_rays;

RSV_INLINE rsv_entrance rsv_direct_entrance(
    const rsv_direct_setting *s, const rsv_node_receivers *receivers)
{
    rsv_entrance entrance = rsv_entrance_through(&receivers->medium, s->bsdf, RSV_COVER_PATCH);
    entrance.patch = &receivers->entry;
    return entrance;
}

// ---- emitters, suns and the sky -----------------------------------------------------------------

/// The point from which sample `index` starts. Points take turns, which keeps the samples of each one stratified. If a
/// tree has a part of the samples, those of invalid points go to the others, because too few might remain for the
/// closed forms.
/// @param valid of a receiver, not 0
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
    const rsv_direct_setting *s, uint32_t node, uint32_t index, float u[3])
{
    rsv_sobol_2d(index, rsv_hash3(s->seed, node, 1), &u[1], &u[2]);
    u[0] = rsv_sobol_1d(index, rsv_hash3(s->seed, node, 2));
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

/// An estimate with sampled visibility and everything else known: its noise is that of a fraction of visible samples.
/// The mean of samples from the tree's emitters is added to it.
/// @param by_tree there are such emitters @param count of samples
RSV_INLINE rsv_direct_estimate rsv_direct_from_sums(
    const rsv_event_sums *sums, rsv_rgb unshadowed, bool by_tree, float count)
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

/// Unoccluded irradiance of all points, without emitters in the tree; and whether there are such.
/// @param local [points] of the valid ones
RSV_INLINE bool rsv_direct_unshadowed(const rsv_direct_setting *s,
    const rsv_node_receivers *receivers, const rsv_local_lights *local, float valid,
    rsv_rgb *unshadowed)
{
    bool by_tree = false;
    *unshadowed = rgb_gray(0);
    for (uint32_t k = 0; k < s->points; k++) {
        if (!(receivers->valid >> k & 1)) continue;
        *unshadowed = rgb_mad(*unshadowed, 1 / valid, local[k].unshadowed);
        by_tree = by_tree || local[k].tree_share > 0;
    }
    return by_tree;
}

// ---- punctual lights ----------------------------------------------------------------------------

/// From point k to a punctual light.
RSV_INLINE void rsv_direct_to_punctual(const rsv_direct_setting *s,
    const rsv_node_receivers *receivers, uint32_t k, uint32_t light, rsv_next_event *event)
{
    rsv_entrance entrance = rsv_direct_entrance(s, receivers);
    float u = rsv_stratified_1d(k, s->points, rsv_hash3(s->seed, receivers->node, 3));
    rsv_next_event_punctual(&receivers->at[k], &entrance, s->lights, light, u, event);
}

/// Sums of one punctual light over the points.
typedef struct rsv_direct_punctual {
    rsv_rgb sum;
    uint32_t seen, hidden; ///< light that is partly blocked counts as both
} rsv_direct_punctual;

/// @param passed share of the event's light that arrives
RSV_INLINE void rsv_direct_count_punctual(
    rsv_direct_punctual *p, const rsv_next_event *event, float passed)
{
    if (passed > 0) p->sum = rgb_mad(p->sum, passed, event->light);
    p->seen += passed > 0;
    p->hidden += passed < 1 && !rgb_is_black(event->light);
}

#endif
