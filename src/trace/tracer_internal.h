/// Common first part of all tracers: with Embree (embree_internal.h) and without (own_internal.h).
#ifndef RSV_TRACER_INTERNAL_H
#define RSV_TRACER_INTERNAL_H

#include "../bvh/bvh.h"
#include "resolvent/trace.h"

#include <pthread.h>

/// A hierarchy of all triangles for devices; built on demand.
typedef struct rsv_device_hierarchy {
    pthread_mutex_t lock;
    rsv_bvh bvh;
} rsv_device_hierarchy;

typedef struct rsv_tracer_head {
    rsv_context *context;
    const rsv_scene *scene;
    rsv_device_hierarchy *hierarchy;
    const rsv_scene_view *twins; ///< the scene, if faces of it lie in the same place; else NULL
    bool blended;                ///< light passes some surfaces in part (passage.h)
} rsv_tracer_head;

/// @param scene committed
/// @param head zeroed; end it even after an error
rsv_status rsv_tracer_head_begin(const rsv_scene *scene, rsv_tracer_head *head);
void rsv_tracer_head_end(rsv_tracer_head *head);

/// Finds out whether the scene has duplicate faces. Call it at first and whenever the scene has moved.
void rsv_tracer_head_find_twins(rsv_tracer_head *head);

static inline const rsv_tracer_head *rsv_tracer_head_of(const rsv_tracer *tracer)
{
    return (const rsv_tracer_head *)tracer;
}

#endif
