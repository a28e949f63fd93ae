/// K of translucent bodies: entering light, its means over clusters, and rows of both.
#ifndef RSV_DIFFUSION_KERNELS_H
#define RSV_DIFFUSION_KERNELS_H

#include "transport_kernels.h"

typedef struct rsv_diffuse_args {
    rsv_leave_args leave; ///< of the field that enters
    rsv_rgb *entered;     ///< [node_count + mean_count]
    rsv_rgb *diffused;    ///< [node_count]
    const uint32_t *mean, *mean_begin, *source;
    const float *share;
    uint32_t first_mean; ///< of the level in hand
    const uint32_t *node;
    const uint64_t *row_begin;
    const uint32_t *column;
    const rsv_rgb *weight;
} rsv_diffuse_args;

/// Light that enters at a node also leaves there, unless a row says otherwise.
RSV_INLINE void rsv_enter_item(const rsv_diffuse_args *a, uint32_t node)
{
    a->entered[node] = a->diffused[node] = rsv_leave_value(&a->leave, node);
}

RSV_KERNEL(enter, rsv_diffuse_args, rsv_enter_item)

RSV_INLINE void rsv_mean_item(const rsv_diffuse_args *a, uint32_t k)
{
    uint32_t i = a->first_mean + k;
    rsv_rgb sum = rgb_gray(0);
    for (uint32_t s = a->mean_begin[i]; s < a->mean_begin[i + 1]; s++)
        sum = rgb_mad(sum, a->share[s], a->entered[a->source[s]]);
    a->entered[a->mean[i]] = sum;
}

RSV_KERNEL(mean, rsv_diffuse_args, rsv_mean_item)

RSV_INLINE rsv_rgb rsv_diffuse_lane(const rsv_diffuse_args *a, uint32_t row, uint32_t lane)
{
    rsv_rgb sum = rgb_gray(0);
    for (uint64_t k = a->row_begin[row] + lane; k < a->row_begin[row + 1]; k += RSV_LANES)
        sum = rgb_add(sum, rgb_mul(a->weight[k], a->entered[a->column[k]]));
    return sum;
}

RSV_INLINE void rsv_diffuse_store(const rsv_diffuse_args *a, uint32_t row, rsv_rgb sum)
{
    a->diffused[a->node[row]] = sum;
}

RSV_KERNEL_SUM(diffuse, rsv_diffuse_args, rsv_rgb, rsv_diffuse_lane, rgb_add, rsv_diffuse_store)

#endif
