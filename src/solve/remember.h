/// What a solution leaves to the next one, of the same scene after an edit.
#ifndef RSV_REMEMBER_H
#define RSV_REMEMBER_H

#include "../elements/past.h"
#include "builder.h"

/// What the solution of an earlier version of the scene knew; builder->scene points to it from then on.
/// @param past out: NULL = nothing; to be closed when the solution is done
rsv_status rsv_builder_recall(rsv_builder *builder, rsv_past **past);

/// Writes down what a finished solution knows beside its rows, if these are kept. Lets go of fields that nothing else needs.
/// A warning where it cannot be written.
void rsv_builder_remember(const rsv_builder *builder, rsv_solution *light);

#endif
