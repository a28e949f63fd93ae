/// Photons at tilted surfaces (photon_turn.h).
#ifndef RSV_PHOTON_TURN_BODY_H
#define RSV_PHOTON_TURN_BODY_H

#include "photon_turn.h"

/// From `in`, where the photon comes from, to `out`; normals are on the side of `in`.
typedef struct rsv_turn {
    rsv_vec3 in, out, geometric;
    rsv_vec3 normal;     ///< that the event was drawn with
    rsv_vec3 eye_normal; ///< that a path from the eye takes, which comes along `out`
    bool front;
} rsv_turn;

RSV_INLINE rsv_turn rsv_turn_of(
    const rsv_transport_scene *scene, const rsv_specular_path *path, rsv_vec3 out)
{
    rsv_surface_point seen = rsv_surface_point_seen(
        scene->view, path->triangle, path->u, path->v, path->back, path->width);
    rsv_turn t;
    t.in = v3_neg(path->direction);
    t.out = out;
    t.geometric = seen.geometric;
    t.front = !path->back;
    t.normal = rsv_bsdf_specular_normal(seen.normal, t.geometric, t.in);
    t.eye_normal =
        v3_dot(t.geometric, out) >= 0
            ? rsv_bsdf_specular_normal(seen.normal, t.geometric, out)
            : v3_neg(rsv_bsdf_specular_normal(v3_neg(seen.normal), v3_neg(t.geometric), out));
    return t;
}

RSV_INLINE bool rsv_same_direction(rsv_vec3 a, rsv_vec3 b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

/// Response of rough lobes to the eye over their response to the photon.
RSV_INLINE rsv_rgb rsv_eye_response(const rsv_turn *t, const rsv_bsdf *bsdf)
{
    bool through = v3_dot(t->geometric, t->out) < 0;
    rsv_vec3 n = through ? v3_neg(t->eye_normal) : t->eye_normal;
    rsv_bsdf_value eye =
        rsv_bsdf_evaluate(bsdf, t->in, t->out, n, t->front != through, RSV_LOBES_ROUGH);
    rsv_bsdf_value own =
        rsv_bsdf_evaluate(bsdf, t->out, t->in, t->normal, t->front, RSV_LOBES_ROUGH);
    rsv_rgb a = eye.response, b = own.response;
    return rgb(
        rsv_bounded_ratio(a.r, b.r), rsv_bounded_ratio(a.g, b.g), rsv_bounded_ratio(a.b, b.b));
}

/// The same of what a clear coat with normals of its own leaves of ideal lobes below it.
RSV_INLINE float rsv_eye_passage(const rsv_turn *t, const rsv_bsdf *bsdf)
{
    bool through = v3_dot(t->geometric, t->out) < 0;
    if (!rsv_bsdf_meets_layers(bsdf, t->front) || (through && bsdf->solid)) return 1;
    rsv_vec3 n = through ? v3_neg(t->eye_normal) : t->eye_normal;
    return rsv_bounded_ratio(
        rsv_bsdf_tilted_passage(bsdf, t->out, n), rsv_bsdf_tilted_passage(bsdf, t->in, t->normal));
}

RSV_SHARED rsv_rgb rsv_photon_turn(
    const rsv_transport_scene *scene, const rsv_specular_path *path, const rsv_bsdf_event *event)
{
    rsv_turn t = rsv_turn_of(scene, path, event->direction);
    rsv_bsdf storage;
    float in = v3_dot(t.geometric, t.in), out = fabsf(v3_dot(t.geometric, t.out));
    bool tilted = scene->bsdf[scene->view->triangle_material[path->triangle]].tilted;
    bool asks =
        tilted || (event->pdf_solid_angle > 0 && !rsv_same_direction(t.normal, t.eye_normal));
    const rsv_bsdf *bsdf = asks ? rsv_specular_bsdf(scene, path, &storage) : NULL;
    if (asks && event->pdf_solid_angle > 0)
        return rgb_scale(rsv_eye_response(&t, bsdf), rsv_bounded_ratio(out, in));
    float arrives = v3_dot(t.normal, t.in), leaves = fabsf(v3_dot(t.normal, t.out));
    float layers = tilted ? rsv_eye_passage(&t, bsdf) : 1;
    return rgb_gray(layers * rsv_bounded_ratio(out * arrives, in * leaves));
}

#endif
