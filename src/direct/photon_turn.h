/// Photons at surfaces that are shaded as if they were tilted: interpolated normals and normal maps.
#ifndef RSV_PHOTON_TURN_H
#define RSV_PHOTON_TURN_H

#include "../specular/specular_path.h"

/// What a photon's flux is multiplied by besides the weight of its specular event, so that light is scattered as paths
/// from the eye are. BSDFs count the cosine of light that arrives by the shading normal, but flux crosses the true
/// surface (Veach 1997, 5.3); and a path that came the other way may take another normal than the photon did.
/// @param event drawn at the specular path's surface
RSV_SHARED rsv_rgb rsv_photon_turn(
    const rsv_transport_scene *scene, const rsv_specular_path *path, const rsv_bsdf_event *event);

#if defined(RSV_DEVICE_CODE)
#include "photon_turn_body.h"
#endif

#endif
