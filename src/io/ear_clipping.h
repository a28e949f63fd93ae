/// Polygons in space as triangles.
#ifndef RSV_EAR_CLIPPING_H
#define RSV_EAR_CLIPPING_H

#include "resolvent/scene.h"

/// Cuts a polygon, convex or not, by clipping ears in the plane that it lies in best; what has no ears left, as it crosses
/// itself, like a fan. Polygons of very many corners are fans, too.
/// @param corner [count] vertices of the polygon, count >= 3 @param cut [3 * (count - 2)] out: places in `corner`
rsv_status rsv_clip_ears(rsv_context *context, const rsv_vec3 *position, const int64_t *corner,
    size_t count, uint32_t *cut);

#endif
