/// Integrals of lobes over polygons.
#ifndef RSV_LOBE_POLYGON_H
#define RSV_LOBE_POLYGON_H

#include "lobe_response.h"

/// Cuts of a polygon at most, and shares that are not worth one.
#define RSV_MOST_CUTS 4
#define RSV_LEAST_CUT 1e-3f

/// Each clip and each cut may add a corner.
#define RSV_LOBE_CORNERS (RSV_HIGHLIGHT_CORNERS + 2 + RSV_MOST_CUTS)

/// A polygon in the frame of the lobes, relative to the point, clipped to what is above both horizons.
typedef struct rsv_local_polygon {
    rsv_vec3 corner[RSV_HIGHLIGHT_CORNERS + 2];
    uint32_t count;
    bool clipped; ///< a part of it is below
} rsv_local_polygon;

/// Sutherland and Hodgman's clip of a convex polygon against dot(n, .) >= 0.
RSV_INLINE void rsv_clip_polygon(rsv_local_polygon *p, rsv_vec3 n)
{
    float height[RSV_HIGHLIGHT_CORNERS + 2];
    rsv_vec3 corner[RSV_HIGHLIGHT_CORNERS + 2];
    uint32_t above = 0, count = p->count, left = 0;
    for (uint32_t i = 0; i < count; i++) {
        height[i] = v3_dot(n, p->corner[i]);
        corner[i] = p->corner[i];
        above += height[i] > 0;
    }
    if (above == count) return;
    p->clipped = true;
    p->count = 0;
    if (above == 0) return;
    for (uint32_t i = 0, before = count - 1; i < count; before = i++) {
        if ((height[i] > 0) != (height[before] > 0)) {
            float t = height[before] / (height[before] - height[i]);
            p->corner[left++] = v3_mad(corner[before], t, v3_sub(corner[i], corner[before]));
        }
        if (height[i] > 0) p->corner[left++] = corner[i];
    }
    p->count = left;
}

RSV_INLINE rsv_vec3 rsv_to_lobe_frame(const rsv_highlight_lobes *l, rsv_vec3 v)
{
    return v3(v3_dot(l->tangent, v), v3_dot(l->bitangent, v), v3_dot(l->point.normal, v));
}

RSV_INLINE rsv_vec3 rsv_from_lobe_frame(const rsv_highlight_lobes *l, rsv_vec3 v)
{
    return v3_mad(v3_mad(v3_scale(l->tangent, v.x), v.y, l->bitangent), v.z, l->point.normal);
}

/// @param side 1 or -1: lobes of the far side are mirrored to the near one
RSV_INLINE void rsv_local_polygon_of(const rsv_highlight_lobes *l, const rsv_vec3 *corner,
    uint32_t count, float side, rsv_local_polygon *p)
{
    rsv_vec3 horizon = rsv_to_lobe_frame(l, l->point.horizon);
    p->count = count;
    p->clipped = false;
    for (uint32_t i = 0; i < count; i++) {
        p->corner[i] = rsv_to_lobe_frame(l, v3_sub(corner[i], l->point.position));
        p->corner[i].z *= side;
    }
    rsv_clip_polygon(p, v3(0, 0, 1));
    if (horizon.z < 1 && p->count > 0)
        rsv_clip_polygon(p, v3(side * horizon.x, side * horizon.y, horizon.z));
}

/// theta / sin(theta) from x = sin^2(theta / 2), as rsv_angle_over_sine, in float: Chebyshev interpolant, relative error 5e-7.
RSV_INLINE float rsv_angle_ratio(float x)
{
    float y = x <= 0.5f ? x : f_max(1 - x, 0), sum = 3.40955538f;
    sum = sum * y - 3.23256172f;
    sum = sum * y + 2.16334394f;
    sum = sum * y - 0.0581846829f;
    sum = sum * y + 0.520027352f;
    sum = sum * y + 0.529253483f;
    sum = sum * y + 0.666765695f;
    sum = sum * y + 0.999999612f;
    return x <= 0.5f ? sum : 0.5f * RSV_PI / sqrtf(f_max(x * y, 1e-30f)) - sum;
}

/// A polygon under the plain cosine of a lobe.
typedef struct rsv_lobe_polygon {
    rsv_vec3 corner[RSV_LOBE_CORNERS];
    uint32_t count;
} rsv_lobe_polygon;

RSV_INLINE void rsv_lobe_polygon_of(
    const rsv_lobe_shape *shape, const rsv_local_polygon *p, rsv_lobe_polygon *q)
{
    float x = 1 / shape->width_x, y = 1 / shape->width_y;
    q->count = p->count;
    for (uint32_t i = 0; i < p->count; i++) {
        rsv_vec3 c = p->corner[i];
        q->corner[i] = v3_normalize(v3((c.x - shape->lean * c.z) * x, c.y * y, c.z));
    }
}

/// 2 int v dw over the polygon: its z is 2 pi times the lobe's share.
RSV_INLINE rsv_vec3 rsv_lobe_vector(const rsv_lobe_polygon *p)
{
    rsv_vec3 sum = v3(0, 0, 0);
    for (uint32_t i = 0, before = p->count - 1; i < p->count; before = i++) {
        rsv_vec3 chord = v3_sub(p->corner[i], p->corner[before]);
        sum = v3_mad(
            sum, rsv_angle_ratio(0.25f * v3_dot(chord, chord)), v3_cross(p->corner[before], chord));
    }
    return sum.z < 0 ? v3_neg(sum) : sum;
}

