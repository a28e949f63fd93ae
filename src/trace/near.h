/// Finds the triangles around a point in the hierarchy.
#ifndef RSV_NEAR_H
#define RSV_NEAR_H

#include "resolvent/trace.h"

/// Called for triangles that may be closer than `*radius`, in no particular order. May reduce the radius to skip
/// triangles that are farther away.
typedef void (*rsv_near_visitor)(void *user, uint32_t triangle, float *radius);

void rsv_tracer_visit_near(
    const rsv_tracer *tracer, rsv_vec3 point, float radius, rsv_near_visitor visit, void *user);

/// Barycentric place of the point of a triangle that is closest to `point`, and its distance in metres.
float rsv_triangle_distance(
    const rsv_scene_view *scene, uint32_t triangle, rsv_vec3 point, float *u, float *v);

#endif
