/// Polygons in space as triangles.
#ifndef RSV_EAR_CLIPPING_H
#define RSV_EAR_CLIPPING_H

#include "resolvent/scene.h"

/// Triangulates a polygon, convex or not, by clipping ears in its best-fitting plane. A rest without ears (a polygon
/// that crosses itself) is cut as a fan, and so are polygons with very many corners.
/// @param corner [count] vertices of the polygon, count >= 3 @param cut [3 * (count - 2)] out: indices into `corner`
rsv_status rsv_clip_ears(rsv_context *context, const rsv_vec3 *position, const int64_t *corner,
    size_t count, uint32_t *cut);

#endif
