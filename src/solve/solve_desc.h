#ifndef RSV_SOLVE_DESC_H
#define RSV_SOLVE_DESC_H

#include "../core/core.h"
#include "resolvent/solve.h"

/// The fewest rays of a row.
#define RSV_FEWEST_RAYS 64
#define RSV_MOST_RAYS 4096

/// RSV_ERROR_ARGUMENT where a number is out of range.
rsv_status rsv_check_solve_desc(const rsv_solve_desc *desc);

#endif
