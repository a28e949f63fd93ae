/// A = G K: irradiance to exitance, exitance along rows to irradiance.
#ifndef RSV_TRANSPORT_KERNELS_H
#define RSV_TRANSPORT_KERNELS_H

#include "../sources/double3.h"
#include "launch.h"

#if defined(__cplusplus)
#define RSV_ALIGN_16 alignas(16)
#else
#define RSV_ALIGN_16 _Alignas(16)
#endif

/// An RGB value that comes with one load.
typedef struct rsv_rgb4 {
    RSV_ALIGN_16 float r;
    float g, b, unused;
} rsv_rgb4;

RSV_INLINE rsv_rgb rgb4_load(const rsv_rgb4 *from)
{
#if defined(__CUDA_ARCH__)
    float4 v = __ldg((const float4 *)from);
    return rgb(v.x, v.y, v.z);
#else
    return rgb(from->r, from->g, from->b);
#endif
}

/// An index that is read once: it shall not drive values out of the cache.
RSV_INLINE uint32_t rsv_load_once(const uint32_t *from)
{
#if defined(__CUDA_ARCH__)
    return __ldcs(from);
#else
    return *from;
#endif
}

RSV_INLINE void rgb4_store(rsv_rgb4 *to, rsv_rgb v)
{
    rsv_rgb4 value = { v.r, v.g, v.b, 0 };
    *to = value;
}

// ---- K -------------------------------------------------------------------------------------------

/// exitance = albedo x irradiance, where hanging nodes have the mean of their parents. One field of `fields`.
typedef struct rsv_leave_args {
    const rsv_rgb *field; ///< of node n at n x fields
    uint32_t fields;
    const uint32_t *parent_begin, *parent;
    const float *parent_weight;
    const rsv_rgb *albedo;
    rsv_rgb4 *exitance;
} rsv_leave_args;

RSV_INLINE rsv_rgb rsv_leave_value(const rsv_leave_args *a, uint32_t node)
{
    uint32_t begin = a->parent_begin[node], end = a->parent_begin[node + 1];
    rsv_rgb sum = rgb_gray(0);
    if (begin == end) return a->field[(size_t)node * a->fields];
    for (uint32_t k = begin; k < end; k++)
        sum = rgb_mad(sum, a->parent_weight[k], a->field[(size_t)a->parent[k] * a->fields]);
    return sum;
}

RSV_INLINE void rsv_leave_item(const rsv_leave_args *a, uint32_t node)
{
    rgb4_store(&a->exitance[node], rgb_mul(a->albedo[node], rsv_leave_value(a, node)));
}

RSV_KERNEL(leave, rsv_leave_args, rsv_leave_item)

// ---- G -------------------------------------------------------------------------------------------

/// image = G exitance, one row by RSV_LANES lanes: its indices come in whole cache lines.
typedef struct rsv_gather_args {
    const uint64_t *row_begin, *tinted_begin;
    const uint32_t *column, *tinted_column;
    const rsv_rgb *tinted_weight;
    const float *scale;
    const rsv_rgb4 *exitance;
    const rsv_rgb *source, *field; ///< of the residual: source + A field - field
    rsv_rgb *image;
    uint32_t fields; ///< of source, field and image
} rsv_gather_args;

RSV_INLINE rsv_rgb rsv_gather_lane(const rsv_gather_args *a, uint32_t row, uint32_t lane)
{
    rsv_rgb sum = rgb_gray(0);
    uint64_t end = a->row_begin[row + 1], tinted_end = a->tinted_begin[row + 1];
    RSV_UNROLL
    for (uint64_t k = a->row_begin[row] + lane; k < end; k += RSV_LANES)
        sum = rgb_add(sum, rgb4_load(&a->exitance[rsv_load_once(&a->column[k])]));
    for (uint64_t k = a->tinted_begin[row] + lane; k < tinted_end; k += RSV_LANES)
        sum = rgb_add(
            sum, rgb_mul(a->tinted_weight[k], rgb4_load(&a->exitance[a->tinted_column[k]])));
    return sum;
}

RSV_INLINE void rsv_gather_store(const rsv_gather_args *a, uint32_t row, rsv_rgb sum)
{
    a->image[(size_t)row * a->fields] = rgb_scale(sum, a->scale[row]);
}

RSV_KERNEL_SUM(gather, rsv_gather_args, rsv_rgb, rsv_gather_lane, rgb_add, rsv_gather_store)

/// image = field - A field
RSV_INLINE void rsv_gather_system_store(const rsv_gather_args *a, uint32_t row, rsv_rgb sum)
{
    size_t k = (size_t)row * a->fields;
    a->image[k] = rgb_sub(a->field[k], rgb_scale(sum, a->scale[row]));
}

RSV_KERNEL_SUM(
    gather_system, rsv_gather_args, rsv_rgb, rsv_gather_lane, rgb_add, rsv_gather_system_store)

// the residual, with sums in double

RSV_INLINE rsv_double3 double3_add(rsv_double3 a, rsv_double3 b)
{
    rsv_double3 sum = { a.x + b.x, a.y + b.y, a.z + b.z };
    return sum;
}

RSV_INLINE rsv_double3 double3_mul(rsv_rgb a, rsv_rgb b)
{
    rsv_double3 product = { (double)a.r * b.r, (double)a.g * b.g, (double)a.b * b.b };
    return product;
}

RSV_INLINE rsv_double3 rsv_residual_lane(const rsv_gather_args *a, uint32_t row, uint32_t lane)
{
    rsv_double3 sum = { 0, 0, 0 };
    uint64_t end = a->row_begin[row + 1], tinted_end = a->tinted_begin[row + 1];
    RSV_UNROLL
    for (uint64_t k = a->row_begin[row] + lane; k < end; k += RSV_LANES)
        sum = double3_add(
            sum, double3_mul(rgb_gray(1), rgb4_load(&a->exitance[rsv_load_once(&a->column[k])])));
    for (uint64_t k = a->tinted_begin[row] + lane; k < tinted_end; k += RSV_LANES)
        sum = double3_add(
            sum, double3_mul(a->tinted_weight[k], rgb4_load(&a->exitance[a->tinted_column[k]])));
    return sum;
}

RSV_INLINE void rsv_residual_store(const rsv_gather_args *a, uint32_t row, rsv_double3 sum)
{
    size_t k = (size_t)row * a->fields;
    double scale = (double)a->scale[row];
    rsv_rgb b = a->source[k], x = a->field[k];
    a->image[k] = rgb((float)((double)b.r + sum.x * scale - (double)x.r),
        (float)((double)b.g + sum.y * scale - (double)x.g),
        (float)((double)b.b + sum.z * scale - (double)x.b));
}

RSV_KERNEL_SUM(gather_residual, rsv_gather_args, rsv_double3, rsv_residual_lane, double3_add,
    rsv_residual_store)

#endif
