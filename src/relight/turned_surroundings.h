/// What the surroundings of a scene do by themselves when they are turned about the vertical. Rows of G stay as they
/// are: they know light from afar direction by direction. What shadow rays and photons find is sampled anew.
#ifndef RSV_TURNED_SURROUNDINGS_H
#define RSV_TURNED_SURROUNDINGS_H

#include "../solve/solution.h"

/// The answer of rsv_solution_relight to the same turn with all other lights off.
/// @param rotation degrees as in rsv_environment; the scene must have surroundings
/// @param turned for rsv_solution_irradiance with all orders and for probes, and for nothing else; to be freed by
/// rsv_turned_surroundings_free even after an error. The solution must outlive it.
rsv_status rsv_turned_surroundings_solve(
    const rsv_solution *solution, float rotation, rsv_solution *turned);
void rsv_turned_surroundings_free(rsv_solution *turned);

#endif
