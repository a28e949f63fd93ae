/// Textures of surfaces (surface.h).
#ifndef RSV_SURFACE_BODY_H
#define RSV_SURFACE_BODY_H

#include "../scene/material_at.h"
#include "surface.h"

RSV_SHARED rsv_surface_point rsv_surface_point_seen(
    const rsv_scene_view *scene, uint32_t triangle, float u, float v, bool back, float width)
{
    rsv_surface_point point = rsv_surface_point_at(scene, triangle, u, v, back);
    if (!(scene->material_varies[scene->triangle_material[triangle]] & RSV_VARIES_BY_TEXTURE))
        return point;
    float side = back ? -1.0f : 1.0f;
    rsv_vec3 mapped = rsv_mapped_normal(scene, triangle, u, v, width, v3_scale(point.normal, side));
    mapped = v3_scale(mapped, side);
    if (v3_dot(mapped, point.geometric) > 0) point.normal = mapped;
    return point;
}

/// Of the clear coat, on the front side; the interpolated one where the map's is below the triangle.
RSV_INLINE rsv_vec3 rsv_surface_coat_normal(const rsv_scene_view *scene, rsv_footprint at)
{
    rsv_surface_point point = rsv_surface_point_at(scene, at.triangle, at.u, at.v, false);
    rsv_vec3 mapped =
        rsv_mapped_coat_normal(scene, at.triangle, at.u, at.v, at.width, point.normal);
    return v3_dot(mapped, point.geometric) > 0 ? mapped : point.normal;
}

/// How the surface scatters light of all channels.
RSV_INLINE const rsv_bsdf *rsv_surface_bsdf_of_all(
    const rsv_scene_view *scene, const rsv_bsdf *common, rsv_footprint at, rsv_bsdf *storage)
{
    uint32_t material = scene->triangle_material[at.triangle];
    if (!scene->material_varies[material]) return &common[material];
    rsv_material m = rsv_material_at(scene, at.triangle, at.u, at.v, at.width);
    rsv_bsdf_vary(&common[material], &m, storage);
    if (storage->brushed)
        storage->brush = rsv_brush_direction(scene, at.triangle, at.u, at.v, m.anisotropy_rotation);
    if (storage->tilted) storage->coat_normal = rsv_surface_coat_normal(scene, at);
    if (!storage->solid) storage->opacity = m.opacity;
    return storage;
}

RSV_SHARED const rsv_bsdf *rsv_surface_bsdf(
    const rsv_scene_view *scene, const rsv_bsdf *common, rsv_footprint at, rsv_bsdf *storage)
{
    const rsv_bsdf *bsdf = rsv_surface_bsdf_of_all(scene, common, at, storage);
    bool one = at.channel != RSV_CHANNEL_OPEN && at.channel != RSV_CHANNEL_ALL;
    if (!one || !rsv_bsdf_disperses(bsdf)) return bsdf;
    *storage = rsv_bsdf_in_channel(bsdf, at.channel);
    return storage;
}

RSV_SHARED const rsv_bsdf *rsv_surface_entry_bsdf(
    const rsv_scene_view *scene, const rsv_bsdf *common, rsv_footprint at, rsv_bsdf *storage)
{
    uint32_t material = scene->triangle_material[at.triangle];
    if (!scene->material_varies[material]) return &common[material];
    rsv_material m = rsv_material_at(scene, at.triangle, at.u, at.v, at.width);
    rsv_bsdf_vary_entry(&common[material], &m, storage);
    if (!storage->solid) storage->opacity = m.opacity;
    return storage;
}

#endif
