/// Direct light of nodes whose shadow rays the context's device traces, many nodes at a time.
#ifndef RSV_DIRECT_DEVICE_H
#define RSV_DIRECT_DEVICE_H

#include "device_direct.h"
#include "direct_receiver.h"

/// Estimates nodes in order, as long as there is a device that can. @param node [count] with valid points
/// @param done out: how many of them; the others are left to the caller, as is what they need
/// @return the device's failure, unless it is optional
rsv_status rsv_direct_by_device(const rsv_direct_job *job, const uint32_t *node, size_t count,
    rsv_direct_light *light, size_t *done);

#endif
