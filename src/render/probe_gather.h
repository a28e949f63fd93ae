/// Readings at virtual receivers, one by one: rsv_probe_irradiance in mode operator.
#ifndef RSV_PROBE_GATHER_H
#define RSV_PROBE_GATHER_H

#include "../connect/connect.h"
#include "../solve/light.h"
#include "resolvent/render.h"
#include "stored_noise.h"

typedef struct rsv_probe_job {
    const rsv_light_view *solution;
    uint32_t gather_rays, light_samples; ///< per group
    uint32_t seed;
    bool gather_caustics; ///< all sources are large
    bool sources;         ///< light that next-event estimation finds is included
    /// Light of punctual lights through mirrors and glass, for receivers without photons; NULL = none, or omitted.
    const rsv_connections *connections;
    const rsv_stored_noise *noise; ///< enters standard errors; NULL = it does not
} rsv_probe_job;

rsv_probe_job rsv_probe_job_of(
    const rsv_light_view *solution, uint32_t samples, uint32_t seed, bool sources);

/// The end of a gather ray of a reading: the light arriving there counts by `weight`.
typedef struct rsv_probe_end {
    uint32_t triangle;
    float u, v;
    bool back;
    rsv_rgb weight;
} rsv_probe_end;

/// Follows the rays of a reading once, for all lights of an operator. @param end [32 * gather_rays] out
/// @param alone out: whether there is light on the way that the ends do not include (lamps, sky, translucent bodies),
/// so that readings must be taken light by light @return number of ends
size_t rsv_probe_ends(const rsv_probe_job *job, const rsv_probe *probe, uint32_t index,
    rsv_probe_end *end, bool *alone);

/// Light of sources and stored caustics in a reading, W/m2.
rsv_rgb rsv_probe_direct(const rsv_probe_job *job, const rsv_probe *probe, uint32_t index);

/// @param index of the reading's random numbers
rsv_probe_reading rsv_probe_read(const rsv_probe_job *job, const rsv_probe *probe, uint32_t index);

#endif
