/// Lobes over single sources.
#include "lobe_polygon.h"

/// Polygons across which lobes are even: the square of their angular radius, over that of the scale on which the lobe varies
/// there.
#define EVEN 1e-3f

/// A polygon that is small beside a lobe, as light from its middle.
typedef struct small_polygon {
    rsv_vec3 towards; ///< its middle, relative to the point
    float distance2;
    float radius2; ///< of its angle
    float solid_angle;
} small_polygon;

static small_polygon measure(const rsv_highlight_lobes *l, const rsv_vec3 *corner, uint32_t count)
{
    small_polygon s = { 0 };
    rsv_vec3 sum = v3(0, 0, 0), area = v3(0, 0, 0);
    for (uint32_t i = 0; i < count; i++)
        sum = v3_add(sum, v3_sub(corner[i], corner[0]));
    rsv_vec3 middle = v3_mad(corner[0], 1 / (float)count, sum);
    for (uint32_t i = 0, before = count - 1; i < count; before = i++) {
        rsv_vec3 arm = v3_sub(corner[i], middle);
        s.radius2 = f_max(s.radius2, v3_dot(arm, arm));
        area = v3_add(area, v3_cross(v3_sub(corner[before], middle), arm));
    }
    s.towards = v3_sub(middle, l->point.position);
    s.distance2 = v3_dot(s.towards, s.towards);
    if (!(s.distance2 > 0)) return s;
    s.radius2 /= s.distance2;
    s.solid_angle = 0.5f * fabsf(v3_dot(area, s.towards)) / (s.distance2 * sqrtf(s.distance2));
    return s;
}

/// Whether the polygon is small beside all lobes.
static bool is_even(const rsv_highlight_lobes *l, const small_polygon *s)
{
    if (!(s->radius2 < EVEN)) return false;
    rsv_vec3 wi = v3_scale(rsv_to_lobe_frame(l, s->towards), 1 / sqrtf(s->distance2));
    wi.z = fabsf(wi.z);
    if (wi.z * wi.z < s->radius2 / EVEN) return false;
    for (uint32_t k = 0; k < l->count; k++) {
        const rsv_lobe_shape *shape = &l->lobe[k].shape;
        float x = (wi.x - shape->lean * wi.z) / shape->width_x, y = wi.y / shape->width_y;
        float narrow = f_min(f_min(shape->width_x, shape->width_y), 1);
        float scale2 = narrow * narrow * f_max(x * x + y * y + wi.z * wi.z, 0);
        if (s->radius2 > EVEN * scale2) return false;
    }
    return true;
}

static bool is_below(const rsv_highlight_lobes *l)
{
    for (uint32_t k = 0; k < l->count; k++)
        if (rsv_lobe_is_below(l->lobe[k].kind)) return true;
    return false;
}

rsv_rgb rsv_highlight_polygon(const rsv_highlight_lobes *l, const rsv_vec3 *corner, uint32_t count)
{
    small_polygon small = measure(l, corner, count);
    if (is_even(l, &small))
        return rgb_scale(
            rsv_highlight_direction(l, v3_normalize(small.towards)), small.solid_angle);
    rsv_local_polygon local;
    rsv_local_polygon_of(l, corner, count, 1, &local);
    rsv_rgb sum = rsv_lobes_over_local(l, &local, false);
    if (!is_below(l)) return sum;
    rsv_local_polygon_of(l, corner, count, -1, &local);
    return rgb_add(sum, rsv_lobes_over_local(l, &local, true));
}

void rsv_highlight_polygon_many(const rsv_highlight_lobes *l, size_t lobes_count,
    const rsv_vec3 *corner, uint32_t count, rsv_rgb *radiance)
{
    for (size_t i = 0; i < lobes_count; i++)
        radiance[i] = rsv_highlight_polygon(&l[i], corner, count);
}

rsv_rgb rsv_highlight_direction(const rsv_highlight_lobes *l, rsv_vec3 wi)
{
    const rsv_highlight_point *p = &l->point;
    float above = v3_dot(p->normal, wi);
    if (above * v3_dot(p->horizon, wi) <= 0) return rgb_gray(0);
    if (above < 0 && l->refracts) return rgb_gray(0);
    return rsv_bsdf_evaluate(p->bsdf, wi, p->wo, p->normal, p->front, RSV_LOBES_ROUGH).response;
}

/// A polygon of the disc's solid angle.
rsv_rgb rsv_highlight_disc(const rsv_highlight_lobes *l, rsv_vec3 direction, float cos_radius)
{
    const float regular[RSV_HIGHLIGHT_CORNERS][2] = { { 1, 0 }, { 0.70710678f, 0.70710678f },
        { 0, 1 }, { -0.70710678f, 0.70710678f }, { -1, 0 }, { -0.70710678f, -0.70710678f },
        { 0, -1 }, { 0.70710678f, -0.70710678f } };
    rsv_vec3 corner[RSV_HIGHLIGHT_CORNERS], t, b;
    float cosine = f_max(cos_radius, 0.02f);
    // 2 sqrt(2) r^2 is the area of the octagon in a circle of radius r
    float radius = sqrtf(f_max(1 - cosine * cosine, 0)) / cosine * 1.0539f;
    v3_frame(direction, &t, &b);
    for (int k = 0; k < RSV_HIGHLIGHT_CORNERS; k++)
        corner[k] = v3_add(l->point.position,
            v3_mad(v3_mad(direction, radius * regular[k][0], t), radius * regular[k][1], b));
    return rsv_highlight_polygon(l, corner, RSV_HIGHLIGHT_CORNERS);
}
