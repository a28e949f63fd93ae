/// The residual of the continuous equation at one point: E0 + G K E~ - E~.
///
/// Everything but E~ itself is estimated without bias, from rays and nothing that elements store:
///
/// - sources by next-event estimation, with unshadowed light in closed form as control variate; its factor for one
///   sample comes from the *other* samples, which are independent, so that nothing is biased;
/// - gathered sources, the sky and caustics by the gather rays that meet them;
/// - G K E~ by gather rays that look E~ up where they end, under the textures as they are there.
///
/// Light is received by normal maps, averaged as elements average them: what they change within a patch that stored light
/// stands for it does not hold.
///
/// Two things are taken from the solution: what translucent surfaces show (the diffusion below them is the
/// operator's), and caustics where punctual lights cast them, which no gather ray can find: photons judge those.
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
    rsv_rgb direct[2];     ///< the part of it in what next-event estimation finds
    rsv_rgb irradiance[2]; ///< E~; the two differ if direct light is exact
    float ior;             ///< of the medium that the point faces
    uint64_t rays;
} rsv_residual;

/// Whether a solution has caustics that no gather ray can find.
bool rsv_has_unseen_caustics(const rsv_light_view *solution);

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
