/// What the surroundings of a scene do by themselves when they are turned about the vertical. Rows of G stay as they
/// are: they know light from afar direction by direction. What shadow rays and photons find is sampled anew.
#ifndef RSV_TURNED_SURROUNDINGS_H
#define RSV_TURNED_SURROUNDINGS_H

#include "../solve/light_change.h"

/// The answer of rsv_light_relight to the same turn with all other lights off.
/// @param rotation degrees as in rsv_environment; the scene must have surroundings
/// @param turned another light of the same operator, on the same levels
rsv_status rsv_turned_surroundings_solve(
    const rsv_light *solution, float rotation, rsv_light **turned);

#endif
