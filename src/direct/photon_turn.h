/// Photons at surfaces that are shaded as if they were tilted: interpolated normals and normal maps.
#ifndef RSV_PHOTON_TURN_H
#define RSV_PHOTON_TURN_H

#include "../specular/specular_path.h"

/// Bound of the gain where a surface is grazed that looks tilted, lest a photon stand out as a dot; with it, a frosted
/// lampshade loses 0.06 % of its light.
#define RSV_LARGEST_GAIN 16

RSV_INLINE float rsv_bounded_ratio(float a, float b)
{
    return b > 0 ? f_min(a / b, RSV_LARGEST_GAIN) : 0;
}

/// Factor of a photon's flux where it lands: irradiance uses the cosine with the shading normal.
/// @param direction of the photon
RSV_INLINE float rsv_photon_tilt(rsv_vec3 shading, rsv_vec3 geometric, rsv_vec3 direction)
{
    return rsv_bounded_ratio(f_max(-v3_dot(shading, direction), 0), -v3_dot(geometric, direction));
}

/// Factor of a photon's flux besides the weight of its specular event, so that photons scatter light as paths from the
/// eye do. BSDFs use the cosine of arriving light with the shading normal, but flux crosses the true surface (Veach
/// 1997, 5.3); and a path in the opposite direction may use another normal than the photon.
/// @param event drawn at the specular path's surface
RSV_SHARED rsv_rgb rsv_photon_turn(
    const rsv_transport_scene *scene, const rsv_specular_path *path, const rsv_bsdf_event *event);

#if defined(RSV_DEVICE_CODE)
#include "photon_turn_body.h"
#endif

#endif
