/// Finds where light that leaves a translucent body at a given point entered it: probe rays through the body along
/// three axes, combined by multiple importance sampling over axes and channels (King et al. 2013, "BSSRDF importance
/// sampling").
///
/// The model is that of diffusion/scatter_sources.h: a body is the surface of one object, material and side. The
/// profile depends on the straight distance, divided by max(1, N) of the two ends. N is the integral of the profile
/// over the body, estimated here by the same probe rays at points distributed over it.
#ifndef RSV_REFERENCE_SUBSURFACE_H
#define RSV_REFERENCE_SUBSURFACE_H

#include "../core/core.h"
#include "../core/index_map.h"
#include "../core/sampling.h"
#include "../subsurface/scatter_profile.h"
#include "resolvent/trace.h"

/// N of one body.
typedef struct rsv_body_sums {
    uint64_t key; ///< object and material
    double area;  ///< m2
    size_t count;
    rsv_vec3 *point; ///< [count]
    rsv_rgb *sum;    ///< [count]
    uint32_t *next;  ///< [count] of the same cell of a grid, RSV_NONE = last
    float cell;      ///< metres, also the radius of averages
    rsv_index_map grid;
} rsv_body_sums;

typedef struct rsv_bodies {
    rsv_context *context;
    const rsv_scene_view *scene;
    const rsv_tracer *tracer;
    size_t count;
    rsv_body_sums *body;          ///< [count]
    uint32_t *triangle_body;      ///< [triangle_count] RSV_NONE = light leaves where it entered
    rsv_scatter_profile *profile; ///< [material_count]
} rsv_bodies;

/// Finds the scene's translucent bodies and estimates their N. @param tracer borrowed
rsv_status rsv_bodies_create(const rsv_scene *scene, const rsv_tracer *tracer, rsv_bodies **bodies);
void rsv_bodies_destroy(rsv_bodies *bodies);

/// A point of a body.
typedef struct rsv_body_point {
    rsv_vec3 point;
    rsv_vec3 geometric; ///< unit, of either side
    uint32_t triangle;
    float u, v;
} rsv_body_point;

/// Samples the point where light that leaves at `exit` entered. False if none was found: the light is lost.
/// @param weight contribution / density, to multiply by the albedo
bool rsv_bodies_sample_entry(const rsv_bodies *bodies, const rsv_body_point *exit,
    rsv_random *random, rsv_body_point *entry, rsv_rgb *weight);

#endif
