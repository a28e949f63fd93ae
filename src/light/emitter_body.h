/// Places on emitters (light.h).
#ifndef RSV_EMITTER_BODY_H
#define RSV_EMITTER_BODY_H

#include "../scene/material_at.h"
#include "light.h"

/// Where a surface does not cover, it does not shine.
RSV_INLINE rsv_rgb rsv_emission_at(
    const rsv_scene_view *scene, uint32_t triangle, float u, float v, float width)
{
    rsv_material m = rsv_material_at(scene, triangle, u, v, width);
    return rgb_scale(m.emission, m.opacity);
}

/// From coordinates on the emitter to those of its triangle.
RSV_INLINE void rsv_emitter_to_triangle(const rsv_emitter *e, float *u, float *v)
{
    float x = *u, y = *v;
    *u = e->u[0] + x * (e->u[1] - e->u[0]) + y * (e->u[2] - e->u[0]);
    *v = e->v[0] + x * (e->v[1] - e->v[0]) + y * (e->v[2] - e->v[0]);
}

RSV_SHARED rsv_rgb rsv_emitter_radiance(
    const rsv_lights *lights, uint32_t emitter, float u, float v)
{
    const rsv_emitter *e = &lights->emitter[emitter];
    if (!e->varies) return e->radiance;
    rsv_emitter_to_triangle(e, &u, &v);
    return rsv_emission_at(lights->scene, e->triangle, u, v, 0);
}

RSV_SHARED uint32_t rsv_emitter_at(const rsv_lights *lights, uint32_t triangle, float u, float v)
{
    uint32_t first = lights->triangle_emitter[triangle], cell = 0;
    if (first == RSV_NONE) return RSV_NONE;
    float b[3] = { 1 - u - v, u, v };
    for (int level = lights->emitter[first].level; level > 0; level--) {
        uint32_t part = b[0] >= 0.5f ? 0 : b[1] >= 0.5f ? 1 : b[2] >= 0.5f ? 2 : 3;
        for (uint32_t k = 0; k < 3; k++)
            b[k] = part == 3 ? 1 - 2 * b[k] : 2 * b[k] - (k == part ? 1 : 0);
        cell = 4 * cell + part;
    }
    return first + cell;
}

#endif
