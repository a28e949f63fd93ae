/// Steps of tracing a row, sixteen rays at a time.
#ifndef RSV_ROW_TRACER_INTERNAL_H
#define RSV_ROW_TRACER_INTERNAL_H

#include "row_tracer.h"

#include <string.h>

/// @param index of the node whose random numbers are used @param valid points that count with these
void rsv_row_receive_as(const rsv_row_tracer *tracer, uint32_t node, uint32_t index, uint16_t valid,
    rsv_row_receiver *receiver);

/// Where the rays of a node leave, and nothing else of its receiver.
void rsv_row_place_points(const rsv_row_tracer *tracer, uint32_t node, rsv_receiver_points *points);

/// An empty row of the receiver's rays. @return a packet with all lanes on, to trace them with
rsv_ray_packet rsv_row_begin(
    const rsv_row_tracer *tracer, const rsv_row_receiver *receiver, rsv_row_scratch *scratch);

/// Aims the packet of sixteen rays from `first` on. @return cosines at the receiver
const float *rsv_row_aim(const rsv_row_tracer *tracer, const rsv_row_receiver *receiver,
    uint32_t first, rsv_ray_packet *packet);

/// Traces all rays of a receiver that is set up.
void rsv_row_trace_from(
    const rsv_row_tracer *tracer, const rsv_row_receiver *receiver, rsv_row_scratch *scratch);

/// Notes where the rays of a traced packet end. @param cos_receiver [RSV_SUPPORT_POINTS] from rsv_row_aim
void rsv_row_process_hits(const rsv_row_tracer *tracer, rsv_row_scratch *scratch,
    uint32_t first_ray, const rsv_row_receiver *receiver, const float *cos_receiver,
    const rsv_ray_packet *packet);

/// Records that a ray ends at a node. @param entered weight of the light as it enters the receiver
void rsv_row_record_node(
    rsv_row_scratch *scratch, uint32_t ray, uint32_t node, rsv_rgb weight, rsv_rgb entered);

/// A row's specular path at the surface that its ray has met.
rsv_specular_path rsv_row_begin_path(const rsv_row_tracer *tracer, const rsv_row_receiver *receiver,
    const rsv_ray_packet *packet, uint32_t k);

/// Weight of gathered light at that cosine.
rsv_rgb rsv_row_entering(const rsv_row_tracer *tracer, const rsv_row_receiver *receiver, float cos);

/// The general case: specular surfaces, coats, emission, fog. @param path from rsv_row_begin_path
void rsv_row_follow_path(const rsv_row_tracer *tracer, rsv_row_scratch *scratch, uint32_t ray,
    const rsv_row_receiver *receiver, float cos_receiver, rsv_specular_path path);

/// Emission that a row's rays count where they come to it.
rsv_emission_wanted rsv_row_emission_wanted(const rsv_row_tracer *tracer);

/// Records the light and the end of a ray. @param entered as in rsv_row_record_node @param random in [0, 1)
void rsv_row_record_gather(const rsv_row_tracer *tracer, rsv_row_scratch *scratch, uint32_t ray,
    const rsv_gather *gather, rsv_rgb entered, float random);

// ---- in fog (row_fog.c) -------------------------------------------------------------------------

/// rsv_row_trace for a node in the air: isotropic rays.
void rsv_row_trace_voxel(const rsv_row_tracer *tracer, uint32_t node, rsv_row_scratch *scratch);

/// Gives the flights of a row in coloured fog a mean weight of 1 in each channel, which they have on average: so rows
/// sum to no more than 1.
void rsv_row_balance_flights(const rsv_row_tracer *tracer, rsv_row_scratch *scratch);

/// Notes where rays of a traced packet end that cross fog.
void rsv_row_process_in_fog(const rsv_row_tracer *tracer, rsv_row_scratch *scratch,
    uint32_t first_ray, const rsv_row_receiver *receiver, const float *cos_receiver,
    const rsv_ray_packet *packet);

/// Notes that a ray ends in the fog. @param entered as in rsv_row_record_node
void rsv_row_land(const rsv_row_tracer *tracer, rsv_row_scratch *scratch, uint32_t ray,
    const rsv_gather *gather, rsv_rgb entered);

/// Notes where a ray ends that was not traced again. @param seen its kind then
void rsv_row_keep_end(rsv_row_scratch *scratch, uint32_t ray, uint32_t node, uint8_t seen);

#endif
