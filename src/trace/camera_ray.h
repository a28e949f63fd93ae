/// From a place in a picture to the ray that sees it.
#ifndef RSV_CAMERA_RAY_H
#define RSV_CAMERA_RAY_H

#include "../core/vec.h"
#include "resolvent/trace.h"

/// Ray through a point of a `width` x `height` picture. The vertical field of view is that of the camera; the
/// horizontal one follows from the shape of the picture.
/// @param x, y in pixels from the top left corner: column or row + offset within the pixel
/// @return unit direction, t_max infinite
rsv_ray rsv_camera_ray(const rsv_camera *camera, uint32_t width, uint32_t height, float x, float y);

/// Values shared by all rays of a picture, for callers that create many.
typedef struct rsv_lens {
    rsv_camera camera;
    float half_width, half_height; ///< pixels
    float pixel_size;              ///< at distance 1, or metres where orthographic
} rsv_lens;

rsv_lens rsv_lens_of(const rsv_camera *camera, uint32_t width, uint32_t height);

/// For device code too.
RSV_INLINE rsv_ray rsv_lens_ray(const rsv_lens *lens, float x, float y)
{
    const rsv_camera *camera = &lens->camera;
    float across = (x - lens->half_width) * lens->pixel_size;
    float upwards = (lens->half_height - y) * lens->pixel_size;
    rsv_vec3 offset = v3_mad(v3_scale(camera->right, across), upwards, camera->up);
    rsv_ray ray = { camera->position, camera->forward, INFINITY };
    if (camera->vertical_fov == 0)
        ray.origin = v3_add(camera->position, offset);
    else
        ray.direction = v3_normalize(v3_add(camera->forward, offset));
    return ray;
}

/// A point as the camera sees it, if nothing hides it.
typedef struct rsv_lens_view {
    float x, y;            ///< place in the picture, pixels
    rsv_vec3 direction;    ///< unit, from the camera to the point
    float distance;        ///< metres
    float pixels_per_area; ///< pixels that a square metre there covers which faces the camera
} rsv_lens_view;

/// The inverse of rsv_lens_ray. False for points behind the camera.
bool rsv_lens_see(const rsv_lens *lens, rsv_vec3 point, rsv_lens_view *view);

/// Angle between the rays through neighbouring pixels, radians. (Orthographic rays do not spread: textures are looked
/// up as they are.)
float rsv_camera_spread(const rsv_camera *camera, uint32_t height);

#endif
