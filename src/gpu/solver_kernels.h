/// Solvers of (I - A) correction = residual that do not involve the host: numbers that control them stay on the device.
/// They work on one RGB field. Its channels are independent systems; a channel that has converged is skipped.
///
/// The methods are those of src/solver (series.c, chebyshev.c, bicgstab.c), with the same names.
#ifndef RSV_SOLVER_KERNELS_H
#define RSV_SOLVER_KERNELS_H

#include "transport_kernels.h"

/// Nodes that are summed by one item of a reduction.
#define RSV_NODES_PER_SUM 1024

/// State of a solver, by channel.
typedef struct rsv_solver_state {
    double size[3], goal[3];                    ///< max |residual|: present, and small enough
    double rho[3], alpha[3], omega[3], beta[3]; ///< BiCGStab's; omega is Chebyshev's as well
    double shadow_length[3];
    double radius[3];      ///< Chebyshev's: the spectral radius as far as it has shown
    double start[3];       ///< and sizes when the acceleration began
    uint32_t plain, steps; ///< plain terms so far, and steps of the acceleration
    uint32_t broke_down;   ///< whether a division by zero would have occurred
} rsv_solver_state;

/// Fields are [node_count].
typedef struct rsv_solver_args {
    rsv_solver_state *state;
    struct rsv_totals *part; ///< [part_count] of RSV_NODES_PER_SUM nodes each
    uint32_t node_count, part_count;
    rsv_rgb *residual, *correction;
    rsv_rgb *shadow, *t;
    rsv_rgb *p;           ///< Chebyshev's direction
    rsv_rgb *v;           ///< its image, and the series' next term
    const rsv_rgb *a, *b; ///< the fields to reduce
    double relative;      ///< of the sizes in the beginning
} rsv_solver_args;

// ---- reductions ----------------------------------------------------------------------------------

/// Sums in double: <a, b>, <b, b> and max |b|.
typedef struct rsv_totals {
    double product[3], square[3], most[3];
} rsv_totals;

/// The larger one; NaN if one of them is.
RSV_INLINE double rsv_larger(double a, double b) { return a >= b ? a : b > a ? b : NAN; }

RSV_INLINE rsv_totals rsv_totals_add(rsv_totals x, rsv_totals y)
{
    rsv_totals sum;
    for (int c = 0; c < 3; c++) {
        sum.product[c] = x.product[c] + y.product[c];
        sum.square[c] = x.square[c] + y.square[c];
        sum.most[c] = rsv_larger(x.most[c], y.most[c]);
    }
    return sum;
}

RSV_INLINE rsv_totals rsv_totals_of(rsv_rgb a, rsv_rgb b)
{
    const double x[3] = { (double)a.r, (double)a.g, (double)a.b };
    const double y[3] = { (double)b.r, (double)b.g, (double)b.b };
    rsv_totals t;
    for (int c = 0; c < 3; c++) {
        t.product[c] = x[c] * y[c];
        t.square[c] = y[c] * y[c];
        t.most[c] = fabs(y[c]);
    }
    return t;
}

RSV_INLINE rsv_totals rsv_no_totals(void)
{
    rsv_totals none = { { 0, 0, 0 }, { 0, 0, 0 }, { 0, 0, 0 } };
    return none;
}

RSV_INLINE rsv_totals rsv_reduce_lane(const rsv_solver_args *a, uint32_t part, uint32_t lane)
{
    rsv_totals sum = rsv_no_totals();
    uint32_t begin = part * RSV_NODES_PER_SUM, end = begin + RSV_NODES_PER_SUM;
    if (end > a->node_count) end = a->node_count;
    for (uint32_t n = begin + lane; n < end; n += RSV_LANES)
        sum = rsv_totals_add(sum, rsv_totals_of(a->a[n], a->b[n]));
    return sum;
}

RSV_INLINE void rsv_reduce_store(const rsv_solver_args *a, uint32_t part, rsv_totals sum)
{
    a->part[part] = sum;
}

/// The sums of all parts, for the kernels of one item that decide.
RSV_INLINE rsv_totals rsv_total_lane(const rsv_solver_args *a, uint32_t item, uint32_t lane)
{
    rsv_totals sum = rsv_no_totals();
    (void)item;
    for (uint32_t part = lane; part < a->part_count; part += RSV_LANES)
        sum = rsv_totals_add(sum, a->part[part]);
    return sum;
}

RSV_KERNEL_SUM(
    reduce, rsv_solver_args, rsv_totals, rsv_reduce_lane, rsv_totals_add, rsv_reduce_store)

/// A kernel that decides from the sums of all parts.
#define RSV_KERNEL_DECIDE(name, store)                                                             \
    RSV_KERNEL_SUM(name, rsv_solver_args, rsv_totals, rsv_total_lane, rsv_totals_add, store)

// ---- numbers and fields --------------------------------------------------------------------------

RSV_INLINE bool rsv_is_active(const rsv_solver_state *s, int channel)
{
    return s->size[channel] > s->goal[channel];
}

/// a / b where the channel is active, 0 elsewhere; notes a breakdown.
RSV_INLINE double rsv_divide(rsv_solver_state *s, int channel, double a, double b)
{
    double quotient = a / b;
    if (!rsv_is_active(s, channel)) return 0;
    if (fabs(b) > 0 && fabs(quotient) < 1e300) return quotient;
    s->broke_down = 1;
    return 0;
}

/// y + factor x
RSV_INLINE rsv_rgb rsv_add_scaled(rsv_rgb y, const double factor[3], rsv_rgb x)
{
    return rgb(
        y.r + (float)factor[0] * x.r, y.g + (float)factor[1] * x.g, y.b + (float)factor[2] * x.b);
}

/// Sizes and goals of the residual that a solver starts with; <shadow, residual>, which is its square.
RSV_INLINE void rsv_begin_store(const rsv_solver_args *a, uint32_t item, rsv_totals sum)
{
    rsv_solver_state *s = a->state;
    (void)item;
    for (int c = 0; c < 3; c++) {
        s->size[c] = sum.most[c];
        s->goal[c] = a->relative * sum.most[c];
        s->rho[c] = sum.square[c];
        s->shadow_length[c] = sqrt(sum.square[c]);
        s->omega[c] = 1;
        s->alpha[c] = s->beta[c] = s->radius[c] = s->start[c] = 0;
    }
    s->plain = s->steps = s->broke_down = 0;
}

RSV_KERNEL_DECIDE(begin, rsv_begin_store)

// ---- the series ----------------------------------------------------------------------------------

/// correction += residual, in active channels.
RSV_INLINE void rsv_series_add_item(const rsv_solver_args *a, uint32_t n)
{
    const rsv_solver_state *s = a->state;
    const double one[3] = { (double)rsv_is_active(s, 0), (double)rsv_is_active(s, 1),
        (double)rsv_is_active(s, 2) };
    a->correction[n] = rsv_add_scaled(a->correction[n], one, a->residual[n]);
}

RSV_KERNEL(series_add, rsv_solver_args, rsv_series_add_item)

RSV_INLINE void rsv_series_store(const rsv_solver_args *a, uint32_t item, rsv_totals sum)
{
    (void)item;
    for (int c = 0; c < 3; c++)
        a->state->size[c] = sum.most[c];
}

RSV_KERNEL_DECIDE(series_check, rsv_series_store)

#endif