/// The part of a polygon on one side of a plane through the origin.
RSV_INLINE void rsv_cut_polygon(const rsv_lobe_polygon *p, rsv_vec3 n, rsv_lobe_polygon *part)
{
    uint32_t left = 0;
    rsv_vec3 before = p->corner[p->count - 1];
    float below = v3_dot(n, before);
    for (uint32_t i = 0; i < p->count; i++) {
        rsv_vec3 here = p->corner[i];
        float height = v3_dot(n, here);
        if ((height > 0) != (below > 0)) {
            float t = below / (below - height);
            part->corner[left++] = v3_normalize(v3_mad(before, t, v3_sub(here, before)));
        }
        if (height > 0) part->corner[left++] = here;
        before = here;
        below = height;
    }
    part->count = left;
}

/// Unit direction that `v` of the plain cosine stands for.
RSV_INLINE rsv_vec3 rsv_lobe_direction(const rsv_lobe_shape *shape, rsv_vec3 v)
{
    return v3_normalize(v3(shape->width_x * v.x + shape->lean * v.z, shape->width_y * v.y, v.z));
}

/// Part of the result that the response in mean directions decides; the albedo decides the rest, as the lobe is filled.
RSV_INLINE float rsv_lobe_detail(const rsv_highlight_lobe *lobe, float share)
{
    share = f_min(share, 1);
    return 1 - (lobe->cuts > 0 ? share * share : share);
}

/// What a lobe makes of light of radiance 1 from a share of it, in the mean about `v`.
RSV_INLINE rsv_rgb rsv_lobe_light(const rsv_highlight_lobes *l, const rsv_highlight_lobe *lobe,
    float share, float detail, rsv_vec3 v)
{
    rsv_vec3 local = rsv_lobe_direction(&lobe->shape, v), wi = local;
    float density = rsv_lobe_density(&lobe->shape, local);
    if (!(share > 0) || !(density > 1e-20f)) return rgb_gray(0);
    if (rsv_lobe_is_below(lobe->kind)) wi.z = -wi.z;
    rsv_rgb response = rsv_lobe_response(l, lobe->kind, rsv_from_lobe_frame(l, wi));
    return rgb_mad(
        rgb_scale(lobe->albedo, share * (1 - detail)), share * detail / density, response);
}

/// A part that has been cut off a polygon, or what is cut next.
typedef struct rsv_lobe_part {
    rsv_lobe_polygon polygon;
    rsv_vec3 vector;
    uint32_t cuts; ///< to come
} rsv_lobe_part;

/// Cuts through the mean direction, by turns upright and across.
RSV_INLINE rsv_vec3 rsv_cut_normal(rsv_vec3 v, uint32_t cuts)
{
    float across2 = v.x * v.x + v.y * v.y;
    rsv_vec3 side = across2 > 1e-10f * v.z * v.z ? v3(v.y, -v.x, 0) : v3(1, 0, 0);
    return cuts & 1 ? v3_cross(v, side) : side;
}

/// The light of a lobe from a polygon that is cut into up to 2^cuts parts, each with a mean direction of its own.
RSV_INLINE rsv_rgb rsv_lobe_in_parts(const rsv_highlight_lobes *l, const rsv_highlight_lobe *lobe,
    const rsv_lobe_part *whole, float detail)
{
    rsv_lobe_part stack[RSV_MOST_CUTS + 1];
    uint32_t height = 1;
    rsv_rgb sum = rgb_gray(0);
    stack[0] = *whole;
    while (height > 0) {
        rsv_lobe_part part = stack[--height];
        float share = part.vector.z * (0.5f / RSV_PI);
        if (part.cuts == 0 || share < RSV_LEAST_CUT) {
            sum = rgb_add(sum, rsv_lobe_light(l, lobe, share, detail, part.vector));
            continue;
        }
        rsv_vec3 n = rsv_cut_normal(part.vector, --part.cuts);
        for (int side = 0; side < 2; side++) {
            rsv_lobe_part *half = &stack[height];
            rsv_cut_polygon(&part.polygon, side ? v3_neg(n) : n, &half->polygon);
            if (half->polygon.count < 3) continue;
            half->vector = rsv_lobe_vector(&half->polygon);
            half->cuts = part.cuts;
            height++;
        }
    }
    return sum;
}

/// The lobes of one side over a clipped polygon.
RSV_INLINE rsv_rgb rsv_lobes_over_local(
    const rsv_highlight_lobes *l, const rsv_local_polygon *p, bool below)
{
    rsv_rgb sum = rgb_gray(0);
    if (p->count < 3) return sum;
    for (uint32_t k = 0; k < l->count; k++) {
        const rsv_highlight_lobe *lobe = &l->lobe[k];
        if (rsv_lobe_is_below(lobe->kind) != below) continue;
        rsv_lobe_part part;
        rsv_lobe_polygon_of(&lobe->shape, p, &part.polygon);
        part.vector = rsv_lobe_vector(&part.polygon);
        part.cuts = lobe->cuts;
        float share = part.vector.z * (0.5f / RSV_PI), detail = rsv_lobe_detail(lobe, share);
        sum = rgb_add(sum, part.cuts > 0 ? rsv_lobe_in_parts(l, lobe, &part, detail)
                                         : rsv_lobe_light(l, lobe, share, detail, part.vector));
    }
    return sum;
}

#endif
