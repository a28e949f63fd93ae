/// Places on what has an irradiance, and which of them count.
#ifndef RSV_SURFACE_POINTS_H
#define RSV_SURFACE_POINTS_H

#include "../elements/cell_visibility.h"
#include "../elements/elements.h"
#include "../solve/light.h"

/// A place on a face of the elements.
typedef struct rsv_face_point {
    uint32_t face;
    float u, v;
} rsv_face_point;

/// What is seen of a scene's surfaces: judged by its geometry alone, alike for solutions of every quality.
typedef struct rsv_visible_surface {
    const rsv_transport_scene *scene;
    const rsv_elements *elements; ///< whose faces points lie on
    float contact;                ///< m: what is closer above a point touches it
} rsv_visible_surface;

/// Edge of the patch that the finest stored light around a point stands for: normal maps are averaged over it where light
/// is judged, as elements average them (rsv_direct_width). What is finer pixels add themselves.
float rsv_point_width(const rsv_light_view *solution, const rsv_face_point *point);

rsv_visible_surface rsv_visible_surface_of(
    const rsv_transport_scene *scene, const rsv_elements *elements);

/// Whether a point lies inside other geometry, in touch with it, or under a face in the same place that hides it
/// (scene/twins.h): nobody sees its light. What elements merely do without, because something hangs close above it, counts.
bool rsv_point_is_buried(
    const rsv_visible_surface *surface, const rsv_face_point *point, uint32_t seed, uint64_t *rays);

#endif
