/// Shared by both kinds of ambient occlusion on the CPU.
#ifndef RSV_OCCLUSION_VIEW_H
#define RSV_OCCLUSION_VIEW_H

#include "occlusion_device.h"
#include "occlusion_setting.h"
#include "resolvent/render.h"
#include "resolvent/trace.h"

/// Data common to pictures of one scene and size.
struct rsv_occlusion {
    rsv_context *context;
    rsv_tracer *tracer;
    rsv_occlusion_setting setting;
    rsv_occlusion_screen *screen; ///< buffers of the screen-space form; NULL = by rays
    rsv_occlusion_device *device; ///< NULL = the processor makes them
    double seconds;               ///< that the last picture took
};

/// One picture in the making.
typedef struct rsv_occlusion_job {
    const rsv_occlusion *shared;
    rsv_lens lens;
    rsv_image *image;
} rsv_occlusion_job;

/// The surfaces seen through places of the picture, traced as one packet.
/// @param count up to RSV_PACKET_WIDTH @param x, y [count] in pixels, as rsv_camera_ray takes them
void rsv_see_surfaces(const rsv_occlusion_job *job, uint32_t count, const float *x, const float *y,
    rsv_seen_surface *seen);

#endif
