/// The contribution of a scene's environment when it is rotated about the vertical. Rows of G stay as they are, because
/// they store distant light by direction. Light found by shadow rays and photons is sampled again.
#ifndef RSV_TURNED_SURROUNDINGS_H
#define RSV_TURNED_SURROUNDINGS_H

#include "../solve/light_change.h"

/// The answer of rsv_light_relight to the same turn with all other lights off.
/// @param rotation degrees as in rsv_environment; the scene must have surroundings
/// @param turned another light of the same operator, on the same levels
rsv_status rsv_turned_surroundings_solve(
    const rsv_light *solution, float rotation, rsv_light **turned);

#endif
