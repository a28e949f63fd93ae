#include "bounded.h"

#include <math.h>
#include <string.h>

#define MOST_STEPS 500
#define WANTED_RESIDUAL 1e-9
#define RIDGE                                                                                      \
    1e-12 ///< of the largest diagonal: columns that depend on each other have a minimum, too
#define MOST_DAMPING 1e3 ///< likewise, where steps lead too far
#define MORE_DAMPING 100
#define SUFFICIENT 1e-4
#define MOST_HALVINGS 40

typedef struct newton {
    const rsv_bounded *p;
    double *x, *trial;
    double *error;    ///< [rows]
    double *gradient; ///< [columns]
    double *hessian;  ///< [columns][columns]
    double *factor;   ///< Cholesky factor
    double *step;     ///< [columns]
    double ridge;     ///< added to the diagonal
    size_t *free;     ///< [columns] those not held by a bound
    size_t free_count;
} newton;

static double clamped(const rsv_bounded *p, size_t k, double x)
{
    return fmin(fmax(x, p->low[k]), p->high[k]);
}

/// Errors that count. @return the objective
static double find_errors(const rsv_bounded *p, const double *x, double *error)
{
    double sum = 0;
    for (size_t i = 0; i < p->rows; i++) {
        double e = -p->b[i];
        for (size_t k = 0; k < p->columns; k++)
            e += p->a[i * p->columns + k] * x[k];
        error[i] = p->one_sided && e > 0 ? 0 : e;
        sum += 0.5 * p->weight[i] * error[i] * error[i];
    }
    for (size_t k = 0; k < p->columns; k++)
        sum += p->cost[k] * x[k];
    return sum;
}

static void add_row(const newton *n, size_t i)
{
    const rsv_bounded *p = n->p;
    const double *a = p->a + i * p->columns;
    double w = p->weight[i];
    for (size_t k = 0; k < p->columns; k++) {
        n->gradient[k] += w * n->error[i] * a[k];
        for (size_t l = 0; l <= k; l++)
            n->hessian[k * p->columns + l] += w * a[k] * a[l];
    }
}

static void differentiate(const newton *n)
{
    const rsv_bounded *p = n->p;
    size_t columns = p->columns;
    memset(n->hessian, 0, columns * columns * sizeof *n->hessian);
    memcpy(n->gradient, p->cost, columns * sizeof *n->gradient);
    for (size_t i = 0; i < p->rows; i++)
        if (!p->one_sided || n->error[i] < 0) add_row(n, i);
    for (size_t k = 0; k < columns; k++)
        n->hessian[k * columns + k] += n->ridge;
}

/// The largest element on the diagonal if all errors count.
static double find_scale(const rsv_bounded *p)
{
    double largest = 0;
    for (size_t k = 0; k < p->columns; k++) {
        double sum = 0;
        for (size_t i = 0; i < p->rows; i++)
            sum += p->weight[i] * p->a[i * p->columns + k] * p->a[i * p->columns + k];
        largest = fmax(largest, sum);
    }
    return largest > 0 ? largest : 1;
}

/// How far from a minimum, and which columns are free to move.
static double find_free(newton *n)
{
    const rsv_bounded *p = n->p;
    double residual = 0, range = 1;
    n->free_count = 0;
    for (size_t k = 0; k < p->columns; k++) {
        double g = n->gradient[k], h = n->hessian[k * p->columns + k];
        range = fmax(range, p->high[k]);
        residual = fmax(residual, fabs(n->x[k] - clamped(p, k, n->x[k] - g / h)));
        bool held = (n->x[k] <= p->low[k] && g >= 0) || (n->x[k] >= p->high[k] && g <= 0);
        if (!held) n->free[n->free_count++] = k;
    }
    return residual / range;
}

