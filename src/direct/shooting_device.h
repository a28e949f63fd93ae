/// Photons that the context's device shoots.
#ifndef RSV_SHOOTING_DEVICE_H
#define RSV_SHOOTING_DEVICE_H

#include "device_shooting.h"

/// Traces as many photons from each source as its part of `count`, if there is a device that can.
/// @param deal without its hierarchy @param done out: whether the maps hold the result; otherwise they are unchanged
/// @return the device's failure, unless it is optional
rsv_status rsv_photons_by_device(
    const rsv_device_shooting_desc *deal, uint32_t count, uint64_t *rays, bool *done);

#endif
