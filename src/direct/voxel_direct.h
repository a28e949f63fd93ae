/// E0 in the air: what arrives at voxels straight from the sources.
#ifndef RSV_VOXEL_DIRECT_H
#define RSV_VOXEL_DIRECT_H

#include "../elements/voxels.h"
#include "../sources/air_light.h"
#include "direct_receiver.h"

/// Voxels, and what lights them. Borrowed.
typedef struct rsv_voxel_air {
    const rsv_voxels *voxels;
    rsv_air_setting setting;
} rsv_voxel_air;

/// A place in a voxel without the point and spot lights close by, whose fluence has no bound there.
rsv_air_receiver rsv_voxel_receiver(const rsv_voxels *voxels, uint32_t voxel, rsv_vec3 place);

/// The mean fluence in the voxel of the lights that this leaves out: one sample. @param u in [0, 1)
rsv_rgb rsv_voxel_near_light(const rsv_voxel_air *air, uint32_t voxel,
    const rsv_air_receiver *receiver, const float u[4], uint64_t *rays);

/// A quarter of the mean fluence that voxels receive from sampled sources, by next-event estimates from places that are
/// evenly distributed. Near point and spot lights, where fluence has no bound, places are distributed as it is.
///
/// @param job of elements with voxels; `samples` per voxel
/// @param irradiance [node_count] those of voxels are set @param rays are added to
rsv_status rsv_voxel_direct(const rsv_direct_job *job, rsv_rgb *irradiance, uint64_t *rays);

#endif
