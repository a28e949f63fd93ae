#include "camera_ray.h"

#include "../core/vec.h"

rsv_ray rsv_camera_ray(const rsv_camera *camera, uint32_t width, uint32_t height, float x, float y)
{
    bool orthographic = camera->vertical_fov == 0;
    float half_height = orthographic ? camera->vertical_extent : tanf(camera->vertical_fov / 2);
    float pixel_size = 2 * half_height / (float)height;
    float across = (x - 0.5f * (float)width) * pixel_size;
    float upwards = (0.5f * (float)height - y) * pixel_size;
    rsv_vec3 offset = v3_mad(v3_scale(camera->right, across), upwards, camera->up);
    if (orthographic)
        return (rsv_ray){ v3_add(camera->position, offset), camera->forward, INFINITY };
    return (rsv_ray){ camera->position, v3_normalize(v3_add(camera->forward, offset)), INFINITY };
}

float rsv_camera_spread(const rsv_camera *camera, uint32_t height)
{
    return 2 * tanf(0.5f * camera->vertical_fov) / (float)height;
}
