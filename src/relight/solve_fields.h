/// Several E0 solved for at once, as parts of one light.
#ifndef RSV_SOLVE_FIELDS_H
#define RSV_SOLVE_FIELDS_H

#include "../solve/light.h"

/// Solves E = E0 + G K E for all fields, with the solver of the solution. Fields share each pass over G.
/// @param relative residual to reach, relative to E0
/// @param source [node_count * fields] E0 in W/m2, fields side by side; afterwards 0 at hanging nodes
/// @param solved [node_count * fields] E, out
/// @param reached out: whether the residual was reached; otherwise the result has a larger one. May be NULL
rsv_status rsv_solve_fields(const rsv_light_view *light, size_t fields, double relative,
    rsv_rgb *source, rsv_rgb *solved, bool *reached);

#endif
