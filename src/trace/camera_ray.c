#include "camera_ray.h"

#include "../core/vec.h"

rsv_lens rsv_lens_of(const rsv_camera *camera, uint32_t width, uint32_t height)
{
    bool orthographic = camera->vertical_fov == 0;
    float half = orthographic ? camera->vertical_extent : tanf(camera->vertical_fov / 2);
    return (
        rsv_lens){ *camera, 0.5f * (float)width, 0.5f * (float)height, 2 * half / (float)height };
}

rsv_ray rsv_lens_ray(const rsv_lens *lens, float x, float y)
{
    const rsv_camera *camera = &lens->camera;
    float across = (x - lens->half_width) * lens->pixel_size;
    float upwards = (lens->half_height - y) * lens->pixel_size;
    rsv_vec3 offset = v3_mad(v3_scale(camera->right, across), upwards, camera->up);
    if (camera->vertical_fov == 0)
        return (rsv_ray){ v3_add(camera->position, offset), camera->forward, INFINITY };
    return (rsv_ray){ camera->position, v3_normalize(v3_add(camera->forward, offset)), INFINITY };
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
