/// @file render.h
/// Pictures and point readings from a solution, and from the reference path tracer.
#ifndef RESOLVENT_RENDER_H
#define RESOLVENT_RENDER_H

#include "resolvent/image.h"
#include "resolvent/solve.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum rsv_render_mode {
    RSV_RENDER_OPERATOR,  ///< camera paths + lookup of the solved light
    RSV_RENDER_FINAL,     ///< direct light per pixel, the rest from the operator
    RSV_RENDER_REFERENCE, ///< unbiased path tracing; needs no solution
    RSV_RENDER_OCCLUSION, ///< the classic baseline: ambient occlusion by rays, times ambient light
    RSV_RENDER_OCCLUSION_SCREEN ///< the same from the depth buffer alone
} rsv_render_mode;

/// See rsv_render_desc.noise.
#define RSV_MOST_SAMPLES 64

/// Start from rsv_default_render_desc().
typedef struct rsv_render_desc {
    size_t size; ///< of this structure; rsv_default_render_desc() sets it
    rsv_render_mode mode;
    uint32_t width, height;
    uint32_t samples; ///< camera rays per pixel (box filter)
    /// Modes operator and final: wanted standard error of a pixel, as a share of what is around it; the noisy ones get up
    /// to RSV_MOST_SAMPLES times as many camera rays. Default 0 = `samples` everywhere.
    float noise;
    uint32_t camera; ///< index in the scene
    /// Modes operator, final and reference: a camera that is not in the scene, instead; borrowed. NULL = none
    const rsv_camera *viewpoint;
    /// Likewise: what the camera's film does. Default: a pinhole camera. Rough coats are seen with more noise without one.
    rsv_film_desc film;
    uint32_t
        gather_rays; ///< mode final: gather rays per camera ray, 0 = look the indirect light up;
                     ///< modes occlusion: rays or points per surface seen, 0 = 16
    /// Modes occlusion: metres beyond which nothing occludes; 0 = none (rays), a twentieth of the scene's
    /// diagonal (screen).
    float occlusion_distance;
    uint32_t path_depth; ///< mirror and glass events along a camera ray at most; default 64
    /// Modes operator and final: all pixels take their samples at the same places, the first at their centre,
    /// as frames do (frame.h); else each has a pattern of its own, and noise may be reduced as above and by shooting
    /// light at matt coats.
    bool shared_pattern;
    bool layers; ///< add one layer per order of T^n Le: emission, direct, bounce1, ...
    uint32_t seed;
} rsv_render_desc;

/// Defaults, for a descriptor of `size` bytes: what rsv_default_render_desc() is made of.
RSV_API void rsv_render_desc_init(rsv_render_desc *desc, size_t size);
static inline rsv_render_desc rsv_default_render_desc(void)
{
    rsv_render_desc desc;
    rsv_render_desc_init(&desc, sizeof desc);
    return desc;
}

/// Renders modes operator and final.
RSV_API rsv_status rsv_render(
    const rsv_light *light, const rsv_render_desc *desc, rsv_image **image);

/// Renders the modes occlusion: albedo times unoccluded share of the hemisphere times what a white surface would
/// reflect of the environment, or of a sky of radiance 1 where there is none, plus emission. Every surface counts as
/// diffuse, lights other than the environment are left out. The form by rays converges to the cosine-weighted share (Zhukov
/// et al. 1998); the screen-space form takes one camera ray per pixel.
RSV_API rsv_status rsv_render_occlusion(
    const rsv_scene *scene, const rsv_render_desc *desc, rsv_image **image);

/// The modes occlusion for many pictures of one scene: ray tracer and buffers are kept. Where the context has a device
/// that can, the pictures are made there.
typedef struct rsv_occlusion rsv_occlusion;

/// The scene must outlive it.
RSV_API rsv_status rsv_occlusion_create(
    const rsv_scene *scene, const rsv_render_desc *desc, rsv_occlusion **occlusion);
