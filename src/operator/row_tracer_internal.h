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

/// Notes where a ray ends that was not traced again. @param seen its kind then
void rsv_row_keep_end(rsv_row_scratch *scratch, uint32_t ray, uint32_t node, uint8_t seen);

#endif
