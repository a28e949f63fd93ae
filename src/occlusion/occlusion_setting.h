/// Rays of ambient occlusion, for CPUs and devices: the surface that a camera ray hits, and the rays that leave it.
#ifndef RSV_OCCLUSION_SETTING_H
#define RSV_OCCLUSION_SETTING_H

#include "../core/stratified.h"
#include "../scene/material_at.h"
#include "../sources/sky.h"
#include "../surface/surface.h"
#include "../trace/camera_ray.h"
#include "../trace/offset.h"

/// Data common to pictures of one scene and size. On a device, all pointers are to device memory.
typedef struct rsv_occlusion_setting {
    const rsv_scene_view *view;
    rsv_sky sky; ///< without pixels: of radiance 1 for surfaces, black for the camera
    rsv_sky_irradiance open;
    uint32_t width, height, seed;
    uint32_t camera_rays; ///< of a pixel
    uint32_t samples;     ///< directions of an estimate
    float distance;       ///< metres; farther geometry does not occlude
} rsv_occlusion_setting;

/// A surface as the camera sees it; everything counts as diffuse.
typedef struct rsv_seen_surface {
    bool hit;
    rsv_surface_point point; ///< normals on the viewer's side
    rsv_rgb ambient;         ///< radiance under the unoccluded sky
    rsv_rgb emission;        ///< of the surface, or of the sky where there is none
} rsv_seen_surface;

/// Radiance of an unoccluded white surface.
RSV_INLINE rsv_rgb rsv_ambient_radiance(const rsv_occlusion_setting *s, rsv_vec3 normal)
{
    if (!s->sky.pixel) return rgb_gray(1);
    return rgb_scale(rsv_sky_irradiance_at(&s->open, normal), 1 / RSV_PI);
}

RSV_INLINE rsv_seen_surface rsv_seen_sky(const rsv_occlusion_setting *s, rsv_vec3 direction)
{
    rsv_seen_surface seen;
    seen.hit = false;
    seen.point.position = seen.point.normal = seen.point.geometric = v3(0, 0, 0);
    seen.point.horizon = seen.point.lift = v3(0, 0, 0);
    seen.point.extent = 0;
    seen.ambient = rgb_gray(0);
    seen.emission = rsv_sky_radiance(&s->sky, direction);
    return seen;
}

/// @param varied false = no surface varies
RSV_INLINE rsv_seen_surface rsv_seen_surface_at(const rsv_occlusion_setting *s, rsv_vec3 direction,
    uint32_t triangle, float u, float v, bool varied)
{
    uint32_t index = s->view->triangle_material[triangle];
    const rsv_material *material = &s->view->material[index];
    rsv_material here;
    if (varied && s->view->material_varies[index]) {
        here = rsv_material_at(s->view, triangle, u, v, 0);
        material = &here;
    }
    rsv_seen_surface seen;
    seen.hit = true;
    seen.ambient = seen.emission = rgb_gray(0);
    seen.point = rsv_surface_point_at(s->view, triangle, u, v, false);
    bool back = v3_dot(seen.point.geometric, direction) > 0;
    if (back) {
        seen.point.geometric = v3_neg(seen.point.geometric);
        seen.point.normal = v3_neg(seen.point.normal);
        seen.point.horizon = seen.point.geometric;
    }
    if (back && !material->double_sided && material->transmission == 0) return seen;
    if (material->unlit) {
        seen.emission = material->base_color;
        return seen;
    }
    seen.ambient = rgb_mul(material->base_color, rsv_ambient_radiance(s, seen.point.normal));
    if (!back || material->double_sided) seen.emission = material->emission;
    return seen;
}

/// Place of camera ray `index` in a pixel's picture, for rsv_lens_ray.
RSV_INLINE void rsv_occlusion_place(const rsv_occlusion_setting *s, uint32_t row, uint32_t column,
    uint32_t index, float *x, float *y)
{
    rsv_stratified_2d(index, s->camera_rays, rsv_hash3(s->seed, row, column), x, y);
    *x += (float)column;
    *y += (float)row;
}

/// Random number of a pixel's directions.
RSV_INLINE uint32_t rsv_occlusion_seed(
    const rsv_occlusion_setting *s, uint32_t row, uint32_t column)
{
    return rsv_hash2(rsv_hash3(s->seed, row, column), 0x5bd1e995u);
}

/// Where the rays of a surface start, and the frame of their directions.
typedef struct rsv_occlusion_spot {
    rsv_vec3 origin, tangent, bitangent, normal, geometric;
} rsv_occlusion_spot;

RSV_INLINE rsv_occlusion_spot rsv_occlusion_spot_of(const rsv_surface_point *point)
{
    rsv_occlusion_spot spot;
    spot.origin = rsv_moved_off(point->position, point->geometric, point->extent);
    spot.normal = point->normal;
    spot.geometric = point->geometric;
    v3_frame(point->normal, &spot.tangent, &spot.bitangent);
    return spot;
}

/// Ray `index` of all those of a pixel, cosine-distributed about the normal.
/// @return false = it lies below the surface, from where no light counts
RSV_INLINE bool rsv_occlusion_ray(const rsv_occlusion_setting *s, const rsv_occlusion_spot *spot,
    uint32_t index, uint32_t seed, rsv_ray *ray)
{
    uint32_t total = s->camera_rays * s->samples;
    float x, y;
    rsv_stratified_2d(index % total, total, seed, &x, &y);
    rsv_vec3 d = rsv_square_to_cosine_hemisphere(x, y);
    rsv_vec3 lateral = v3_mad(v3_scale(spot->tangent, d.x), d.y, spot->bitangent);
    ray->origin = spot->origin;
    ray->direction = v3_mad(lateral, d.z, spot->normal);
    ray->t_max = s->distance;
    return v3_dot(ray->direction, spot->geometric) > 0;
}

#endif
