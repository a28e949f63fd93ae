/// The pilot of a scene that was edited: it looks again at what lies near the edit, and takes the light of the rest for what
/// it was.
#ifndef RSV_PILOT_NEAR_H
#define RSV_PILOT_NEAR_H

#include "../update/update.h"
#include "builder.h"

/// What is known from before an edit that left sources as they were: other ones bend light elsewhere. NULL = nothing
const rsv_history *rsv_pilot_settled(const rsv_builder *builder);

/// The first few orders of light, with rows near the edit alone, where rsv_pilot_settled knows the rest.
/// @param far [node_count], out: nodes that it is far from, for which nothing is gathered
rsv_status rsv_pilot_solve_near(rsv_builder *builder, uint8_t *far, rsv_light **light);

#endif
