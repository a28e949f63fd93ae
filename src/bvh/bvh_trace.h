/// Ray tracing in the wide hierarchy, for hosts and devices. Every path through the tree fits into the stack.
///
/// Conventions are those of src/trace: hits are in (0, t_max), directions have any length, triangles have two sides, u
/// and v are the weights of corners 1 and 2. Rays that leave surfaces start at rsv_offset_origin.
#ifndef RSV_BVH_TRACE_H
#define RSV_BVH_TRACE_H

#include "../core/bits.h"
#include "../scene/twins.h"
#include "bvh.h"
#include "watertight.h"

#if defined(__wasm_simd128__)
#include "bvh_visit_wasm.h"
#endif

/// A ray as nodes want it.
typedef struct rsv_bvh_ray {
    rsv_vec3 origin, inverse; ///< 1 / direction, finite
    uint32_t flip;            ///< turns slots into the order in which the ray meets them
} rsv_bvh_ray;

/// Children or triangles that remain to be visited, one bit each, starting at `first`. Children use the highest byte,
/// with the nearest in its lowest bit; the lowest byte says which slots contain children.
typedef struct rsv_bvh_group {
    uint32_t first, bits;
} rsv_bvh_group;

/// 2^e of a biased exponent.
RSV_INLINE float rsv_power_of_two(uint32_t biased)
{
    union {
        uint32_t bits;
        float value;
    } power;
    power.bits = biased << 23;
    return power.value;
}

RSV_INLINE float rsv_inverse_component(float d, float least)
{
    return 1 / (fabsf(d) > least ? d : copysignf(least, d));
}

RSV_INLINE rsv_bvh_ray rsv_bvh_ray_of(rsv_vec3 origin, rsv_vec3 direction)
{
    float least =
        0x1p-60f * v3_max_abs(direction); // stands in for 0, so that no product is not a number
    rsv_bvh_ray ray;
    ray.origin = origin;
    ray.inverse = v3(rsv_inverse_component(direction.x, least),
        rsv_inverse_component(direction.y, least), rsv_inverse_component(direction.z, least));
    ray.flip =
        (direction.x < 0 ? 1u : 0u) | (direction.y < 0 ? 2u : 0u) | (direction.z < 0 ? 4u : 0u);
    return ray;
}

/// Distances at which a ray passes the planes of a node's grid along one axis: plane q at q * step + start, by as much
/// as rounding may have moved it earlier or later.
typedef struct rsv_bvh_axis {
    float step, start, slack;
} rsv_bvh_axis;

RSV_INLINE rsv_bvh_axis rsv_bvh_axis_of(float to_origin, float step, float reach, float inverse)
{
    rsv_bvh_axis axis;
    axis.step = step * inverse;
    axis.start = to_origin * inverse;
    axis.slack = reach * fabsf(inverse);
    return axis;
}

RSV_INLINE float rsv_bvh_byte(const uint32_t word[2], int k)
{
    return (float)(word[k >> 2] >> (8 * (k & 3)) & 0xff);
}

/// When a ray enters and leaves the slab of child k.
RSV_INLINE void rsv_bvh_pass_slab(const rsv_bvh_axis *axis, const uint32_t low[2],
    const uint32_t high[2], int k, float *enter, float *leave)
{
    float a = rsv_bvh_byte(low, k) * axis->step + axis->start;
    float b = rsv_bvh_byte(high, k) * axis->step + axis->start;
    *enter = f_max(f_min(a, b) - axis->slack, *enter);
    *leave = f_min(f_max(a, b) + axis->slack, *leave);
}

