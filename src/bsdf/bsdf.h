/// How a surface scatters: a Lambert lobe under a smooth dielectric interface, an ideal mirror, an
/// ideal dielectric, and blends of the three. Plain C, also for device code.
///
/// Frame: `wo` points away from the surface, towards where the radiance is wanted; `n` is the unit
/// normal on wo's side (cos_o = n.wo >= 0); `front` says whether wo leaves from the front of the
/// triangle. With m = metallic, t = transmission, s = specular, F the Fresnel reflectance:
///
///     reflect  = m F_metal + (1 - m) s F          (F_metal: Schlick from base_color)
///     transmit = (1 - m) t (1 - s F) base_color   (refracted if thickness > 0, else straight on)
///     diffuse  = D T(wo),  D = (1 - m)(1 - t),  T(w) = 1 - s F(w)
///
/// The diffuse lobe is reciprocal and neither loses nor gains energy at its interface:
///
///     f(wi, wo) = D base_color T(wi) T(wo) / (pi T_mean),  T_mean = 2 int T(cos) cos dcos
///
/// so that its directional albedo is D base_color T(wo). It is evaluated through two factors: the
/// light that enters, E = int L T(wi) cos dwi ("irradiance" of the operator), and the radiance that
/// leaves, D T(wo) B / pi with B = exitance_albedo * E, exitance_albedo = base_color / T_mean.
#ifndef RSV_BSDF_H
#define RSV_BSDF_H

#include "../core/sampling.h"
#include "resolvent/scene.h"

/// Unpolarised Fresnel reflectance of a smooth dielectric interface.
/// @param cos_i cosine on the incident side, >= 0
/// @param eta   ior of the far side over ior of the incident side
/// @param cos_t cosine on the far side, >= 0; 0 on total internal reflection
/// @return 1 on total internal reflection
float rsv_fresnel_dielectric(float cos_i, float eta, float *cos_t);

/// Unpolarised reflectance of a conductor with complex index eta + i k (relative).
float rsv_fresnel_conductor(float cos_i, float eta, float k);

/// Hemispherical mean 2 int F cos dcos of the dielectric reflectance from outside, eta >= 1
/// (Walsh's closed form); from inside it is 1 - (1 - mean) / eta^2.
double rsv_fresnel_dielectric_mean(double eta);

/// Material constants precomputed once per material, so that no hot loop needs Walsh's formula.
typedef struct rsv_bsdf {
    rsv_rgb base_color;                         ///< metal F0 and tint of transmission
    rsv_rgb exitance_albedo;                    ///< base_color / T_mean: exitance per irradiance
    rsv_rgb absorption;                         ///< 1/m inside a solid body (Beer-Lambert)
    rsv_rgb emission;                           ///< W/(sr m2)
    rsv_rgb specular_tint;                      ///< s * specular_color
    float ior, metallic, transmission, diffuse; ///< diffuse = D
    bool solid;                                 ///< transmission refracts into a body
    bool double_sided; ///< both sides scatter; solid bodies count as double-sided
    bool lambert;      ///< nothing but D = 1, T = 1: the fast path
    bool coated;       ///< T is not 1
    bool unlit;
    bool emissive; ///< emission is not black (and not unlit)
} rsv_bsdf;

/// Maps a material to the scattering model. Rough lobes are mapped to the nearest ideal ones:
/// `approximation` receives a phrase for a warning ("rough metal (0.40) shown as an ideal mirror"),
/// or an empty string. @param approximation [80] bytes
rsv_bsdf rsv_bsdf_from_material(const rsv_material *material, char *approximation);

/// Weights of the branches in which light that leaves along `wo` may have arrived, and where from.
typedef struct rsv_bsdf_branches {
    rsv_rgb reflect, transmit;
    rsv_rgb diffuse;             ///< D T(wo), to be multiplied by B / pi
    rsv_vec3 reflect_direction;  ///< unit, away from the surface
    rsv_vec3 transmit_direction; ///< unit, into the far side
} rsv_bsdf_branches;

rsv_bsdf_branches rsv_bsdf_evaluate_branches(
    const rsv_bsdf *bsdf, rsv_vec3 wo, rsv_vec3 n, bool front);

/// The normal for mirror and refraction branches: the shading normal, unless the mirrored direction
/// would then end below the surface and its light be lost; then the geometric one. Both normals are
/// unit and `geometric` is on wo's side.
rsv_vec3 rsv_bsdf_specular_normal(rsv_vec3 shading, rsv_vec3 geometric, rsv_vec3 wo);

/// T(w): share of light at cosine `cos` that passes the coat, per channel.
rsv_rgb rsv_bsdf_entry(const rsv_bsdf *bsdf, float cos);

typedef enum rsv_lobe {
    RSV_LOBE_NONE,
    RSV_LOBE_DIFFUSE,
    RSV_LOBE_REFLECT,
    RSV_LOBE_TRANSMIT
} rsv_lobe;

/// A direction drawn from the BSDF.
typedef struct rsv_bsdf_sample {
    rsv_lobe lobe;         ///< RSV_LOBE_NONE = absorbed
    rsv_vec3 direction;    ///< unit; where the light comes from
    rsv_rgb weight;        ///< f cos / pdf; delta lobes: branch weight / probability
    float pdf_solid_angle; ///< of the diffuse lobe including its choice; 0 for delta lobes
} rsv_bsdf_sample;

/// Draws a lobe by its weight and a direction within it. `u_lobe`, `u1`, `u2` lie in [0, 1).
rsv_bsdf_sample rsv_bsdf_sample_direction(
    const rsv_bsdf *bsdf, rsv_vec3 wo, rsv_vec3 n, bool front, float u_lobe, float u1, float u2);

/// Value (1/sr) of the non-delta lobes for light from `wi`; 0 below the horizon. Not to be
/// asked on a side where rsv_bsdf_evaluate_branches finds the diffuse branch black.
rsv_rgb rsv_bsdf_eval(const rsv_bsdf *bsdf, rsv_vec3 wi, rsv_vec3 wo, rsv_vec3 n);

/// Density per solid angle with which rsv_bsdf_sample_direction draws `wi` by a non-delta lobe.
float rsv_bsdf_pdf(const rsv_bsdf *bsdf, rsv_vec3 wi, rsv_vec3 wo, rsv_vec3 n);

#endif
