/// Photons from sources to where they land: the GPU version of src/direct/photons.c, photon by photon.
#ifndef RSV_SHOOTING_KERNELS_H
#define RSV_SHOOTING_KERNELS_H

#include "../direct/device_shooting.h"
#include "launch.h"

/// Data for photons; the structure and all its pointers are in device memory.
typedef struct rsv_gpu_range {
    rsv_transport_scene transport;
    rsv_tracer tracer;
    rsv_shooting shooting;
    rsv_photon_origins origins;
    rsv_photon_map map[RSV_DEVICE_MAPS];
    size_t map_count;
    const rsv_photon_source *source;
    int64_t *rays; ///< one number: traced so far
} rsv_gpu_range;

typedef struct rsv_shooting_args {
    const rsv_gpu_range *range;
    uint32_t source, first, count;
} rsv_shooting_args;

RSV_INLINE void rsv_shooting_item(const rsv_shooting_args *a, uint32_t item)
{
    const rsv_gpu_range *r = a->range;
    rsv_photon photon;
    bool begins = rsv_photon_begin(
        &r->shooting, &r->source[a->source], a->source, a->first + item, a->count, &photon);
    while (begins &&
           rsv_photon_scatter(&r->transport, &photon.path, &photon.level, &photon.random, NULL))
        rsv_photon_land(&r->transport, &photon.path, rgb_mul(photon.flux, photon.path.weight),
            r->map, r->map_count);
    rsv_add_atomically(r->rays, 1 + (begins ? photon.path.rays : 0));
}

RSV_KERNEL(shooting, rsv_shooting_args, rsv_shooting_item)

#endif
