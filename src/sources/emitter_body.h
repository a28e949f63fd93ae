/// Places on emitters (light.h).
#ifndef RSV_EMITTER_BODY_H
#define RSV_EMITTER_BODY_H

#include "../scene/material_at.h"
#include "../scene/twins.h"
#include "lights.h"

/// Where a surface does not cover, it does not shine, nor where another lies in the same place and is seen.
RSV_INLINE rsv_rgb rsv_emission_at(
    const rsv_scene_view *scene, uint32_t triangle, bool back, float u, float v, float width)
{
    if (rsv_twins_hide_place(scene, triangle, back, u, v)) return rgb_gray(0);
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
    const rsv_lights *lights, uint32_t emitter, bool back, float u, float v)
{
    const rsv_emitter *e = &lights->emitter[emitter];
    if (!e->varies) return e->radiance;
    rsv_emitter_to_triangle(e, &u, &v);
    return rsv_emission_at(lights->scene, e->triangle, back, u, v, 0);
}

RSV_SHARED uint32_t rsv_emitter_at(const rsv_lights *lights, uint32_t triangle, float u, float v)
{
    uint32_t first = lights->triangle_emitter[triangle];
    if (first == RSV_NONE || lights->emitter[first].cells == 1) return first;
    uint32_t place = rsv_emitter_place(u, v), count = lights->emitter[first].cells;
    while (count > 1) { // the last one that does not begin behind the place
        uint32_t half = count / 2;
        bool behind = lights->emitter[first + half].place > place;
        first += behind ? 0 : half;
        count = behind ? half : count - half;
    }
    return first;
}

#endif
