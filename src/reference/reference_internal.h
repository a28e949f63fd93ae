/// The path tracer behind rsv_render_reference and rsv_probe_reference.
#ifndef RSV_REFERENCE_INTERNAL_H
#define RSV_REFERENCE_INTERNAL_H

#include "../connect/connect.h"
#include "../sources/fog_lights.h"
#include "../sources/lights.h"
#include "../surface/medium.h"
#include "../surface/surface.h"
#include "resolvent/trace.h"
#include "subsurface.h"

/// What paths are traced through; constant after creation and thread-safe.
typedef struct rsv_path_tracer {
    rsv_context *context;
    const rsv_scene_view *scene;
    rsv_tracer *tracer;
    rsv_bsdf *bsdf; ///< [material_count]
    rsv_lights *lights;
    rsv_bodies *bodies; ///< translucent ones
    rsv_media media;
    const rsv_fog *fog; ///< the scene's; NULL = clear air
    rsv_fog_lights fog_lights;
    /// What mirrors and glass make of punctual lights; NULL = nothing, or left out.
    rsv_connections *connections;
    bool blended; ///< some surfaces do not cover all that is behind them
} rsv_path_tracer;

/// @param connected paths are connected with punctual lights by way of mirrors and glass; else a warning tells of what is
/// left out, if anything
rsv_status rsv_path_tracer_create(const rsv_scene *scene, bool connected, rsv_path_tracer **tracer);
void rsv_path_tracer_destroy(rsv_path_tracer *tracer);

/// Light is told apart by its diffuse reflections, 0, 1, ...; the last order collects the rest.
#define RSV_PATH_ORDERS 9

/// What one path found, W/(sr m2).
typedef struct rsv_path_light {
    rsv_rgb order[RSV_PATH_ORDERS];
} rsv_path_light;

/// One path of a randomised quasi-random set: paths that share `stream` and differ in `sample`
/// (0, 1, ...) are stratified against each other; different streams are independent.
typedef struct rsv_path_id {
    uint32_t sample, stream;
} rsv_path_id;

/// Radiance that arrives along a camera ray. @param medium the camera's
void rsv_trace_camera_path(const rsv_path_tracer *tracer, const rsv_ray *ray,
    const rsv_medium *medium, rsv_path_id id, rsv_path_light *light);

/// Radiance that a white Lambert surface at `point` would reflect (irradiance / pi). Order 0 stays
/// black.
/// @param point possibly on a surface, whose side `normal` (unit) tells
/// @param medium above it
void rsv_trace_receiver_path(const rsv_path_tracer *tracer, rsv_vec3 point, rsv_vec3 normal,
    const rsv_medium *medium, rsv_path_id id, rsv_path_light *light);

/// The same of a point of a surface, of the light that enters it to be scattered diffusely.
/// @param point with the side that receives @param normal that it receives by
void rsv_trace_entering_path(const rsv_path_tracer *tracer, rsv_body_point point, rsv_vec3 normal,
    const rsv_medium *medium, rsv_path_id id, rsv_path_light *light);

/// Sum over the orders.
rsv_rgb rsv_path_light_total(const rsv_path_light *light);

#endif
