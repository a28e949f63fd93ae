/// The scene of one light: surfaces, their ray tracer and their scattering.
///
/// All lights of an operator start in its world. A light with other strengths, colours, environment or lamp positions
/// gets a variant of it, so that lights are independent of each other.
#ifndef RSV_WORLD_H
#define RSV_WORLD_H

#include "../specular/specular_path.h"

typedef struct rsv_world {
    rsv_context *context;
    uint32_t references;       ///< holders
    rsv_transport_scene scene; ///< for everything that traces rays
    struct rsv_world *base;    ///< that this one varies; NULL = the scene is the caller's
    rsv_scene *variant;        ///< of the caller's scene; NULL = the same
    rsv_tracer *tracer;        ///< of its own; NULL = the base's
    rsv_bsdf *bsdf;            ///< [material_count]
    double build_seconds;      ///< that the hierarchy took
} rsv_world;

/// Builds the hierarchy of rays.
/// @param scene committed; must outlive the world
rsv_status rsv_world_create(const rsv_scene *scene, rsv_world **world);

/// The same surfaces with lights, colours and surroundings of their own (`variant`), which may be changed.
rsv_status rsv_world_vary(rsv_world *base, rsv_world **variant);

/// Gives a variant vertices and a hierarchy of its own, in which triangles of some materials can be moved. Does nothing
/// where it has them. @param moves [material_count]
rsv_status rsv_world_vary_places(rsv_world *variant, const bool *moves);

/// Gives a variant vertices, normals and a hierarchy of its own, in which single triangles can be moved, on top of
/// those that can be already. @param moves [triangle_count]
rsv_status rsv_world_vary_triangles(rsv_world *variant, const uint8_t *moves);

/// Takes over the places of vertices that were moved.
rsv_status rsv_world_follow_places(rsv_world *variant);
/// The same, but faces that are newly in the same place are left to a later rsv_world_follow_places.
rsv_status rsv_world_follow_places_in_haste(rsv_world *variant);

/// Updates the scattering of materials from the present scene.

void rsv_world_find_bsdfs(rsv_world *world);

rsv_world *rsv_world_retain(rsv_world *world);
void rsv_world_release(rsv_world *world); ///< NULL is allowed

#endif
