/// What a budget of elements leaves once all spacings that fit have been tried.
#ifndef RSV_BUDGET_FILL_H
#define RSV_BUDGET_FILL_H

#include "builder.h"

/// Splits the largest cells as long as the budget of elements has room for that. Spacings alone jump: all walls of a room are
/// divided at once, or none.
/// @param wanted metres between elements: smaller cells stay whole
rsv_status rsv_budget_fill(rsv_builder *builder, float wanted);

#endif
