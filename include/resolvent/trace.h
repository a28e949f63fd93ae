/// @file trace.h
/// Rays against a committed scene. Embree is hidden behind this header.
#ifndef RESOLVENT_TRACE_H
#define RESOLVENT_TRACE_H

#include "resolvent/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct rsv_tracer rsv_tracer;

typedef struct rsv_ray {
    rsv_vec3 origin;
    rsv_vec3 direction; ///< need not be unit; t counts in its lengths
    float t_max;
} rsv_ray;

typedef struct rsv_hit {
    uint32_t triangle; ///< RSV_NONE = missed
    float t;
    float u, v; ///< barycentric weights of the triangle's corners 1 and 2
} rsv_hit;

#define RSV_PACKET_WIDTH 16

/// Sixteen rays side by side (structure of arrays, 64-byte aligned). Set `t_max` negative for lanes that
/// are not in use. After rsv_tracer_closest_packet, `triangle` is RSV_NONE for misses; after
/// rsv_tracer_occluded_packet, `t_max` is -INFINITY for blocked rays.
typedef struct rsv_ray_packet {
    float origin_x[16], origin_y[16], origin_z[16], t_min[16];
    float direction_x[16], direction_y[16], direction_z[16], time[16];
    float t_max[16]; ///< in: length; out: distance of the hit
    uint32_t mask[16], id[16], flags[16];
    float normal_x[16], normal_y[16], normal_z[16]; ///< geometric normal, not unit, front side
    float u[16], v[16];
    uint32_t triangle[16];
    uint32_t geometry[16], instance[16], reserved[16]; ///< the tracer's own
} __attribute__((aligned(64))) rsv_ray_packet;

/// Builds the bounding volume hierarchy. The scene must outlive the tracer.
RSV_API rsv_status rsv_tracer_create(const rsv_scene *scene, rsv_tracer **tracer);
RSV_API void rsv_tracer_destroy(rsv_tracer *tracer);
RSV_API const rsv_scene *rsv_tracer_scene(const rsv_tracer *tracer);

/// Nearest intersection with t in (0, t_max).
RSV_API bool rsv_tracer_closest(const rsv_tracer *tracer, const rsv_ray *ray, rsv_hit *hit);

/// Whether anything lies in (0, t_max).
RSV_API bool rsv_tracer_occluded(const rsv_tracer *tracer, const rsv_ray *ray);

/// The surface point nearest to `point` among triangles seen from the side that `normal` points to (or
/// seen from either side, if there are none such). `hit->t` is the distance in metres. False if the
/// scene has no triangle.
RSV_API bool rsv_tracer_nearest(
    const rsv_tracer *tracer, rsv_vec3 point, rsv_vec3 normal, rsv_hit *hit);

/// Nearest intersection and occlusion for the sixteen lanes of a packet, through 16-, 8- or 4-wide traversal, whichever the
/// CPU runs natively. `coherent` says that the rays are alike in origin and direction.
RSV_API void rsv_tracer_closest_packet(
    const rsv_tracer *tracer, rsv_ray_packet *packet, bool coherent);
RSV_API void rsv_tracer_occluded_packet(
    const rsv_tracer *tracer, rsv_ray_packet *packet, bool coherent);

/// Where a ray that leaves a surface starts: `point` moved off it, along `normal` (unit, towards the
/// side the ray leaves to), by more than the rounding error of `point` and of the intersection.
/// @param extent largest absolute coordinate that entered the computation of `point`: of its triangle
///               (rsv_triangle_extent), or of the scene for a free point (rsv_scene_extent)
RSV_API rsv_vec3 rsv_offset_origin(rsv_vec3 point, rsv_vec3 normal, float extent);
/// Where the rays of a virtual receiver start: a point that lies on a surface is moved off it to the side of
/// `normal` (unit), any other stays where it is.
RSV_API rsv_vec3 rsv_tracer_receiver_origin(
    const rsv_tracer *tracer, rsv_vec3 point, rsv_vec3 normal);
RSV_API float rsv_triangle_extent(const rsv_scene_view *scene, uint32_t triangle);
RSV_API float rsv_scene_extent(const rsv_scene_view *scene);

#ifdef __cplusplus
}
#endif

#endif
