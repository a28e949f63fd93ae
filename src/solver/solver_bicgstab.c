/// BiCGStab (van der Vorst 1992) on (I - A) d = r: two applications per step, six fields.
#include "solver_run.h"

#include <math.h>
#include <string.h>

/// A product this small against the norms of its factors is nothing.
#define NOTHING 1e-14

typedef struct stabilised {
    float *shadow, *p, *v, *t;
    double *rho, *alpha, *omega, *beta, *minus; ///< [columns]
    double *a, *b;                              ///< [columns] scalar products
    double *shadow_length;                      ///< [columns]
} stabilised;

/// image = (I - A) field
static void apply_system(rsv_solver_run *run, const float *field, float *image)
{
    rsv_run_apply(run, field, image);
    size_t values = run->shape.count * run->shape.columns;
    for (size_t k = 0; k < values; k++)
        image[k] = field[k] - image[k];
}

/// quotient = a / b in active columns, 0 elsewhere; notes a breakdown.
static void divide(rsv_solver_run *run, const double *a, const double *b, double *quotient)
{
    for (size_t c = 0; c < run->shape.columns; c++) {
        quotient[c] = 0;
        if (!rsv_run_active(run, c)) continue;
        if (fabs(b[c]) > 0 && isfinite(a[c] / b[c]))
            quotient[c] = a[c] / b[c];
        else
            run->broke_down = true;
    }
}

static void negate(const rsv_solver_run *run, const double *value, double *negative)
{
    for (size_t c = 0; c < run->shape.columns; c++)
        negative[c] = -value[c];
}

/// beta = (rho_new / rho) (alpha / omega)
static void find_beta(rsv_solver_run *run, stabilised *s, const double *rho)
{
    for (size_t c = 0; c < run->shape.columns; c++) {
        s->beta[c] = 0;
        if (!rsv_run_active(run, c)) continue;
        double beta = rho[c] / s->rho[c] * (s->alpha[c] / s->omega[c]);
        if (isfinite(beta))
            s->beta[c] = beta;
        else
            run->broke_down = true;
    }
    memcpy(s->rho, rho, run->shape.columns * sizeof *rho);
}

/// Whether the residual has turned away from its shadow: the next step would divide by next to nothing.
/// @param product <shadow, residual>
static bool lost_shadow(
    rsv_solver_run *run, stabilised *s, const float *residual, const double *product)
{
    rsv_columns_dot(&run->shape, residual, residual, s->b);
    for (size_t c = 0; c < run->shape.columns; c++)
        if (rsv_run_active(run, c) &&
            fabs(product[c]) <= NOTHING * sqrt(s->b[c]) * s->shadow_length[c])
            return true;
    return false;
}

static void step(rsv_solver_run *run, stabilised *s, float *residual, float *correction)
{
    const rsv_field_shape *shape = &run->shape;
    apply_system(run, s->p, s->v);
    rsv_columns_dot(shape, s->shadow, s->v, s->a);
    divide(run, s->rho, s->a, s->alpha);
    negate(run, s->alpha, s->minus);
    rsv_columns_add(shape, s->minus, s->v, residual);
    rsv_columns_add(shape, s->alpha, s->p, correction);
    rsv_columns_max(shape, residual, run->size);
    apply_system(run, residual, s->t);
    rsv_columns_dot(shape, s->t, residual, s->a);
    rsv_columns_dot(shape, s->t, s->t, s->b);
    divide(run, s->a, s->b, s->omega);
    rsv_columns_add(shape, s->omega, residual, correction);
    negate(run, s->omega, s->minus);
    rsv_columns_add(shape, s->minus, s->t, residual);
    rsv_columns_max(shape, residual, run->size);
}

/// p = residual + beta (p - omega v)
static void turn(rsv_solver_run *run, stabilised *s, const float *residual)
{
    rsv_columns_dot(&run->shape, s->shadow, residual, s->a);
    if (lost_shadow(run, s, residual, s->a)) run->broke_down = true;
    find_beta(run, s, s->a);
    rsv_columns_add(&run->shape, s->minus, s->v, s->p);
    rsv_columns_scale_add(&run->shape, residual, s->beta, s->p);
}

static rsv_status improve(rsv_solver_run *run, float *residual, float *correction)
{
    rsv_status status = RSV_OK;
    size_t columns = run->shape.columns, bytes = run->shape.count * columns * sizeof(float);
    double *numbers = rsv_run_numbers(run, 8);
    stabilised s = { rsv_run_field(run), rsv_run_field(run), rsv_run_field(run), rsv_run_field(run),
        .rho = numbers };
    if (!numbers || !s.shadow || !s.p || !s.v || !s.t) {
        status = RSV_ERROR_MEMORY;
        goto cleanup;
    }
    s.alpha = numbers + columns, s.omega = numbers + 2 * columns, s.beta = numbers + 3 * columns;
    s.minus = numbers + 4 * columns, s.a = numbers + 5 * columns, s.b = numbers + 6 * columns;
    s.shadow_length = numbers + 7 * columns;
    memcpy(s.shadow, residual, bytes);
    memcpy(s.p, residual, bytes);
    rsv_columns_dot(&run->shape, s.shadow, residual, s.rho);
    for (size_t c = 0; c < columns; c++)
        s.shadow_length[c] = sqrt(s.rho[c]);
    for (;;) {
        step(run, &s, residual, correction);
        if (!rsv_run_goes_on(run)) break;
        turn(run, &s, residual);
        if (run->broke_down) break;
    }
cleanup:
    rsv_free(run->shape.context, numbers);
    rsv_free(run->shape.context, s.shadow);
    rsv_free(run->shape.context, s.p);
    rsv_free(run->shape.context, s.v);
    rsv_free(run->shape.context, s.t);
    return status;
}

const rsv_solver_method rsv_solver_bicgstab = { .improve = improve };
