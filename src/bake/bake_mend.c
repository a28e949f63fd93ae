#include "bake_mend.h"

#include "../core/sampling.h"
#include "../core/vec.h"
#include "bake_constants.h"
#include "bake_direct.h"
#include "bake_gather.h"

/// 0 below `from`, 1 above `to`, smooth between.
static float ramp(float x, float from, float to)
{
    float t = f_min(f_max((x - from) / (to - from), 0), 1);
    return t * t * (3 - 2 * t);
}

/// How much stored light changes within an element, W/m2. @param size out: its edge, metres
static float change_within(const rsv_light_view *s, const rsv_surface_place *p, float *size)
{
    float w[3], low = INFINITY, high = 0;
    const rsv_elements *e = s->elements;
    uint32_t cell = rsv_elements_locate(e, e->face_of[p->back][p->triangle], p->u, p->v, w);
    for (int k = 0; k < 3; k++) {
        float value = rgb_luminance(s->indirect[e->cell_node[cell][k]]);
        low = f_min(low, value);
        high = f_max(high, value);
    }
    *size = sqrtf(2 * rsv_cell_area(e, cell));
    return high - low;
}

/// Harmonic mean of the distances seen from a place, as its inverse, 1/m.
static float nearness(const rsv_light_view *s, const rsv_surface_place *p)
{
    rsv_surface_point at = rsv_surface_point_at(s->scene.view, p->triangle, p->u, p->v, p->back);
    rsv_vec3 origin = rsv_offset_origin(at.position, at.geometric, at.extent);
    float sum = 0;
    for (uint32_t k = 0; k < NEAR_RAYS; k++) {
        float a, b;
        rsv_hit hit;
        rsv_sobol_2d(k, 0, &a, &b);
        rsv_vec3 d = rsv_square_to_cosine_hemisphere(a, b);
        const rsv_ray ray = { origin, v3_turned_to(at.geometric, d), INFINITY };
        if (rsv_tracer_closest(s->tracer, &ray, &hit)) sum += 1 / f_max(hit.t, 1e-6f);
    }
    return sum / NEAR_RAYS;
}

/// Fraction of the stored light to replace.
static float doubt(const rsv_light_view *s, const rsv_surface_place *p, float total)
{
    float size, change = change_within(s, p, &size) / total;
    float steep = ramp(change, DOUBTED_CHANGE, WRONG_CHANGE);
    return steep == 1 ? 1 : f_max(steep, ramp(size * nearness(s, p), DOUBTED_NEAR, WRONG_NEAR));
}

/// Mean over a patch of the light gathered by one group of rays.
static rsv_rgb gather_patch(const rsv_light_view *s, const rsv_bake_patch *patch, uint32_t seed)
{
    rsv_rgb sum = rgb_gray(0);
    uint32_t rays = (MEND_RAYS + patch->count - 1) / patch->count;
    for (uint32_t k = 0; k < patch->count; k++)
        sum = rgb_add(sum, rsv_bake_gather(s, &patch->place[k], rays, rsv_hash2(seed, k)));
    return rgb_scale(sum, 1 / (float)patch->count);
}

/// Difference between gathered and stored light.
typedef struct difference {
    rsv_rgb mean;
    float square, noise; ///< of its luminance: squared, and the variance of that
} difference;

/// Traces as many groups of rays as needed to bring noise below the target.
static difference gather_difference(
    const rsv_light_view *s, const rsv_bake_patch *patch, float wanted, uint32_t seed)
{
    rsv_rgb stored = rsv_bake_stored_mean(s, patch), sum = rgb_gray(0);
    float squares = 0, groups = 0;
    difference d = { .noise = INFINITY };
    while (groups < MEND_GROUPS && (groups < LEAST_MEND_GROUPS || d.noise > wanted * wanted)) {
        rsv_rgb off = rgb_sub(gather_patch(s, patch, rsv_hash2(seed, (uint32_t)groups)), stored);
        sum = rgb_add(sum, off);
        squares += rgb_luminance(off) * rgb_luminance(off);
        groups++;
        d.mean = rgb_scale(sum, 1 / groups);
        d.square = rgb_luminance(d.mean) * rgb_luminance(d.mean);
        if (groups > 1) d.noise = (squares / groups - d.square) / (groups - 1);
    }
    return d;
}

rsv_rgb rsv_bake_mend(
    const rsv_light_view *s, const rsv_bake_patch *patch, float total, uint32_t seed)
{
    const rsv_rgb none = rgb_gray(0);
    if (patch->count == 0 || !(total > 0) || !rsv_bake_is_sampled(s, &patch->place[0])) return none;
    float share = doubt(s, &patch->place[0], total);
    if (share == 0) return none;
    difference d = gather_difference(s, patch, MEND_NOISE * total / share, seed);
    // the part explained by noise is not an error of the stored light (James and Stein 1961)
    float sure = d.square > 0 ? f_max(1 - d.noise / d.square, 0) : 0;
    return rgb_scale(d.mean, share * sure);
}
