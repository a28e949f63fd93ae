/// Tangents of surfaces, for normal maps and brushed metal. Plain C, also for device code.
#ifndef RSV_TANGENT_H
#define RSV_TANGENT_H

#include "texture_triangle.h"

/// Interpolated tangent and hand of the triangle's vertices; false if one has none.
RSV_INLINE bool rsv_vertex_tangent(const rsv_scene_view *scene, const uint32_t *corner, float u,
    float v, rsv_vec3 *tangent, float *hand)
{
    if (!scene->tangent) return false;
    rsv_vec3 t[3];
    for (int k = 0; k < 3; k++) {
        const float *from = scene->tangent[corner[k]];
        t[k] = v3(from[0], from[1], from[2]);
        if (v3_max_abs(t[k]) == 0) return false;
    }
    *tangent = v3_barycentric(t[0], t[1], t[2], u, v);
    *hand = scene->tangent[corner[0]][3];
    return v3_max_abs(*tangent) > 0;
}

/// The direction of increasing u on the triangle. Texture coordinates run down, normal maps' y up: the
/// ordinary case has a negative area there and the hand +1.
RSV_INLINE bool rsv_derived_tangent(const rsv_scene_view *scene, const rsv_texture_ref *ref,
    const uint32_t *corner, rsv_vec3 *tangent, float *hand)
{
    if (!scene->uv[ref->uv_set]) return false;
    rsv_texture_triangle t = rsv_texture_triangle_of(scene, ref, corner);
    float area = rsv_texture_area(&t);
    rsv_vec3 edge1, edge2;
    rsv_triangle_edges(scene, corner, &edge1, &edge2);
    *tangent = v3_sub(v3_scale(edge1, t.dv[1] / area), v3_scale(edge2, t.dv[0] / area));
    *hand = area < 0 ? 1.0f : -1.0f;
    float size = v3_max_abs(*tangent);
    return size > 0 && isfinite(size);
}

/// A tangent of the triangle at right angles to a normal, and the bitangent; false if there is none.
/// @param at u and v on the triangle @param frame in: [0] the normal, unit; out: tangent and bitangent
RSV_INLINE bool rsv_tangent_frame(const rsv_scene_view *scene, const rsv_texture_ref *ref,
    const uint32_t *corner, const float at[2], rsv_vec3 frame[2])
{
    rsv_vec3 tangent, normal = frame[0];
    float hand;
    if (!rsv_vertex_tangent(scene, corner, at[0], at[1], &tangent, &hand) &&
        !rsv_derived_tangent(scene, ref, corner, &tangent, &hand))
        return false;
    tangent = v3_scale(tangent, 1 / v3_max_abs(tangent));
    frame[0] = v3_normalize(v3_mad(tangent, -v3_dot(tangent, normal), normal));
    frame[1] = v3_scale(v3_cross(normal, frame[0]), hand);
    return true;
}

#endif
