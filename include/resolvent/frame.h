/// @file frame.h
/// Pictures at interactive rates from a solution: `operator` mode as an object that keeps what frames share.
///
/// Creating it stores the light of every plain diffuse surface in one table, so a pixel there costs a camera ray and a
/// lookup. Mirrors, glass, textures and translucent surfaces also cost a specular path. A frame takes one sample per
/// pixel, at the same place in all pixels. While cameras rest, frames add up to the picture that rsv_render makes with
/// rsv_render_desc.shared_pattern and as many samples. Nothing is allocated after creation.
#ifndef RESOLVENT_FRAME_H
#define RESOLVENT_FRAME_H

#include "resolvent/mover.h"
#include "resolvent/render.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Instructions that frames are computed with. All of them give the same picture, bit by bit.
typedef enum rsv_instructions {
    RSV_INSTRUCTIONS_BEST, ///< the widest that the CPU supports
    RSV_INSTRUCTIONS_PORTABLE,
    RSV_INSTRUCTIONS_AVX2,
    RSV_INSTRUCTIONS_AVX512
} rsv_instructions;

/// "best", "portable", "avx2", "avx512"; NULL beyond the last.
RSV_API const char *rsv_instructions_name(rsv_instructions instructions);

#define RSV_MAX_EYES 2

/// How frames find what rough surfaces reflect.
typedef enum rsv_frame_gloss {
    RSV_GLOSS_PATHS, ///< by a random path for each pixel and frame: right in the mean, noisy, slow
    /// By a few rays per frame, which end at the first surface and whose light is kept from frame to frame and shared among
    /// neighbours: smooth and fast, an approximation while the camera moves. Edges are smoothed by the samples of up to
    /// eight frames, followed to where they lie now. Very rough lobes reflect the irradiance. Where
    /// the camera rests, some pixels of each frame take a path as above, and the picture goes over to what these find as
    /// their noise falls: it converges to the same one. Where an object moves (rsv_frame_renderer_put), it stays an
    /// approximation. Ignored where a device makes the frames. The default
    RSV_GLOSS_REUSED
} rsv_frame_gloss;

/// What frames become while the cameras rest.
typedef enum rsv_frame_rest {
    RSV_REST_OPERATOR, ///< mode `operator`: paths end at the light that is stored. The default
    /// Mode `final`: direct light is sampled where paths end, too, so that shadows become as sharp as they are. Single
    /// layers, objects that move and frames of a device stay as above
    RSV_REST_FINAL
} rsv_frame_rest;

/// Start from rsv_default_frame_desc().
typedef struct rsv_frame_desc {
    size_t size;            ///< of this structure; rsv_default_frame_desc() sets it
    uint32_t width, height; ///< of one eye's picture
    uint32_t eyes;          ///< pictures per frame that share everything but the camera: 1 or 2
    uint32_t path_depth;    ///< mirror and glass events along a camera ray at most; default 8
    uint32_t seed;          ///< of rough reflections and faint branches
    rsv_instructions instructions;
    rsv_frame_gloss gloss; ///< default RSV_GLOSS_REUSED
    rsv_frame_rest rest;
    /// Frames that will be rendered of one view: their samples are spread evenly over the pixel, and preparations that
    /// only many frames repay are spared. Default 0 = as many as there is time for.
    uint32_t frames;
} rsv_frame_desc;

/// Defaults, for a descriptor of `size` bytes: what rsv_default_frame_desc() is made of.
RSV_API void rsv_frame_desc_init(rsv_frame_desc *desc, size_t size);
static inline rsv_frame_desc rsv_default_frame_desc(void)
{
    rsv_frame_desc desc;
    rsv_frame_desc_init(&desc, sizeof desc);
    return desc;
}

/// Milliseconds of the last frame, and its specular paths.
typedef struct rsv_frame_stats {
    double total_ms;
    double camera_ms;  ///< camera rays and lookups, mean over the threads
    double path_ms;    ///< mirrors, glass and all that is not in the table
    double gloss_ms;   ///< rays of rough lobes and their reuse (RSV_GLOSS_REUSED)
    double display_ms; ///< adding up and tone mapping
    uint64_t path_rays;
    uint64_t gloss_rays; ///< of rough lobes
    uint32_t samples;    ///< frames that have added up
} rsv_frame_stats;

