/// Least squares within bounds, a linear cost besides; independent of light.
#ifndef RSV_FIT_BOUNDED_H
#define RSV_FIT_BOUNDED_H

#include "../core/core.h"

/// minimise 1/2 sum_i w_i e_i^2 + cost . x over low <= x <= high, with e = A x - b, or only its negative part
typedef struct rsv_bounded {
    rsv_context *context;
    size_t rows, columns;
    const double *a;          ///< [rows][columns]
    const double *b, *weight; ///< [rows]
    const double *cost;       ///< [columns]
    const double *low, *high; ///< [columns]
    bool one_sided;           ///< only values below b are errors
} rsv_bounded;

typedef struct rsv_bounded_report {
    uint32_t iterations;
    double kkt_residual; ///< max_k |x_k - P(x_k - g_k / H_kk)| / max(1, max high)
} rsv_bounded_report;

/// By projected Newton steps (Bertsekas 1982). @param x [columns] a start in, the minimum out
rsv_status rsv_bounded_solve(const rsv_bounded *problem, double *x, rsv_bounded_report *report);

#endif
