#include "elements.h"

float rsv_triangle_area(const rsv_scene_view *scene, uint32_t triangle)
{
    const uint32_t *corner = scene->triangle[triangle];
    rsv_vec3 a = scene->position[corner[0]];
    rsv_vec3 e1 = v3_sub(scene->position[corner[1]], a), e2 = v3_sub(scene->position[corner[2]], a);
    return 0.5f * v3_length(v3_cross(e1, e2));
}

rsv_surface_point rsv_surface_point_at(
    const rsv_scene_view *scene, uint32_t triangle, float u, float v, bool back)
{
    const uint32_t *corner = scene->triangle[triangle];
    rsv_vec3 a = scene->position[corner[0]], b = scene->position[corner[1]];
    rsv_vec3 c = scene->position[corner[2]];
    rsv_surface_point point;
    point.position = v3_barycentric(a, b, c, u, v);
    point.geometric = v3_normalize(v3_cross(v3_sub(b, a), v3_sub(c, a)));
    point.normal = v3_normalize(v3_barycentric(
        scene->normal[corner[0]], scene->normal[corner[1]], scene->normal[corner[2]], u, v));
    if (v3_dot(point.normal, point.geometric) <= 0) point.normal = point.geometric;
    if (back) {
        point.geometric = v3_neg(point.geometric);
        point.normal = v3_neg(point.normal);
    }
    point.extent = f_max(v3_max_abs(a), f_max(v3_max_abs(b), v3_max_abs(c)));
    return point;
}
