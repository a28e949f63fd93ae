/// Receivers of direct light: a point with its normals, and the last surfaces that light passes on its way there.
///
/// Elements, pixels, probes, movers, rough lobes, residuals and devices all use it, and sample sources by next_event.h.
/// sources/partition.h says which sources they count. The path tracer deliberately has separate code
/// (reference/path_sources.h).
///
/// Plain C, also for device code.
#ifndef RSV_RECEIVER_H
#define RSV_RECEIVER_H

#include "../media/fog_run.h"
#include "../sources/lights.h"
#include "../surface/entry.h"
#include "../surface/lift.h"
#include "../surface/medium.h"

/// A point that receives light from above its surface. No pointers: devices get arrays of them.
typedef struct rsv_receiver {
    rsv_surface_point point;
    rsv_vec3 origin; ///< off the surface: where rays start that do not graze it
} rsv_receiver;

/// A point of a triangle. @param point of it; lifted here where the triangle stands for a curved surface
RSV_INLINE rsv_receiver rsv_receiver_at(const rsv_scene_view *scene, const rsv_tracer *tracer,
    uint32_t triangle, float u, float v, rsv_surface_point point)
{
    rsv_receiver r;
    r.point = point;
    rsv_surface_lift(scene, tracer, triangle, u, v, &r.point);
    r.origin = rsv_moved_off(point.position, point.geometric, point.extent);
    return r;
}

/// A point that lies on no surface. @param origin of its rays
RSV_INLINE rsv_receiver rsv_receiver_in_space(rsv_vec3 position, rsv_vec3 normal, rsv_vec3 origin)
{
    rsv_receiver r;
    r.point.position = position;
    r.point.normal = r.point.geometric = r.point.horizon = normal;
    r.point.lift = v3(0, 0, 0);
    r.point.extent = 0;
    r.origin = origin;
    return r;
}

/// The same point of the surface's other side, which is not lifted.
RSV_INLINE rsv_receiver rsv_receiver_below(const rsv_receiver *above)
{
    rsv_receiver r = *above;
    r.point.normal = v3_neg(r.point.normal);
    r.point.geometric = r.point.horizon = v3_neg(r.point.geometric);
    r.point.lift = v3(0, 0, 0);
    r.origin = rsv_moved_off(r.point.position, r.point.geometric, r.point.extent);
    return r;
}

/// Where a ray that leaves along unit `direction` starts.
RSV_INLINE rsv_vec3 rsv_receiver_start(const rsv_receiver *r, rsv_vec3 direction)
{
    return rsv_lifted_origin(&r->point, r->origin, direction);
}

/// The layer over a receiver.
typedef enum rsv_cover {
    RSV_COVER_NONE,
    RSV_COVER_COAT, ///< of the point
    RSV_COVER_PATCH ///< on average over the element around it
} rsv_cover;

/// How a receiver transmits and weights incoming light. Pointers are borrowed.
typedef struct rsv_entrance {
    const rsv_bsdf *bsdf;     ///< [material_count]
    const rsv_medium *medium; ///< above the receiver
    rsv_cover cover;
    const rsv_bsdf *coat;           ///< RSV_COVER_COAT
    const rsv_surface_entry *patch; ///< RSV_COVER_PATCH
    rsv_rgb weight;                 ///< of irradiance, in the estimate
} rsv_entrance;

/// @param medium, bsdf borrowed
RSV_INLINE rsv_entrance rsv_entrance_through(
    const rsv_medium *medium, const rsv_bsdf *bsdf, rsv_cover cover)
{
    rsv_entrance e;
    e.bsdf = bsdf;
    e.medium = medium;
    e.cover = cover;
    e.coat = NULL;
    e.patch = NULL;
    e.weight = rgb_gray(1);
    return e;
}

/// Weight of light at that cosine, as irradiance below the cover.
RSV_INLINE rsv_rgb rsv_entrance_share(const rsv_entrance *e, float cos)
{
    if (e->cover == RSV_COVER_COAT) return rsv_bsdf_entry(e->coat, cos);
    if (e->cover == RSV_COVER_PATCH) return rsv_surface_entry_at(e->patch, e->bsdf, cos);
    return rgb_gray(1);
}

/// Transmittance of fog from a point to a source. Devices get no scenes with fog.
RSV_INLINE rsv_rgb rsv_air_transmittance(
    const rsv_lights *lights, rsv_vec3 point, rsv_vec3 towards, float distance)
{
#if !defined(RSV_DEVICE_CODE)
    const rsv_fog *fog = lights->scene->fog;
    if (fog)
        return rsv_fog_transmittance(fog, rsv_fog_run_of(fog, point, towards, distance).column);
#endif
    (void)lights, (void)point, (void)towards, (void)distance;
    return rgb_gray(1);
}

/// Weight of light from a source at that distance.
RSV_INLINE rsv_rgb rsv_entrance_weight(const rsv_entrance *e, float distance)
{
    return rgb_mul(e->weight, rsv_medium_transmittance(e->medium, e->bsdf, distance));
}

#endif
