/// What both forms of ambient occlusion share: the surface a camera ray meets, and its ambient light.
#ifndef RSV_OCCLUSION_H
#define RSV_OCCLUSION_H

#include "../light/sky.h"
#include "../operator/elements.h"
#include "resolvent/render.h"
#include "resolvent/trace.h"

typedef struct rsv_occlusion_job {
    rsv_context *context;
    const rsv_scene_view *view;
    const rsv_tracer *tracer;
    const rsv_camera *camera;
    const rsv_render_desc *desc;
    uint32_t samples; ///< directions of an estimate
    float distance;   ///< metres; what is farther away does not occlude
    rsv_sky sky;      ///< without pixels: of radiance 1 for surfaces, black for the camera
    rsv_sky_irradiance sky_irradiance;
    rsv_image *image;
} rsv_occlusion_job;

/// A surface as the camera sees it; everything counts as diffuse.
typedef struct rsv_seen_surface {
    bool hit;
    rsv_surface_point point; ///< normals on the viewer's side
    rsv_rgb ambient;         ///< radiance under the unoccluded sky
    rsv_rgb emission;        ///< of the surface, or of the sky where there is none
} rsv_seen_surface;

/// @param x, y in pixels, as rsv_camera_ray takes them
rsv_seen_surface rsv_see_surface(const rsv_occlusion_job *job, float x, float y);

rsv_status rsv_render_ray_occlusion(const rsv_occlusion_job *job);
rsv_status rsv_render_screen_occlusion(const rsv_occlusion_job *job);

#endif
