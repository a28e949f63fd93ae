/// Light from each light at each of many receivers.
#ifndef RSV_FIT_READINGS_H
#define RSV_FIT_READINGS_H

#include "../relight/light_response.h"
#include "resolvent/fit.h"

/// Rays are followed once for all lights; where that does not do (rsv_probe_ends), light by light.
/// @param samples gather rays of a reading @param reading [count][responses->count] out, W/m2
rsv_status rsv_fit_read(const rsv_light_view *whole, const rsv_light_responses *responses,
    const rsv_fit_wanted *wanted, size_t count, const rsv_fit_desc *desc, rsv_rgb *reading);

#endif
