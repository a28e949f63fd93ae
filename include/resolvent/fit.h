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

/// A target reading.
typedef struct rsv_fit_wanted {
    rsv_probe probe;
    rsv_rgb reading; ///< lux in r; with rsv_fit_desc.colors, W/m2
    float weight;    ///< of its squared error, not negative; usually 1
} rsv_fit_wanted;

/// Options of a fit. Start from rsv_default_fit_desc().
typedef struct rsv_fit_desc {
    size_t size; ///< sizeof this structure; rsv_default_fit_desc() sets it
    /// true = targets are W/m2 per channel, and each light gets a factor per channel. false (default) = lux, one factor
    bool colors;
    bool at_least;          ///< readings may exceed their targets
    double lowest, highest; ///< bounds of factors, 0 <= lowest <= highest <= 1e6; default 0 and 1
    /// Weight of power relative to errors. Among factors that give the same readings, those with the least power are
    /// chosen. Default 1e-6.
    double saving;
    /// [keep_count] lights to leave unchanged, by name or node; `*` stands for any text
    const char *const *keep;
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

/// A fitted light. Lights that share a name and cannot be told apart form one entry, and so do all lamps that only
/// gather rays find.
typedef struct rsv_fit_light {
    const char *name; ///< as in rsv_light_scale
    rsv_rgb factor;   ///< relative to its present strength
    rsv_rgb scale;    ///< relative to its strength in the scene, for rsv_light_relight
    double lumens;    ///< at its present strength; 0 for the environment and directional lights
    bool kept;
} rsv_fit_light;

typedef struct rsv_fit_report {
    /// RMS difference of readings from their targets (only shortfalls with at_least), relative to the mean target
    double error_rms;
    double error_largest;         ///< lux or W/m2
    size_t worst;                 ///< index of the point with the largest error
    double lumens, lumens_before; ///< of all lights
    /// Largest remaining step of the projected gradient, scaled by the diagonal of the Hessian, relative to the highest
    /// factor
    double kkt_residual;
    uint32_t iterations;
    double time_readings, time_fit; ///< s
} rsv_fit_report;

typedef struct rsv_fit rsv_fit;

/// Fits factors of lights. The solution is not changed; pass the factors to rsv_light_relight. It must outlive the fit.
/// @return RSV_ERROR_ARGUMENT if there are no targets, bounds are invalid, names are unknown or no light may change
RSV_API rsv_status rsv_fit_create(const rsv_light *light, const rsv_fit_wanted *wanted,
    size_t count, const rsv_fit_desc *desc, rsv_fit **fit);
RSV_API void rsv_fit_destroy(rsv_fit *fit);

RSV_API size_t rsv_fit_light_count(const rsv_fit *fit);
RSV_API rsv_fit_light rsv_fit_get_light(const rsv_fit *fit, size_t index);
/// Reading of point `index` with the fitted factors: lux in r, or W/m2.
RSV_API rsv_rgb rsv_fit_reading(const rsv_fit *fit, size_t index);
RSV_API rsv_fit_report rsv_fit_get_report(const rsv_fit *fit);

#ifdef __cplusplus
}
#endif

#endif
