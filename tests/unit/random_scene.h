/// Random scenes for tests: rooms with furniture, and white things under a white sky. The same seed makes the same
/// scene on every machine.
#ifndef RSV_TEST_RANDOM_SCENE_H
#define RSV_TEST_RANDOM_SCENE_H

#include "core/core.h"
#include "resolvent/scene.h"

/// Which materials are allowed.
typedef struct random_material_choice {
    bool
        lossless; ///< give back all light that they receive: in a uniform surrounding they cannot be seen
    bool body;   ///< of closed surfaces that face outwards: may be solid, may be one-sided
    bool matt;   ///< no mirror and no smooth glass, nor nearly: what only photons find is left out
    bool opaque; ///< neither holes nor glass
} random_material_choice;

/// A random material, with textures in any of its slots and sometimes in all. Its name describes it.
rsv_status random_material(
    rsv_scene *scene, uint32_t seed, random_material_choice choice, uint32_t *id);

/// A faceted sphere with smooth normals and the texture coordinates of a globe.
rsv_status textured_ball(rsv_scene *scene, uint32_t material, rsv_vec3 centre, float radius);

/// A number of spheres above plates, with lossless materials of many kinds, under surroundings of radiance 1: every
/// pixel is 1. Camera k sees the k-th pair and the sky. Committed.
rsv_status random_furnace(rsv_scene *scene, uint32_t seed, uint32_t pairs);

/// A room, closed or open to a sky on one side, with lamps, lights and three to six pieces of furniture, and a camera
/// that sees most of it. The path tracer finds all of its light: no mirror reflects lights without an area. Committed.
rsv_status random_room(rsv_scene *scene, uint32_t seed);

#endif
