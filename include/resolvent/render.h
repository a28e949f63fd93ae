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
    RSV_RENDER_FINAL,     ///< direct light sampled per pixel, the rest from the operator
    RSV_RENDER_REFERENCE, ///< unbiased path tracing; needs no solution
    RSV_RENDER_OCCLUSION, ///< for comparison: ambient occlusion by rays, multiplied by ambient light
    RSV_RENDER_OCCLUSION_SCREEN ///< the same from the depth buffer alone
} rsv_render_mode;

/// Upper limit of the extra camera rays of rsv_render_desc.noise.
#define RSV_MOST_SAMPLES 64

/// Options of a picture. Start from rsv_default_render_desc().
typedef struct rsv_render_desc {
    size_t size; ///< sizeof this structure; rsv_default_render_desc() sets it
    rsv_render_mode mode;
    uint32_t width, height;
    uint32_t samples; ///< camera rays per pixel (box filter)
    /// Modes operator and final: target for the standard error of a pixel, relative to the pixels around it. Noisy
    /// pixels get up to RSV_MOST_SAMPLES times as many camera rays. Default 0 = `samples` everywhere.
    float noise;
    uint32_t camera; ///< index in the scene
    /// Modes operator, final and reference: a camera to use instead of one of the scene; borrowed. NULL = none
    const rsv_camera *viewpoint;
    /// The same modes: the camera's film and lens. Default: a pinhole camera, which shows rough coats with less noise.
    rsv_film_desc film;
    /// Mode final: gather rays per camera ray; 0 = look up indirect light. Modes occlusion: rays or points per surface
    /// hit; 0 = 16
    uint32_t gather_rays;
    /// Modes occlusion: metres beyond which nothing occludes. 0 = no limit (rays), or a twentieth of the scene's
    /// diagonal (screen).
    float occlusion_distance;
    uint32_t
        path_depth; ///< maximum number of mirror and glass events along a camera ray; default 64
    /// Modes operator and final: all pixels use the same sample positions, the first at the centre, as frames do
    /// (frame.h). Otherwise each pixel has its own pattern, and `noise` and light paths towards matt coats can reduce
    /// the noise.
    bool shared_pattern;
    bool layers; ///< add one layer per order of T^n Le: emission, direct, bounce1, ...
    uint32_t seed;
    /// rsv_render and rsv_render_planned: remove noise with a filter that keeps edges, textures and all detail that
    /// exceeds the noise found around it. Fainter detail is blurred: a bias, in exchange for noise. `samples` are
    /// rounded up to an even number. Not with `layers` or `shared_pattern`. Default: false
    bool denoise;
} rsv_render_desc;

/// Writes defaults to a descriptor of `size` bytes. Usually called through rsv_default_render_desc().
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

/// Renders the modes occlusion. A pixel is emission plus albedo times ambient light times the unoccluded fraction of
/// the hemisphere. Ambient light is what a white surface would reflect of the environment, or of a sky of radiance 1 if
/// there is none. All surfaces count as diffuse, and other lights are ignored. With rays, the fraction converges to the
/// cosine-weighted one (Zhukov et al. 1998). The screen-space mode takes one camera ray per pixel.
RSV_API rsv_status rsv_render_occlusion(
    const rsv_scene *scene, const rsv_render_desc *desc, rsv_image **image);

/// Renders many pictures of one scene in the modes occlusion. Keeps the ray tracer and buffers, and uses the context's
/// device if it supports this.
typedef struct rsv_occlusion rsv_occlusion;

/// The scene must outlive the object.
RSV_API rsv_status rsv_occlusion_create(
    const rsv_scene *scene, const rsv_render_desc *desc, rsv_occlusion **occlusion);
RSV_API void rsv_occlusion_destroy(rsv_occlusion *occlusion);

/// @param image of the size given at creation
RSV_API rsv_status rsv_occlusion_render(
    rsv_occlusion *occlusion, const rsv_camera *camera, rsv_image *image);

