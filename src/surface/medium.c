#include "medium.h"

#include "surface.h"

#define LOOK_UP_RAYS 8

rsv_media rsv_media_of(const rsv_scene_view *view, const rsv_tracer *tracer, const rsv_bsdf *bsdf)
{
    rsv_media media = { view, tracer, bsdf, false };
    for (size_t m = 0; m < view->material_count; m++)
        media.bodies = media.bodies || bsdf[m].solid;
    return media;
}

rsv_medium rsv_medium_above(const rsv_media *media, rsv_vec3 origin, rsv_vec3 normal)
{
    rsv_medium medium = { .depth = 0 };
    rsv_vec3 t, b;
    v3_frame(normal, &t, &b);
    for (int k = 0; media->bodies && k < LOOK_UP_RAYS; k++) {
        // the first goes straight up
        float turn = 2 * RSV_PI * 0.618034f * (float)k, z = 1 - (float)k / LOOK_UP_RAYS;
        rsv_vec3 side = v3_mad(v3_scale(t, cosf(turn)), sinf(turn), b);
        rsv_ray ray = { origin, v3_mad(v3_scale(normal, z), sqrtf(1 - z * z), side), INFINITY };
        rsv_hit hit;
        if (!rsv_tracer_closest(media->tracer, &ray, &hit)) continue;
        uint32_t material = media->view->triangle_material[hit.triangle];
        if (!media->bsdf[material].solid) continue;
        rsv_surface_point met =
            rsv_surface_point_at(media->view, hit.triangle, hit.u, hit.v, false);
        if (v3_dot(met.geometric, ray.direction) > 0) rsv_medium_enter(&medium, material);
        break;
    }
    return medium;
}