/// Tests the children of a node. @param children, triangles out
RSV_INLINE void rsv_bvh_visit(const rsv_bvh_node *from, const rsv_bvh_ray *ray, float t_max,
    rsv_bvh_group *children, rsv_bvh_group *triangles)
{
    rsv_bvh_node node = *from;
    rsv_vec3 to = v3_sub(v3(node.origin[0], node.origin[1], node.origin[2]), ray->origin);
    float sx = rsv_power_of_two(node.exponents & 0xff),
          sy = rsv_power_of_two(node.exponents >> 8 & 0xff),
          sz = rsv_power_of_two(node.exponents >> 16 & 0xff);
    // the triangle test sees corners with the rounding of the axis along which they are farthest
    float size = f_max(sx, f_max(sy, sz));
    float reach = 0x1p-21f * (v3_max_abs(to) + 255 * size);
    rsv_bvh_axis x = rsv_bvh_axis_of(to.x, sx, reach, ray->inverse.x),
                 y = rsv_bvh_axis_of(to.y, sy, reach, ray->inverse.y),
                 z = rsv_bvh_axis_of(to.z, sz, reach, ray->inverse.z);
    uint32_t hits = 0;
#if defined(__wasm_simd128__)
    rsv_bvh_spans spans = { { wasm_f32x4_splat(0), wasm_f32x4_splat(0) },
        { wasm_f32x4_splat(t_max), wasm_f32x4_splat(t_max) } };
    rsv_bvh_pass_slabs(&spans, from->low[0], from->high[0], x.step, x.start, x.slack);
    rsv_bvh_pass_slabs(&spans, from->low[1], from->high[1], y.step, y.start, y.slack);
    rsv_bvh_pass_slabs(&spans, from->low[2], from->high[2], z.step, z.start, z.slack);
    for (uint32_t met = rsv_bvh_met(&spans); met; met &= met - 1) {
        uint32_t k = rsv_lowest_bit(met);
        uint32_t meta = node.meta[k >> 2] >> (8 * (k & 3)) & 0xff, first = meta & 31;
        hits |= (meta >> 5) << (first >= 24 ? first ^ ray->flip : first);
    }
#else
#if defined(__CUDA_ARCH__)
#pragma unroll
#endif
    for (int k = 0; k < 8; k++) {
        float enter = 0, leave = t_max;
        rsv_bvh_pass_slab(&x, node.low[0], node.high[0], k, &enter, &leave);
        rsv_bvh_pass_slab(&y, node.low[1], node.high[1], k, &enter, &leave);
        rsv_bvh_pass_slab(&z, node.low[2], node.high[2], k, &enter, &leave);
        uint32_t meta = node.meta[k >> 2] >> (8 * (k & 3)) & 0xff, first = meta & 31;
        uint32_t bit = first >= 24 ? first ^ ray->flip : first;
        if (enter <= leave) hits |= (meta >> 5) << bit;
    }
#endif
    children->first = node.first_child;
    children->bits = (hits & 0xff000000u) | node.exponents >> 24;
    triangles->first = node.first_triangle;
    triangles->bits = hits & 0xffffffu;
}

/// Takes the nearest child out of a group. @return its node
RSV_INLINE uint32_t rsv_bvh_take_child(rsv_bvh_group *group, uint32_t flip)
{
    uint32_t place = rsv_lowest_bit(group->bits >> 24), slot = place ^ flip;
    group->bits &= ~(1u << (24 + place));
    return group->first + rsv_count_bits(group->bits & ((1u << slot) - 1));
}

/// The nearest hit with t in (0, ray.t_max), or any. @param hit its triangle is RSV_NONE where nothing is met
RSV_INLINE bool rsv_bvh_trace(const rsv_bvh_view *bvh, const rsv_ray *ray, bool any, rsv_hit *hit)
{
    rsv_bvh_group stack[RSV_BVH_DEPTH], group = { 0, 1u << 24 }, triangles = { 0, 0 };
    rsv_bvh_ray in = rsv_bvh_ray_of(ray->origin, ray->direction);
    rsv_shear shear = rsv_shear_of(ray->direction);
    int depth = 0;
    group.bits <<= in.flip; // the root is in slot 0
    hit->triangle = RSV_NONE;
    hit->t = ray->t_max;
    hit->u = hit->v = 0;
    if (bvh->node_count == 0) return false;
    for (;;) {
        uint32_t node = rsv_bvh_take_child(&group, in.flip);
        if (group.bits >> 24) stack[depth++] = group;
        rsv_bvh_visit(&bvh->node[node], &in, hit->t, &group, &triangles);
        for (; triangles.bits; triangles.bits &= triangles.bits - 1) {
            rsv_bvh_triangle t = bvh->triangle[triangles.first + rsv_lowest_bit(triangles.bits)];
            rsv_hit met;
            if (!rsv_meets_triangle(&shear, ray->origin, &t, hit->t, &met)) continue;
            if (bvh->holes && rsv_is_cut_out(bvh->holes, t.index, met.u, met.v)) continue;
            met.triangle = t.index;
            *hit = met;
            if (any) return true;
        }
        if (group.bits >> 24) continue;
        if (depth == 0) return hit->triangle != RSV_NONE;
        group = stack[--depth];
    }
}

/// A hierarchy for code that traces holes only where there are some.
RSV_INLINE rsv_bvh_view rsv_bvh_with_holes(rsv_bvh_view bvh, bool holes)
{
    if (!holes) bvh.holes = NULL;
    return bvh;
}

RSV_INLINE bool rsv_bvh_closest(const rsv_bvh_view *bvh, const rsv_ray *ray, rsv_hit *hit)
{
    if (!rsv_bvh_trace(bvh, ray, false, hit)) return false;
    if (bvh->twins) rsv_twins_settle(bvh->twins, ray->direction, hit);
    return true;
}

RSV_INLINE bool rsv_bvh_occluded(const rsv_bvh_view *bvh, const rsv_ray *ray)
{
    rsv_hit hit;
    return rsv_bvh_trace(bvh, ray, true, &hit);
}

#endif
