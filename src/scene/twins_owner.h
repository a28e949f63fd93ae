/// Storage of duplicate faces.
#ifndef RSV_TWINS_OWNER_H
#define RSV_TWINS_OWNER_H

#include "scene.h"
#include "twin_tree.h"

/// Rays start this many times the distance of copies away from faces that have copies.
#define RSV_TWIN_CLEAR 1.5f

typedef struct rsv_twins_owner {
    rsv_twins twins; ///< the view's, once there are any
    rsv_twin_tree tree;
    uint8_t *flags;                ///< [triangle_count]
    uint32_t *first_rival, *rival; ///< see rsv_twins; NULL = of a variant whose triangles move
    rsv_twin_node *
        run; ///< of a variant: boxes around runs of triangles where they were at first; NULL = not yet moved
} rsv_twins_owner;

/// How far faces in the same place may lie apart at most, in this scene. @param reach, rounding out: see rsv_twins
void rsv_twins_limits(const rsv_scene_view *scene, float *reach, float *rounding);

/// Flags of a triangle in whose place lies another. @param opposite whether that one turns the other way, else the same
/// way
uint8_t rsv_twin_flags(const rsv_scene_view *scene, uint32_t triangle, bool opposite);

/// Makes the tree of the triangles that have flags and are not hidden, and puts it into the scene's view.
/// @param owner the scene's, with flags
rsv_status rsv_twins_plant(rsv_scene *scene);

/// Lists the faces that share the inner part of a triangle with it, so that few hits need a search.
/// @param scene with twins in its view
rsv_status rsv_twins_find_rivals(rsv_scene *scene);

#endif
