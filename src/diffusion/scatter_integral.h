/// The diffusion profile over a triangle, exact where the triangle is near: the profile is singular and may be
/// far narrower than the triangle, so that no point sample stands for it.
#ifndef RSV_SCATTER_INTEGRAL_H
#define RSV_SCATTER_INTEGRAL_H

#include "../subsurface/scatter_profile.h"

/// weight[k] = int p(|x - y|) b_k(y) dA(y) over a triangle, where b_k is the barycentric weight of corner k. In polar
/// coordinates around the foot of x on the triangle's plane, radial integrals have closed forms, which leaves one
/// dimension along each edge.
/// @param corner of the triangle, relative to x
void rsv_scatter_integrate(
    const rsv_scatter_profile *profile, const rsv_vec3 corner[3], rsv_rgb weight[3]);

#endif
