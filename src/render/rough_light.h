/// Light sources as rough surfaces on the way of a camera ray reflect them: small lamps, suns and punctual
/// lights are aimed at, large ones met by chance, and the two weighed by the power heuristic.
#ifndef RSV_ROUGH_LIGHT_H
#define RSV_ROUGH_LIGHT_H

#include "../light/light.h"
#include "../operator/chain.h"

/// How a chain left a rough surface, for what it meets next.
typedef struct rsv_rough_departure {
    rsv_vec3 point, side;  ///< of the surface; unit normal on the side that the chain left to
    float pdf_solid_angle; ///< 0 = not from a rough surface: nothing has been aimed at
} rsv_rough_departure;

/// The departure of a chain from its rough surface along `direction`.
rsv_rough_departure rsv_rough_depart(
    const rsv_transport_scene *scene, const rsv_chain *chain, rsv_vec3 direction);

/// Radiance that the chain's rough surface scatters towards the camera from sources aimed at.
rsv_rgb rsv_rough_light(const rsv_transport_scene *scene, const rsv_lights *lights,
    const rsv_chain *chain, rsv_random *random);

/// Weight of the emission of the surface that the chain has come to.
float rsv_rough_emission_weight(const rsv_transport_scene *scene, const rsv_lights *lights,
    const rsv_chain *chain, const rsv_rough_departure *departure);

/// Radiance of the sky that the chain has left the scene to. What rough surfaces aim at is weighed part by part, as
/// it is drawn; what is gathered counts in full.
rsv_rgb rsv_rough_sky(
    const rsv_lights *lights, rsv_vec3 direction, const rsv_rough_departure *departure);

#endif