/// Renders mode reference: path tracing with next-event estimation, BSDF sampling, MIS and Russian roulette. Layers
/// (desc->layers) are emission, direct, bounce1, ..., by the number of diffuse reflections.
/// @param standard_error out: standard error of the mean luminance, relative to it; may be NULL
RSV_API rsv_status rsv_render_reference(
    const rsv_scene *scene, const rsv_render_desc *desc, rsv_image **image, double *standard_error);

typedef enum rsv_probe_mode {
    RSV_PROBE_LOOKUP,   ///< the stored solution at the nearest surface point
    RSV_PROBE_OPERATOR, ///< one gather through the solution, with direct light sampled (default)
    RSV_PROBE_REFERENCE ///< path traced
} rsv_probe_mode;

typedef struct rsv_probe_reading {
    rsv_rgb irradiance; ///< W/m2
    /// W/m2, from independent randomisations. In modes that read a solution, it includes errors that all rays share:
    /// noise of the stored light, mostly of caustics, and interpolation where fields are not linear.
    rsv_rgb standard_error;
} rsv_probe_reading;

/// Options of readings. Start from rsv_default_probe_desc().
typedef struct rsv_probe_desc {
    size_t size; ///< sizeof this structure; rsv_default_probe_desc() sets it
    rsv_probe_mode mode;
    /// Gather rays (operator) or paths (reference) per probe, rounded up to 32 equal groups; default 4096
    uint32_t samples;
    uint32_t seed; ///< selects other random numbers; default 0
} rsv_probe_desc;

/// Writes defaults to a descriptor of `size` bytes. Usually called through rsv_default_probe_desc().
RSV_API void rsv_probe_desc_init(rsv_probe_desc *desc, size_t size);
static inline rsv_probe_desc rsv_default_probe_desc(void)
{
    rsv_probe_desc desc;
    rsv_probe_desc_init(&desc, sizeof desc);
    return desc;
}

/// Irradiance at probes. For scenes far from the origin, positions are relative to rsv_scene_view.origin, like all
/// coordinates.
/// @param desc NULL = defaults
/// @param probes [probe_count]
/// @param readings out, [probe_count]
RSV_API rsv_status rsv_probe_irradiance(const rsv_light *light, const rsv_probe_desc *desc,
    const rsv_probe *probes, size_t probe_count, rsv_probe_reading *readings);

/// Irradiance, W/m2, on the first surface that a camera sees at a place in its picture, on the side that it sees.
/// @param width, height of the picture, pixels
/// @param place x to the right and y down, each from 0 to 1
/// @return false if no surface with stored light is visible there: there is nothing, or only mirrors and clear glass
RSV_API bool rsv_read_picture_point(const rsv_light *light, const rsv_camera *camera,
    uint32_t width, uint32_t height, const float place[2], rsv_rgb *irradiance);

/// Path-traced readings. They need no solution.
/// @param samples, seed as in rsv_probe_desc
RSV_API rsv_status rsv_probe_reference(const rsv_scene *scene, const rsv_probe *probes,
    size_t probe_count, uint32_t samples, uint32_t seed, rsv_probe_reading *readings);

/// A point on one side of a triangle.
typedef struct rsv_surface_place {
    uint32_t triangle; ///< of the scene
    float u, v;        ///< barycentric weights of corners 1 and 2
    bool back;
    float width; ///< metres: side of the patch over which the normal map is averaged
} rsv_surface_place;

/// Path-traced irradiance of surfaces, comparable to what elements store and bakes write: normal maps are averaged over
/// patches, and light that coats keep from the diffuse layer below does not count.
/// @param samples, seed as in rsv_probe_desc
/// @param readings out, [count]
RSV_API rsv_status rsv_surface_reference(const rsv_scene *scene, const rsv_surface_place *places,
    size_t count, uint32_t samples, uint32_t seed, rsv_probe_reading *readings);

#ifdef __cplusplus
}
#endif

#endif
