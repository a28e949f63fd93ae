#include "camera_ray.h"

rsv_lens rsv_lens_of(const rsv_camera *camera, uint32_t width, uint32_t height)
{
    bool orthographic = camera->vertical_fov == 0;
    float half = orthographic ? camera->vertical_extent : tanf(camera->vertical_fov / 2);
    return (
        rsv_lens){ *camera, 0.5f * (float)width, 0.5f * (float)height, 2 * half / (float)height };
}

bool rsv_lens_see(const rsv_lens *lens, rsv_vec3 point, rsv_lens_view *view)
{
    const rsv_camera *camera = &lens->camera;
    rsv_vec3 offset = v3_sub(point, camera->position);
    float depth = v3_dot(offset, camera->forward);
    if (!(depth > 0)) return false;
    bool orthographic = camera->vertical_fov == 0;
    float unit = orthographic ? lens->pixel_size : lens->pixel_size * depth;
    view->x = lens->half_width + v3_dot(offset, camera->right) / unit;
    view->y = lens->half_height - v3_dot(offset, camera->up) / unit;
    view->distance = orthographic ? depth : v3_length(offset);
    view->direction = orthographic ? camera->forward : v3_scale(offset, 1 / view->distance);
    // across a perspective picture, solid angle shrinks with the cube of the cosine off its axis
    view->pixels_per_area = view->distance / (unit * unit * depth);
    return true;
}

rsv_ray rsv_camera_ray(const rsv_camera *camera, uint32_t width, uint32_t height, float x, float y)
{
    rsv_lens lens = rsv_lens_of(camera, width, height);
    return rsv_lens_ray(&lens, x, y);
}

float rsv_camera_spread(const rsv_camera *camera, uint32_t height)
{
    return 2 * tanf(0.5f * camera->vertical_fov) / (float)height;
}
