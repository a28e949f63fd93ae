/// Solvers of x = b + A x behind one interface.
///
/// Each solver only finds a correction d such that (I - A) d is close to a given residual. The driver adds it, computes
/// the new residual from scratch with sums in double precision, and decides whether to continue. Rounding of the stored
/// floats can therefore not accumulate, Krylov methods restart at no cost, and stagnation looks the same for all
/// solvers.
///
/// Columns of a field are independent systems. A column that has converged, or whose source is 0, is skipped.
#ifndef RSV_LINEAR_SOLVER_H
#define RSV_LINEAR_SOLVER_H

#include "linear_map.h"
#include "resolvent/solve.h"

typedef struct rsv_linear_desc {
    rsv_solver solver; ///< not RSV_SOLVER_AUTO
    double relative;   ///< a column has converged when max |residual| <= relative max |source| ...
    double absolute;   ///< ... or max |residual| <= absolute
    double max_applications;
    double spectral_radius; ///< of A as far as known, for Chebyshev; 0 = estimate it on the way
    /// Called with each residual: applications of A so far, and the largest max |residual| / max |source| of a column.
    /// NULL = none
    void (*observe)(void *user, double applications, double residual);
    void *user;
} rsv_linear_desc;

typedef struct rsv_linear_report {
    rsv_stop_reason stop_reason;
    double applications; ///< of A, or passes over its entries that cost as much
    double residual;     ///< largest |residual|, accumulated in double
    uint32_t cycles;     ///< corrections added
} rsv_linear_report;

/// Relative 1e-5, any number of applications up to 10 000, no spectral radius.
rsv_linear_desc rsv_default_linear_desc(rsv_solver solver);

/// What a solver needs of a map besides products.
typedef struct rsv_solver_needs {
    bool rows, columns, groups; ///< scatter_rows and gather_rows, shoot, sum_groups
    bool outside;               ///< correct
} rsv_solver_needs;

rsv_solver_needs rsv_solver_needs_of(rsv_solver solver);

/// Whether the map provides what the solver needs.
bool rsv_solver_fits(rsv_solver solver, const rsv_linear_map *map);

/// Solves x = source + A x.
/// @param source, solution [count x columns]; the first guess in, the best found out
/// @return RSV_OK even if not converged: see report->stop_reason
rsv_status rsv_linear_solve(const rsv_linear_map *map, size_t columns, const float *source,
    const rsv_linear_desc *desc, float *solution, rsv_linear_report *report);

#endif
