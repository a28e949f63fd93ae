/// Photons in fog, after a specular event: beams of light that mirrors and glass send through the air.
///
/// What a beam brings to the fog is not drawn but integrated along it, so that one photon lights all voxels on its way. Even
/// fog takes from the photon what it takes from light. The uneven part of a phase function turns photons, as it turns gather
/// rays (specular/fog_flight.h).
#ifndef RSV_PHOTON_AIR_H
#define RSV_PHOTON_AIR_H

#include "../elements/voxels.h"
#include "../specular/fog_flight.h"
#include "photon_map.h"

/// Takes a photon through the fog on its last segment. False if it ends there, or leaves the scene.
/// @param move by which it set out @param air is told of each segment; NULL = nobody is
bool rsv_photon_cross_fog(const rsv_transport_scene *scene, rsv_specular_path *path,
    rsv_specular_move move, rsv_random *random, const rsv_fog_witness *air);

/// Leaves on a map of elements with voxels what a beam brings to these: its flux times the length of its way through each,
/// dimmed on the way, and times the extinction, so that flux per area (voxels.h) is a quarter of the fluence.
/// @param flux W, where the ray begins
void rsv_photon_map_light_air(
    const rsv_photon_map *map, const rsv_tracer *tracer, const rsv_ray *ray, rsv_rgb flux);

#endif
