/// Solvers of (I - A) correction = residual that never ask the host: numbers that decide stay on the device. One RGB
/// field; its channels are systems of their own, and one that has arrived is left alone.
///
/// The methods are those of src/solve (series.c, chebyshev.c, bicgstab.c), with the same names.
#ifndef RSV_SOLVER_KERNELS_H
#define RSV_SOLVER_KERNELS_H

#include "transport_kernels.h"

/// Nodes that are summed by one item of a reduction.
#define RSV_NODES_PER_SUM 1024

/// What a solver knows, channel by channel.
typedef struct rsv_solver_state {
    double size[3], goal[3];                    ///< max |residual|: present, and small enough
    double rho[3], alpha[3], omega[3], beta[3]; ///< BiCGStab's; omega is Chebyshev's as well
    double shadow_length[3];
    double radius[3];      ///< Chebyshev's: the spectral radius as far as it has shown
    double start[3];       ///< and sizes when the acceleration began
    uint32_t plain, steps; ///< plain terms so far, and steps of the acceleration
    uint32_t broke_down;   ///< whether something had to be divided by nothing
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
    const rsv_rgb *a, *b; ///< what is reduced
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

// ---- Chebyshev -----------------------------------------------------------------------------------

#define RSV_CHEBYSHEV_PLAIN_TERMS 4
#define RSV_CHEBYSHEV_CHECK_INTERVAL 8
#define RSV_CHEBYSHEV_FORGIVEN 4.0

/// direction = omega residual + (omega - 1) direction; correction follows.
RSV_INLINE void rsv_chebyshev_turn_item(const rsv_solver_args *a, uint32_t n)
{
    const rsv_solver_state *s = a->state;
    float omega[3], *p = &a->p[n].r, *x = &a->correction[n].r;
    const float *r = &a->residual[n].r;
    for (int c = 0; c < 3; c++) {
        omega[c] = rsv_is_active(s, c) ? (float)s->omega[c] : 0;
        p[c] = omega[c] > 0 ? omega[c] * r[c] + (omega[c] - 1) * p[c] : 0;
        x[c] += p[c];
    }
}

RSV_KERNEL(chebyshev_turn, rsv_solver_args, rsv_chebyshev_turn_item)

/// residual -= direction - A direction, which is in v.
RSV_INLINE void rsv_chebyshev_follow_item(const rsv_solver_args *a, uint32_t n)
{
    a->residual[n] = rgb_sub(a->residual[n], a->v[n]);
}

RSV_KERNEL(chebyshev_follow, rsv_solver_args, rsv_chebyshev_follow_item)

/// What Chebyshev polynomials promise: 1 / T_k(1 / radius).
RSV_INLINE double rsv_chebyshev_promise(double radius, uint32_t steps)
{
    double x = radius > 0 ? 1 / radius : 0;
    return radius > 0 ? 1 / cosh((double)steps * acosh(x > 1 ? x : 1)) : 0;
}

/// The factor of the next step, after so many.
RSV_INLINE double rsv_chebyshev_omega(double radius, double omega, uint32_t steps)
{
    double square = radius * radius;
    return steps == 0 ? 1 : steps == 1 ? 2 / (2 - square) : 1 / (1 - square * omega / 4);
}

/// Halves the distance of a radius from 1 where the residual stays behind the promise. @return whether it did
RSV_INLINE bool rsv_chebyshev_raise(rsv_solver_state *s, int c)
{
    double expected =
        RSV_CHEBYSHEV_FORGIVEN * rsv_chebyshev_promise(s->radius[c], s->steps) * s->start[c];
    if (!rsv_is_active(s, c) || s->size[c] <= expected) return false;
    s->radius[c] = (1 + s->radius[c]) / 2;
    return true;
}

/// After a step: plain terms show the spectral radius, the others are held to their promise.
RSV_INLINE void rsv_chebyshev_store(const rsv_solver_args *a, uint32_t item, rsv_totals sum)
{
    rsv_solver_state *s = a->state;
    bool raised = false;
    bool plain = s->plain < RSV_CHEBYSHEV_PLAIN_TERMS;
    (void)item;
    for (int c = 0; c < 3; c++) {
        if (plain) s->radius[c] = s->size[c] > 0 ? sum.most[c] / s->size[c] : 0;
        s->size[c] = sum.most[c];
    }
    if (plain)
        s->plain++;
    else
        s->steps++;
    if (s->steps > 0 && s->steps % RSV_CHEBYSHEV_CHECK_INTERVAL == 0)
        for (int c = 0; c < 3; c++)
            raised = rsv_chebyshev_raise(s, c) || raised;
    if (raised) s->steps = 0;
    for (int c = 0; c < 3; c++) {
        if (s->steps == 0) s->start[c] = s->size[c];
        s->omega[c] = rsv_chebyshev_omega(
            s->radius[c], s->omega[c], s->plain < RSV_CHEBYSHEV_PLAIN_TERMS ? 0 : s->steps);
    }
}

RSV_KERNEL_DECIDE(chebyshev_check, rsv_chebyshev_store)

// ---- BiCGStab ------------------------------------------------------------------------------------

/// A product this small against the norms of its factors is nothing.
#define RSV_BICGSTAB_NOTHING 1e-14

/// alpha = rho / <shadow, v>
RSV_INLINE void rsv_alpha_store(const rsv_solver_args *a, uint32_t item, rsv_totals sum)
{
    (void)item;
    for (int c = 0; c < 3; c++)
        a->state->alpha[c] = rsv_divide(a->state, c, a->state->rho[c], sum.product[c]);
}

RSV_KERNEL_DECIDE(bicgstab_alpha, rsv_alpha_store)

/// residual -= alpha v; correction += alpha p
RSV_INLINE void rsv_half_step_item(const rsv_solver_args *a, uint32_t n)
{
    const double *alpha = a->state->alpha;
    const double minus[3] = { -alpha[0], -alpha[1], -alpha[2] };
    a->residual[n] = rsv_add_scaled(a->residual[n], minus, a->v[n]);
    a->correction[n] = rsv_add_scaled(a->correction[n], alpha, a->p[n]);
}

RSV_KERNEL(bicgstab_half_step, rsv_solver_args, rsv_half_step_item)

/// omega = <t, residual> / <t, t>; t = 0 where the half step has found the answer.
RSV_INLINE void rsv_omega_store(const rsv_solver_args *a, uint32_t item, rsv_totals sum)
{
    (void)item;
    for (int c = 0; c < 3; c++)
        a->state->omega[c] =
            sum.square[c] == 0 ? 0 : rsv_divide(a->state, c, sum.product[c], sum.square[c]);
}

RSV_KERNEL_DECIDE(bicgstab_omega, rsv_omega_store)

/// correction += omega residual; residual -= omega t
RSV_INLINE void rsv_whole_step_item(const rsv_solver_args *a, uint32_t n)
{
    const double *omega = a->state->omega;
    const double minus[3] = { -omega[0], -omega[1], -omega[2] };
    a->correction[n] = rsv_add_scaled(a->correction[n], omega, a->residual[n]);
    a->residual[n] = rsv_add_scaled(a->residual[n], minus, a->t[n]);
}

RSV_KERNEL(bicgstab_whole_step, rsv_solver_args, rsv_whole_step_item)

/// beta = (rho_new / rho) (alpha / omega), from <shadow, residual>; a residual that has turned away from its shadow
/// is a breakdown.
RSV_INLINE void rsv_beta_store(const rsv_solver_args *a, uint32_t item, rsv_totals sum)
{
    rsv_solver_state *s = a->state;
    (void)item;
    for (int c = 0; c < 3; c++) {
        double rho = sum.product[c];
        s->size[c] = sum.most[c];
        double nothing = RSV_BICGSTAB_NOTHING * sqrt(sum.square[c]) * s->shadow_length[c];
        if (rsv_is_active(s, c) && !(fabs(rho) > nothing)) s->broke_down = 1;
        s->beta[c] = rsv_divide(s, c, rho * s->alpha[c], s->rho[c] * s->omega[c]);
        s->rho[c] = rho;
    }
}

RSV_KERNEL_DECIDE(bicgstab_beta, rsv_beta_store)

/// p = residual + beta (p - omega v)
RSV_INLINE void rsv_turn_item(const rsv_solver_args *a, uint32_t n)
{
    const rsv_solver_state *s = a->state;
    const double minus[3] = { -s->omega[0], -s->omega[1], -s->omega[2] };
    a->p[n] = rsv_add_scaled(a->residual[n], s->beta, rsv_add_scaled(a->p[n], minus, a->v[n]));
}

RSV_KERNEL(bicgstab_turn, rsv_solver_args, rsv_turn_item)

#endif
