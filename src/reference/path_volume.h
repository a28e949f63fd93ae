/// How a path of the reference crosses fog whose density varies.
///
/// Nothing here integrates density: flights and transmittances come from tentative collisions with a majorant
/// (Woodcock et al. 1965; ratio tracking, Novak et al. 2014), so that they judge the integrals that all else uses. At a
/// tentative collision, a path of throughput w is scattered with probability P or goes on, by weights
///
///     scattered: a_c sigma_c / (M P),   on: (M - sigma_c) / (M (1 - P)),   P ~ sum w_c a_c sigma_c
///
/// with the local extinction sigma_c, albedo a_c and majorant M. Absorption is a weight and ends no path.
#ifndef RSV_PATH_VOLUME_H
#define RSV_PATH_VOLUME_H

#include "path_fog.h"

/// Takes a path along its ray through the fog, up to `length` metres.
rsv_fog_outcome rsv_path_cross_volume(struct rsv_light_path *path, float length);

/// An unbiased estimate of what the fog leaves of light over `distance` metres from a point in the air.
rsv_rgb rsv_path_volume_transmittance(const rsv_fog *fog, rsv_random *random, const rsv_ray *ray);

#endif
