/// What a solution leaves to the next one, of the same scene after an edit.
#ifndef RSV_SOLVE_UPDATE_H
#define RSV_SOLVE_UPDATE_H

#include "builder.h"

/// What the solution of an earlier version of the scene knew; builder->scene points to it from then on.
/// @param history out: NULL = nothing; to be closed when the solution is done
rsv_status rsv_builder_open_history(rsv_builder *builder, rsv_history **history);

/// From here on, nothing is known of elements and their light.
void rsv_builder_forget_history(rsv_builder *builder);

/// Writes down what a finished solution knows beside its rows, if these are kept. Lets go of fields that nothing else needs.
/// A warning where it cannot be written.
void rsv_builder_keep_history(const rsv_builder *builder, rsv_light *light);

#endif
