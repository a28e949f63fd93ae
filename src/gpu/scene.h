/// A scene on the device: its triangles, the hierarchy over them, and its materials.
#ifndef RSV_GPU_SCENE_H
#define RSV_GPU_SCENE_H

#include "../bvh/bvh.h"
#include "../scene/texture.h"
#include "../scene/twins.h"
#include "gpu.h"

typedef struct rsv_gpu_scene {
    const rsv_scene_view *host; ///< borrowed
    rsv_bvh_view host_bvh;      ///< borrowed until it is uploaded
    bool varied;                ///< includes data of materials that vary over their surfaces
    rsv_material *material;     ///< [material_count] on the host, with addresses on the device
    rsv_texture *texture;       ///< [texture_count], device memory
    rsv_luminaire *luminaire;   ///< [luminaire_count], device memory
    rsv_texture_ref **use;      ///< [material_count] the textures of each, on the device
    /// With addresses on the device. No lights (sources.h) and no names; where it is not varied no textures either.
    rsv_scene_view view;
    rsv_scene_view *there; ///< the same, on the device
    rsv_twins twins;       ///< with addresses on the device
    rsv_bvh_view bvh;
} rsv_gpu_scene;

/// @param varied whether materials are evaluated at points; scenes with cut-outs are always varied
/// @param message of a failure, [RSV_DEVICE_MESSAGE_BYTES]
rsv_status rsv_gpu_scene_create(
    const rsv_scene_view *host, rsv_bvh_view bvh, bool varied, rsv_gpu_scene *scene, char *message);
void rsv_gpu_scene_destroy(rsv_gpu_scene *scene);

/// Part of a task's layout.
void rsv_gpu_scene_place(rsv_gpu_scene *scene, rsv_gpu_block *block);
void rsv_gpu_scene_upload(const rsv_gpu_scene *scene, rsv_gpu *gpu);
/// Uploads only the materials, after an edit.
void rsv_gpu_scene_upload_materials(const rsv_gpu_scene *scene, rsv_gpu *gpu);

#endif
