#include "../core/vec.h"
#include "scene.h"

#include <string.h>

rsv_camera rsv_camera_look_at(
    const char *name, rsv_vec3 position, rsv_vec3 target, float vertical_fov, float aspect)
{
    rsv_vec3 forward = v3_normalize(v3_sub(target, position));
    if (v3_length(forward) == 0) forward = v3(0, 0, -1);
    rsv_vec3 right = v3_cross(forward, v3(0, 1, 0));
    // straight up or down: turn so that +x stays right
    right = v3_length(right) < 1e-6f ? v3(1, 0, 0) : v3_normalize(right);
    return (rsv_camera){
        .name = name,
        .position = position,
        .right = right,
        .up = v3_normalize(v3_cross(right, forward)),
        .forward = forward,
        .vertical_fov = vertical_fov,
        .aspect = aspect,
    };
}

rsv_camera rsv_camera_frame_sphere(const char *name, rsv_vec3 centre, float radius)
{
    const float vertical_fov = RSV_PI / 4, margin = 1.05f;
    rsv_vec3 towards_viewer = v3_normalize(v3(0, 0.35f, 1));
    float distance = margin * f_max(radius, 1e-6f) / sinf(vertical_fov / 2);
    return rsv_camera_look_at(
        name, v3_mad(centre, distance, towards_viewer), centre, vertical_fov, 0);
}

uint32_t rsv_scene_find_camera(const rsv_scene *scene, const char *name)
{
    if (!name) return scene->camera_count ? 0 : RSV_NONE;
    for (size_t i = 0; i < scene->camera_count; i++)
        if (strcmp(scene->camera[i].name, name) == 0) return (uint32_t)i;
    for (size_t i = 0; i < scene->camera_count; i++) {
        const char *node = scene->camera_fixture[i].node;
        if (node && strcmp(node, name) == 0) return (uint32_t)i;
    }
    return RSV_NONE;
}
