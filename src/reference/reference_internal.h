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

/// Scene data for paths. Constant after creation and thread-safe.
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
    /// Light of punctual lights through mirrors and glass; NULL = none, or omitted.
    rsv_connections *connections;
    bool blended; ///< some surfaces do not fully cover what is behind them
} rsv_path_tracer;

/// @param connected connect paths with punctual lights through mirrors and glass; false = omit this light, with a
/// warning if there is any
rsv_status rsv_path_tracer_create(const rsv_scene *scene, bool connected, rsv_path_tracer **tracer);
void rsv_path_tracer_destroy(rsv_path_tracer *tracer);

/// Light is separated by its diffuse reflections, 0, 1, ...; the last order includes all later ones.
#define RSV_PATH_ORDERS 9

/// Light found by one path, W/(sr m2).
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

/// Radiance that a white Lambert surface at `point` would reflect (irradiance / pi). Order 0 stays black.
/// @param point may be on a surface, on the side given by `normal` (unit)
/// @param medium above it
void rsv_trace_receiver_path(const rsv_path_tracer *tracer, rsv_vec3 point, rsv_vec3 normal,
    const rsv_medium *medium, rsv_path_id id, rsv_path_light *light);

/// The same for light that enters a surface at a point, to be scattered diffusely.
/// @param point with the receiving side @param normal with which it receives
void rsv_trace_entering_path(const rsv_path_tracer *tracer, rsv_body_point point, rsv_vec3 normal,
    const rsv_medium *medium, rsv_path_id id, rsv_path_light *light);

/// Sum over the orders.
rsv_rgb rsv_path_light_total(const rsv_path_light *light);

#endif
