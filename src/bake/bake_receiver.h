/// Where on the scene's surfaces a value of a file is taken.
#ifndef RSV_BAKE_RECEIVER_H
#define RSV_BAKE_RECEIVER_H

#include "../solve/solution.h"

/// Light there, or a little beyond a border: E(u, v) + beyond (E(u, v) - E(u_back, v_back)).
typedef struct rsv_bake_receiver {
    uint32_t triangle; ///< RSV_NONE = nowhere: dark
    float u, v;
    float u_back, v_back; ///< as far inside as the receiver is outside
    float beyond;         ///< 0 = on the surface
} rsv_bake_receiver;

static inline rsv_rgb rsv_bake_irradiance(const rsv_solution *s, const rsv_bake_receiver *r)
{
    if (r->triangle == RSV_NONE) return rgb_gray(0);
    rsv_rgb on = rsv_solution_irradiance(s, r->triangle, r->u, r->v, false, RSV_NONE);
    if (r->beyond == 0) return on;
    rsv_rgb back = rsv_solution_irradiance(s, r->triangle, r->u_back, r->v_back, false, RSV_NONE);
    return rgb_mad(on, r->beyond, rgb_sub(on, back));
}

#endif
