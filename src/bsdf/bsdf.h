/// Scattering at a surface: a blend of diffuse, metal, glass and a dielectric coat, smooth or rough. Plain C, also for
/// device code.
///
/// Frame: `wo` points away from the surface, along the outgoing light, and `wi` towards the incoming light; `n` is the
/// unit normal on wo's side (cos_o = n.wo >= 0); `front` says whether wo is on the front of the triangle. With m =
/// metallic and t = transmission, the surface is m metal, (1 - m) t glass and (1 - m)(1 - t) coated diffuse:
///
///     metal    reflects F_metal (Schlick from base_color)
///     glass    reflects s F, transmits (1 - s F) base_color (refracted into a body if thickness > 0)
///     coated   reflects s F and diffuses D T(wo) under it, D = (1 - m)(1 - t), T(w) = 1 - s R(w)
///
/// F is the Fresnel reflectance, R(w) the directional albedo of the (rough) interface, s its tint. Under a thin film, F
/// is that of the film, per channel (thin_film.h). For rough surfaces it is linear between RSV_FACET_COS cosines with
/// the facets, so that its directional albedo is a sum of tabulated ones.
///
/// Rough interfaces are GGX microsurfaces of width alpha = roughness^2. A lobe of Kulla and Conty's form (2017; here
/// also for refraction) restores the energy of multiple scattering, so that white metal and clear glass are lossless at
/// any roughness.
///
/// The diffuse lobe is reciprocal, and conserves energy at its interface:
///
///     f(wi, wo) = D base_color T(wi) T(wo) / (pi T_mean),  T_mean = 2 int T(cos) cos dcos
///
/// Its directional albedo is therefore D base_color T(wo). It is evaluated in two factors: the irradiance E = int L
/// T(wi) / T_mean cos dwi, in which light is weighted by its transmission through the coat, and the radiance that
/// leaves, D T(wo) B / pi with B = base_color E. In uniform light, E is the light that arrives, for any coat. It is
/// smooth even where textures change the coat, and elements store it. In thin sheets, a fraction of the light leaves on
/// the other side. It is not stored in elements, but scattered like a rough lobe.
///
/// Sheen and a clear coat (ior 1.5) cover all of this. Each reflects by itself, c R(w). The rest, L(w) = (1 - c R)(1 -
/// c S), reaches the base. Light that the layers send back to a white base must leave in the end, so that a base of
/// albedo A(wo) has L(wo) A(wo) under them. The diffuse lobe's T gets the factor L. Any other lobe becomes
///
///     f(wi, wo) a(wi) a(wo),  a(w) = L(w) / s(w),  s(wo) = mean of a over the light that f scatters from wo
///
/// which is symmetric and lossless. For a mirror s = a, and the factor is L. For a diffuse f, a = L / sqrt(L_mean), as
/// in T. Rough lobes lie between; balance.h finds s. Light that refracts into a body is dimmed by L(wo); light inside a
/// body does not interact with the layers.
///
/// A clear coat may have a normal m other than n. It then reflects c R(m.wo) about m, and everything below, computed as
/// under a coat along the surface, is scaled by (1 - c R(m.wo)) / (1 - c R(n.wo)). Only light that the coat reflects
/// below the surface is lost. As with all normal maps, f is not symmetric.
///
/// Radiance here is basic radiance, L / ior^2 of the medium, which interfaces do not scale. The same functions
/// therefore serve radiance and photons, and f(wi, wo) / ior(wi)^2 is symmetric.
#ifndef RSV_BSDF_H
#define RSV_BSDF_H

#include "../core/sampling.h"
#include "../scene/coat_normal.h"
#include "fresnel.h"
#include "ggx.h"
#include "resolvent/scene.h"
#include "tables.h"
#include "thin_film.h"

/// Narrower microsurfaces scatter like smooth ones: ideal reflection and refraction.
#define RSV_SMOOTH_ALPHA 1e-3f

