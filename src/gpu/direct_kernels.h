/// Direct light: weights sources at receiver points, samples points on them, traces shadow rays, and forms estimates.
/// Arithmetic and random numbers are those of src/direct/direct.c; only the order of a node's sums differs.
#ifndef RSV_DIRECT_KERNELS_H
#define RSV_DIRECT_KERNELS_H

#include "../bvh/bvh_trace.h"
#include "../direct/device_direct.h"
#include "../sources/local_lights.h"
#include "../trace/ray.h"
#include "launch.h"

typedef struct rsv_direct_args {
    rsv_bvh_view bvh;
    bool varied;                ///< surfaces have holes, or lamps shine unevenly
    rsv_direct_setting setting; ///< of addresses on the device
    rsv_direct_rays rays;
    uint32_t light; ///< punctual: which one
    const rsv_node_receivers *receivers;
    rsv_local_lights *local; ///< [nodes][points]
    rsv_event_sums *sums;    ///< [nodes]
    rsv_direct_estimate *estimate;
} rsv_direct_args;

/// Light of an event that arrives.
RSV_INLINE float rsv_direct_arrives(
    const rsv_direct_args *a, const rsv_next_event *event, bool varied)
{
    rsv_tracer tracer = { rsv_bvh_with_holes(a->bvh, varied) };
    return rsv_next_event_passed(&tracer, event);
}

// ---- emitters, suns and the sky -----------------------------------------------------------------

/// Weighs the sources at one point.
RSV_INLINE void rsv_direct_weigh_item(const rsv_direct_args *a, uint32_t item)
{
    const rsv_direct_setting *s = &a->setting;
    const rsv_node_receivers *receivers = &a->receivers[item / s->points];
    uint32_t k = item % s->points;
    if (!(receivers->valid >> k & 1)) return;
    const rsv_surface_point *point = &receivers->at[k].point;
    rsv_weigh_lights(s->lights, point->position, point->normal, false, &a->local[item]);
}

RSV_KERNEL(direct_weigh, rsv_direct_args, rsv_direct_weigh_item)

/// One shadow ray of a node to its emitters.
RSV_INLINE void rsv_direct_draw(
    const rsv_direct_args *a, uint32_t node, uint32_t index, bool varied, rsv_next_event *event)
{
    const rsv_direct_setting *s = &a->setting;
    const rsv_node_receivers *receivers = &a->receivers[node];
    float u[3];
    rsv_light_sample sample;
    rsv_next_event_clear(event);
    if (!receivers->valid) return;
    uint32_t at = rsv_direct_turn(s, receivers->valid, index);
    if (!(receivers->valid >> at & 1)) return;
    rsv_direct_numbers(s, receivers->node, index, u);
    const rsv_local_lights *local = &a->local[(size_t)node * s->points + at];
    bool drawn = varied ? rsv_local_lights_sample(local, u[0], u[1], u[2], &sample)
                        : rsv_draw_light(local, u[0], u[1], u[2], &sample);
    rsv_entrance entrance = rsv_direct_entrance(s, receivers);
    if (drawn) rsv_next_event_diffuse(&receivers->at[at], &entrance, s->lights, &sample, event);
}

RSV_INLINE rsv_event_sums rsv_direct_emitters_lane(
    const rsv_direct_args *a, uint32_t node, uint32_t lane, bool varied)
{
    rsv_event_sums sums = rsv_event_sums_zero();
    for (uint32_t index = lane; index < a->rays.samples; index += RSV_LANES) {
        rsv_next_event event;
        rsv_direct_draw(a, node, index, varied, &event);
        rsv_event_sums_add(&sums, &event, rsv_direct_arrives(a, &event, varied));
    }
    return sums;
}

RSV_INLINE void rsv_direct_emitters_store(
    const rsv_direct_args *a, uint32_t node, rsv_event_sums sums)
{
    a->sums[node] = sums;
}

RSV_KERNEL_SUM_VARIED(direct_emitters, rsv_direct_args, rsv_event_sums, rsv_direct_emitters_lane,
    rsv_event_sums_merge, rsv_direct_emitters_store)

/// Estimate of a node from its sums.
RSV_INLINE void rsv_direct_finish_item(const rsv_direct_args *a, uint32_t node)
{
    const rsv_direct_setting *s = &a->setting;
    const rsv_node_receivers *receivers = &a->receivers[node];
    float valid = (float)rsv_count_bits(receivers->valid);
    rsv_rgb unshadowed;
    bool by_tree = rsv_direct_unshadowed(
        s, receivers, a->local + (size_t)node * s->points, valid, &unshadowed);
    rsv_direct_estimate e = rsv_direct_no_estimate();
    if (by_tree || !rgb_is_black(unshadowed)) {
        e = rsv_direct_from_sums(&a->sums[node], unshadowed, by_tree,
            rsv_direct_drawn(s, receivers->valid, a->rays.samples));
        e.rays = a->rays.samples;
    }
    a->estimate[node] = e;
}

RSV_KERNEL(direct_finish, rsv_direct_args, rsv_direct_finish_item)

RSV_INLINE void rsv_direct_nothing_item(const rsv_direct_args *a, uint32_t node)
{
    a->estimate[node] = rsv_direct_no_estimate();
}

RSV_KERNEL(direct_nothing, rsv_direct_args, rsv_direct_nothing_item)

// ---- punctual lights ----------------------------------------------------------------------------

RSV_INLINE rsv_direct_punctual rsv_direct_punctual_lane(
    const rsv_direct_args *a, uint32_t node, uint32_t lane, bool varied)
{
    const rsv_node_receivers *receivers = &a->receivers[node];
    rsv_direct_punctual p;
    p.sum = rgb_gray(0);
    p.seen = p.hidden = 0;
    if (lane >= a->setting.points || !(receivers->valid >> lane & 1)) return p;
    rsv_next_event event;
    rsv_direct_to_punctual(&a->setting, receivers, lane, a->light, &event);
    rsv_direct_count_punctual(&p, &event, rsv_direct_arrives(a, &event, varied));
    return p;
}

RSV_INLINE rsv_direct_punctual rsv_direct_punctual_add(rsv_direct_punctual a, rsv_direct_punctual b)
{
    a.sum = rgb_add(a.sum, b.sum);
    a.seen += b.seen;
    a.hidden += b.hidden;
    return a;
}

/// Lights come one after the other.
RSV_INLINE void rsv_direct_punctual_store(
    const rsv_direct_args *a, uint32_t node, rsv_direct_punctual p)
{
    rsv_direct_estimate *e = &a->estimate[node];
    float valid = (float)rsv_count_bits(a->receivers[node].valid);
    e->irradiance = rgb_mad(e->irradiance, 1 / valid, p.sum);
    e->partial = e->partial || (p.seen > 0 && p.hidden > 0);
    e->rays += a->setting.points;
}

RSV_KERNEL_SUM_VARIED(direct_punctual, rsv_direct_args, rsv_direct_punctual,
    rsv_direct_punctual_lane, rsv_direct_punctual_add, rsv_direct_punctual_store)

#endif
