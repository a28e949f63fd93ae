/// Straight transmittance along rays: 1 = nothing is in the way, 0 = something opaque is; each alpha-blended surface
/// transmits 1 - opacity. All shadow rays except those of the path tracer use it.
#ifndef RSV_PASSAGE_H
#define RSV_PASSAGE_H

#include "resolvent/trace.h"

/// Share of light that passes (0, t_max). Code that devices share calls rsv_ray_passed (ray.h).
float rsv_tracer_passed(const rsv_tracer *tracer, const rsv_ray *ray);

/// The same for the lanes of a packet, whose t_max come out positive where anything passes, negative elsewhere and
/// where they were.
/// @param passed [RSV_PACKET_WIDTH] out
void rsv_tracer_passed_packet(
    const rsv_tracer *tracer, rsv_ray_packet *packet, bool coherent, float *passed);

#endif
