/// @file bake.h
/// Bakes solved light into files for other programs: vertices, lightmaps, grids of probes.
///
/// Starts from the scene's own glTF file, which scenes and operator files can keep (rsv_load_desc.keep_document). Only
/// parts of its JSON change: nodes, animations, cameras, extras and unknown extensions stay as they are. Scenes without
/// such a file (other formats, built-in, made in code) are written as new files. Changes made by relighting are
/// included: strengths, colours and positions of lights, colours of materials. docs/bake-reference.md describes the
/// files.
#ifndef RESOLVENT_BAKE_H
#define RESOLVENT_BAKE_H

#include "resolvent/render.h"
#include "resolvent/solve.h"

#ifdef __cplusplus
extern "C" {
#endif

/// A baked texel or vertex, and its location.
typedef struct rsv_bake_value {
    uint32_t at[2]; ///< texel, from the upper left; or index among the file's lit vertices, and 0
    rsv_rgb irradiance; ///< W/m2, before the file's format rounds or clips it
    /// [place_count] visible places, of whose light the value is the mean
    const rsv_surface_place *place;
    uint32_t place_count;
    /// The light is diffused below the surface, so it differs from what arrives at the places
    bool translucent;
} rsv_bake_value;

/// Receives the values of lightmaps and vertices as they are written, for example to measure their errors. Called by
/// one thread, in order. Hidden values, such as those below an object that stands on the surface, are skipped.
typedef struct rsv_bake_visitor {
    void *user;
    /// Returns true to receive a value. @param size of the map; or the number of vertices, and 1
    bool (*wants)(void *user, const uint32_t at[2], const uint32_t size[2]);
    void (*take)(void *user, const rsv_bake_value *value); ///< valid only during the call
} rsv_bake_visitor;

/// Options of a bake. Start from rsv_default_bake_desc().
typedef struct rsv_bake_desc {
    size_t size; ///< sizeof this structure; rsv_default_bake_desc() sets it
    /// Vertices: surfaces are tessellated, down to the size of elements, until light between vertices has at most this
    /// relative error; 0.002..1, default 0.02.
    float tolerance;
    /// Target for the relative error that shadow rays leave in the median texel or vertex. The 99th percentile is about
    /// five times as large. 0.001..0.5, default 0.01
    float error;
    /// Vertices, lightmaps: number of random values to estimate again with independent rays, for the errors in the
    /// report; 0..65536, default 0 = none.
    uint32_t judged;
    bool
        unlit; ///< mark purely diffuse materials as KHR_materials_unlit, so that viewers add no light
    /// Vertices, lightmaps: the radiance of a white surface that 1 stands for in the file, W/(m2 sr). Brighter light is
    /// clipped. 0 = automatic: lightmaps clip at most 0.1 % of their texels, vertices nothing or, if unlit, what is
    /// more than four times as bright as the mean.
    float light_scale;
    bool ktx2;     ///< lightmaps: also write OUT.lightmap.ktx2, with shared exponents (RGB9E5)
    float density; ///< lightmaps: texels per metre; 0 = as many as fit
    /// Maximum number of texels along a side, 16..8192; 0 = 1024, or up to 4096 if there are many charts
    uint32_t map_size;
    /// Texels between charts, 1..16, default 2. Rectangles need half as many, because filtering reads nothing beyond
    /// their border.
    uint32_t padding;
    /// Keep the file's second texture coordinates where they are valid (default); false = generate new ones
    bool keep_uv;
    bool directional; ///< lightmaps: also store the direction of light, for normal maps
    bool basis;       ///< also write the contribution of each light, for the runtime
    bool packed;      ///< write the basis in about a tenth of the bytes, as halves (docs/bake-reference.md)
    /// Vertices, lightmaps: also write the operator, for lights that were not baked
    bool operator_file;
    /// Number of angles about the vertical, evenly spaced over a full turn, for which a basis holds the environment;
    /// 1..64, default 1: as it is.
    uint32_t turns;
    float probe_spacing;    ///< metres; 0 = a sixteenth of the scene's longest side
    uint32_t probe_samples; ///< rays per direction of a probe, 32..65536, default 64
    /// Also write OUT.hdr: the environment, W/(sr m2), without its rotation, for backgrounds and reflections
    bool sky;
    /// Lightmaps: .exr and .ktx2 in lux (683 lm/W) instead of W/m2: 0.2126 R + 0.7152 G + 0.0722 B is illuminance. The
    /// glTF file stays in W/m2.
    bool photometric;
    bool dry_run;                    ///< compute the report, but write nothing
    const rsv_bake_visitor *visitor; ///< borrowed; NULL = none
} rsv_bake_desc;

/// Writes defaults to a descriptor of `size` bytes. Usually called through rsv_default_bake_desc().
RSV_API void rsv_bake_desc_init(rsv_bake_desc *desc, size_t size);
static inline rsv_bake_desc rsv_default_bake_desc(void)
{
    rsv_bake_desc desc;
    rsv_bake_desc_init(&desc, sizeof desc);
    return desc;
}

/// Result of a bake.
typedef struct rsv_bake_report {
    size_t vertices, triangles; ///< with baked light, after tessellation
    size_t input_triangles;
    size_t charts;
    uint32_t map_width, map_height; ///< texels
    float density;                  ///< texels per metre
    double coverage;                ///< fraction of the map's texels that lie on surfaces
    double largest_seam; ///< largest jump of light across charts on smooth surfaces, relative
    uint32_t probe_count[3];
    size_t valid_probes;
    float light_scale; ///< radiance of a white surface that 1 stands for in the file, W/(m2 sr)
    double saturated;  ///< fraction of texels or vertices that are brighter, and clipped
    /// Errors of the values that were estimated again (desc->judged), relative to the light there, or to a twentieth of
    /// the mean if that is larger. They include the noise of the new estimates.
    size_t judged;       ///< number of values; 0 = errors were not measured
    double error_median; ///< median error
    double error_99;     ///< 99th percentile of the errors
    double error_noise;  ///< median noise of the new estimates
    size_t lights;       ///< in the basis, with the environment counted once for each angle
} rsv_bake_report;

/// Bakes light into COLOR_0, as irradiance / pi / light_scale. The visible radiance is base colour * COLOR_0 *
/// light_scale.
/// @param output .glb
/// @param desc NULL = defaults
/// @param report may be NULL
/// @return RSV_ERROR_FORMAT if the scene's document is damaged, RSV_ERROR_ARGUMENT if it belongs to another scene
RSV_API rsv_status rsv_bake_vertices(
    const rsv_light *light, const char *output, const rsv_bake_desc *desc, rsv_bake_report *report);

/// Bakes irradiance into a map: as MOZ_lightmap in 8-bit sRGB in the file, and in full precision in OUT.lightmap.exr.
/// With desc->directional also OUT.lightmap-x.exr, -y and -z, for normal maps. The file's second texture coordinates
/// are used where they are inside the unit square and do not overlap.
RSV_API rsv_status rsv_bake_lightmap(
    const rsv_light *light, const char *output, const rsv_bake_desc *desc, rsv_bake_report *report);

/// Bakes radiance around the points of a grid, in spherical harmonics of order 2, for moving objects: OUT.json and
/// OUT.probes.bin. Probes that mostly see backs of surfaces are inside something, and marked invalid.
/// @param output .json
RSV_API rsv_status rsv_bake_probes(
    const rsv_light *light, const char *output, const rsv_bake_desc *desc, rsv_bake_report *report);

/// Bakes to a target by name: "vertex", "lightmap", "probes" or another from rsv_bake_target_names().
RSV_API rsv_status rsv_bake(const rsv_light *light, const char *target, const char *output,
    const rsv_bake_desc *desc, rsv_bake_report *report);
RSV_API const char *const *rsv_bake_target_names(void); ///< NULL-terminated
/// Extension of a target's output, such as ".glb"; NULL if there is no such target.
RSV_API const char *rsv_bake_target_extension(const char *target);

#ifdef __cplusplus
}
#endif

#endif
