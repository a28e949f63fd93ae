/// E0 in the air: what arrives at voxels straight from the sources.
#ifndef RSV_VOXEL_DIRECT_H
#define RSV_VOXEL_DIRECT_H

#include "direct_receiver.h"

/// A quarter of the mean fluence that voxels receive from sampled sources, by next-event estimates from places that are
/// evenly distributed. Near point and spot lights, where fluence has no bound, places are distributed as it is.
///
/// @param job of elements with voxels; `samples` per voxel
/// @param irradiance [node_count] those of voxels are set @param rays are added to
rsv_status rsv_voxel_direct(const rsv_direct_job *job, rsv_rgb *irradiance, uint64_t *rays);

#endif