typedef struct rsv_frame_renderer rsv_frame_renderer;

/// The solution must outlive the renderer. Builds a hierarchy of its triangles where there is none yet, about a second per
/// million.
RSV_API rsv_status rsv_frame_renderer_create(
    const rsv_light *light, const rsv_frame_desc *desc, rsv_frame_renderer **renderer);
RSV_API void rsv_frame_renderer_destroy(rsv_frame_renderer *renderer);

/// Which light to show, and how.
typedef struct rsv_frame_view {
    rsv_camera camera[RSV_MAX_EYES];
    float exposure; ///< in stops: codes are those of radiance x 2^exposure
    bool
        soft; ///< compress highlights, x (1 + x / 16) / (1 + x) (Reinhard et al. 2002), or else clip
} rsv_frame_view;

/// Renders one more frame, starting over where a camera has moved.
/// @param stats may be NULL
RSV_API rsv_status rsv_frame_render(
    rsv_frame_renderer *renderer, const rsv_frame_view *view, rsv_frame_stats *stats);

/// Makes the frames that follow smaller than the renderer was created for, or as large again: what has added up is dropped.
/// Nothing is allocated. @return RSV_ERROR_ARGUMENT: larger than that, or nothing; RSV_ERROR_UNSUPPORTED: on a device
RSV_API rsv_status rsv_frame_renderer_resize(
    rsv_frame_renderer *renderer, uint32_t width, uint32_t height);

/// Chooses the light that is shown from the next frame on.
/// @param layer RSV_NONE = all; 0 = emission, 1 = direct, 1 + n = n bounces
RSV_API void rsv_frame_renderer_show(rsv_frame_renderer *renderer, uint32_t layer);

/// Takes the solution's light over again after it has changed, and starts over. Costs about as much as a frame. Light of
/// rough lobes that was kept from frames before counts the less the more the light has changed anywhere: not at all from a
/// sixteenth on.
RSV_API void rsv_frame_renderer_refresh(rsv_frame_renderer *renderer);

/// Shows an object that moves, with its shadow, in all light but not in single layers; NULL = none. To be called again
/// whenever it was placed or lit again: frames start over.
/// @param mover of the same solution; borrowed
RSV_API void rsv_frame_renderer_put(rsv_frame_renderer *renderer, const rsv_mover *mover);

/// The picture on show, as large as frames are: [height * width] red, green, blue and 255, sRGB. Valid until the renderer is destroyed.
RSV_API const uint8_t (*rsv_frame_pixels(const rsv_frame_renderer *renderer, uint32_t eye))[4];

/// Mean radiance of the frames that have added up. @param radiance [height * width]
RSV_API void rsv_frame_radiance(
    const rsv_frame_renderer *renderer, uint32_t eye, rsv_rgb *radiance);

/// The instructions in use, never RSV_INSTRUCTIONS_BEST.
RSV_API rsv_instructions rsv_frame_instructions(const rsv_frame_renderer *renderer);

/// Renders mode operator as a sum of frames, many times as fast as rsv_render. What frames do not show goes through
/// rsv_render: depth of field, projections, shifted films, layers, noise limits, teams, and, unless `gloss` says otherwise,
/// scenes with rough surfaces, whose random reflections have less noise there.
/// @param desc as for rsv_render; errors likewise
/// @param gloss RSV_GLOSS_PATHS: right in the mean; RSV_GLOSS_REUSED: fast and smooth, and a little biased
RSV_API rsv_status rsv_render_operator(
    const rsv_light *light, const rsv_render_desc *desc, rsv_frame_gloss gloss, rsv_image **image);

/// A camera moved sideways for one of two eyes. @param eye 0 = left @param separation metres between them
RSV_API rsv_camera rsv_camera_eye(const rsv_camera *camera, uint32_t eye, float separation);

#ifdef __cplusplus
}
#endif

#endif
