/// The chain of specular events `S*` between two diffuse interfaces: what the propagation operator G
/// folds away. Used from receivers (rows of G, probes) and, in the adjoint direction, from lights.
#ifndef RSV_CHAIN_H
#define RSV_CHAIN_H

#include "chain_walk.h"

typedef enum rsv_chain_end {
    RSV_CHAIN_ESCAPED,
    RSV_CHAIN_ABSORBED,
    RSV_CHAIN_DIFFUSE
} rsv_chain_end;

#define RSV_CHAIN_MAX_EVENTS 256

/// How the chain's surface scatters there. @param storage may be used to hold it
RSV_SHARED const rsv_bsdf *rsv_chain_bsdf(
    const rsv_transport_scene *scene, const rsv_chain *chain, rsv_bsdf *storage);

/// Shading normal (with its normal map) and geometric normal on the side the chain arrived from.
RSV_SHARED void rsv_chain_normals(const rsv_transport_scene *scene, const rsv_chain *chain,
    rsv_vec3 *shading, rsv_vec3 *geometric);

/// The same, with the normal that the BSDF is to be asked with: the one seen, unless it would lose what is mirrored.
RSV_SHARED const rsv_bsdf *rsv_chain_scattering(
    const rsv_transport_scene *scene, const rsv_chain *chain, rsv_vec3 *normal, rsv_bsdf *storage);

/// Branch weights at the chain's surface. What it does not cover counts as transmitted, straight on.
RSV_SHARED rsv_bsdf_branches rsv_chain_branches(
    const rsv_transport_scene *scene, const rsv_chain *chain);

/// The same at a surface point that is known, with its normal map.
RSV_SHARED rsv_bsdf_branches rsv_chain_branches_at(
    const rsv_transport_scene *scene, const rsv_chain *chain, const rsv_surface_point *seen);

/// Draws what happens to the chain at its surface, which it may pass where that does not cover (RSV_LOBE_PASS).
RSV_SHARED rsv_bsdf_event rsv_chain_draw_event(
    const rsv_transport_scene *scene, const rsv_chain *chain, rsv_random *random);

/// Draws among what is neither diffuse nor a gap in the surface's cover; the weight holds the chance of these.
/// @param u for the lobe and for the direction within it, in [0, 1)
RSV_SHARED rsv_bsdf_event rsv_chain_draw_specular(
    const rsv_transport_scene *scene, const rsv_chain *chain, const float u[3]);

typedef enum rsv_chain_move {
    RSV_CHAIN_MOVED,
    RSV_CHAIN_LEFT_SCENE, ///< direction and weight say how
    RSV_CHAIN_LOST ///< the direction belongs to the other side of the surface; nothing changed
} rsv_chain_move;

/// Leaves the surface by reflection or transmission and moves to the next one (rsv_chain_depart, rsv_chain_set_out and
/// rsv_chain_arrive in one).
/// @param weight multiplies the throughput
RSV_SHARED rsv_chain_move rsv_chain_step(const rsv_transport_scene *scene, rsv_chain *chain,
    bool transmit, rsv_vec3 direction, rsv_rgb weight);

/// The same for an event that was drawn and is not diffuse.
RSV_SHARED rsv_chain_move rsv_chain_follow(const rsv_transport_scene *scene, rsv_chain *chain,
    const rsv_bsdf_event *event, rsv_rgb weight);

/// What a gather chain found on its way: emission that counts, and where it ended.
typedef struct rsv_gather {
    rsv_chain_end end;
    rsv_chain
        chain; ///< at the diffuse interface, if end is RSV_CHAIN_DIFFUSE; its weight is then the
               ///< throughput of radiance, the coat of that interface included
    rsv_rgb emission; ///< radiance emitted towards the receiver by the surfaces met
} rsv_gather;

/// Roulette: divides by the largest channel after having survived with that probability.
bool rsv_chain_survives(rsv_rgb *weight, rsv_random *random);

/// Whether radiance emitted by a surface met after `turns` specular events (rsv_chain.turns) is wanted.
typedef bool (*rsv_emission_filter)(const void *user, uint32_t triangle, uint32_t turns);

/// Follows a gather chain to its diffuse end, drawing events by their probability. What the roulette
/// leaves is colour only: a colourless chain keeps weight 1.
rsv_gather rsv_chain_gather(const rsv_transport_scene *scene, rsv_chain chain, rsv_random *random,
    rsv_emission_filter filter, const void *user);

#if defined(RSV_DEVICE_CODE)
#include "chain_body.h"
#endif

#endif
