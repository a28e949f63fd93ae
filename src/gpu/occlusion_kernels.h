/// Ambient occlusion: camera rays to the surfaces that they meet, and from these rays or looks at the depth buffer. The
/// arithmetic is that of src/occlusion.
#ifndef RSV_OCCLUSION_KERNELS_H
#define RSV_OCCLUSION_KERNELS_H

#include "../bvh/bvh_trace.h"
#include "../occlusion/device_occlusion.h"
#include "launch.h"

/// All of it lies on the device, the picture's buffers too.
typedef struct rsv_occlusion_args {
    const rsv_occlusion_setting *setting;
    const rsv_occlusion_screen
        *screen; ///< for occlusion by rays, only its surfaces are used
    rsv_bvh_view bvh;
    bool varied;            ///< some surfaces do
    rsv_seen_surface *seen; ///< [pixels]
    rsv_rgb *pixel;         ///< [pixels] the picture
    rsv_lens lens;
    uint32_t camera_ray;  ///< which one of each pixel
    uint32_t first_pixel; ///< of those whose rays are traced together
    uint8_t *open;        ///< [pixels of these][samples] whether a ray meets nothing
} rsv_occlusion_args;

/// The hit of a pixel's camera ray.
RSV_INLINE rsv_seen_surface rsv_occlusion_see(
    const rsv_occlusion_args *a, float column_place, float row_place, bool varied)
{
    rsv_bvh_view bvh = rsv_bvh_with_holes(a->bvh, varied);
    const rsv_occlusion_setting *s = a->setting;
    rsv_ray ray = rsv_lens_ray(&a->lens, column_place, row_place);
    rsv_hit hit;
    if (!rsv_bvh_closest(&bvh, &ray, &hit)) return rsv_seen_sky(s, ray.direction);
    return rsv_seen_surface_at(s, ray.direction, hit.triangle, hit.u, hit.v, varied);
}

// ---- by rays ------------------------------------------------------------------------------------

RSV_INLINE void rsv_occlusion_camera_item(const rsv_occlusion_args *a, uint32_t pixel, bool varied)
{
    const rsv_occlusion_setting *s = a->setting;
    float x, y;
    rsv_occlusion_place(s, pixel / s->width, pixel % s->width, a->camera_ray, &x, &y);
    a->seen[pixel] = rsv_occlusion_see(a, x, y, varied);
}

RSV_KERNEL_VARIED(occlusion_camera, rsv_occlusion_args, rsv_occlusion_camera_item)

RSV_INLINE void rsv_occlusion_ray_item(const rsv_occlusion_args *a, uint32_t item, bool varied)
{
    rsv_bvh_view bvh = rsv_bvh_with_holes(a->bvh, varied);
    const rsv_occlusion_setting *s = a->setting;
    uint32_t pixel = a->first_pixel + item / s->samples;
    uint32_t index = a->camera_ray * s->samples + item % s->samples;
    const rsv_seen_surface *seen = &a->seen[pixel];
    rsv_ray ray;
    a->open[item] = 0;
    if (rgb_is_black(seen->ambient)) return;
    rsv_occlusion_spot spot = rsv_occlusion_spot_of(&seen->point);
    uint32_t seed = rsv_occlusion_seed(s, pixel / s->width, pixel % s->width);
    if (!rsv_occlusion_ray(s, &spot, index, seed, &ray)) return;
    a->open[item] = !rsv_bvh_occluded(&bvh, &ray);
}

RSV_KERNEL_VARIED(occlusion_ray, rsv_occlusion_args, rsv_occlusion_ray_item)

/// Adds the light of a camera ray to its pixel.
RSV_INLINE void rsv_occlusion_add_item(const rsv_occlusion_args *a, uint32_t item)
{
    const rsv_occlusion_setting *s = a->setting;
    uint32_t pixel = a->first_pixel + item, open = 0;
    const uint8_t *ray = a->open + (size_t)item * s->samples;
    for (uint32_t k = 0; k < s->samples; k++)
        open += ray[k];
    float openness = (float)open / (float)s->samples;
    rsv_rgb light = rgb_mad(a->seen[pixel].emission, openness, a->seen[pixel].ambient);
    rsv_rgb before = a->camera_ray ? a->pixel[pixel] : rgb_gray(0);
    a->pixel[pixel] = rgb_mad(before, 1 / (float)s->camera_rays, light);
}

RSV_KERNEL(occlusion_add, rsv_occlusion_args, rsv_occlusion_add_item)

// ---- in screen space ----------------------------------------------------------------------------

RSV_INLINE rsv_screen_picture rsv_occlusion_screen_of(const rsv_occlusion_args *a)
{
    rsv_screen_picture s;
    s.setting = a->setting;
    s.buffer = a->screen;
    s.lens = a->lens;
    return s;
}

RSV_INLINE void rsv_screen_camera_item(const rsv_occlusion_args *a, uint32_t pixel, bool varied)
{
    uint32_t width = a->setting->width;
    rsv_screen_picture s = rsv_occlusion_screen_of(a);
    rsv_seen_surface seen =
        rsv_occlusion_see(a, (float)(pixel % width) + 0.5f, (float)(pixel / width) + 0.5f, varied);
    rsv_screen_note(&s, pixel, &seen);
}

RSV_KERNEL_VARIED(screen_camera, rsv_occlusion_args, rsv_screen_camera_item)

RSV_INLINE void rsv_screen_open_item(const rsv_occlusion_args *a, uint32_t pixel)
{
    rsv_screen_picture s = rsv_occlusion_screen_of(a);
    rsv_screen_open(&s, pixel % a->setting->width, pixel / a->setting->width);
}

RSV_KERNEL(screen_open, rsv_occlusion_args, rsv_screen_open_item)

RSV_INLINE void rsv_screen_shade_item(const rsv_occlusion_args *a, uint32_t pixel)
{
    rsv_screen_picture s = rsv_occlusion_screen_of(a);
    a->pixel[pixel] = rsv_screen_shade(&s, pixel % a->setting->width, pixel / a->setting->width);
}

RSV_KERNEL(screen_shade, rsv_occlusion_args, rsv_screen_shade_item)

#endif
