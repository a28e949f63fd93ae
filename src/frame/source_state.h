/// Whether sources that no surface shows are as they were.
#ifndef RSV_SOURCE_STATE_H
#define RSV_SOURCE_STATE_H

#include "../solve/light.h"

/// A number that follows from punctual lights and surroundings: another one after any change of their strengths, colours,
/// places and directions (but for one chance in 2^32).
uint32_t rsv_source_state(const rsv_light_view *solution);

#endif
