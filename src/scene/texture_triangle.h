/// Triangles in texture coordinates.
#ifndef RSV_TEXTURE_TRIANGLE_H
#define RSV_TEXTURE_TRIANGLE_H

#include "../core/vec.h"
#include "resolvent/scene.h"

/// Coordinates far away, or none at all, are as good as 0: nothing repeats visibly out there.
RSV_INLINE float rsv_tame(float coordinate) { return fabsf(coordinate) < 1e7f ? coordinate : 0; }

RSV_INLINE void rsv_corner_uv(
    const rsv_scene_view *scene, const rsv_texture_ref *ref, uint32_t vertex, float *u, float *v)
{
    const float *uv = scene->uv[ref->uv_set][vertex];
    *u = ref->transform[0][0] * uv[0] + ref->transform[0][1] * uv[1] + ref->transform[0][2];
    *v = ref->transform[1][0] * uv[0] + ref->transform[1][1] * uv[1] + ref->transform[1][2];
}

/// A triangle in the coordinates of a texture: its first corner, and the edges from there.
typedef struct rsv_texture_triangle {
    float u, v, du[2], dv[2];
} rsv_texture_triangle;

RSV_INLINE rsv_texture_triangle rsv_texture_triangle_of(
    const rsv_scene_view *scene, const rsv_texture_ref *ref, const uint32_t *corner)
{
    rsv_texture_triangle t;
    rsv_corner_uv(scene, ref, corner[0], &t.u, &t.v);
    for (int k = 0; k < 2; k++) {
        rsv_corner_uv(scene, ref, corner[k + 1], &t.du[k], &t.dv[k]);
        t.du[k] -= t.u;
        t.dv[k] -= t.v;
    }
    return t;
}

/// Twice the signed area in texture coordinates.
RSV_INLINE float rsv_texture_area(const rsv_texture_triangle *t)
{
    return t->du[0] * t->dv[1] - t->du[1] * t->dv[0];
}

RSV_INLINE void rsv_triangle_edges(
    const rsv_scene_view *scene, const uint32_t *corner, rsv_vec3 *edge1, rsv_vec3 *edge2)
{
    rsv_vec3 a = scene->position[corner[0]];
    *edge1 = v3_sub(scene->position[corner[1]], a);
    *edge2 = v3_sub(scene->position[corner[2]], a);
}

#endif
