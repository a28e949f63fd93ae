/// Directions of incoming light, for normals close to a surface's own.
///
/// Irradiance for a normal m other than the surface's n is assumed to be linear in m, as with spherical harmonics of
/// order 1:
///
///     E(m) = (E + V . m) / 2     with V . n = E, so that it is E for m = n
///
/// V = E (n + d) for each channel. d is a tangential vector at the coarse nodes. It varies slowly, even where shadows
/// cut through E, and is fitted to irradiance gathered for n and three normals around it.
#ifndef RSV_BAKE_DIRECTIONS_H
#define RSV_BAKE_DIRECTIONS_H

#include "bake_receiver.h"

typedef struct rsv_bake_directions {
    const rsv_light_view *solution;
    rsv_rgb *axis[3]; ///< [node_count] x, y and z of d, for each channel
} rsv_bake_directions;

rsv_status rsv_bake_directions_create(
    const rsv_light_view *solution, rsv_bake_directions *directions);
void rsv_bake_directions_destroy(rsv_bake_directions *directions);

/// V / E at a place of the surfaces. @param out x, y and z for each channel
void rsv_bake_directions_at(
    const rsv_bake_directions *directions, const rsv_bake_receiver *receiver, rsv_rgb out[3]);

#endif
