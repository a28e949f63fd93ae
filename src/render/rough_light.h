/// Light sources as rough surfaces on the way of a camera ray reflect them: small lamps, suns and punctual
/// lights are aimed at, large ones met by chance, and the two weighed by the power heuristic. So is what the surface sees of the
/// gathered sky, as far as rows of G tell.
#ifndef RSV_ROUGH_LIGHT_H
#define RSV_ROUGH_LIGHT_H

#include "../chain/chain.h"
#include "../light/light.h"
#include "sky_aim.h"

/// How a chain left a rough surface, for what it meets next.
typedef struct rsv_rough_departure {
    rsv_vec3 point, side;  ///< of the surface; unit normal on the side that the chain left to
    float pdf_solid_angle; ///< 0 = not from a rough surface: nothing has been aimed at
    float sky_pdf;         ///< of the aim at the gathered sky
    bool
        shot; ///< emitters that are not gathered, suns and punctual lights are left out: shot_light.h
} rsv_rough_departure;

/// A rough surface that a chain has come to, as sources light it: what its textures make of it is looked up once.
typedef struct rsv_rough_surface {
    const rsv_transport_scene *scene;
    const rsv_chain *chain;
    const rsv_bsdf *bsdf; ///< into the scene's, or `storage`: the surface is not to be copied
    rsv_bsdf storage;
    rsv_surface_point point;
    rsv_vec3 wo, normal;
    bool front;
} rsv_rough_surface;

/// @param chain borrowed
void rsv_rough_meet(
    const rsv_transport_scene *scene, const rsv_chain *chain, rsv_rough_surface *surface);

/// Whether the lobes of a rough surface are all so wide that a light path which ends there is likely to reach any eye.
bool rsv_rough_is_wide(const rsv_bsdf *bsdf);

/// What the rough lobes make of light from unit direction `wi`: radiance at the chain's start per irradiance on a
/// surface that faces it.
rsv_rgb rsv_rough_response(const rsv_rough_surface *surface, rsv_vec3 wi);

/// Radiance that the surface scatters towards the camera from sources aimed at.
/// @param shot leaves out those of rsv_rough_departure.shot
/// @param u for the choice of a source and for the place on it, in [0, 1)
rsv_rgb rsv_rough_light(
    const rsv_rough_surface *surface, const rsv_lights *lights, bool shot, const float u[3]);

/// Draws a direction from all lobes but the diffuse one, with their chance in the weight.
/// @param u for the lobe and for the direction within it, in [0, 1)
rsv_bsdf_event rsv_rough_draw(const rsv_rough_surface *surface, const float u[3]);

/// Where the surface aims at the gathered sky; nowhere if none is known to be seen.
/// @param openings NULL = none is
void rsv_rough_aim(
    const rsv_rough_surface *surface, const rsv_openings *openings, rsv_sky_aim *aim);

/// Radiance that the surface scatters towards the camera from the gathered sky. @param u in [0, 1)
rsv_rgb rsv_rough_aimed_light(const rsv_rough_surface *surface, const rsv_lights *lights,
    const rsv_sky_aim *aim, const float u[3]);

/// The departure of the chain along `direction`.
rsv_rough_departure rsv_rough_depart(
    const rsv_rough_surface *surface, const rsv_sky_aim *aim, rsv_vec3 direction);

/// Weight of the emission of the surface that the chain has come to.
float rsv_rough_emission_weight(const rsv_transport_scene *scene, const rsv_lights *lights,
    const rsv_chain *chain, const rsv_rough_departure *departure);

/// Radiance of the sky that the chain has left the scene to. What rough surfaces aim at is weighed part by part, as
/// it is drawn; what is gathered counts in full.
rsv_rgb rsv_rough_sky(
    const rsv_lights *lights, rsv_vec3 direction, const rsv_rough_departure *departure);

#endif
