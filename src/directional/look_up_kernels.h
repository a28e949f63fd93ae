/// Lookups of sixteen lobes at a time, compiled for several instruction sets from one source (look_up_body.h). They use no
/// operation whose rounding could differ between those.
#ifndef RSV_LOOK_UP_KERNELS_H
#define RSV_LOOK_UP_KERNELS_H

#include "directional_internal.h"

struct rsv_look_up_kernels {
    /// Looks up the first `lanes` of a packet; the others come out black.
    void (*look_up)(
        const rsv_directional *directional, uint32_t lanes, rsv_directional_packet *packet);
};

extern const rsv_look_up_kernels rsv_look_up_kernels_portable, rsv_look_up_kernels_avx2,
    rsv_look_up_kernels_avx512;

/// What the processor runs fastest.
const rsv_look_up_kernels *rsv_look_up_kernels_best(void);

#endif
