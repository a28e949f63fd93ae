/// Pilots: solutions with few rays that show where coarse elements are too large, for the goal or for the indirect
/// light.
#ifndef RSV_PILOT_H
#define RSV_PILOT_H

#include "builder.h"

/// Whether elements are chosen for a picture or for sensors. They start larger then, by RSV_GOAL_LEARNED.
bool rsv_pilot_has_goal(const rsv_builder *builder);

/// Splits coarse elements until pilots find no more to split, or the budgets are used up.
rsv_status rsv_pilot_refine(rsv_builder *builder);

#endif
