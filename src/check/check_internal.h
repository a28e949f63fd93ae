/// Findings in the making.
#ifndef RSV_CHECK_INTERNAL_H
#define RSV_CHECK_INTERNAL_H

#include "../core/core.h"
#include "../scene/scene.h"
#include "resolvent/check.h"

typedef struct rsv_checker {
    rsv_context *context;
    const rsv_scene *scene;
    const rsv_scene_view *view;
    rsv_finding *finding; ///< [count]
    size_t count, capacity;
    size_t told[RSV_MISTAKES]; ///< of each kind, those left out too
} rsv_checker;

/// Adds a finding, unless there are eight of its kind.
/// @param finding its text is filled in from `format`, its place is `where`
rsv_status rsv_check_tell(rsv_checker *checker, const rsv_finding *finding, const char *where,
    const char *format, ...) RSV_PRINTF(4, 5);

/// Edges of each object: faces that turn different ways, seams that are open.
rsv_status rsv_check_edges(rsv_checker *checker);

/// Faces that share all corners with another face, in any order.
rsv_status rsv_check_doubled(rsv_checker *checker);

/// Faults visible to cameras: backs, and gaps in a closed room.
rsv_status rsv_check_views(rsv_checker *checker);

/// An order of points: by x, then y, then z.
static inline int compare_places(rsv_vec3 p, rsv_vec3 q)
{
    if (p.x != q.x) return p.x < q.x ? -1 : 1;
    if (p.y != q.y) return p.y < q.y ? -1 : 1;
    return p.z != q.z ? (p.z < q.z ? -1 : 1) : 0;
}

#endif
