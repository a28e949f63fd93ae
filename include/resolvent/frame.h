/// @file frame.h
/// Pictures at interactive rates from a solution, in mode `operator`.
///
/// A renderer stores the light of all plain diffuse surfaces in one table, so that a pixel there costs a camera ray and
/// a lookup. Mirrors, glass, textures and translucent surfaces also cost a specular path. A frame takes one sample per
/// pixel, at the same place in all pixels. While cameras rest, frames add up to the picture that rsv_render makes with
/// rsv_render_desc.shared_pattern and as many samples. Rendering a frame allocates no memory.
#ifndef RESOLVENT_FRAME_H
#define RESOLVENT_FRAME_H

#include "resolvent/mover.h"
#include "resolvent/render.h"

#ifdef __cplusplus
extern "C" {
#endif

/// SIMD instructions for frames. All give the same picture, bit for bit.
typedef enum rsv_instructions {
    RSV_INSTRUCTIONS_BEST, ///< the widest that the CPU supports
    RSV_INSTRUCTIONS_PORTABLE,
    RSV_INSTRUCTIONS_AVX2,
    RSV_INSTRUCTIONS_AVX512
} rsv_instructions;

/// "best", "portable", "avx2", "avx512"; NULL if out of range.
RSV_API const char *rsv_instructions_name(rsv_instructions instructions);

#define RSV_MAX_EYES 2

/// How frames compute the reflections of rough surfaces.
typedef enum rsv_frame_gloss {
    RSV_GLOSS_PATHS, ///< one random path per pixel and frame: unbiased, noisy, slow
    /// A few rays per frame, which end at the first surface. Their light is reused in later frames and by neighbouring
    /// pixels. Smooth and fast, but an approximation while the camera moves. Edges are smoothed with the samples of up
    /// to eight frames, reprojected. Very rough lobes reflect the irradiance. While the camera rests, some pixels of
    /// each frame also take a random path, and the picture converges to that of RSV_GLOSS_PATHS. With a moving object
    /// (rsv_frame_renderer_put), it remains an approximation. Ignored if a device renders the frames. The default
    RSV_GLOSS_REUSED
} rsv_frame_gloss;

/// What frames converge to while the cameras rest.
typedef enum rsv_frame_rest {
    RSV_REST_OPERATOR, ///< mode `operator`: paths end at stored light. The default
    /// Mode `final`: direct light is sampled at the ends of paths too, which makes shadows sharp. Does not apply to
    /// single layers, moving objects and frames of a device
    RSV_REST_FINAL
} rsv_frame_rest;

/// Options of a frame renderer. Start from rsv_default_frame_desc().
typedef struct rsv_frame_desc {
    size_t size;            ///< sizeof this structure; rsv_default_frame_desc() sets it
    uint32_t width, height; ///< of one eye's picture
    uint32_t eyes;          ///< pictures per frame, which differ only in the camera: 1 or 2
    uint32_t
        path_depth; ///< maximum number of mirror and glass events along a camera ray; default 8
    uint32_t seed;  ///< for rough reflections and faint branches
    rsv_instructions instructions;
    rsv_frame_gloss gloss; ///< default RSV_GLOSS_REUSED
    rsv_frame_rest rest;
    /// Number of frames that will be rendered of one view. Their samples are spread evenly over the pixel, and
    /// preparations that pay off only over many frames are skipped. Default 0 = not known.
    uint32_t frames;
} rsv_frame_desc;

/// Writes defaults to a descriptor of `size` bytes. Usually called through rsv_default_frame_desc().
RSV_API void rsv_frame_desc_init(rsv_frame_desc *desc, size_t size);
static inline rsv_frame_desc rsv_default_frame_desc(void)
{
    rsv_frame_desc desc;
    rsv_frame_desc_init(&desc, sizeof desc);
    return desc;
}

/// Milliseconds of the last frame, and its rays.
typedef struct rsv_frame_stats {
    double total_ms;
    double camera_ms; ///< camera rays and lookups, mean over the threads
    double path_ms; ///< specular paths: mirrors, glass and everything else that is not in the table
    double gloss_ms;   ///< rays of rough lobes and their reuse (RSV_GLOSS_REUSED)
    double display_ms; ///< accumulation and tone mapping
    uint64_t path_rays;
    uint64_t gloss_rays; ///< of rough lobes
    uint32_t samples;    ///< number of frames accumulated
} rsv_frame_stats;

typedef struct rsv_frame_renderer rsv_frame_renderer;

/// The solution must outlive the renderer. Builds a ray-tracing hierarchy if there is none yet, in about a second per
/// million triangles.
RSV_API rsv_status rsv_frame_renderer_create(
    const rsv_light *light, const rsv_frame_desc *desc, rsv_frame_renderer **renderer);
RSV_API void rsv_frame_renderer_destroy(rsv_frame_renderer *renderer);

/// Cameras and tone mapping of a frame.
typedef struct rsv_frame_view {
    rsv_camera camera[RSV_MAX_EYES];
    float exposure; ///< stops: the picture shows radiance x 2^exposure
    /// Compress highlights by x (1 + x / 16) / (1 + x) (Reinhard et al. 2002); false = clip them
    bool soft;
} rsv_frame_view;

/// Renders one more frame. Accumulation starts over if a camera has moved.
/// @param stats may be NULL
RSV_API rsv_status rsv_frame_render(
    rsv_frame_renderer *renderer, const rsv_frame_view *view, rsv_frame_stats *stats);

/// Changes the size of later frames, up to the size at creation, without allocating memory. Accumulation starts over.
/// @return RSV_ERROR_ARGUMENT for larger sizes and 0; RSV_ERROR_UNSUPPORTED on a device
RSV_API rsv_status rsv_frame_renderer_resize(
    rsv_frame_renderer *renderer, uint32_t width, uint32_t height);

/// Selects the light that later frames show.
/// @param layer RSV_NONE = all; 0 = emission, 1 = direct, 1 + n = n bounces
RSV_API void rsv_frame_renderer_show(rsv_frame_renderer *renderer, uint32_t layer);

/// Reads the solution's light again after it has changed, and starts over. Costs about as much as a frame. Reused light
/// of rough lobes gets less weight the more the light has changed anywhere, and none if it has changed by a sixteenth
/// or more.
RSV_API void rsv_frame_renderer_refresh(rsv_frame_renderer *renderer);

/// Shows a moving object and its shadow; NULL = none. Single layers do not include it. Call it again whenever the
/// object was placed or lit again. Accumulation starts over.
/// @param mover of the same solution; borrowed
RSV_API void rsv_frame_renderer_put(rsv_frame_renderer *renderer, const rsv_mover *mover);

/// The displayed picture, of the size of frames: [height * width] red, green, blue and 255, sRGB. Valid until the
/// renderer is destroyed.
RSV_API const uint8_t (*rsv_frame_pixels(const rsv_frame_renderer *renderer, uint32_t eye))[4];

/// Mean radiance of the accumulated frames. @param radiance out, [height * width]
RSV_API void rsv_frame_radiance(
    const rsv_frame_renderer *renderer, uint32_t eye, rsv_rgb *radiance);

/// The instructions in use, never RSV_INSTRUCTIONS_BEST.
RSV_API rsv_instructions rsv_frame_instructions(const rsv_frame_renderer *renderer);

/// Renders mode operator as a sum of frames, many times as fast as rsv_render. These are passed to rsv_render instead:
/// depth of field, projections, shifted films, layers, noise targets, teams and, with RSV_GLOSS_PATHS, scenes with
/// rough surfaces, whose random reflections have less noise there.
/// @param desc as for rsv_render, with the same errors
/// @param gloss RSV_GLOSS_PATHS = unbiased; RSV_GLOSS_REUSED = fast and smooth, slightly biased
RSV_API rsv_status rsv_render_operator(
    const rsv_light *light, const rsv_render_desc *desc, rsv_frame_gloss gloss, rsv_image **image);

/// The camera of one of two eyes, moved sideways. @param eye 0 = left @param separation metres between the eyes

RSV_API rsv_camera rsv_camera_eye(const rsv_camera *camera, uint32_t eye, float separation);

#ifdef __cplusplus
}
#endif

#endif
