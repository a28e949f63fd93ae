/// Highlights: what the rough lobes of a surface make of sources, in closed form, without noise and without occlusion;
/// and the share of that light that arrives.
///
/// A lobe is a linearly transformed cosine (Heitz, Dupuy, Hill and Neubelt 2016) whose transform maps the upper hemisphere
/// onto itself, so that clipping a lamp at the horizon is exact and so is an even surrounding: it gives the albedo of the
/// engine's own tables. The integral over a lamp is corrected by the ratio between the engine's BSDF and the transformed cosine
/// in the lamp's mean direction, as far as the lamp fills less than the lobe: small or distant lamps come out exactly, with
/// masking, Fresnel reflectance and all layers. Point lights, spots and distant lights are the BSDF times irradiance, exact.
///
/// Lobes: metal, the dielectric interface (from outside and inside), what both scatter again, the clear coat, sheen, thin
/// sheets' rough transmission, and diffuse light that passes a thin sheet. Left out: refraction into rough bodies, which no
/// transformed cosine follows (rsv_highlight_prepare says so), the ideal branches of smooth surfaces, which take a ray, and
/// the diffuse lobe, which E0 knows.
///
/// Sources are those of rsv_lights, by what casts a shadow of its own: a group of emitters, a sun, a punctual light, and the
/// rest of the surroundings. Use: create once (rsv_highlights_create); for each surface point rsv_highlight_prepare, then
/// rsv_highlights_at for the light of each source, then rsv_highlight_shadowed, which traces a few rays, or the shares that
/// are stored with nodes (shadow_shares.h).
#ifndef RSV_HIGHLIGHT_H
#define RSV_HIGHLIGHT_H

#include "../sources/lights.h"
#include "../surface/surface.h"
#include "lobe_tables.h"

/// A surface point and the direction from which it is seen.
typedef struct rsv_highlight_point {
    rsv_vec3 position;
    rsv_vec3 normal;      ///< unit shading normal, on wo's side
    rsv_vec3 horizon;     ///< unit, on that side: what is below does not arrive (rsv_surface_point)
    rsv_vec3 wo;          ///< unit, towards the eye
    const rsv_bsdf *bsdf; ///< borrowed, at this point
    bool front;           ///< the front of the triangle is seen
} rsv_highlight_point;

typedef struct rsv_highlight_lobe {
    rsv_lobe_shape shape;
    rsv_rgb albedo; ///< share of even light that it sends to the eye
    uint32_t kind;  ///< RSV_HIGHLIGHT_BASE, ...
    uint32_t cuts;  ///< of polygons, where the shape fits badly
} rsv_highlight_lobe;

enum {
    RSV_HIGHLIGHT_BASE,   ///< metal and interface, reflected once
    RSV_HIGHLIGHT_COAT,   ///< the clear coat
    RSV_HIGHLIGHT_WIDE,   ///< what is scattered again, and wide layers such as sheen
    RSV_HIGHLIGHT_SHEET,  ///< through a thin sheet, as if mirrored by it
    RSV_HIGHLIGHT_PASSED, ///< the wide lobes on the far side
    RSV_HIGHLIGHT_LOBES
};

/// The lobes of a point; what of it depends on no source.
typedef struct rsv_highlight_lobes {
    rsv_highlight_point point;
    rsv_vec3 tangent, bitangent; ///< of the frame of the lobes
    rsv_highlight_lobe lobe[RSV_HIGHLIGHT_LOBES];
    uint32_t count;
    float cos_o;
    bool layered;             ///< the layers are met
    bool refracts;            ///< there is rough refraction too, which is left out
    rsv_rgb way[RSV_SPREADS]; ///< a(wo) of bsdf.h, if layered
    /// What the wide lobes have of wo: metal and glass that scatter again, glass to the far side, layers.
    rsv_rgb metal_again, glass_again, glass_through;
    rsv_wide_layers wide;
} rsv_highlight_lobes;

/// About as much work as two evaluations of the BSDF. Opacity is left to the caller, as by rsv_bsdf_evaluate.
/// @return false: no rough lobe, nothing to be done
bool rsv_highlight_prepare(const rsv_highlight_point *point, rsv_highlight_lobes *lobes);

/// Sum of the albedos: radiance towards the eye under even light of radiance 1.
rsv_rgb rsv_highlight_albedo(const rsv_highlight_lobes *lobes);

// ---- one source ---------------------------------------------------------------------------------

#define RSV_HIGHLIGHT_CORNERS 8

/// Radiance towards the eye from a convex polygon that shines with radiance 1 towards the point.
/// The caller decides whether that is so (one-sided lamps).
/// @param corner [count], 3 <= count <= RSV_HIGHLIGHT_CORNERS
rsv_rgb rsv_highlight_polygon(
    const rsv_highlight_lobes *lobes, const rsv_vec3 *corner, uint32_t count);

