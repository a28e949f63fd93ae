#include "occlusion_view.h"

#include "../scene/material_at.h"
#include "../trace/packet.h"

#include <string.h>

#define LANES RSV_PACKET_WIDTH

/// What a white surface without obstacles reflects.
static rsv_rgb ambient_radiance(const rsv_occlusion *o, rsv_vec3 normal)
{
    if (!o->sky.pixel) return rgb_gray(1);
    return rgb_scale(rsv_sky_irradiance_at(&o->sky_irradiance, normal), 1 / RSV_PI);
}

static rsv_seen_surface surface_at(
    const rsv_occlusion *o, rsv_vec3 direction, uint32_t triangle, float u, float v)
{
    rsv_seen_surface seen = { .hit = true };
    const rsv_scene_view *view = o->view;
    uint32_t index = view->triangle_material[triangle];
    rsv_material varied;
    const rsv_material *material = &view->material[index];
    if (view->material_varies[index]) {
        varied = rsv_material_at(view, triangle, u, v, 0);
        material = &varied;
    }
    seen.point = rsv_surface_point_at(view, triangle, u, v, false);
    bool back = v3_dot(seen.point.geometric, direction) > 0;
    if (back) {
        seen.point.geometric = v3_neg(seen.point.geometric);
        seen.point.normal = v3_neg(seen.point.normal);
    }
    if (back && !material->double_sided && material->transmission == 0) return seen;
    if (material->unlit) {
        seen.emission = material->base_color;
        return seen;
    }
    seen.ambient = rgb_mul(material->base_color, ambient_radiance(o, seen.point.normal));
    if (!back || material->double_sided) seen.emission = material->emission;
    return seen;
}

void rsv_see_surfaces(const rsv_occlusion_job *job, uint32_t count, const float *x, const float *y,
    rsv_seen_surface *seen)
{
    const rsv_occlusion *o = job->shared;
    rsv_ray_packet packet = { 0 };
    memset(packet.mask, 0xff, sizeof packet.mask);
    for (uint32_t k = 0; k < LANES; k++) {
        uint32_t place = k < count ? k : 0;
        rsv_ray ray = rsv_lens_ray(&job->lens, x[place], y[place]);
        ray.t_max = k < count ? INFINITY : -1;
        rsv_packet_set_ray(&packet, k, ray);
    }
    rsv_tracer_closest_packet(o->tracer, &packet, true);
    for (uint32_t k = 0; k < count; k++) {
        rsv_vec3 direction =
            v3(packet.direction_x[k], packet.direction_y[k], packet.direction_z[k]);
        if (packet.triangle[k] != RSV_NONE)
            seen[k] = surface_at(o, direction, packet.triangle[k], packet.u[k], packet.v[k]);
        else
            seen[k] = (rsv_seen_surface){ .emission = rsv_sky_radiance(&o->sky, direction) };
    }
}
