/// Keys of materials: by them a surface is known to let light pass and enter as it did before an edit.
///
/// Base colours and emission are no part of them: albedos and sources are found anew each time.
#ifndef RSV_MATERIAL_KEYS_H
#define RSV_MATERIAL_KEYS_H

#include "../specular/specular_path.h"

typedef struct rsv_material_key {
    uint64_t key; ///< 0 = may be another each time: holes, and what covers in part
    bool placed;  ///< textures count, and so do texture coordinates
} rsv_material_key;

/// @param keys out: [material_count], to be freed
rsv_status rsv_material_keys_create(
    rsv_context *context, const rsv_transport_scene *scene, rsv_material_key **keys);

/// Of a triangle and its material; 0 if that has none.
uint64_t rsv_surface_key(
    const rsv_scene_view *scene, const rsv_material_key *keys, uint32_t triangle);

/// Of the normal maps by which elements receive what rows gather.
/// @param keys out: [material_count], `key` 0 where there is none; to be freed
rsv_status rsv_normal_map_keys_create(
    rsv_context *context, const rsv_scene_view *scene, rsv_material_key **keys);

/// Texture coordinates of a triangle, behind `key`.
uint64_t rsv_key_add_uvs(uint64_t key, const rsv_scene_view *scene, uint32_t triangle);

#endif
