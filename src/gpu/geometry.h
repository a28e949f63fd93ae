/// What kernels that follow rays need of a scene, on the device.
#ifndef RSV_GPU_GEOMETRY_H
#define RSV_GPU_GEOMETRY_H

#include "../bvh/bvh.h"
#include "gpu.h"

typedef struct rsv_gpu_geometry {
    const rsv_scene_view *host; ///< borrowed until it is uploaded, as the next one's arrays
    rsv_bvh_view host_bvh;
    /// With addresses on the device: position, normal, triangle, triangle_material and material alone.
    rsv_scene_view view;
    rsv_scene_view *view_there; ///< the same, on the device
    rsv_bvh_view bvh;
} rsv_gpu_geometry;

rsv_gpu_geometry rsv_gpu_geometry_of(const rsv_scene_view *view, rsv_bvh_view bvh);

/// Part of a task's layout.
void rsv_gpu_geometry_place(rsv_gpu_geometry *geometry, rsv_gpu_block *block);
void rsv_gpu_geometry_upload(const rsv_gpu_geometry *geometry, rsv_gpu *gpu);

#endif
