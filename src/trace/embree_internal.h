/// Shared by the files that use Embree.
#ifndef RSV_EMBREE_INTERNAL_H
#define RSV_EMBREE_INTERNAL_H

#include "tracer_internal.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

struct rsv_tracer {
    rsv_tracer_head head;
    RTCDevice device;
    RTCScene bvh;
    int native_width; ///< widest packet the processor traverses natively: 16, 8, 4 or 1
    uint32_t *apart;  ///< [apart_count] triangles of the second geometry; NULL = there is but one
    size_t apart_count;
    bool apart_attached; ///< there is that geometry
};

/// Geometries: the scene's triangles under their own numbers, and those set apart.
enum { SCENE_GEOMETRY, APART_GEOMETRY };

/// The scene's number of a triangle.
static inline uint32_t triangle_of(const rsv_tracer *tracer, uint32_t geometry, uint32_t primitive)
{
    return geometry == APART_GEOMETRY ? tracer->apart[primitive] : primitive;
}

#endif
