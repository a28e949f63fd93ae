/// Results that a solution leaves to the next one of the same scene after an edit.
#ifndef RSV_SOLVE_UPDATE_H
#define RSV_SOLVE_UPDATE_H

#include "builder.h"

/// Opens the results of an earlier version of the scene; builder->scene then points to them.
/// @param history out: NULL = none; close it when the solution is done
rsv_status rsv_builder_open_history(rsv_builder *builder, rsv_history **history);

/// From here on, nothing is known of elements and their light.
void rsv_builder_forget_history(rsv_builder *builder);

/// Stores the results of a finished solution besides its rows, if these are stored. Frees fields that nothing else
/// needs. If writing fails, this is a warning.
void rsv_builder_keep_history(const rsv_builder *builder, rsv_light *light);

#endif
