/// Uses the rest of a budget of elements, after all spacings that fit have been tried.
#ifndef RSV_BUDGET_FILL_H
#define RSV_BUDGET_FILL_H

#include "builder.h"

/// Splits the largest cells while the budget of elements allows it. Spacings alone would leave gaps: they divide all
/// walls of a room at once, or none.
/// @param wanted requested metres between elements: smaller cells stay whole
rsv_status rsv_budget_fill(rsv_builder *builder, float wanted);

#endif
