/// Points on everything that has an irradiance, and which of them count.
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

/// Visible parts of a scene's surfaces. Depends only on geometry, and is the same for solutions of every quality.
typedef struct rsv_visible_surface {
    const rsv_transport_scene *scene;
    const rsv_elements *elements; ///< whose faces points lie on
    float contact;                ///< m: geometry closer than this above a point touches it
} rsv_visible_surface;

/// Side of the patch that the finest stored light around a point represents, over which normal maps are averaged, as
/// elements do (rsv_direct_width). Pixels add finer detail.
float rsv_point_width(const rsv_light_view *solution, const rsv_face_point *point);

rsv_visible_surface rsv_visible_surface_of(
    const rsv_transport_scene *scene, const rsv_elements *elements);

/// Whether a point is inside other geometry, touches it, or is hidden by a face in the same place (scene/twins.h).
/// Points that elements only skip because something is close above them count.
bool rsv_point_is_buried(
    const rsv_visible_surface *surface, const rsv_face_point *point, uint32_t seed, uint64_t *rays);

#endif
