/// Keys of materials, equal if a surface transmits and receives light as it did before an edit.
///
/// Base colours and emission are not included, because albedos and sources are computed for each solve.
#ifndef RSV_MATERIAL_KEYS_H
#define RSV_MATERIAL_KEYS_H

#include "../specular/specular_path.h"

typedef struct rsv_material_key {
    uint64_t key; ///< 0 = never equal: cut-outs and partial coverage
    bool placed;  ///< textures count, and so do texture coordinates
} rsv_material_key;

/// @param keys out: [material_count], freed by the caller
rsv_status rsv_material_keys_create(
    rsv_context *context, const rsv_transport_scene *scene, rsv_material_key **keys);

/// Of a triangle and its material; 0 if that has none.
uint64_t rsv_surface_key(
    const rsv_scene_view *scene, const rsv_material_key *keys, uint32_t triangle);

/// Keys of the normal maps that affect how elements receive light from rows.
/// @param keys out: [material_count], `key` 0 = no normal map; freed by the caller
rsv_status rsv_normal_map_keys_create(
    rsv_context *context, const rsv_scene_view *scene, rsv_material_key **keys);

/// Texture coordinates of a triangle, behind `key`.
uint64_t rsv_key_add_uvs(uint64_t key, const rsv_scene_view *scene, uint32_t triangle);

#endif
