/// Readings at virtual receivers, one by one: what rsv_probe_irradiance makes in mode operator.
#ifndef RSV_PROBE_GATHER_H
#define RSV_PROBE_GATHER_H

#include "../solve/light.h"
#include "resolvent/render.h"
#include "stored_noise.h"

typedef struct rsv_probe_job {
    const rsv_light_view *solution;
    uint32_t gather_rays, light_samples; ///< per group
    uint32_t seed;
    bool gather_caustics;          ///< all sources are large
    bool sources;                  ///< light that next-event estimation finds is included
    const rsv_stored_noise *noise; ///< enters standard errors; NULL = it does not
} rsv_probe_job;

rsv_probe_job rsv_probe_job_of(
    const rsv_light_view *solution, uint32_t samples, uint32_t seed, bool sources);

/// @param index of the reading's random numbers
rsv_probe_reading rsv_probe_read(const rsv_probe_job *job, const rsv_probe *probe, uint32_t index);

#endif
