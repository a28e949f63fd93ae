/// How the surfaces of a scene look, on the device: its materials with what makes them vary, and how they scatter.
#ifndef RSV_GPU_SURFACES_H
#define RSV_GPU_SURFACES_H

#include "../bsdf/bsdf.h"
#include "../scene/texture.h"
#include "geometry.h"

/// Materials and textures as they are uploaded, with addresses on the device.
typedef struct rsv_gpu_surfaces {
    rsv_material *material;     ///< [material_count] on the host
    rsv_texture *texture;       ///< [texture_count] likewise
    rsv_texture_ref **use;      ///< [material_count] the textures of each, on the device
    rsv_bsdf *scattering;       ///< [material_count] on the host, as they are uploaded
    rsv_bsdf *bsdf;             ///< [material_count] on the device
    rsv_bsdf_tables *tables;    ///< on the device
    const rsv_scene_view *host; ///< borrowed, as the geometry's
} rsv_gpu_surfaces;

/// @param message of a failure, [RSV_DEVICE_MESSAGE_BYTES]
rsv_status rsv_gpu_surfaces_create(
    const rsv_scene_view *host, rsv_gpu_surfaces *surfaces, char *message);
void rsv_gpu_surfaces_destroy(rsv_gpu_surfaces *surfaces);

/// Part of a task's layout, after the geometry, whose view gets the addresses.
void rsv_gpu_surfaces_place(
    rsv_gpu_surfaces *surfaces, rsv_gpu_geometry *geometry, rsv_gpu_block *block);
/// After the upload of the geometry. @param bsdf [material_count]
void rsv_gpu_surfaces_upload(const rsv_gpu_surfaces *surfaces, const rsv_gpu_geometry *geometry,
    const rsv_bsdf *bsdf, rsv_gpu *gpu);
/// The materials alone, as edits leave them.
void rsv_gpu_surfaces_upload_materials(const rsv_gpu_surfaces *surfaces,
    const rsv_gpu_geometry *geometry, const rsv_bsdf *bsdf, rsv_gpu *gpu);

#endif
