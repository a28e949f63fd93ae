/// Linearly transformed cosines that fit the GGX microsurface of white metal, by lobes_generate.c when the library is built.
/// Their axes are those of bsdf/tables.h.
#ifndef RSV_LOBE_TABLES_H
#define RSV_LOBE_TABLES_H

#include "../bsdf/tables.h"

/// A transformed cosine: v is distributed as cos / pi about the normal, z, and light comes from (width_x v.x + lean v.z,
/// width_y v.y, v.z), where x points away from the eye. Its inverse maps lamps to where they are under a plain cosine.
typedef struct rsv_lobe_shape {
    float lean, width_x, width_y;
} rsv_lobe_shape;

/// What varies little, whatever the width alpha.
typedef struct rsv_lobe_fit {
    float
        turn; ///< from the mirror direction to the lobe's axis, towards the normal; radians / alpha
    float width_x,
        width_y; ///< of the lobe about its axis, within and across the plane of incidence; tangents / alpha
    float grazing; ///< mean of (1 - cos_h)^5 over the lobe: Schlick's part beside that of F0
    float misfit;  ///< what its affinity with the lobe lacks to 1
} rsv_lobe_fit;

extern const rsv_lobe_fit rsv_lobe_fits[RSV_TABLE_ALPHA][RSV_TABLE_COS];

/// Bilinear.
RSV_INLINE rsv_lobe_fit rsv_lobe_fit_at(rsv_table_place alpha, rsv_table_place cos)
{
    const rsv_lobe_fit *low = &rsv_lobe_fits[alpha.index][cos.index], *high = low + RSV_TABLE_COS;
    float w[4] = { (1 - alpha.weight) * (1 - cos.weight), (1 - alpha.weight) * cos.weight,
        alpha.weight * (1 - cos.weight), alpha.weight * cos.weight };
    rsv_lobe_fit fit;
    fit.turn = w[0] * low[0].turn + w[1] * low[1].turn + w[2] * high[0].turn + w[3] * high[1].turn;
    fit.width_x = w[0] * low[0].width_x + w[1] * low[1].width_x + w[2] * high[0].width_x +
                  w[3] * high[1].width_x;
    fit.width_y = w[0] * low[0].width_y + w[1] * low[1].width_y + w[2] * high[0].width_y +
                  w[3] * high[1].width_y;
    fit.grazing = w[0] * low[0].grazing + w[1] * low[1].grazing + w[2] * high[0].grazing +
                  w[3] * high[1].grazing;
    fit.misfit =
        w[0] * low[0].misfit + w[1] * low[1].misfit + w[2] * high[0].misfit + w[3] * high[1].misfit;
    return fit;
}

/// Axes closer to the horizon would make a transform without an inverse.
#define RSV_LOWEST_AXIS 1e-4f

/// About the axis, the widths are tangents of angles; about the normal, tangents along the plane stretch by 1 / cos^2, across
/// it by 1 / cos.
RSV_INLINE rsv_lobe_shape rsv_lobe_shape_of(
    const rsv_lobe_fit *fit, float alpha, float cos_o, float sin_o)
{
    float turn = fit->turn * alpha, turn2 = turn * turn;
    // |turn| is below 1.6: Taylor's series to 1e-4, and the same in the fit
    float s = turn * (1 - turn2 / 6 * (1 - turn2 / 20 * (1 - turn2 / 42)));
    float c = 1 - turn2 / 2 * (1 - turn2 / 12 * (1 - turn2 / 30 * (1 - turn2 / 56)));
    float cos_axis = f_max(cos_o * c + sin_o * s, RSV_LOWEST_AXIS);
    float across = 1 / cos_axis;
    rsv_lobe_shape shape = { (sin_o * c - cos_o * s) * across,
        fit->width_x * alpha * across * across, fit->width_y * alpha * across };
    return shape;
}

/// Density per solid angle of the transformed cosine at unit `wi`, in the frame of the lobe; its integral over the upper
/// hemisphere is 1.
RSV_INLINE float rsv_lobe_density(const rsv_lobe_shape *shape, rsv_vec3 wi)
{
    float x = (wi.x - shape->lean * wi.z) / shape->width_x, y = wi.y / shape->width_y;
    float length2 = x * x + y * y + wi.z * wi.z;
    return wi.z / (RSV_PI * shape->width_x * shape->width_y * length2 * length2);
}

#endif
