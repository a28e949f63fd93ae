#include "path_surface.h"

/// Textures are looked up as they are: what a pixel averages is the business of its samples.
void rsv_path_surface_meet(
    const rsv_path_tracer *tracer, const rsv_ray *ray, const rsv_hit *hit, rsv_path_surface *s)
{
    const rsv_scene_view *scene = tracer->scene;
    rsv_surface_point point =
        rsv_surface_point_seen(scene, hit->triangle, hit->u, hit->v, false, 0);
    s->bsdf = rsv_surface_bsdf(scene, tracer->bsdf, hit->triangle, hit->u, hit->v, 0, &s->own);
    s->point = point.position;
    s->wo = v3_neg(v3_normalize(ray->direction));
    s->extent = point.extent;
    s->triangle = hit->triangle;
    s->material = scene->triangle_material[hit->triangle];
    s->u = hit->u;
    s->v = hit->v;
    s->translucent = tracer->bodies->triangle_body[hit->triangle] != RSV_NONE;
    s->entry = false;
    s->front = v3_dot(point.geometric, s->wo) > 0;
    s->geometric_normal = s->front ? point.geometric : v3_neg(point.geometric);
    s->normal = s->front ? point.normal : v3_neg(point.normal);
    if (!s->bsdf->lambert)
        s->normal = rsv_bsdf_specular_normal(s->normal, s->geometric_normal, s->wo);
}

rsv_vec3 rsv_path_surface_departure(const rsv_path_surface *s, bool transmitted)
{
    rsv_vec3 side = transmitted ? v3_neg(s->geometric_normal) : s->geometric_normal;
    return rsv_offset_origin(s->point, side, s->extent);
}

/// What of the light from wi enters a translucent body, over pi: as if it left a white one right here.
static rsv_bsdf_value respond_to_entering(const rsv_path_surface *s, rsv_vec3 wi)
{
    float cos = f_max(v3_dot(s->normal, wi), 0);
    return (rsv_bsdf_value){ rgb_scale(rsv_bsdf_entry(s->bsdf, cos), cos / RSV_PI), cos / RSV_PI };
}

rsv_bsdf_value rsv_path_surface_respond(const rsv_path_surface *s, rsv_vec3 wi, rsv_lobe_set lobes)
{
    rsv_bsdf_value nothing = { rgb_gray(0), 0 };
    if (v3_dot(s->geometric_normal, wi) * v3_dot(s->normal, wi) <= 0) return nothing;
    if (s->entry) return lobes == RSV_LOBES_DIFFUSE ? respond_to_entering(s, wi) : nothing;
    if (s->translucent && lobes == RSV_LOBES_DIFFUSE) return nothing;
    return rsv_bsdf_evaluate(s->bsdf, wi, s->wo, s->normal, s->front, lobes);
}

/// Share of light that passes a surface without turning: past what it does not cover, and through thin sheets.
static rsv_rgb straight_through(const rsv_path_surface *s, bool sheets)
{
    rsv_rgb uncovered = rgb_gray(1 - s->bsdf->opacity);
    if (!sheets || s->bsdf->transmission == 0 || s->bsdf->solid) return uncovered;
    rsv_rgb sheet = rsv_bsdf_evaluate_branches(s->bsdf, s->wo, s->normal, s->front).transmit;
    return rgb_mad(uncovered, s->bsdf->opacity, sheet);
}

rsv_rgb rsv_straight_transmittance(const rsv_path_tracer *tracer, rsv_ray ray, bool sheets)
{
    rsv_rgb passed = rgb_gray(1);
    rsv_vec3 end = v3_mad(ray.origin, ray.t_max, ray.direction);
    rsv_hit hit;
    while (!rgb_is_black(passed) && rsv_tracer_closest(tracer->tracer, &ray, &hit)) {
        rsv_path_surface s;
        rsv_path_surface_meet(tracer, &ray, &hit, &s);
        passed = rgb_mul(passed, straight_through(&s, sheets));
        ray.origin = rsv_path_surface_departure(&s, true);
        if (!(ray.t_max < INFINITY)) continue;
        ray.direction = v3_sub(end, ray.origin);
        ray.t_max = 1;
    }
    return passed;
}
