/// Relighting by factors: the light of receivers is the sum of each light's contribution times its scale.
#ifndef RSV_BASIS_KERNELS_H
#define RSV_BASIS_KERNELS_H

#include "launch.h"

typedef struct rsv_basis_args {
    const float *value; ///< [light_count][float_count]
    const float *scale; ///< [light_count][3]
    float *out;         ///< [float_count]: receivers, three channels each
    uint32_t light_count;
    size_t float_count;
} rsv_basis_args;

RSV_INLINE void rsv_basis_item(const rsv_basis_args *a, uint32_t k)
{
    const float *scale = a->scale + k % 3, *value = a->value + k;
    float sum = 0;
    RSV_UNROLL
    for (uint32_t light = 0; light < a->light_count; light++)
        sum += scale[3 * light] * value[light * a->float_count];
    a->out[k] = sum;
}

RSV_KERNEL(basis, rsv_basis_args, rsv_basis_item)

#endif
