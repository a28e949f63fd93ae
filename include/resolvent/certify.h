/// @file certify.h
/// The error of a solution: a certificate that does not rely on how the solution was computed.
///
/// Let E~ be what rsv_light_irradiance returns at every point of every diffuse surface. Its residual
///
///     r(x) = E0(x) + (G K E~)(x) - E~(x)
///
/// is estimated at random points on the surfaces, half of them uniform in area and half where E~ is bright. The
/// estimate is one more gather of rays. The receiving end does not use elements, and no random numbers of the solve are
/// reused. Normal maps are averaged over the patches that stored light represents. The error
/// e = E - E~ satisfies e = r + G K e. In the area-weighted mean square, G K shrinks by at least the largest albedo, so
///
///     RMS(e) <= RMS(r) / (1 - max albedo)
///
/// whatever the cause of the error: elements that are too large, too few rays, too few orders. Where light escapes, applying
/// the operator to uniform light gives a better bound, which also allows albedos of 1. (If diffuse surfaces are inside bodies
/// that refract, G K shrinks L / n^2, and the bound grows by the ratio of the largest n^2 to the smallest.)
/// docs/certificate.md has the details, and what is not claimed.
#ifndef RESOLVENT_CERTIFY_H
#define RESOLVENT_CERTIFY_H

#include "resolvent/image.h"
#include "resolvent/solve.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Start from rsv_default_certify_desc().
typedef struct rsv_certify_desc {
    size_t size; ///< of this structure; rsv_default_certify_desc() sets it
    uint32_t
        samples; ///< points on the surfaces, 16..2^24, default 2048; rounded up to a multiple of 8
    uint32_t gather_rays;   ///< of each of the two estimates at a point, 1..2^16, default 512
    uint32_t light_samples; ///< shadow rays likewise, 2..2^16, default 64
    uint32_t seed;          ///< any: independent of the solution's, even if equal
} rsv_certify_desc;

/// Defaults, for a descriptor of `size` bytes: what rsv_default_certify_desc() is made of.
RSV_API void rsv_certify_desc_init(rsv_certify_desc *desc, size_t size);
static inline rsv_certify_desc rsv_default_certify_desc(void)
{
    rsv_certify_desc desc;
    rsv_certify_desc_init(&desc, sizeof desc);
    return desc;
}

/// A smaller sample that costs little beside a solve: for a first idea of the error.
static inline rsv_certify_desc rsv_brief_certify_desc(void)
{
    rsv_certify_desc desc = rsv_default_certify_desc();
    desc.samples = 128;
    desc.gather_rays = 256;
    desc.light_samples = 32;
    return desc;
}

/// Luminance of irradiance, W/m2, area-weighted over all sides of surfaces that have a diffuse lobe and are not
/// inside other geometry or in touch with it (docs/certificate.md).
typedef struct rsv_certificate {
    uint32_t samples; ///< points that count
    double residual_rms;
    double residual_ci95[2]; ///< 95 % confidence interval of the true RMS(r)
    double
        error_bound_rms; ///< amplification residual_ci95[1]; INFINITY where light all but never dies out
    double error_estimate_rms; ///< of e itself, from one solve with the residual
    double error_estimate_ci95[2];
    double
        residual_direct_rms; ///< the part of r in direct light that shadow rays find; 0 where that is exact
    double residual_gathered_rms; ///< the rest: indirect light, gathered sources, caustics
    double irradiance_rms;        ///< of E~: what makes the others relative
    double max_albedo; ///< largest of the operator that was solved, at the nodes of elements
    double
        medium_factor; ///< (largest / least refractive index around the points)^2: 1 but for surfaces within glass or water
    double
        amplification; ///< bound of RMS(e) / RMS(r): 1 / (1 - max_albedo) or less, times medium_factor and that of coats
    uint64_t rays;
    double seconds;
} rsv_certificate;

/// Examines a solution. Solutions without a direct level leave direct light to the renderer: it then counts as
/// exact. Surfaces without a diffuse lobe have no irradiance: where there are no others, all numbers are 0.
/// Caustics of punctual lights cannot be found by gathering: a warning says where they are taken on trust.
/// @param desc NULL = defaults
RSV_API rsv_status rsv_certify(
    const rsv_light *light, const rsv_certify_desc *desc, rsv_certificate *certificate);

/// Where an error comes from, luminance, W/m2. Squares add up to that of the certificate's estimate.
typedef struct rsv_error_split {
    double truncation;     ///< the solver's: at most this (the report's truncation_bound)
    double sampling;       ///< too few rays, shadow rays or photons: what another seed changes
    double discretisation; ///< the rest: elements too large
} rsv_error_split;

/// Splits a certified error. Solves once more with another seed: two solutions that differ in their random numbers
/// alone, elements refined by noisy pilots included, differ by sqrt(2) times the sampling error of each.
RSV_API rsv_status rsv_split_error(
    const rsv_light *light, const rsv_certificate *certificate, rsv_error_split *split);

/// The error of one camera's picture, or of what sensors read: of the mean luminance, as far as it comes from diffuse
/// surfaces.
typedef struct rsv_goal_certificate {
    double reading; ///< what the solution says, W/(sr m2); of sensors W/m2
    double error;   ///< estimate of how much is missing there (negative: too much)
    double error_ci95[2];
} rsv_goal_certificate;

/// With w the camera's weights and z = (I - (G K)*)^-1 w, the adjoint solution, the error <w, e> of the reading <w, E~> is
/// <z, r>: residuals at points drawn by importance. Their signs count, so unlike in rsv_certify one estimate at a point
/// would do, and what errs where the camera does not look is weighted by what comes of it.
/// @param desc NULL = defaults
RSV_API rsv_status rsv_certify_goal(const rsv_light *light, const rsv_certify_desc *desc,
    uint32_t camera, rsv_goal_certificate *certificate);

