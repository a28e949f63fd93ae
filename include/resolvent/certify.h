/// @file certify.h
/// The error of a solution: a certificate that does not rely on how the solution was computed.
///
/// Let E~ be what rsv_light_irradiance returns at every point of every diffuse surface. Its residual
///
///     r(x) = E0(x) + (G K E~)(x) - E~(x)
///
/// is estimated at random points on the surfaces, half of them uniform in area and half where E~ is bright. The
/// estimate takes one more gather of rays. It uses no elements at the receiving end, and no random numbers of the
/// solve. Normal maps are averaged over the patches that stored light represents. The error e = E - E~ satisfies e = r
/// + G K e. G K multiplies the area-weighted root mean square by at most the largest albedo, so
///
///     RMS(e) <= RMS(r) / (1 - max albedo)
///
/// for any cause of the error: elements that are too large, too few rays, too few orders. If light escapes, applying
/// the operator to uniform light gives a better bound, which also allows albedos of 1. If diffuse surfaces are inside
/// refractive bodies, the same argument holds for L / n^2, and the bound grows by the ratio of the largest n^2 to the
/// smallest. docs/certificate.md has the details, and says what is not claimed.
#ifndef RESOLVENT_CERTIFY_H
#define RESOLVENT_CERTIFY_H

#include "resolvent/image.h"
#include "resolvent/solve.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Options of a certificate. Start from rsv_default_certify_desc().
typedef struct rsv_certify_desc {
    size_t size; ///< sizeof this structure; rsv_default_certify_desc() sets it
    uint32_t
        samples; ///< points on the surfaces, 16..2^24, default 2048; rounded up to a multiple of 8
    uint32_t gather_rays;   ///< for each of the two estimates at a point, 1..2^16, default 512
    uint32_t light_samples; ///< shadow rays for each of them, 2..2^16, default 64
    uint32_t seed;          ///< any; independent of the solution's, even if equal
} rsv_certify_desc;

/// Writes defaults to a descriptor of `size` bytes. Usually called through rsv_default_certify_desc().
RSV_API void rsv_certify_desc_init(rsv_certify_desc *desc, size_t size);
static inline rsv_certify_desc rsv_default_certify_desc(void)
{
    rsv_certify_desc desc;
    rsv_certify_desc_init(&desc, sizeof desc);
    return desc;
}

/// A smaller sample, for a quick look at the error. It costs little compared with a solve.
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
    double error_bound_rms; ///< amplification * residual_ci95[1]; INFINITY if light hardly dies out
    double error_estimate_rms; ///< of e itself, from one solve with the residual
    double error_estimate_ci95[2];
    /// Part of r in direct light that shadow rays find; 0 if that is exact
    double residual_direct_rms;
    double residual_gathered_rms; ///< the rest: indirect light, gathered sources, caustics
    double irradiance_rms;        ///< of E~; divide the others by it for relative errors
    double max_albedo; ///< largest albedo of the solved operator, at the nodes of elements
    /// (largest / smallest refractive index around the points)^2: 1, unless surfaces are inside glass or water
    double medium_factor;
    /// Bound of RMS(e) / RMS(r): 1 / (1 - max_albedo) or less, times medium_factor and that of coats
    double amplification;
    uint64_t rays;
    double seconds;
} rsv_certificate;

/// Estimates the error of a solution. Direct light counts as exact if the solution leaves it to the renderer (no direct
/// level). Surfaces without a diffuse lobe have no irradiance; if there are no others, all numbers are 0. Caustics of
/// punctual lights cannot be found by gathering. A warning says where they are not checked.
/// @param desc NULL = defaults
RSV_API rsv_status rsv_certify(
    const rsv_light *light, const rsv_certify_desc *desc, rsv_certificate *certificate);

/// Sources of an error, as luminance, W/m2. The sum of their squares is the square of the certificate's estimate.
typedef struct rsv_error_split {
    double truncation;     ///< due to the solver: at most this (the report's truncation_bound)
    double sampling;       ///< too few rays, shadow rays or photons: what changes with the seed
    double discretisation; ///< the rest: elements that are too large
} rsv_error_split;

/// Splits a certified error by solving again with another seed. Two solutions that differ only in their random numbers,
/// including those of the pilots that refine elements, differ by sqrt(2) times the sampling error of each.
RSV_API rsv_status rsv_split_error(
    const rsv_light *light, const rsv_certificate *certificate, rsv_error_split *split);

/// The error of one camera's picture or of sensors: that of the mean luminance, from diffuse surfaces.
typedef struct rsv_goal_certificate {
    double reading; ///< of the solution, W/(sr m2); for sensors W/m2
    double
        error; ///< estimate of the true reading minus `reading` (negative: the reading is too high)
    double error_ci95[2];
} rsv_goal_certificate;

/// Estimates the error of a camera's picture. With w the camera's weights and z = (I - (G K)*)^-1 w the adjoint
/// solution, the error <w, e> of the reading <w, E~> is <z, r>: residuals at points drawn by importance. Residuals keep
/// their signs, and errors outside the picture are weighted by their effect on it.
/// @param desc NULL = defaults
RSV_API rsv_status rsv_certify_goal(const rsv_light *light, const rsv_certify_desc *desc,
    uint32_t camera, rsv_goal_certificate *certificate);