RSV_API void rsv_occlusion_destroy(rsv_occlusion *occlusion);

/// @param image of the size asked for at creation
RSV_API rsv_status rsv_occlusion_render(
    rsv_occlusion *occlusion, const rsv_camera *camera, rsv_image *image);

/// Renders mode reference: next-event estimation and BSDF sampling combined by MIS, Russian roulette.
/// With desc->layers: emission, direct, bounce1, ... by the number of diffuse reflections.
/// @param standard_error of the picture's mean luminance, relative to it; may be NULL
RSV_API rsv_status rsv_render_reference(
    const rsv_scene *scene, const rsv_render_desc *desc, rsv_image **image, double *standard_error);

typedef enum rsv_probe_mode {
    RSV_PROBE_LOOKUP,   ///< the stored solution at the nearest surface point
    RSV_PROBE_OPERATOR, ///< one gather through it, direct light sampled (default)
    RSV_PROBE_REFERENCE ///< path traced
} rsv_probe_mode;

typedef struct rsv_probe_reading {
    rsv_rgb irradiance; ///< W/m2
    /// W/m2, from independent randomisations. In modes that read a solution what all readings share enters too: the noise of
    /// stored light, of caustics above all, and what interpolation misses, as far as fields depart from planes.
    rsv_rgb standard_error;
} rsv_probe_reading;

/// How readings are taken.
typedef struct rsv_probe_desc {
    size_t size; ///< of this structure; rsv_default_probe_desc() sets it
    rsv_probe_mode mode;
    uint32_t
        samples; ///< gather rays (operator) or paths (reference) per probe; rounded up to 32 equal groups; default 4096
    uint32_t seed; ///< another set of random numbers; default 0
} rsv_probe_desc;

/// Defaults, for a descriptor of `size` bytes: what rsv_default_probe_desc() is made of.
RSV_API void rsv_probe_desc_init(rsv_probe_desc *desc, size_t size);
static inline rsv_probe_desc rsv_default_probe_desc(void)
{
    rsv_probe_desc desc;
    rsv_probe_desc_init(&desc, sizeof desc);
    return desc;
}

/// Of scenes far from the origin, probes are less rsv_scene_view.origin, as all coordinates are.
/// @param desc copied @param probes [probe_count] @param readings [probe_count], out
RSV_API rsv_status rsv_probe_irradiance(const rsv_light *light, const rsv_probe_desc *desc,
    const rsv_probe *probes, size_t probe_count, rsv_probe_reading *readings);

/// Irradiance on the first surface that a camera sees at a place of its picture, on the side that it sees, W/m2.
/// @param width, height of the picture, pixels @param place x to the right and y down, each from 0 to 1
/// @return false where it sees no surface that stores light: nothing, or mirrors and clear glass
RSV_API bool rsv_read_picture_point(const rsv_light *light, const rsv_camera *camera,
    uint32_t width, uint32_t height, const float place[2], rsv_rgb *irradiance);

/// Path-traced readings; needs no solution. @param samples, seed as in rsv_probe_desc
RSV_API rsv_status rsv_probe_reference(const rsv_scene *scene, const rsv_probe *probes,
    size_t probe_count, uint32_t samples, uint32_t seed, rsv_probe_reading *readings);

/// A point of one side of a triangle.
typedef struct rsv_surface_place {
    uint32_t triangle; ///< of the scene
    float u, v;        ///< barycentric
    bool back;
    float width; ///< metres: edge of the patch that its normal map is averaged over
} rsv_surface_place;

/// Path-traced irradiance of surfaces: by their normal maps, averaged over patches, and without the light that coats keep
/// from what scatters diffusely below. What elements hold, and what bakes write.
/// @param samples, seed as in rsv_probe_desc @param readings [count], out
RSV_API rsv_status rsv_surface_reference(const rsv_scene *scene, const rsv_surface_place *places,
    size_t count, uint32_t samples, uint32_t seed, rsv_probe_reading *readings);

#ifdef __cplusplus
}
#endif

#endif
