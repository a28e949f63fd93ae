/// Rays of code that the library and devices share.
#ifndef RSV_TRACE_RAY_H
#define RSV_TRACE_RAY_H

#include "resolvent/trace.h"

#if defined(RSV_DEVICE_CODE)

#include "../bvh/bvh_trace.h"

/// There, it is a hierarchy.
struct rsv_tracer {
    rsv_bvh_view bvh;
};

RSV_INLINE bool rsv_ray_meets(const rsv_tracer *tracer, const rsv_ray *ray, rsv_hit *hit)
{
    return rsv_bvh_closest(&tracer->bvh, ray, hit);
}

RSV_INLINE bool rsv_ray_is_stopped(const rsv_tracer *tracer, const rsv_ray *ray)
{
    return rsv_bvh_occluded(&tracer->bvh, ray);
}

#else

static inline bool rsv_ray_meets(const rsv_tracer *tracer, const rsv_ray *ray, rsv_hit *hit)
{
    return rsv_tracer_closest(tracer, ray, hit);
}

static inline bool rsv_ray_is_stopped(const rsv_tracer *tracer, const rsv_ray *ray)
{
    return rsv_tracer_occluded(tracer, ray);
}

#endif

#endif
