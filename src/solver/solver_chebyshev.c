/// Chebyshev semi-iteration (Golub and Varga 1961): if the eigenvalues of A are real and within [-rho, rho], no other
/// combination of the terms of the Neumann series has a smaller worst case. Light transport is close to that: by
/// reciprocity, A is similar to a symmetric map, up to the noise of its rows.
///
/// It needs no dot products, but rho. A few plain terms give a lower bound. If the residual then falls more slowly than
/// predicted, rho was too small, and the cycle ends with a larger one.
#include "solver_run.h"

#include <math.h>

#define PLAIN_TERMS 4
/// Number of steps between comparisons with the prediction, and the tolerance.
#define CHECK_INTERVAL 8
#define FORGIVEN 4.0

typedef struct semi_iteration {
    double *radius, *omega; ///< [columns]
    double *start;          ///< [columns] sizes when the acceleration began
    float *direction, *image;
} semi_iteration;

/// One step: direction = omega residual + (omega - 1) direction; then correction and residual follow it.
static void advance(rsv_solver_run *run, semi_iteration *s, float *residual, float *correction)
{
    size_t columns = run->shape.columns;
    for (size_t n = 0; n < run->shape.count; n++) {
        for (size_t c = 0; c < columns; c++) {
            size_t k = n * columns + c;
            float omega = rsv_run_active(run, c) ? (float)s->omega[c] : 0;
            s->direction[k] = omega > 0 ? omega * residual[k] + (omega - 1) * s->direction[k] : 0;
            correction[k] += s->direction[k];
        }
    }
    rsv_run_apply(run, s->direction, s->image);
    rsv_columns_subtract(&run->shape, s->direction, residual);
    rsv_columns_sum(&run->shape, s->image, residual);
}

/// Terms of the plain series, which show the spectral radius. @return whether to go on
static bool find_radius(rsv_solver_run *run, semi_iteration *s, float *residual, float *correction)
{
    bool goes_on = true;
    for (size_t c = 0; c < run->shape.columns; c++)
        s->omega[c] = 1;
    for (int term = 0; term < PLAIN_TERMS && goes_on; term++) {
        for (size_t c = 0; c < run->shape.columns; c++)
            s->start[c] = run->size[c];
        advance(run, s, residual, correction);
        rsv_columns_max(&run->shape, residual, run->size);
        goes_on = rsv_run_goes_on(run);
    }
    for (size_t c = 0; c < run->shape.columns; c++)
        s->radius[c] = s->start[c] > 0 ? run->size[c] / s->start[c] : 0;
    return goes_on;
}

/// Reduction predicted by Chebyshev polynomials: 1 / T_k(1 / radius).
static double promised(double radius, uint32_t steps)
{
    return radius > 0 ? 1 / cosh(steps * acosh(fmax(1 / radius, 1))) : 0;
}

/// Halves the distance of a radius from 1 where the residual stays behind. @return whether one did
static bool raise_radius(const rsv_solver_run *run, semi_iteration *s, uint32_t steps)
{
    bool raised = false;
    for (size_t c = 0; c < run->shape.columns; c++) {
        double expected = FORGIVEN * promised(s->radius[c], steps) * s->start[c];
        if (!rsv_run_active(run, c) || run->size[c] <= expected) continue;
        s->radius[c] = (1 + s->radius[c]) / 2;
        raised = true;
    }
    return raised;
}

static void accelerate(rsv_solver_run *run, semi_iteration *s, float *residual, float *correction)
{
    uint32_t steps = 0;
    for (;;) {
        for (size_t c = 0; c < run->shape.columns && steps == 0; c++)
            s->start[c] = run->size[c];
        for (size_t c = 0; c < run->shape.columns; c++) {
            double square = s->radius[c] * s->radius[c];
            s->omega[c] = steps == 0   ? 1
                          : steps == 1 ? 2 / (2 - square)
                                       : 1 / (1 - square * s->omega[c] / 4);
        }
        advance(run, s, residual, correction);
        rsv_columns_max(&run->shape, residual, run->size);
        if (!rsv_run_goes_on(run)) return;
        if (++steps % CHECK_INTERVAL == 0 && raise_radius(run, s, steps)) steps = 0;
    }
}

static rsv_status improve(rsv_solver_run *run, float *residual, float *correction)
{
    rsv_status status = RSV_OK;
    size_t columns = run->shape.columns;
    double *numbers = rsv_run_numbers(run, 3);
    semi_iteration s = { .direction = rsv_run_field(run), .image = rsv_run_field(run) };
    if (!numbers || !s.direction || !s.image) {
        status = RSV_ERROR_MEMORY;
        goto cleanup;
    }
    s.radius = numbers, s.omega = numbers + columns, s.start = numbers + 2 * columns;
    bool goes_on = true;
    for (size_t c = 0; c < columns; c++)
        s.radius[c] = run->desc->spectral_radius;
    if (run->desc->spectral_radius <= 0) goes_on = find_radius(run, &s, residual, correction);
    if (goes_on) accelerate(run, &s, residual, correction);
cleanup:
    rsv_free(run->shape.context, numbers);
    rsv_free(run->shape.context, s.direction);
    rsv_free(run->shape.context, s.image);
    return status;
}

const rsv_solver_method rsv_solver_chebyshev = { .improve = improve };
