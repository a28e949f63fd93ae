/// How light enters a patch of surface through its coat, which may be textured.
///
/// For a plain material, this is rsv_bsdf_entry. Where the coat varies, it is the mean over points of the patch, by
/// cosine only. In uniform light all points have the same value, so a few suffice.
///
/// Inline functions are also for device code.
#ifndef RSV_ENTRY_H
#define RSV_ENTRY_H

#include "surface.h"

#define RSV_ENTRY_COS 16 ///< cos = (k / 15)^2

typedef struct rsv_surface_entry {
    uint32_t material;
    uint32_t points; ///< that `mean` was made from; 0 = the coat is the same all over
    rsv_rgb mean[RSV_ENTRY_COS];
} rsv_surface_entry;

/// Whether textures change the transmission of the material's coat.
bool rsv_coat_varies(const rsv_scene_view *scene, uint32_t material);

/// The entry of a patch of this material, of no points yet.
rsv_surface_entry rsv_surface_entry_of(uint32_t material);

/// Adds a point of a patch whose coat varies. @param common [material_count] from rsv_surface_common_bsdf
void rsv_surface_entry_add(rsv_surface_entry *entry, const rsv_scene_view *scene,
    const rsv_bsdf *common, uint32_t triangle, float u, float v);

/// Divides the sums to get means.
void rsv_surface_entry_finish(rsv_surface_entry *entry);

/// Whether the patch is coated at all.
RSV_INLINE bool rsv_surface_entry_tints(const rsv_surface_entry *entry, const rsv_bsdf *common)
{
    return entry->points > 0 || common[entry->material].coated;
}

/// Weight of light at that cosine as irradiance of the patch.
RSV_INLINE rsv_rgb rsv_surface_entry_at(
    const rsv_surface_entry *entry, const rsv_bsdf *common, float cos)
{
    if (!entry->points) return rsv_bsdf_entry(&common[entry->material], cos);
    rsv_table_place at = rsv_table_place_at(sqrtf(f_min(fabsf(cos), 1)), RSV_ENTRY_COS);
    const rsv_rgb *mean = &entry->mean[at.index];
    return rgb_mad(mean[0], at.weight, rgb_sub(mean[1], mean[0]));
}

#endif