/// Interfaces with a smaller ratio of indices are ignored: their facets would need more digits than float has.
#define RSV_LEAST_IOR 1.002f

/// Of the layer of KHR_materials_clearcoat.
#define RSV_CLEARCOAT_IOR 1.5f

/// Interfaces that may lie under a thin film.
enum { RSV_FILMED_METAL, RSV_FILMED_COAT, RSV_FILMED };

/// Constants of a material at a point; rsv_bsdf_vary makes them from those of the material.
typedef struct rsv_bsdf {
    rsv_rgb base_color;    ///< exitance per irradiance, metal F0 and tint of transmission
    rsv_rgb entry_scale;   ///< 1 / T_mean
    rsv_rgb absorption;    ///< 1/m inside a solid body (Beer-Lambert)
    rsv_rgb emission;      ///< W/(sr m2)
    float camera_emission; ///< share of it that cameras see directly
    rsv_rgb specular_tint; ///< s = specular * specular_color
    float ior, metallic, transmission, diffuse; ///< diffuse = D
    float alpha;                                ///< width of the microsurface; 0 = smooth
    float clearcoat, clearcoat_alpha;           ///< share and width of the layer over all
    bool tilted;                                ///< the clear coat has normals of its own
    rsv_vec3 coat_normal;                       ///< unit, on the front; zero: n instead
    float sheen_mean;                           ///< hemispherical mean of S(w) (1 - c R(w))
    rsv_rgb sheen;                              ///< reflectance at grazing angles
    float sheen_power;                          ///< S(w) = (1 - cos)^sheen_power
    float passed;         ///< share of light that leaves diffusely on the other side, like D
    rsv_rgb passed_color; ///< its tint
    float smooth_mean;    ///< hemispherical mean of F from outside
    rsv_table_place alpha_place, eta_place; ///< in the tables, if alpha > 0
    rsv_table_place clearcoat_place, clearcoat_eta_place;
    rsv_rgb balance[RSV_SPREADS][RSV_SPREAD_COS]; ///< s^2 - L; if layered and alpha > 0
    rsv_rgb brushed_balance[RSV_BRUSHED_NODES];   ///< likewise, of brushed metal
    float
        dispersion; ///< of a smooth solid body: ior of blue less that of red, over ior - 1; 0 = none
    bool brushed;   ///< facets of metal have two widths
    float brush_along, brush_across;
    rsv_table_place brush_alpha, brush_strength; ///< in the tables
    rsv_vec3 brush;     ///< unit, of the longer width; zero = any direction will do
    rsv_thin_film film; ///< directly on the interface
    rsv_rgb filmed[RSV_FILMED]
                  [RSV_FACET_COS]; ///< reflectance of facets under it, s in it; if film.share > 0
    const rsv_bsdf_tables *tables;
    float opacity; ///< coverage; the rest of the light passes unchanged
    bool solid;    ///< transmission refracts into a body
    bool straight; ///< same index as its surroundings, so that nothing refracts at any roughness
    bool double_sided; ///< both sides scatter; solid bodies count as double-sided
    bool lambert;      ///< nothing but D = 1, T = 1: the fast path
    bool coated;       ///< T is not 1
    bool layered;      ///< there is a clear coat or sheen
    bool rough;        ///< some lobe but the diffuse one scatters into a solid angle
    bool unlit;
    bool emissive; ///< emission is not black (and not unlit)
} rsv_bsdf;

/// Whether cameras see less of the emission than mirrors and other surfaces do.
RSV_INLINE bool rsv_hides_emission(const rsv_bsdf *bsdf)
{
    return bsdf->camera_emission < 1 && (bsdf->emissive || bsdf->unlit);
}

/// Maps a material to the scattering model.
rsv_bsdf rsv_bsdf_from_material(const rsv_material *material);