/// The same for many points at once.
/// @param lobes [lobes_count] @param radiance [lobes_count] out
void rsv_highlight_polygon_many(const rsv_highlight_lobes *lobes, size_t lobes_count,
    const rsv_vec3 *corner, uint32_t count, rsv_rgb *radiance);

/// Radiance towards the eye per irradiance on a surface that faces unit `wi`.
rsv_rgb rsv_highlight_direction(const rsv_highlight_lobes *lobes, rsv_vec3 wi);

/// Radiance towards the eye from a disc of radiance 1 at infinity. @param cos_radius below 1
rsv_rgb rsv_highlight_disc(const rsv_highlight_lobes *lobes, rsv_vec3 direction, float cos_radius);

// ---- all sources of a scene -----------------------------------------------------------------------

/// Which sources take part (rsv_lights): those that next-event estimation samples, those that rays gather, or both.
typedef enum rsv_highlight_part {
    RSV_HIGHLIGHT_SAMPLED = 1,
    RSV_HIGHLIGHT_GATHERED = 2,
    RSV_HIGHLIGHT_ALL = 3
} rsv_highlight_part;

typedef struct rsv_highlights_desc {
    rsv_highlight_part part; ///< default RSV_HIGHLIGHT_ALL
    uint32_t polygons;       ///< integrated at a point at most, 1..64; default 24
    uint32_t sky_side; ///< texels along the finest octahedral map of the surroundings; default 512
} rsv_highlights_desc;

rsv_highlights_desc rsv_default_highlights_desc(void);

/// The sources of a scene, made ready. Const and shared by threads once created.
typedef struct rsv_highlights rsv_highlights;

/// @param lights borrowed
rsv_status rsv_highlights_create(
    const rsv_lights *lights, const rsv_highlights_desc *desc, rsv_highlights **highlights);
void rsv_highlights_destroy(rsv_highlights *highlights);

typedef enum rsv_highlight_source_kind {
    RSV_HIGHLIGHT_GROUP,    ///< index of rsv_lights.group
    RSV_HIGHLIGHT_SUN,      ///< of the environment's suns
    RSV_HIGHLIGHT_PUNCTUAL, ///< of the scene's lights
    RSV_HIGHLIGHT_SKY       ///< 0
} rsv_highlight_source_kind;

typedef struct rsv_highlight_source {
    rsv_highlight_source_kind kind;
    uint32_t index;
} rsv_highlight_source;

/// Sources have numbers below this count, the same for all points: groups, suns, punctual lights, then the surroundings.
uint32_t rsv_highlights_source_count(const rsv_highlights *highlights);
rsv_highlight_source rsv_highlights_source(const rsv_highlights *highlights, uint32_t source);

/// What one source gives at a point.
typedef struct rsv_highlight_light {
    uint32_t source;
    rsv_rgb radiance; ///< towards the eye, without occlusion
} rsv_highlight_light;

/// The brightest sources are told one by one; the others are summed up in the last entry, whose source is RSV_NONE.
#define RSV_HIGHLIGHT_LIGHTS 16

/// The light of all sources, in the order of their numbers.
/// @param light [RSV_HIGHLIGHT_LIGHTS] out @return how many: those that give none are left out
uint32_t rsv_highlights_at(
    const rsv_highlights *highlights, const rsv_highlight_lobes *lobes, rsv_highlight_light *light);

/// Their sum alone.
rsv_rgb rsv_highlights_sum(const rsv_highlights *highlights, const rsv_highlight_lobes *lobes);

/// The sums of many points. @param point [count] @param radiance [count] out
void rsv_highlights_sum_many(const rsv_highlights *highlights, const rsv_highlight_point *point,
    size_t count, rsv_rgb *radiance);

// ---- shadows --------------------------------------------------------------------------------------

/// The light of `count` sources that arrives: their unshadowed light times the share that a few shadow rays find (ratio
/// estimator, Heitz, Hill and McGuire 2018). The rays go to sources by how much they give, and there to places by how much
/// these give, so that one ray is right in the mean; where all arrives, or nothing, the answer has no noise.
/// @param tracer of the scene
/// @param surface where rays start (its position, extent and lift); of the same point
/// @param light   [light_count] from rsv_highlights_at
/// @param known   [light_count] shares that are known already (shadow_shares.h): no rays go there; negative = not known; NULL =
///                none is
/// @param rays    0..RSV_HIGHLIGHT_RAYS; 0 = what is not known counts as lit
/// @param seed    hashed number of pixel and sample
rsv_rgb rsv_highlight_shadowed(const rsv_highlights *highlights, const rsv_tracer *tracer,
    const rsv_highlight_lobes *lobes, const rsv_surface_point *surface,
    const rsv_highlight_light *light, uint32_t light_count, const float *known, uint32_t rays,
    uint32_t seed);

#define RSV_HIGHLIGHT_RAYS 16

#endif