/// (H + damping) d = -g over the free columns.
static void find_step(const newton *n, double damping)
{
    size_t count = n->free_count, columns = n->p->columns;
    double *l = n->factor, *d = n->step;
    for (size_t i = 0; i < count; i++) {
        for (size_t j = 0; j <= i; j++) {
            double sum = n->hessian[n->free[i] * columns + n->free[j]] + (i == j ? damping : 0);
            for (size_t k = 0; k < j; k++)
                sum -= l[i * columns + k] * l[j * columns + k];
            // rounding may make the remainder negative
            l[i * columns + j] = i == j ? sqrt(fmax(sum, 1e-300)) : sum / l[j * columns + j];
        }
        double sum = -n->gradient[n->free[i]];
        for (size_t k = 0; k < i; k++)
            sum -= l[i * columns + k] * d[k];
        d[i] = sum / l[i * columns + i];
    }
    for (size_t i = count; i-- > 0;) {
        for (size_t k = i + 1; k < count; k++)
            d[i] -= l[k * columns + i] * d[k];
        d[i] /= l[i * columns + i];
    }
}

/// Goes along the step as far as it improves, bent by the bounds. @return whether it does
static bool take_step(newton *n, double *objective)
{
    const rsv_bounded *p = n->p;
    double length = 1;
    for (int h = 0; h < MOST_HALVINGS; h++, length /= 2) {
        double expected = 0;
        memcpy(n->trial, n->x, p->columns * sizeof *n->trial);
        for (size_t i = 0; i < n->free_count; i++) {
            size_t k = n->free[i];
            n->trial[k] = clamped(p, k, n->x[k] + length * n->step[i]);
            expected += n->gradient[k] * (n->x[k] - n->trial[k]);
        }
        double found = find_errors(p, n->trial, n->error);
        if (!(expected > 0) || found > *objective - SUFFICIENT * expected) continue;
        memcpy(n->x, n->trial, p->columns * sizeof *n->x);
        *objective = found;
        return true;
    }
    return false;
}

/// Steps more and more along the gradient, until one leads down.
static bool step_down(newton *n, double *objective)
{
    double most = MOST_DAMPING * n->ridge / RIDGE;
    for (double damping = 0; damping <= most;
         damping = damping > 0 ? MORE_DAMPING * damping : n->ridge) {
        find_step(n, damping);
        if (take_step(n, objective)) return true;
    }
    return false;
}

static void iterate(newton *n, rsv_bounded_report *report)
{
    double objective = find_errors(n->p, n->x, n->error);
    n->ridge = RIDGE * find_scale(n->p);
    for (report->iterations = 0; report->iterations < MOST_STEPS; report->iterations++) {
        differentiate(n);
        report->kkt_residual = find_free(n);
        if (report->kkt_residual < WANTED_RESIDUAL || !n->free_count) return;
        if (!step_down(n, &objective)) return; // to rounding
    }
}

rsv_status rsv_bounded_solve(const rsv_bounded *p, double *x, rsv_bounded_report *report)
{
    size_t columns = p->columns;
    newton n = { .p = p, .x = x };
    *report = (rsv_bounded_report){ 0 };
    n.trial = rsv_alloc(p->context, columns, sizeof *n.trial);
    n.error = rsv_alloc(p->context, p->rows, sizeof *n.error);
    n.gradient = rsv_alloc(p->context, columns, sizeof *n.gradient);
    n.hessian = rsv_alloc(p->context, columns * columns, sizeof *n.hessian);
    n.factor = rsv_alloc(p->context, columns * columns, sizeof *n.factor);
    n.step = rsv_alloc(p->context, columns, sizeof *n.step);
    n.free = rsv_alloc(p->context, columns, sizeof *n.free);
    bool ready = n.trial && n.error && n.gradient && n.hessian && n.factor && n.step && n.free;
    for (size_t k = 0; k < columns; k++)
        x[k] = clamped(p, k, x[k]);
    if (ready) iterate(&n, report);
    rsv_free(p->context, n.trial);
    rsv_free(p->context, n.error);
    rsv_free(p->context, n.gradient);
    rsv_free(p->context, n.hessian);
    rsv_free(p->context, n.factor);
    rsv_free(p->context, n.step);
    rsv_free(p->context, n.free);
    return ready ? RSV_OK : RSV_ERROR_MEMORY;
}