/// The same material with other values at one point. Keeps everything that depends only on the ior, and is cheap enough
/// for every hit. The kind of `bsdf` (solid, double-sided, unlit) stays.
/// @param material with the values there @param varied out, not `bsdf` itself
RSV_SHARED void rsv_bsdf_vary(const rsv_bsdf *bsdf, const rsv_material *material, rsv_bsdf *varied);

/// The same for the diffuse lobe only, at a lower cost: the other lobes are undefined.
RSV_SHARED void rsv_bsdf_vary_entry(
    const rsv_bsdf *bsdf, const rsv_material *material, rsv_bsdf *varied);

/// Colours that refract each in its own way.
typedef enum rsv_channel {
    RSV_CHANNEL_OPEN, ///< not chosen yet
    RSV_CHANNEL_RED,
    RSV_CHANNEL_GREEN,
    RSV_CHANNEL_BLUE,
    RSV_CHANNEL_ALL ///< refract alike
} rsv_channel;

/// The same material to light of one channel, where that matters.
RSV_INLINE rsv_bsdf rsv_bsdf_in_channel(const rsv_bsdf *bsdf, rsv_channel channel)
{
    rsv_bsdf own = *bsdf;
    float turn = (float)channel - (float)RSV_CHANNEL_GREEN;
    own.ior = f_max(1 + (bsdf->ior - 1) * (1 + 0.5f * turn * bsdf->dispersion), RSV_LEAST_IOR);
    return own;
}

/// Weight of a channel that was chosen with equal probabilities.
RSV_INLINE rsv_rgb rsv_channel_weight(rsv_channel channel)
{
    return rgb(channel == RSV_CHANNEL_RED ? 3 : 0, channel == RSV_CHANNEL_GREEN ? 3 : 0,
        channel == RSV_CHANNEL_BLUE ? 3 : 0);
}

/// Whether light of channels goes different ways through the surface.
RSV_INLINE bool rsv_bsdf_disperses(const rsv_bsdf *bsdf)
{
    return bsdf->dispersion > 0 && bsdf->alpha == 0;
}

typedef enum rsv_lobe {
    RSV_LOBE_NONE,
    RSV_LOBE_DIFFUSE,
    RSV_LOBE_REFLECT,
    RSV_LOBE_TRANSMIT,
    RSV_LOBE_PASS ///< straight on, where the surface does not cover: drawn by specular paths, not by the BSDF
} rsv_lobe;

/// Weights of the ideal branches in which light that leaves along `wo` may have arrived, and where
/// from.
typedef struct rsv_bsdf_branches {
    rsv_rgb reflect, transmit;
    rsv_rgb diffuse;             ///< D T(wo), for multiplication by B / pi
    rsv_vec3 reflect_direction;  ///< unit, away from the surface
    rsv_vec3 transmit_direction; ///< unit, into the far side
    bool rough;                  ///< there are lobes besides that scatter into solid angles
} rsv_bsdf_branches;

/// An event of light at the surface, drawn by its physical probability; colour is left to the weight.
typedef struct rsv_bsdf_event {
    rsv_lobe lobe;         ///< RSV_LOBE_NONE = absorbed
    rsv_vec3 direction;    ///< unit; where the light comes from; not set for RSV_LOBE_DIFFUSE
    rsv_rgb weight;        ///< f cos / pdf; of the diffuse lobe D T(wo) / probability
    float pdf_solid_angle; ///< of all rough lobes together; 0 for ideal ones; diffuse: probability
} rsv_bsdf_event;

/// A direction drawn from the BSDF.
typedef struct rsv_bsdf_sample {
    rsv_lobe lobe;         ///< RSV_LOBE_NONE = absorbed
    rsv_vec3 direction;    ///< unit; where the light comes from
    rsv_rgb weight;        ///< f cos / pdf; ideal lobes: branch weight / probability
    float pdf_solid_angle; ///< of all lobes but ideal ones, as rsv_bsdf_pdf; 0 for ideal lobes
} rsv_bsdf_sample;

