/// Surfaces near a point.
#include "near.h"

#include "../core/vec.h"

/// Closest point of a triangle to p (Ericson, Real-Time Collision Detection, section 5.1.5).
static void closest_on_triangle(rsv_vec3 a, rsv_vec3 b, rsv_vec3 c, rsv_vec3 p, float *u, float *v)
{
    rsv_vec3 ab = v3_sub(b, a), ac = v3_sub(c, a), ap = v3_sub(p, a);
    float d1 = v3_dot(ab, ap), d2 = v3_dot(ac, ap);
    *u = *v = 0;
    if (d1 <= 0 && d2 <= 0) return;
    rsv_vec3 bp = v3_sub(p, b), cp = v3_sub(p, c);
    float d3 = v3_dot(ab, bp), d4 = v3_dot(ac, bp), d5 = v3_dot(ab, cp), d6 = v3_dot(ac, cp);
    float vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
    if (d3 >= 0 && d4 <= d3) {
        *u = 1;
    } else if (d6 >= 0 && d5 <= d6) {
        *v = 1;
    } else if (vc <= 0 && d1 >= 0 && d3 <= 0) {
        *u = d1 / (d1 - d3);
    } else if (vb <= 0 && d2 >= 0 && d6 <= 0) {
        *v = d2 / (d2 - d6);
    } else if (va <= 0 && d4 >= d3 && d5 >= d6) {
        *v = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        *u = 1 - *v;
    } else {
        *u = vb / (va + vb + vc);
        *v = vc / (va + vb + vc);
    }
}

float rsv_triangle_distance(
    const rsv_scene_view *scene, uint32_t triangle, rsv_vec3 point, float *u, float *v)
{
    rsv_vec3 a = scene->position[scene->triangle[triangle][0]];
    rsv_vec3 b = scene->position[scene->triangle[triangle][1]];
    rsv_vec3 c = scene->position[scene->triangle[triangle][2]];
    closest_on_triangle(a, b, c, point, u, v);
    return v3_length(v3_sub(v3_barycentric(a, b, c, *u, *v), point));
}

/// Rare (a handful of probes), so every triangle is looked at.
bool rsv_tracer_nearest(const rsv_tracer *tracer, rsv_vec3 point, rsv_vec3 normal, rsv_hit *hit)
{
    const rsv_scene_view *scene = rsv_scene_get_view(rsv_tracer_scene(tracer));
    rsv_hit best[2] = { { RSV_NONE, INFINITY, 0, 0 }, { RSV_NONE, INFINITY, 0, 0 } };
    for (size_t t = 0; t < scene->triangle_count; t++) {
        rsv_vec3 a = scene->position[scene->triangle[t][0]];
        rsv_vec3 b = scene->position[scene->triangle[t][1]];
        rsv_vec3 c = scene->position[scene->triangle[t][2]];
        float u, v, distance = rsv_triangle_distance(scene, (uint32_t)t, point, &u, &v);
        // a back counts only where there is something to see on it
        bool faces = v3_dot(v3_cross(v3_sub(b, a), v3_sub(c, a)), normal) > 0;
        bool unseen = !faces && !scene->material[scene->triangle_material[t]].double_sided;
        if (distance < best[unseen].t) best[unseen] = (rsv_hit){ (uint32_t)t, distance, u, v };
    }
    *hit = best[0].triangle != RSV_NONE ? best[0] : best[1];
    return hit->triangle != RSV_NONE;
}
