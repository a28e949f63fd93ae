/// Whether sources that no surface shows are as they were.
#ifndef RSV_SOURCE_STATE_H
#define RSV_SOURCE_STATE_H

#include "../solve/light.h"

/// A hash of punctual lights and environment, which changes with their strengths, colours, positions and directions
/// (except with a probability of 2^-32).
uint32_t rsv_source_state(const rsv_light_view *solution);

#endif