/// The same of sensors: of the mean of their irradiances, but for what reaches them from sources without a diffuse
/// surface in between (rsv_probe_irradiance samples that for itself).
RSV_API rsv_status rsv_certify_points(const rsv_light *light, const rsv_certify_desc *desc,
    const rsv_probe *points, size_t point_count, rsv_goal_certificate *certificate);

/// How good a solution must be, and what it may cost. Start from rsv_default_error_target().
typedef struct rsv_error_target {
    size_t size; ///< of this structure; rsv_default_error_target() sets it
    double
        relative_error; ///< RMS(e) / irradiance_rms, or with a goal error / reading, 1e-4..1: 0.01 = 1 %
    size_t max_elements; ///< rows of the operator (default 5,000,000), as in rsv_solve_desc
    double max_seconds;  ///< for everything (default INFINITY)
    uint32_t max_rounds; ///< solutions built at most (default 8)
} rsv_error_target;

/// Defaults, for a descriptor of `size` bytes: what rsv_default_error_target() is made of.
RSV_API void rsv_error_target_init(rsv_error_target *desc, size_t size, double relative_error);
static inline rsv_error_target rsv_default_error_target(double relative_error)
{
    rsv_error_target desc;
    rsv_error_target_init(&desc, sizeof desc, relative_error);
    return desc;
}

typedef enum rsv_error_stop {
    RSV_ERROR_TARGET_REACHED,
    RSV_ERROR_TARGET_MAX_ELEMENTS, ///< one more round would have exceeded this
    RSV_ERROR_TARGET_MAX_SECONDS,  ///< or there was no time to confirm that the target is reached
    RSV_ERROR_TARGET_MAX_ROUNDS,
    RSV_ERROR_TARGET_STALLED ///< refinement does not lower the error any more
} rsv_error_stop;

/// Solves, certifies and refines until the certificate (with a goal: rsv_certify_goal or rsv_certify_points) says that the
/// target is reached, by the *estimate* of the error at the upper end of its interval, and four times as many other points
/// confirm it. (The bound would ask for several times the accuracy, and so for tens of times the work.) What is refined is
/// what errs most: elements and rays of the operator, or those of direct light. Every round is logged; so is the budget
/// that stopped them.
/// @param start of the first round, its goal that of all; NULL = draft @param target NULL = an error of 5 %
/// Rounds end early where two in a row have not lowered the error.
/// @param light the one that reached the target; else that of the lowest error, whatever stopped the rounds
/// @param certificate its certificate
RSV_API rsv_status rsv_solve_to_error(const rsv_scene *scene, const rsv_solve_desc *start,
    const rsv_error_target *target, rsv_light **light, rsv_certificate *certificate,
    rsv_error_stop *stop);

/// A picture of where the error is. Start from rsv_default_heat_map_desc().
typedef struct rsv_heat_map_desc {
    size_t size;            ///< of this structure; rsv_default_heat_map_desc() sets it
    uint32_t width, height; ///< pixels, 16 x 32 at least: a colour bar takes the lowest 12 rows
    uint32_t camera;        ///< index in the scene
    const rsv_camera *viewpoint; ///< one that is not in the scene, instead; borrowed. NULL = none
    uint32_t gather_rays;        ///< of each of the two estimates per pixel, default 128
} rsv_heat_map_desc;

/// Defaults, for a descriptor of `size` bytes: what rsv_default_heat_map_desc() is made of.
RSV_API void rsv_heat_map_desc_init(rsv_heat_map_desc *desc, size_t size);
static inline rsv_heat_map_desc rsv_default_heat_map_desc(void)
{
    rsv_heat_map_desc desc;
    rsv_heat_map_desc_init(&desc, sizeof desc);
    return desc;
}

#define RSV_HEAT_MAP_LOW                                                                           \
    1e-3 ///< relative error at the left end of the colour bar; ticks every decade
#define RSV_HEAT_MAP_HIGH 1.0

/// Certifies a solution, and shows the estimated error of the irradiance of each surface seen: its root mean square over
/// some pixels around, relative to the certificate's irradiance_rms. Layer 0 is coloured, black to white over
/// RSV_HEAT_MAP_LOW to RSV_HEAT_MAP_HIGH on a logarithmic scale, what has no irradiance grey; layer
/// "relative_error" holds the numbers.
/// @param certify, desc NULL = defaults
RSV_API rsv_status rsv_certify_picture(const rsv_light *light, const rsv_certify_desc *certify,
    const rsv_heat_map_desc *desc, rsv_certificate *certificate, rsv_image **image);

/// What certificates are judged by: irradiance at other random points, path traced twice over, by the reference that
/// knows nothing of elements or operators.
typedef struct rsv_truth rsv_truth;

/// Points, drawn and weighted as those of certificates are. Of coated surfaces what gets past the coat counts.
/// @param light any of the scene: it tells where the points may lie, where light is, and over what patches normal maps are
/// averaged: with such maps, create truth from the solution that it is to judge
/// @param points 16..2^24 @param paths of each of the two readings at a point
RSV_API rsv_status rsv_truth_create(
    const rsv_light *light, uint32_t points, uint32_t paths, uint32_t seed, rsv_truth **truth);
RSV_API void rsv_truth_destroy(rsv_truth *truth);

/// True error of a solution, luminance, W/m2: the root of the mean product of both readings' differences from it, in
/// which their noise cancels. Counts direct light even where the solution leaves it to the renderer.
/// @param light of the truth's scene @param ci95 its 95 % confidence interval
RSV_API rsv_status rsv_truth_error(
    const rsv_truth *truth, const rsv_light *light, double *error_rms, double ci95[2]);

#ifdef __cplusplus
}
#endif

#endif
