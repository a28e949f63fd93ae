/// The residual of the continuous equation at one point: E0 + G K E~ - E~.
///
/// Everything but E~ itself is estimated without bias, from rays and without elements:
///
/// - sources, by next-event estimation with the closed-form unshadowed light as control variate. Its factor for one sample comes
///   from the *other* samples, which are independent, so there is no bias;
/// - gathered sources, the sky and caustics, by gather rays that hit them;
/// - G K E~, by gather rays that look E~ up where they end, with the textures there.
///
/// Normal maps are averaged as elements average them, because stored light does not represent their detail.
///
/// Two parts are taken from the solution: what translucent surfaces show (their diffusion is the operator's), and
/// caustics of punctual lights, which no gather ray can find and which photons check.
#ifndef RSV_RESIDUAL_H
#define RSV_RESIDUAL_H

#include "caustic_judge.h"
#include "resolvent/certify.h"

typedef struct rsv_residual_job {
    const rsv_light_view *solution;
    uint32_t gather_rays, light_samples; ///< of one estimate
    bool stored_caustics;                ///< caustics are taken from the solution
    bool exact_direct; ///< the renderer estimates direct light itself: E~ has no error there
    const rsv_caustic_judge *judge; ///< of stored caustics; NULL = they count as exact
} rsv_residual_job;

/// Two independent estimates at one point.
typedef struct rsv_residual {
    rsv_rgb residual[2];
    rsv_rgb direct[2];     ///< the part of it in light found by next-event estimation
    rsv_rgb irradiance[2]; ///< E~; the two differ if direct light is exact
    float ior;             ///< of the medium that the point faces
    uint64_t rays;
} rsv_residual;

rsv_residual_job rsv_residual_job_of(
    const rsv_light_view *solution, uint32_t gather_rays, uint32_t light_samples);

/// @param stream differs between points; the estimates of different streams are independent
rsv_residual rsv_residual_at(
    const rsv_residual_job *job, const rsv_face_point *point, uint32_t stream);

/// The same at a random place in a voxel, of a quarter of the fluence there.
rsv_residual rsv_residual_in_air(const rsv_residual_job *job, uint32_t voxel, uint32_t stream);

/// Whether the numbers of samples are in their ranges.
rsv_status rsv_check_certify_desc(const rsv_certify_desc *desc);

#endif
