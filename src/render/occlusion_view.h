/// What both forms of ambient occlusion share: the surface a camera ray meets, and its ambient light.
#ifndef RSV_OCCLUSION_VIEW_H
#define RSV_OCCLUSION_VIEW_H

#include "../light/sky.h"
#include "../operator/elements.h"
#include "../trace/camera_ray.h"
#include "resolvent/render.h"
#include "resolvent/trace.h"

/// What pictures of one scene and size share.
struct rsv_occlusion {
    rsv_context *context;
    const rsv_scene_view *view;
    rsv_tracer *tracer;
    rsv_render_desc desc;
    uint32_t samples; ///< directions of an estimate
    float distance;   ///< metres; what is farther away does not occlude
    rsv_sky sky;      ///< without pixels: of radiance 1 for surfaces, black for the camera
    rsv_sky_irradiance sky_irradiance;
    struct rsv_occlusion_screen *screen; ///< buffers of the screen-space form; NULL = by rays
};

/// One picture in the making.
typedef struct rsv_occlusion_job {
    const rsv_occlusion *shared;
    rsv_lens lens;
    rsv_image *image;
} rsv_occlusion_job;

/// A surface as the camera sees it; everything counts as diffuse.
typedef struct rsv_seen_surface {
    bool hit;
    rsv_surface_point point; ///< normals on the viewer's side
    rsv_rgb ambient;         ///< radiance under the unoccluded sky
    rsv_rgb emission;        ///< of the surface, or of the sky where there is none
} rsv_seen_surface;

/// The surfaces seen through places of the picture, traced as one packet.
/// @param count up to RSV_PACKET_WIDTH @param x, y [count] in pixels, as rsv_camera_ray takes them
void rsv_see_surfaces(const rsv_occlusion_job *job, uint32_t count, const float *x, const float *y,
    rsv_seen_surface *seen);

#endif
