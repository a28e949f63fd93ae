#include "choose_solver.h"

#include "../core/number_text.h"

#include <stdio.h>

/// Orders that the series may still take before another solver, and the residual it checks afresh, are worth it.
#define FEW_TERMS 6
/// From here on steps of Krylov methods get more with every restart, those of two grids stay the same (measured
/// on closed boxes: as many at 0.99).
#define SLOW_RADIUS 0.98
/// Minimum number of nodes for a coarse level to be useful.
#define MIN_NODES 256
/// Above this the eleven fields of GMRES weigh more than applications do: in rooms of 0.1 to 0.4 M nodes BiCGStab
/// applies the operator as often, and takes half the time.
#define MANY_NODES ((size_t)1 << 17)

rsv_solver rsv_choose_solver(const rsv_solver_question *q, char *reason, size_t reason_bytes)
{
    if (q->wanted != RSV_SOLVER_AUTO) {
        snprintf(reason, reason_bytes, "asked for");
        return q->wanted;
    }
    char radius[RSV_NUMBER_BYTES], norm[RSV_NUMBER_BYTES]; // files keep the reason
    const char *because;
    rsv_solver solver;
    if (q->terms <= FEW_TERMS)
        solver = RSV_SOLVER_NEUMANN, because = "that is few";
    else if (q->on_device)
        solver = RSV_SOLVER_BICGSTAB, because = "its steps run on the device alone";
    else if (q->spectral_radius >= SLOW_RADIUS && q->node_count >= MIN_NODES)
        solver = RSV_SOLVER_TWO_GRID, because = "the number of two-grid steps does not depend on "
                                                "it";
    else if (q->node_count > MANY_NODES)
        solver = RSV_SOLVER_BICGSTAB, because = "so many elements require a method with few fields";
    else
        solver = RSV_SOLVER_GMRES, because = "it takes the fewest applications";
    rsv_number_text(radius, 4, q->spectral_radius);
    rsv_number_text(norm, 4, q->norm_inf);
    snprintf(reason, reason_bytes,
        "spectral radius %s, norm %s, %zu elements: the series would take %u more orders; %s",
        radius, norm, q->node_count, q->terms, because);
    return solver;
}
