/// Rows of G whose rays the context's device traces, many rows at a time. The CPU does what follows a first hit on a
/// surface that is not plain: specular paths through mirrors and glass, and gathered emission.
#ifndef RSV_ROW_DEVICE_H
#define RSV_ROW_DEVICE_H

#include "device_rows.h"
#include "row_tracer.h"

typedef struct rsv_row_device rsv_row_device;

/// @param tracer has begun; borrowed @param rows total number of rows
/// @param made out; NULL = there is no suitable device @return the device's failure, unless it is optional
rsv_status rsv_row_device_create(const rsv_row_tracer *tracer, size_t rows, rsv_row_device **made);
void rsv_row_device_destroy(rsv_row_device *device);

/// Rows that can be traced at a time: whole blocks.
size_t rsv_row_device_most(const rsv_row_device *device);

/// Traces the rays of some rows. @param device NULL = there is none @param done out: false = the caller has to do it
/// @return the device's failure, unless it is optional
rsv_status rsv_row_device_trace(
    rsv_row_device *device, const uint32_t *node, size_t count, bool *done);

/// The results of rsv_row_trace for row `index` of the batch. @param scratch of the calling thread
void rsv_row_device_finish(const rsv_row_device *device, size_t index, rsv_row_scratch *scratch);

#endif
