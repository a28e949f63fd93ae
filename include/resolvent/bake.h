/// @file bake.h
/// Bakes solved light into files for other programs: vertices, lightmaps, grids of probes.
///
/// Starts from the scene's own glTF file, which scenes and operator files can keep (rsv_load_desc.keep_document). Only parts of
/// its JSON change: nodes, animations, cameras, extras and unknown extensions stay as they are. Scenes without such a file
/// (other formats, built-in, made in code) are written as new files. Changes made by relighting are included: strengths,
/// colours and positions of lights, colours of materials. docs/bake.md describes the output.
#ifndef RESOLVENT_BAKE_H
#define RESOLVENT_BAKE_H

#include "resolvent/render.h"
#include "resolvent/solve.h"

#ifdef __cplusplus
extern "C" {
#endif

/// A texel or vertex as it was baked, and where it is.
typedef struct rsv_bake_value {
    uint32_t at[2]; ///< texel, from the upper left; or a vertex of the file's lit primitives, and 0
    rsv_rgb irradiance; ///< W/m2, before the file's format rounds or clips it
    const rsv_surface_place
        *place; ///< [place_count] that it is the mean of: those that can be seen
    uint32_t place_count;
    bool
        translucent; ///< its light is diffused below the surface: it is not what arrives at the places
} rsv_bake_value;

/// Sees values of lightmaps and vertices as they are written, for instance to judge them. Called by one thread, in order. Values
/// that nobody sees, below what stands on a surface, are not shown.
typedef struct rsv_bake_visitor {
    void *user;
    /// Whether a value is wanted. @param size of the map; or of the list of vertices, and 1
    bool (*wants)(void *user, const uint32_t at[2], const uint32_t size[2]);
    void (*take)(void *user, const rsv_bake_value *value); ///< value is valid during the call alone
} rsv_bake_visitor;

/// Start from rsv_default_bake_desc().
typedef struct rsv_bake_desc {
    size_t size; ///< of this structure; rsv_default_bake_desc() sets it
    /// Vertices: surfaces are tessellated, down to the elements, until light between vertices is off by no more than
    /// this share of itself; 0.002..1, default 0.02.
    float tolerance;
    /// Error of the median texel or vertex that shadow rays go for, relative; that of the 99th percentile is about five times as
    /// large. 0.001..0.5, default 0.01
    float error;
    /// Vertices, lightmaps: about so many values, drawn at random, are estimated once more by rays of their own, for the errors in the
    /// report; 0..65536, default 0 = none.
    uint32_t judged;
    bool unlit; ///< mark what only reflects diffusely as KHR_materials_unlit: viewers add no light
    /// Vertices, lightmaps: what 1 stands for in the file, as the radiance of a white surface, W/(m2 sr); brighter light is
    /// clipped. 0 = by itself: lightmaps clip 0.1 % of their texels at most, vertices nothing, or, if unlit, what is more than
    /// four times as bright as the mean.
    float light_scale;
    bool ktx2;     ///< lightmaps: also OUT.lightmap.ktx2, in shared exponents (RGB9E5)
    float density; ///< lightmaps: texels per metre; 0 = as many as fit
    uint32_t
        map_size; ///< texels along a side at most, 16..8192; 0 = 1024, up to 4096 for many charts
    /// Texels between charts, 1..16, default 2; half as many beside rectangles, where filtering reads nothing beyond the border.
    uint32_t padding;
    bool
        keep_uv; ///< use second texture coordinates where they are valid (default); else make new ones
    bool directional; ///< lightmaps: also where light comes from, for normal maps
    bool basis;       ///< also write what each light does by itself, for the runtime
    bool packed; ///< the basis is written in about a tenth of the bytes, as halves (docs/bake.md)
    bool
        operator_file; ///< vertices, lightmaps: also write the operator, for lights that were not baked
    /// Angles, evenly spread over a full turn about the vertical, at which a basis holds the surroundings; 1..64, default 1:
    /// as they are.
    uint32_t turns;
    float probe_spacing;    ///< metres; 0 = a sixteenth of the scene's longest side
    uint32_t probe_samples; ///< rays per direction of a probe, 32..65536, default 64
    bool
        sky; ///< also OUT.hdr: the surroundings, W/(sr m2), not rotated, for backgrounds and reflections
    bool dry_run;                    ///< find out what would come out, write nothing
    const rsv_bake_visitor *visitor; ///< borrowed; NULL = none
} rsv_bake_desc;

/// Defaults, for a descriptor of `size` bytes: what rsv_default_bake_desc() is made of.
RSV_API void rsv_bake_desc_init(rsv_bake_desc *desc, size_t size);
static inline rsv_bake_desc rsv_default_bake_desc(void)
{
    rsv_bake_desc desc;
    rsv_bake_desc_init(&desc, sizeof desc);
    return desc;
}

/// What came out.
typedef struct rsv_bake_report {
    size_t vertices, triangles; ///< of what carries light, after tessellation
    size_t input_triangles;
    size_t charts;
    uint32_t map_width, map_height; ///< texels
    float density;                  ///< texels per metre
    double coverage;                ///< share of the map's texels that some surface shows
    double largest_seam; ///< largest jump of light across charts on smooth surfaces, relative
    uint32_t probe_count[3];
    size_t valid_probes;
    float light_scale; ///< that 1 stands for in the file: radiance of a white surface, W/(m2 sr)
    double saturated;  ///< share of texels or vertices that are brighter, and clipped
    /// What desc->judged asks for; 0 = nothing was judged. Errors are relative to the light there, or to a twentieth of the mean if that
    /// is more; noise of the estimates that values are compared with is part of them.
    size_t judged;       ///< how many values
    double error_median; ///< of their errors
    double error_99;     ///< 99th percentile of them
    double error_noise;  ///< median noise of the estimates
    size_t lights;       ///< of the basis, surroundings counted at every angle
} rsv_bake_report;

/// Light in COLOR_0: irradiance / pi / light_scale, so that base colour times it is what is seen.
/// @param output .glb @param desc NULL = defaults @param report may be NULL
/// @return RSV_ERROR_FORMAT if the document that the scene keeps is damaged, RSV_ERROR_ARGUMENT if it is another scene's
RSV_API rsv_status rsv_bake_vertices(
    const rsv_light *light, const char *output, const rsv_bake_desc *desc, rsv_bake_report *report);

/// Irradiance in a picture: MOZ_lightmap with 8-bit sRGB codes in the file, and OUT.lightmap.exr beside it in full
/// precision, for normal maps also OUT.lightmap-x.exr, -y and -z (desc->directional). Second texture coordinates of the file are used where they are in the unit square and do not overlap.
RSV_API rsv_status rsv_bake_lightmap(
    const rsv_light *light, const char *output, const rsv_bake_desc *desc, rsv_bake_report *report);

/// Radiance around the points of a grid, in spherical harmonics of order 2, for what moves: OUT.json and OUT.probes.bin.
/// Probes
/// that see mostly backs of surfaces are inside something and invalid.
/// @param output .json
RSV_API rsv_status rsv_bake_probes(
    const rsv_light *light, const char *output, const rsv_bake_desc *desc, rsv_bake_report *report);

/// Any of them by its name: "vertex", "lightmap", "probes", and whatever else rsv_bake_target_names() lists.
RSV_API rsv_status rsv_bake(const rsv_light *light, const char *target, const char *output,
    const rsv_bake_desc *desc, rsv_bake_report *report);
RSV_API const char *const *rsv_bake_target_names(void); ///< ends with NULL
/// Of the files that a target writes: ".glb"; NULL = there is no such target.
RSV_API const char *rsv_bake_target_extension(const char *target);

#ifdef __cplusplus
}
#endif

#endif
