/// Direct light: sources weighed at receiver points, places on them drawn, shadow rays traced, and what they tell. The
/// arithmetic and the random numbers are those of src/direct/direct.c; only the order of a node's sums differs.
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
    const rsv_direct_receiver *receiver;
    rsv_local_lights *local; ///< [nodes][points]
    rsv_direct_sums *sums;   ///< [nodes]
    rsv_direct_estimate *estimate;
} rsv_direct_args;

/// What arrives of a ray's light.
RSV_INLINE float rsv_direct_arrives(const rsv_direct_args *a, const rsv_direct_ray *r, bool varied)
{
    rsv_tracer tracer = { rsv_bvh_with_holes(a->bvh, varied) };
    return r->ray.t_max > 0 ? rsv_ray_passed(&tracer, &r->ray) : 0;
}

// ---- emitters, suns and the sky -----------------------------------------------------------------

/// Weighs the sources at one point.
RSV_INLINE void rsv_direct_weigh_item(const rsv_direct_args *a, uint32_t item)
{
    const rsv_direct_setting *s = &a->setting;
    const rsv_direct_receiver *receiver = &a->receiver[item / s->points];
    uint32_t k = item % s->points;
    if (!(receiver->valid >> k & 1)) return;
    rsv_weigh_lights(
        s->lights, receiver->point[k].position, receiver->point[k].normal, &a->local[item]);
}

RSV_KERNEL(direct_weigh, rsv_direct_args, rsv_direct_weigh_item)

/// One shadow ray of a node to its emitters.
RSV_INLINE rsv_direct_ray rsv_direct_draw(
    const rsv_direct_args *a, uint32_t node, uint32_t index, bool varied)
{
    const rsv_direct_setting *s = &a->setting;
    const rsv_direct_receiver *receiver = &a->receiver[node];
    float select, x, y;
    rsv_light_sample sample;
    if (!receiver->valid) return rsv_direct_no_ray();
    uint32_t at = rsv_direct_turn(s, receiver->valid, index);
    if (!(receiver->valid >> at & 1)) return rsv_direct_no_ray();
    rsv_direct_numbers(s, receiver->node, index, &select, &x, &y);
    const rsv_local_lights *local = &a->local[(size_t)node * s->points + at];
    bool drawn = varied ? rsv_local_lights_sample(local, select, x, y, &sample)
                        : rsv_draw_light(local, select, x, y, &sample);
    return drawn ? rsv_direct_to_sample(s, receiver, at, &sample) : rsv_direct_no_ray();
}

RSV_INLINE rsv_direct_sums rsv_direct_emitters_lane(
    const rsv_direct_args *a, uint32_t node, uint32_t lane, bool varied)
{
    rsv_direct_sums sums = rsv_direct_no_sums();
    for (uint32_t index = lane; index < a->rays.samples; index += RSV_LANES) {
        rsv_direct_ray r = rsv_direct_draw(a, node, index, varied);
        rsv_direct_count(&sums, &r, rsv_direct_arrives(a, &r, varied));
    }
    return sums;
}

RSV_INLINE rsv_direct_sums rsv_direct_sums_add(rsv_direct_sums a, rsv_direct_sums b)
{
    a.open = rgb_add(a.open, b.open);
    a.visible = rgb_add(a.visible, b.visible);
    a.further = rgb_add(a.further, b.further);
    a.further_squared += b.further_squared;
    a.veiled += b.veiled;
    a.seen += b.seen;
    a.hidden += b.hidden;
    return a;
}

RSV_INLINE void rsv_direct_emitters_store(
    const rsv_direct_args *a, uint32_t node, rsv_direct_sums sums)
{
    a->sums[node] = sums;
}

RSV_KERNEL_SUM_VARIED(direct_emitters, rsv_direct_args, rsv_direct_sums, rsv_direct_emitters_lane,
    rsv_direct_sums_add, rsv_direct_emitters_store)

/// What the sums say of a node.
RSV_INLINE void rsv_direct_finish_item(const rsv_direct_args *a, uint32_t node)
{
    const rsv_direct_setting *s = &a->setting;
    const rsv_direct_receiver *receiver = &a->receiver[node];
    float valid = (float)rsv_count_bits(receiver->valid);
    rsv_rgb unshadowed;
    bool by_tree =
        rsv_direct_unshadowed(s, receiver, a->local + (size_t)node * s->points, valid, &unshadowed);
    rsv_direct_estimate e = rsv_direct_no_estimate();
    if (by_tree || !rgb_is_black(unshadowed)) {
        e = rsv_direct_from_sums(&a->sums[node], unshadowed, by_tree,
            rsv_direct_drawn(s, receiver->valid, a->rays.samples));
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
    const rsv_direct_receiver *receiver = &a->receiver[node];
    rsv_direct_punctual p;
    p.sum = rgb_gray(0);
    p.seen = p.hidden = 0;
    if (lane >= a->setting.points || !(receiver->valid >> lane & 1)) return p;
    rsv_direct_ray r = rsv_direct_to_punctual(&a->setting, receiver, lane, a->light);
    rsv_direct_count_punctual(&p, &r, rsv_direct_arrives(a, &r, varied));
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
    float valid = (float)rsv_count_bits(a->receiver[node].valid);
    e->irradiance = rgb_mad(e->irradiance, 1 / valid, p.sum);
    e->partial = e->partial || (p.seen > 0 && p.hidden > 0);
    e->rays += a->setting.points;
}

RSV_KERNEL_SUM_VARIED(direct_punctual, rsv_direct_args, rsv_direct_punctual,
    rsv_direct_punctual_lane, rsv_direct_punctual_add, rsv_direct_punctual_store)

#endif
