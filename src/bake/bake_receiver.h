/// Where on the scene's surfaces a value of a file is taken.
#ifndef RSV_BAKE_RECEIVER_H
#define RSV_BAKE_RECEIVER_H

#include "../solve/light.h"

/// Light there, or a little beyond a border: E(u, v) + beyond (E(u, v) - E(u_back, v_back)).
typedef struct rsv_bake_receiver {
    uint32_t triangle; ///< RSV_NONE = nowhere: dark
    bool back;         ///< its side
    float u, v;
    float u_back, v_back; ///< as far inside as the receiver is outside
    float beyond;         ///< 0 = on the surface
} rsv_bake_receiver;

/// Displayed irradiance of a side of a surface: the entering one, diffused below the surface if the material is
/// translucent.
static inline rsv_rgb rsv_bake_shown(
    const rsv_light_view *s, uint32_t triangle, bool back, float u, float v)
{
    uint32_t face = s->elements->face_of[back][triangle];
    if (face == RSV_NONE || !rsv_is_translucent(s, face))
        return rsv_light_view_irradiance(s, triangle, u, v, back, RSV_NONE);
    rsv_rgb shown = rgb_add(rsv_light_view_diffused_direct(s, face, u, v),
        rsv_light_view_diffused(s, face, u, v, RSV_NONE));
    return rgb_positive(shown);
}

static inline rsv_rgb rsv_bake_irradiance(const rsv_light_view *s, const rsv_bake_receiver *r)
{
    if (r->triangle == RSV_NONE) return rgb_gray(0);
    rsv_rgb on = rsv_bake_shown(s, r->triangle, r->back, r->u, r->v);
    if (r->beyond == 0) return on;
    rsv_rgb back = rsv_bake_shown(s, r->triangle, r->back, r->u_back, r->v_back);
    return rgb_mad(on, r->beyond, rgb_sub(on, back));
}

#endif
