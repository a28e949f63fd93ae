/// Photons in fog after a specular event: beams of light that mirrors and glass send through the air.
///
/// The light that a beam leaves in fog is not sampled but integrated along it, so that one photon lights all voxels on
/// its way. Isotropic scattering attenuates the photon like any light. The directional part of a phase function turns
/// photons, as it turns gather rays (specular/fog_flight.h).
#ifndef RSV_PHOTON_AIR_H
#define RSV_PHOTON_AIR_H

#include "../elements/voxels.h"
#include "../specular/fog_flight.h"
#include "photon_map.h"

/// Follows a photon through the fog on its last segment. False if it ends there, or leaves the scene.
/// @param move of its start @param air receives each segment; NULL = none
bool rsv_photon_cross_fog(const rsv_transport_scene *scene, rsv_specular_path *path,
    rsv_specular_move move, rsv_random *random, const rsv_fog_witness *air);

/// Adds the light of a beam to the voxels of a map: its flux times its length in each voxel, attenuated on the way,
/// times the extinction, so that flux per area (voxels.h) is a quarter of the fluence.
/// @param flux W, at the start of the ray
void rsv_photon_map_light_air(
    const rsv_photon_map *map, const rsv_tracer *tracer, const rsv_ray *ray, rsv_rgb flux);

#endif
