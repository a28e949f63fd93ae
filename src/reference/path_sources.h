/// A path of the reference, and the light of sources that it finds: by next-event estimation at its surfaces, combined
/// with sources that it hits by the power heuristic with exponent 2 (Veach and Guibas 1995).
///
/// All other code uses receiver/next_event.h. Paths deliberately do not: the reference should share as little as
/// possible with the code that it checks. What they share is the list of sources and how to sample a point on one
/// (sources/lights.h), which tests compare with exact answers.
#ifndef RSV_PATH_SOURCES_H
#define RSV_PATH_SOURCES_H

#include "path_fog.h"
#include "path_surface.h"

typedef struct rsv_path_numbers {
    rsv_path_id id;
    uint32_t pairs_taken;
    rsv_random random;
} rsv_path_numbers;

typedef struct rsv_light_path {
    const rsv_path_tracer *tracer;
    rsv_path_numbers numbers;
    rsv_ray ray;
    rsv_vec3 departure;  ///< point of the surface that the ray left
    rsv_rgb throughput;  ///< of basic radiance (surface/medium.h)
    rsv_medium medium;   ///< that the ray runs through
    rsv_channel channel; ///< of its light, once a body has dispersed it
    float start_ior;     ///< of the medium that the path started in
    bool settled;        ///< has hit the surface of a body, so the medium at its start is known
    rsv_vec3 sight;     ///< direction of the camera's ray; 0 = there is none
    uint32_t bounces, diffuse_events;
    /// With which the last surface chose the ray; 0 = next-event estimation could not have sampled what the ray hits.
    float pdf_solid_angle;
    float passed; ///< metres since then, past surfaces that did not cover
    /// The lights of next-event estimation as seen from the last surface, above and below it. The ray left on one of
    /// these sides.
    rsv_local_lights local[2];
    bool aimed[2]; ///< whether they are set
    bool below;
    rsv_path_light *light;
    rsv_fog_vertex vertex; ///< where it was last scattered in fog
} rsv_light_path;

/// Another pair of the path's random numbers in [0, 1).
void rsv_path_next_pair(rsv_path_numbers *numbers, float *x, float *y);

/// Adds radiance of a source in the path's medium, or of its scattered light there.
void rsv_path_add_light(
    rsv_light_path *path, uint32_t diffuse_events, rsv_rgb throughput, rsv_rgb radiance);

/// The medium on either side of a surface that the path has come to.
rsv_medium rsv_path_medium_beside(
    const rsv_light_path *path, const rsv_path_surface *s, bool below);

/// Of the surface that the ray has met at that distance, as far as it covers.
void rsv_path_add_emission(rsv_light_path *path, const rsv_path_surface *s, float distance);

/// Of the surroundings, seen by a ray that left the scene.
void rsv_path_add_environment(rsv_light_path *path);

/// Aims at the sources. Three random numbers choose one of the emitters and a point of it.
void rsv_path_gather_sources(
    rsv_light_path *path, const rsv_path_surface *s, float u_select, float u1, float u2);

#endif
