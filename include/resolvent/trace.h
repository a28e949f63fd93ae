/// @file trace.h
/// Ray tracing in a committed scene. Embree is hidden behind this header.
#ifndef RESOLVENT_TRACE_H
#define RESOLVENT_TRACE_H

#include "resolvent/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct rsv_tracer rsv_tracer;

typedef struct rsv_ray {
    rsv_vec3 origin;
    rsv_vec3 direction; ///< of any length, which is the unit of t
    float t_max;
} rsv_ray;

typedef struct rsv_hit {
    uint32_t triangle; ///< RSV_NONE = missed
    float t;
    float u, v; ///< barycentric weights of corners 1 and 2 of the triangle
} rsv_hit;

#define RSV_PACKET_WIDTH 16

/// Sixteen rays side by side (structure of arrays, 64-byte aligned). Set `t_max` negative for unused lanes. After
/// rsv_tracer_closest_packet, `triangle` is RSV_NONE for misses; after rsv_tracer_occluded_packet, `t_max` is -INFINITY
/// for blocked rays.
typedef struct rsv_ray_packet {
    float origin_x[16], origin_y[16], origin_z[16], t_min[16];
    float direction_x[16], direction_y[16], direction_z[16], time[16];
    float t_max[16]; ///< in: length; out: distance of the hit
    uint32_t mask[16], id[16], flags[16];
    float normal_x[16], normal_y[16], normal_z[16]; ///< geometric normal, not unit, front side
    float u[16], v[16];
    uint32_t triangle[16];
    uint32_t geometry[16], instance[16], reserved[16]; ///< for the tracer's own use
} __attribute__((aligned(64))) rsv_ray_packet;

/// Builds the bounding volume hierarchy. The scene must outlive the tracer.
RSV_API rsv_status rsv_tracer_create(const rsv_scene *scene, rsv_tracer **tracer);
RSV_API void rsv_tracer_destroy(rsv_tracer *tracer);
RSV_API const rsv_scene *rsv_tracer_scene(const rsv_tracer *tracer);

/// Nearest intersection with t in (0, t_max).
RSV_API bool rsv_tracer_closest(const rsv_tracer *tracer, const rsv_ray *ray, rsv_hit *hit);

/// Whether there is an intersection with t in (0, t_max).
RSV_API bool rsv_tracer_occluded(const rsv_tracer *tracer, const rsv_ray *ray);

/// The surface point nearest to `point`, on triangles seen from the side that `normal` points to, or from either side
/// if there are no such triangles. `hit->t` is the distance in metres.
/// @return false if the scene has no triangles
RSV_API bool rsv_tracer_nearest(
    const rsv_tracer *tracer, rsv_vec3 point, rsv_vec3 normal, rsv_hit *hit);

/// Nearest intersection and occlusion for the sixteen lanes of a packet, with the traversal width (16, 8 or 4) of the
/// CPU.
/// @param coherent whether the rays have similar origins and directions
RSV_API void rsv_tracer_closest_packet(
    const rsv_tracer *tracer, rsv_ray_packet *packet, bool coherent);
RSV_API void rsv_tracer_occluded_packet(
    const rsv_tracer *tracer, rsv_ray_packet *packet, bool coherent);

/// Origin of a ray that leaves a surface: `point`, moved along `normal` (unit, towards the side of the ray) by more
/// than the rounding error of `point` and of intersections.
/// @param extent largest absolute coordinate in the computation of `point`: that of its triangle (rsv_triangle_extent),
/// or of
///               the scene for a free point (rsv_scene_extent)
RSV_API rsv_vec3 rsv_offset_origin(rsv_vec3 point, rsv_vec3 normal, float extent);
/// Origin of the rays of a virtual receiver: a point on a surface is moved off it, to the side of `normal` (unit);
/// other points are not moved.
RSV_API rsv_vec3 rsv_tracer_receiver_origin(
    const rsv_tracer *tracer, rsv_vec3 point, rsv_vec3 normal);
RSV_API float rsv_triangle_extent(const rsv_scene_view *scene, uint32_t triangle);
RSV_API float rsv_scene_extent(const rsv_scene_view *scene);

#ifdef __cplusplus
}
#endif

#endif
