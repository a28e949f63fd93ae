/// Reading at one place of a picture.
#include "../solve/light.h"
#include "../trace/camera_ray.h"
#include "resolvent/render.h"

bool rsv_read_picture_point(const rsv_light *light, const rsv_camera *camera, uint32_t width,
    uint32_t height, const float place[2], rsv_rgb *irradiance)
{
    const rsv_light_view *view = rsv_light_get_view(light);
    rsv_ray ray =
        rsv_camera_ray(camera, width, height, place[0] * (float)width, place[1] * (float)height);
    rsv_hit hit;
    *irradiance = rgb_gray(0);
    if (!rsv_tracer_closest(view->tracer, &ray, &hit)) return false;
    rsv_specular_path path = rsv_specular_begin(&view->scene, NULL, ray.direction, hit);
    if (view->elements->face_of[path.back][hit.triangle] == RSV_NONE) return false;
    *irradiance = rsv_light_view_irradiance(view, hit.triangle, hit.u, hit.v, path.back, RSV_NONE);
    return true;
}
