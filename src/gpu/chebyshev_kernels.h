/// Chebyshev acceleration (src/solver/chebyshev.c), step by step.
#ifndef RSV_CHEBYSHEV_KERNELS_H
#define RSV_CHEBYSHEV_KERNELS_H

#include "solver_kernels.h"

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

/// Reduction predicted by Chebyshev polynomials: 1 / T_k(1 / radius).
RSV_INLINE double rsv_chebyshev_promise(double radius, uint32_t steps)
{
    double x = radius > 0 ? 1 / radius : 0;
    return radius > 0 ? 1 / cosh((double)steps * acosh(x > 1 ? x : 1)) : 0;
}

/// The factor of the next step.
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

#endif
