/// @file fit.h
/// Strengths of lights for target readings: the inverse of rsv_light_relight and rsv_probe_irradiance.
///
/// A reading is a sum over lights, each multiplied by its factor. The factors minimise
///     1/2 sum_i w_i (reading_i - wanted_i)^2 / mean(wanted)^2 + saving * power / power of all lights at their highest factors
/// within bounds, by projected Newton steps (Bertsekas 1982).
#ifndef RESOLVENT_FIT_H
#define RESOLVENT_FIT_H

#include "resolvent/render.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct rsv_fit_wanted {
    rsv_probe probe;
    rsv_rgb reading; ///< lux in r; or with rsv_fit_desc.colors, W/m2
    float weight;    ///< of its squared error, from 0 on; usually 1
} rsv_fit_wanted;

/// Start from rsv_default_fit_desc().
typedef struct rsv_fit_desc {
    size_t size; ///< sizeof this structure; rsv_default_fit_desc() sets it
    bool
        colors; ///< wanted are W/m2 of each channel, and each light gets a factor per channel; default lux, one factor
    bool at_least;          ///< readings may be above what is wanted
    double lowest, highest; ///< bounds of factors, 0 <= lowest <= highest <= 1e6; default 0 and 1
    /// What power counts beside errors: of factors that meet readings alike, those of least power are found. Default 1e-6.
    double saving;
    const char *const *
        keep; ///< [keep_count] lights that stay as they are, by name or node; `*` stands for any text
    size_t keep_count;
    uint32_t samples; ///< gather rays of a reading; default 512
    uint32_t seed;
} rsv_fit_desc;

/// Writes defaults to a descriptor of `size` bytes. Usually called through rsv_default_fit_desc().
RSV_API void rsv_fit_desc_init(rsv_fit_desc *desc, size_t size);
static inline rsv_fit_desc rsv_default_fit_desc(void)
{
    rsv_fit_desc desc;
    rsv_fit_desc_init(&desc, sizeof desc);
    return desc;
}

/// Lights that share a name and cannot be told apart, and those that only gather rays find, are one.
typedef struct rsv_fit_light {
    const char *name; ///< as in rsv_light_scale
    rsv_rgb factor;   ///< of its present strength
    rsv_rgb
        scale; ///< the same of the strength that it has in the scene: what rsv_light_relight takes
    double lumens; ///< at its present strength; of surroundings and distant lights 0
    bool kept;
} rsv_fit_light;

typedef struct rsv_fit_report {
    double
        error_rms; ///< of readings against what is wanted (below it, if at_least), relative to the mean wanted
    double error_largest;         ///< lux or W/m2
    size_t worst;                 ///< the point where that is
    double lumens, lumens_before; ///< of all lights
    /// Largest step that projected gradients, scaled by the diagonal of the Hessian, would still take, over the highest factor
    double kkt_residual;
    uint32_t iterations;
    double time_readings, time_fit; ///< s
} rsv_fit_report;

typedef struct rsv_fit rsv_fit;

/// RSV_ERROR_ARGUMENT where nothing is wanted, bounds are no bounds, names are unknown or nothing is left to change.
/// The solution must outlive the fit, and is not changed: rsv_light_relight takes the factors.
RSV_API rsv_status rsv_fit_create(const rsv_light *light, const rsv_fit_wanted *wanted,
    size_t count, const rsv_fit_desc *desc, rsv_fit **fit);
RSV_API void rsv_fit_destroy(rsv_fit *fit);

RSV_API size_t rsv_fit_light_count(const rsv_fit *fit);
RSV_API rsv_fit_light rsv_fit_get_light(const rsv_fit *fit, size_t index);
/// What point `index` reads with the factors; lux in r, or W/m2.
RSV_API rsv_rgb rsv_fit_reading(const rsv_fit *fit, size_t index);
RSV_API rsv_fit_report rsv_fit_get_report(const rsv_fit *fit);

#ifdef __cplusplus
}
#endif

#endif
