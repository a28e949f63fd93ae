/// Highlights of punctual lights on rough lobes. They are often hundreds of times as bright as what is around them, and
/// smaller than a cell (glossy_cells.h). So each pixel computes by itself how much brighter than RSV_HIGHLIGHT_LIMIT
/// times its surroundings it is, with a shadow ray to the light. The rest is as smooth as other light, and is left to
/// the cells.
#ifndef RSV_HIGHLIGHTS_H
#define RSV_HIGHLIGHTS_H

#include "../sources/punctual_light.h"

/// Radiance of lobes, relative to the mean that arrives, up to which cells show a highlight. The more they show, the
/// fewer shadow rays pixels need, and the more blurred highlights are.
#define RSV_HIGHLIGHT_LIMIT 4.0f

/// A punctual light as pixels judge it.
typedef struct rsv_highlight_light {
    rsv_vec3 place;  ///< or the unit direction towards it
    float strength;  ///< luminance of its intensity at most; 0 = cells have all of its light
    float is_nearby; ///< 1; 0 = it is distant
} rsv_highlight_light;

/// Those of rsv_punctual_at; none if it draws them.
typedef struct rsv_highlights {
    uint32_t count;
    rsv_highlight_light light[RSV_SUMMED_LIGHTS];
} rsv_highlights;

void rsv_highlights_of(const rsv_lights *lights, rsv_highlights *highlights);

/// A point that is seen.
typedef struct rsv_highlight_point {
    rsv_vec3 place, out, normal; ///< out, normal unit: towards the eye
    float alpha;                 ///< width of its narrowest lobe
    float even;                  ///< luminance of the mean radiance that arrives; 0 = not known
    float variance;              ///< of the normals within the pixel, radian^2, which widens lobes
} rsv_highlight_point;

/// Share of a light's highlight that cells show: less than 1 only where it is above RSV_HIGHLIGHT_LIMIT, judged by the
/// narrowest lobe (Walter et al. 2007). The irradiance of a surface is at least that of each light that reaches it:
/// shaded surfaces need no shadow rays.
RSV_INLINE float rsv_highlight_share(
    const rsv_highlight_light *light, const rsv_highlight_point *at)
{
    float x = light->place.x - light->is_nearby * at->place.x;
    float y = light->place.y - light->is_nearby * at->place.y;
    float z = light->place.z - light->is_nearby * at->place.z;
    float squared = x * x + y * y + z * z + 1e-20f, scale = 1 / sqrtf(squared);
    float cos_in = scale * (x * at->normal.x + y * at->normal.y + z * at->normal.z);
    float cos_out = v3_dot(at->out, at->normal);
    float hx = scale * x + at->out.x, hy = scale * y + at->out.y, hz = scale * z + at->out.z;
    float cos_half = (cos_in + cos_out) / sqrtf(hx * hx + hy * hy + hz * hz + 1e-20f);
    float square = at->alpha * at->alpha + at->variance,
          ratio = cos_half * cos_half * (square - 1) + 1;
    float lobe = square / (RSV_PI * ratio * ratio * 4 * f_max(cos_out, 0.1f));
    float irradiance = light->strength / (light->is_nearby > 0 ? squared : 1);
    float bright = f_min(irradiance / (at->even + 1e-20f), RSV_PI / f_max(cos_in, 0.01f)) * lobe;
    return cos_in > 0 ? RSV_HIGHLIGHT_LIMIT / f_max(bright, RSV_HIGHLIGHT_LIMIT) : 1;
}

/// The same where normals vary more than was known: nothing changes for pixels that leave all to cells.
RSV_INLINE float rsv_highlight_left(
    const rsv_highlight_light *light, const rsv_highlight_point *at, float variance)
{
    rsv_highlight_point wide = *at;
    float share = rsv_highlight_share(light, at);
    wide.variance = variance;
    return share < 1 && variance > at->variance ? rsv_highlight_share(light, &wide) : share;
}

/// Share of the variance of the normals of 2x2 pixels by which lobes are widened in a moving picture:
/// highlights smaller than a pixel would be as rare as they are bright, and frames lose what is much brighter than its
/// surroundings. At rest, each place in a pixel gets its turn instead. Of 0.25, 0.5 and 1, the first loses light of
/// small balls in the sun, and the last errs more where normal maps bend metal (relative MSE 0.18, 0.20, 0.28).
#define RSV_PIXEL_VARIANCE 0.5f

/// Variance of normals, which normal maps may bend: sum over both directions, radian^2.
/// @param x, y, z their sum @param count of them
RSV_INLINE float rsv_normals_variance(float x, float y, float z, float count)
{
    return f_max(count * count - (x * x + y * y + z * z), 0) / f_max(count * (count - 1), 1);
}

/// Sixteen pixels in a row.
typedef struct rsv_highlight_lanes {
    float share[RSV_SUMMED_LIGHTS][16]; ///< rsv_highlight_share of each light
    float x[16], y[16], z[16];          ///< points that they show
    float variance[16];                 ///< of normals within them, radian^2; 0 at rest
} __attribute__((aligned(64))) rsv_highlight_lanes;

#endif