/// Value and density of the lobes that scatter into solid angles.
typedef struct rsv_bsdf_value {
    rsv_rgb response; ///< f |cos_i|
    float pdf_solid_angle;
} rsv_bsdf_value;

/// Which lobes to evaluate.
typedef enum rsv_lobe_set {
    RSV_LOBES_ROUGH = 1,
    RSV_LOBES_DIFFUSE = 2,
    RSV_LOBES_ALL = 3
} rsv_lobe_set;

/// The normal for mirror and refraction branches: the shading normal, unless the mirrored direction
/// would then end below the surface and its light be lost; then the geometric one. Both normals are
/// unit and `geometric` is on wo's side.
RSV_INLINE rsv_vec3 rsv_bsdf_specular_normal(rsv_vec3 shading, rsv_vec3 geometric, rsv_vec3 wo);

/// T(w): fraction of the base's light that leaves through the coat at cosine `cos`, per channel.
RSV_INLINE rsv_rgb rsv_bsdf_exit(const rsv_bsdf *bsdf, float cos);

/// T(w) / T_mean: weight, in irradiance, of light that arrives at cosine `cos`; its mean over the hemisphere is 1.
RSV_INLINE rsv_rgb rsv_bsdf_entry(const rsv_bsdf *bsdf, float cos);

RSV_INLINE rsv_bsdf_branches rsv_bsdf_evaluate_branches(
    const rsv_bsdf *bsdf, rsv_vec3 wo, rsv_vec3 n, bool front);

/// Part of [0, 1), from 0 on, in which u[0] makes rsv_bsdf_draw_event draw another lobe than the diffuse one.
RSV_INLINE float rsv_bsdf_specular_chance(
    const rsv_bsdf *bsdf, rsv_vec3 wo, rsv_vec3 n, bool front);

/// Draws an event for light that leaves along `wo`. Weights are 1 where the surface is colourless and lossless.
/// @param u in [0, 1): the first chooses a lobe, the others its direction
RSV_INLINE rsv_bsdf_event rsv_bsdf_draw_event(
    const rsv_bsdf *bsdf, rsv_vec3 wo, rsv_vec3 n, bool front, const float u[3]);

/// Draws among the lobes that are not diffuse, with the chance of these in the weight; the density is not divided by
/// it.
RSV_INLINE rsv_bsdf_event rsv_bsdf_draw_specular(
    const rsv_bsdf *bsdf, rsv_vec3 wo, rsv_vec3 n, bool front, const float u[3]);

/// Draws an event and, in the diffuse lobe, its direction.
RSV_INLINE rsv_bsdf_sample rsv_bsdf_sample_direction(
    const rsv_bsdf *bsdf, rsv_vec3 wo, rsv_vec3 n, bool front, const float u[3]);

/// Response to light from `wi`, on either side of the surface, of the lobes in `lobes`, and the density
/// per solid angle with which rsv_bsdf_sample_direction draws wi by one of them.
RSV_INLINE rsv_bsdf_value rsv_bsdf_evaluate(
    const rsv_bsdf *bsdf, rsv_vec3 wi, rsv_vec3 wo, rsv_vec3 n, bool front, rsv_lobe_set lobes);

/// Value (1/sr) of all lobes but ideal ones.
RSV_INLINE rsv_rgb rsv_bsdf_eval(
    const rsv_bsdf *bsdf, rsv_vec3 wi, rsv_vec3 wo, rsv_vec3 n, bool front);

/// Density per solid angle with which rsv_bsdf_sample_direction draws `wi` by any lobe but ideal ones.
RSV_INLINE float rsv_bsdf_pdf(
    const rsv_bsdf *bsdf, rsv_vec3 wi, rsv_vec3 wo, rsv_vec3 n, bool front);

#include "bsdf_interface.h"

#include "bsdf_layers.h"

#include "bsdf_evaluate.h"

#include "bsdf_sample.h"

#if defined(RSV_DEVICE_CODE)
#include "vary_body.h"
#endif

#endif
