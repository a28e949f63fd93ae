/// BiCGStab (src/solver/bicgstab.c), step by step.
#ifndef RSV_BICGSTAB_KERNELS_H
#define RSV_BICGSTAB_KERNELS_H

#include "solver_kernels.h"

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
