/// Several E0 solved for at once, as parts of one light.
#ifndef RSV_SOLVE_FIELDS_H
#define RSV_SOLVE_FIELDS_H

#include "../solve/light.h"

/// E = E0 + G K E for every field, by the solver that the solution was found with; fields share each pass over G.
/// @param relative residual to reach, over the size of E0
/// @param source [node_count * fields] E0 in W/m^2, fields side by side; 0 at hanging nodes afterwards
/// @param solved [node_count * fields] E, out
/// @param reached whether the residual was; NULL = never mind. What is solved is good to a larger one otherwise.
rsv_status rsv_solve_fields(const rsv_light_view *light, size_t fields, double relative,
    rsv_rgb *source, rsv_rgb *solved, bool *reached);

#endif
