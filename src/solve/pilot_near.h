/// The pilot of an edited scene: it only traces rays near the edit, and assumes that the other light has not changed.
#ifndef RSV_PILOT_NEAR_H
#define RSV_PILOT_NEAR_H

#include "../update/update.h"
#include "builder.h"

/// Results from before an edit that left the sources unchanged. (With other sources, light curves elsewhere.) NULL =
/// none
const rsv_history *rsv_pilot_settled(const rsv_builder *builder);

/// The first few orders of light, with rows near the edit only, if rsv_pilot_settled knows the rest.
/// @param far [node_count], out: nodes far from the edit, for which nothing is gathered
rsv_status rsv_pilot_solve_near(rsv_builder *builder, uint8_t *far, rsv_light **light);

#endif
