/// Direct light of nodes whose shadow rays the context's device traces, many nodes at a time.
#ifndef RSV_DIRECT_DEVICE_H
#define RSV_DIRECT_DEVICE_H

#include "device_direct.h"
#include "direct_receiver.h"

/// Estimates nodes in order, if there is a device that can. @param node [count] with valid points
/// @param done out: number of nodes estimated; the others, with their samples, are left to the caller
/// @return the device's failure, unless it is optional
rsv_status rsv_direct_by_device(const rsv_direct_job *job, const uint32_t *node, size_t count,
    rsv_direct_light *light, size_t *done);

#endif