/// The same for sensors: the error of their mean irradiance, without the light that arrives from sources directly
/// (without a diffuse surface in between), which rsv_probe_irradiance samples itself.
RSV_API rsv_status rsv_certify_points(const rsv_light *light, const rsv_certify_desc *desc,
    const rsv_probe *points, size_t point_count, rsv_goal_certificate *certificate);

/// Target accuracy of a solution, and limits of its cost. Start from rsv_default_error_target().
typedef struct rsv_error_target {
    size_t size; ///< sizeof this structure; rsv_default_error_target() sets it
    /// RMS(e) / irradiance_rms or, with a goal, error / reading; 1e-4..1, where 0.01 = 1 %
    double relative_error;
    size_t max_elements; ///< as in rsv_solve_desc; default 5,000,000
    double max_seconds;  ///< for everything; default INFINITY
    uint32_t max_rounds; ///< maximum number of solutions; default 8
} rsv_error_target;

/// Writes defaults to a descriptor of `size` bytes. Usually called through rsv_default_error_target().
RSV_API void rsv_error_target_init(rsv_error_target *desc, size_t size, double relative_error);
static inline rsv_error_target rsv_default_error_target(double relative_error)
{
    rsv_error_target desc;
    rsv_error_target_init(&desc, sizeof desc, relative_error);
    return desc;
}

typedef enum rsv_error_stop {
    RSV_ERROR_TARGET_REACHED,
    RSV_ERROR_TARGET_MAX_ELEMENTS, ///< one more round would have exceeded this limit
    RSV_ERROR_TARGET_MAX_SECONDS, ///< the same, or there was no time to confirm that the target was reached
    RSV_ERROR_TARGET_MAX_ROUNDS,
    RSV_ERROR_TARGET_STALLED ///< refinement no longer lowers the error
} rsv_error_stop;

/// Solves, certifies and refines until the target is reached. It is reached when the upper end of the confidence
/// interval of the *estimated* error is below the target, and four times as many other points confirm this. (The bound
/// would require several times the accuracy, and so tens of times the work.) With a goal, rsv_certify_goal or
/// rsv_certify_points give the estimate. Each round refines the largest source of error: elements and rays of the
/// operator, or those of direct light. Rounds end early if two in a row have not lowered the error. Each round is
/// logged, and so is the limit that ended them.
/// @param start options of the first round, and goal of all rounds; NULL = draft
/// @param target NULL = an error of 5 %
/// @param light out: the solution that reached the target, otherwise the one with the lowest error
/// @param certificate out: its certificate
/// @param stop out: why the rounds ended
RSV_API rsv_status rsv_solve_to_error(const rsv_scene *scene, const rsv_solve_desc *start,
    const rsv_error_target *target, rsv_light **light, rsv_certificate *certificate,
    rsv_error_stop *stop);

/// Options of a picture of the error. Start from rsv_default_heat_map_desc().
typedef struct rsv_heat_map_desc {
    size_t size;            ///< sizeof this structure; rsv_default_heat_map_desc() sets it
    uint32_t width, height; ///< pixels, at least 16 x 32; the lowest 12 rows show a colour bar
    uint32_t camera;        ///< index in the scene
    const rsv_camera
        *viewpoint;       ///< a camera to use instead of one of the scene; borrowed. NULL = none
    uint32_t gather_rays; ///< for each of the two estimates per pixel, default 128
} rsv_heat_map_desc;

/// Writes defaults to a descriptor of `size` bytes. Usually called through rsv_default_heat_map_desc().
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

/// Certifies a solution and renders a map of the estimated error of irradiance: root mean square over the pixels
/// around, relative to the certificate's irradiance_rms. Layer 0 shows it on a logarithmic scale, black to white from
/// RSV_HEAT_MAP_LOW to RSV_HEAT_MAP_HIGH, with grey where there is no irradiance. Layer "relative_error" holds the
/// numbers.
/// @param certify, desc NULL = defaults
RSV_API rsv_status rsv_certify_picture(const rsv_light *light, const rsv_certify_desc *certify,
    const rsv_heat_map_desc *desc, rsv_certificate *certificate, rsv_image **image);

/// A reference for certificates: irradiance at other random points, path-traced twice, independently of elements and
/// operators.
typedef struct rsv_truth rsv_truth;

/// Draws and weights points in the same way as certificates. On coated surfaces, light that passes the coat counts.
/// @param light any solution of the scene. It determines where points may be, where there is light, and the patches
/// over which normal maps are averaged; in scenes with normal maps, use the solution to be tested
/// @param points 16..2^24
/// @param paths for each of the two readings at a point
RSV_API rsv_status rsv_truth_create(
    const rsv_light *light, uint32_t points, uint32_t paths, uint32_t seed, rsv_truth **truth);
RSV_API void rsv_truth_destroy(rsv_truth *truth);

/// True error of a solution, luminance, W/m2: the root of the mean product of the two readings' differences from it, in
/// which their noise cancels. Direct light counts, even if the solution leaves it to the renderer.
/// @param light of the same scene
/// @param error_rms out
/// @param ci95 out: 95 % confidence interval
RSV_API rsv_status rsv_truth_error(
    const rsv_truth *truth, const rsv_light *light, double *error_rms, double ci95[2]);

#ifdef __cplusplus
}
#endif

#endif
