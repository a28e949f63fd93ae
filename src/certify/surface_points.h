/// Random points, uniform in area over everything that has an irradiance.
#ifndef RSV_SURFACE_POINTS_H
#define RSV_SURFACE_POINTS_H

#include "../elements/elements.h"
#include "../elements/hover.h"

/// A place on a face of the elements.
typedef struct rsv_face_point {
    uint32_t face;
    float u, v;
} rsv_face_point;

/// The faces' areas, added up.
typedef struct rsv_face_areas {
    const rsv_elements *elements;
    double *below; ///< [face_count + 1] area of the faces before each, m2
} rsv_face_areas;

rsv_status rsv_face_areas_create(const rsv_elements *elements, rsv_face_areas *areas);
void rsv_face_areas_destroy(rsv_face_areas *areas);

/// All of them, m2.
double rsv_face_areas_total(const rsv_face_areas *areas);

/// Point `index` of `count`, one in each of as many strips of equal area. Different seeds are independent.
rsv_face_point rsv_face_areas_draw(
    const rsv_face_areas *areas, uint32_t index, uint32_t count, uint32_t seed);

/// Whether a point lies inside other geometry or in touch with it, where nobody sees its light. What elements merely do
/// without, because something hangs close above it, counts.
bool rsv_point_is_buried(const rsv_transport_scene *scene, const rsv_elements *elements,
    const rsv_face_point *point, uint32_t seed, uint64_t *rays);

#endif
