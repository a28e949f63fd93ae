#include "path_surface.h"

/// Largest cosine with the triangle at which a ray begins above it.
#define GRAZING 0.1f

/// Heights by which the tangent planes of the vertices pass over a point of the triangle that they enclose from
/// outside, weighed as normals are: the shape that the shading normals speak of. Concave ones do not count.
static void rise_to_curve(const rsv_path_tracer *tracer, const rsv_hit *hit, rsv_path_surface *s)
{
    const rsv_scene_view *scene = tracer->scene;
    const uint32_t *corner = scene->triangle[hit->triangle];
    const float share[3] = { 1 - hit->u - hit->v, hit->u, hit->v };
    rsv_vec3 normal[3], smooth = v3(0, 0, 0), rise = v3(0, 0, 0);
    bool curved = false;
    for (int k = 0; k < 3; k++) {
        normal[k] = v3_normalize(scene->normal[corner[k]]);
        if (!s->front) normal[k] = v3_neg(normal[k]);
        if (v3_dot(normal[k], s->geometric_normal) <= 0) return;
        curved = curved || v3_dot(normal[k], normal[0]) < 1 - 1e-6f;
        smooth = v3_mad(smooth, share[k], normal[k]);
        float height = v3_dot(v3_sub(scene->position[corner[k]], s->point), normal[k]);
        if (height > 0) rise = v3_mad(rise, share[k] * height, normal[k]);
    }
    rsv_vec3 start = rsv_offset_origin(s->point, s->geometric_normal, s->extent);
    rsv_ray up = { start, rise, 1 };
    if (!curved || !(v3_length(rise) > 0) || rsv_tracer_occluded(tracer->tracer, &up)) return;
    s->rise = rise;
    s->horizon = v3_normalize(smooth);
}

/// Textures are not filtered: averaging over a pixel is left to its samples.
void rsv_path_surface_meet(
    const rsv_path_tracer *tracer, const rsv_ray *ray, const rsv_hit *hit, rsv_path_surface *s)
{
    const rsv_scene_view *scene = tracer->scene;
    rsv_surface_point point =
        rsv_surface_point_seen(scene, hit->triangle, hit->u, hit->v, false, 0);
    s->bsdf = rsv_surface_bsdf(scene, tracer->bsdf,
        (rsv_footprint){ hit->triangle, hit->u, hit->v, 0, RSV_CHANNEL_ALL }, &s->own);
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
    s->horizon = s->geometric_normal;
    s->rise = v3(0, 0, 0);
    rise_to_curve(tracer, hit, s);
    s->receiving = s->normal;
    if (!s->bsdf->lambert)
        s->normal = rsv_bsdf_specular_normal(s->normal, s->geometric_normal, s->wo);
    else if (v3_dot(s->normal, s->wo) <=
             0) // a silhouette, whose normal turns away: Lambert's law asks for no direction
        s->wo = s->geometric_normal;
}

rsv_vec3 rsv_path_surface_departure(const rsv_path_surface *s, bool transmitted, rsv_vec3 direction)
{
    rsv_vec3 side = transmitted ? v3_neg(s->geometric_normal) : s->geometric_normal;
    rsv_vec3 start = rsv_offset_origin(s->point, side, s->extent);
    float slope = v3_dot(s->geometric_normal, direction);
    if (transmitted || slope >= GRAZING) return start;
    return v3_mad(start, f_min(1 - slope / GRAZING, 1), s->rise);
}

bool rsv_path_surface_leads(const rsv_path_surface *s, bool transmitted, rsv_vec3 direction)
{
    return transmitted ? v3_dot(s->geometric_normal, direction) < 0
                       : v3_dot(s->horizon, direction) > 0;
}

/// Fraction of the light from wi that enters a translucent body, / pi: as if it left a white one at the same point.
static rsv_bsdf_value respond_to_entering(const rsv_path_surface *s, rsv_vec3 wi)
{
    float cos = f_max(v3_dot(s->normal, wi), 0);
    return (rsv_bsdf_value){ rgb_scale(rsv_bsdf_entry(s->bsdf, cos), cos / RSV_PI), cos / RSV_PI };
}

static bool is_received(const rsv_path_surface *s, rsv_vec3 wi)
{
    return v3_dot(s->receiving, wi) > 0 && rsv_path_surface_leads(s, false, wi);
}

bool rsv_path_surface_is_below(const rsv_path_surface *s, rsv_vec3 wi)
{
    return v3_dot(s->normal, wi) < 0 && !(rsv_path_surface_turned(s) && is_received(s, wi));
}

/// The diffuse lobe with its own normal, which needs only the cosine of wi.
static rsv_bsdf_value respond_diffusely(const rsv_path_surface *s, rsv_vec3 wi)
{
    rsv_vec3 t, b;
    float cos = v3_dot(s->receiving, wi);
    if (!is_received(s, wi)) return (rsv_bsdf_value){ rgb_gray(0), 0 };
    v3_frame(s->normal, &t, &b);
    rsv_vec3 same = v3_mad(v3_scale(s->normal, cos), sqrtf(f_max(1 - cos * cos, 0)), t);
    return rsv_bsdf_evaluate(s->bsdf, same, s->wo, s->normal, s->front, RSV_LOBES_DIFFUSE);
}

rsv_bsdf_value rsv_path_surface_respond(const rsv_path_surface *s, rsv_vec3 wi, rsv_lobe_set lobes)
{
    rsv_bsdf_value nothing = { rgb_gray(0), 0 }, value = nothing;
    bool own =
        (lobes & RSV_LOBES_DIFFUSE) && !s->entry && !s->translucent && rsv_path_surface_turned(s);
    if (own) {
        value = respond_diffusely(s, wi);
        lobes &= ~(rsv_lobe_set)RSV_LOBES_DIFFUSE;
        if (!lobes) return value;
    }
    float cos = v3_dot(s->normal, wi);
    if (cos == 0 || !rsv_path_surface_leads(s, cos < 0, wi)) return value;
    if (s->entry) return lobes == RSV_LOBES_DIFFUSE ? respond_to_entering(s, wi) : nothing;
    if (s->translucent && lobes == RSV_LOBES_DIFFUSE) return nothing;
    rsv_bsdf_value rest = rsv_bsdf_evaluate(s->bsdf, wi, s->wo, s->normal, s->front, lobes);
    rest.response = rgb_add(rest.response, value.response);
    rest.pdf_solid_angle += value.pdf_solid_angle;
    return rest;
}

/// Fraction of light that passes a surface straight: past its coverage, and through thin sheets.
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
        ray.origin = rsv_path_surface_departure(&s, true, ray.direction);
        if (!(ray.t_max < INFINITY)) continue;
        ray.direction = v3_sub(end, ray.origin);
        ray.t_max = 1;
    }
    return passed;
}
