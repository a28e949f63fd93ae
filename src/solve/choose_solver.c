#include "choose_solver.h"

#include "linear_solver.h"

#include <stdio.h>

/// Measured on cornell-blocks and closed boxes: two grids take 4 to 8 applications and the setting-up of the coarse
/// level, which costs about as much as 3. GMRES takes more of them but no setting-up.
#define FEW_TERMS 8
/// Groups fewer than this are too coarse to be of use.
#define LEAST_GROUPS 8

rsv_solver rsv_choose_solver(const rsv_solver_question *q, char *reason, size_t reason_bytes)
{
    if (q->wanted != RSV_SOLVER_AUTO) {
        snprintf(reason, reason_bytes, "asked for");
        return q->wanted;
    }
    if (q->terms <= FEW_TERMS) {
        snprintf(reason, reason_bytes, "spectral radius %.3f: %u more orders are enough",
            q->spectral_radius, q->terms);
        return RSV_SOLVER_NEUMANN;
    }
    bool grids =
        q->map->group_count >= LEAST_GROUPS && rsv_solver_fits(RSV_SOLVER_TWO_GRID, q->map);
    snprintf(reason, reason_bytes,
        "spectral radius %.3f (norm %.3f): the series would take %u more orders, and %zu elements "
        "are %s for a coarse level",
        q->spectral_radius, q->norm_inf, q->terms, q->map->count, grids ? "enough" : "too few");
    return grids ? RSV_SOLVER_TWO_GRID : RSV_SOLVER_GMRES;
}
