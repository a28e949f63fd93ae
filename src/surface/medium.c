#include "medium.h"

#include "surface.h"

#include <string.h>

#define LOOK_UP_RAYS 8

/// Makes room at the innermost place.
static void drop_outermost(rsv_medium *medium)
{
    if (medium->depth < RSV_MEDIUM_DEPTH) return;
    memmove(medium->body, medium->body + 1, (RSV_MEDIUM_DEPTH - 1) * sizeof *medium->body);
    medium->depth--;
}

/// Place of the innermost body of this material, -1 = none.
static int find(const rsv_medium *medium, uint32_t material)
{
    int k = (int)medium->depth;
    while (--k >= 0 && medium->body[k] != material)
        ;
    return k;
}

static void leave(rsv_medium *medium, uint32_t material)
{
    int k = find(medium, material);
    if (k < 0) return;
    medium->depth--;
    for (; k < (int)medium->depth; k++)
        medium->body[k] = medium->body[k + 1];
}

static void enter(rsv_medium *medium, uint32_t material)
{
    drop_outermost(medium);
    medium->body[medium->depth++] = material;
}

void rsv_medium_arrive_inside(rsv_medium *medium, uint32_t material)
{
    if (find(medium, material) < 0) enter(medium, material);
}

void rsv_medium_cross(rsv_medium *medium, uint32_t material, bool back)
{
    if (back)
        leave(medium, material);
    else
        enter(medium, material);
}

static const rsv_bsdf *innermost(const rsv_medium *medium, const rsv_bsdf *bsdf)
{
    return medium->depth ? &bsdf[medium->body[medium->depth - 1]] : NULL;
}

float rsv_medium_ior(const rsv_medium *medium, const rsv_bsdf *bsdf)
{
    const rsv_bsdf *body = innermost(medium, bsdf);
    return body ? body->ior : 1;
}

bool rsv_medium_absorbs(const rsv_medium *medium, const rsv_bsdf *bsdf)
{
    const rsv_bsdf *body = innermost(medium, bsdf);
    return body && !rgb_is_black(body->absorption);
}

rsv_rgb rsv_medium_transmittance(const rsv_medium *medium, const rsv_bsdf *bsdf, float distance)
{
    if (!rsv_medium_absorbs(medium, bsdf) || !(distance < INFINITY)) return rgb_gray(1);
    rsv_rgb a = innermost(medium, bsdf)->absorption;
    return rgb(expf(-a.r * distance), expf(-a.g * distance), expf(-a.b * distance));
}

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
        if (v3_dot(met.geometric, ray.direction) > 0) enter(&medium, material);
        break;
    }
    return medium;
}
