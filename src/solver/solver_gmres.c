/// GMRES(m) (Saad and Schultz 1986) on (I - A) d = r: of all combinations of the first m terms of the Neumann
/// series the one with the smallest residual. One application per step; m + 1 fields.
#include "solver_run.h"

#include <math.h>

#define RESTART 10
/// A new direction that is this short once the others are taken out of it is rounding.
#define NOTHING 1e-6

/// The least-squares problem of one column.
typedef struct small_system {
    double h[RESTART + 1][RESTART]; ///< Hessenberg matrix, made triangular by rotations as it grows
    double cosine[RESTART], sine[RESTART];
    double g[RESTART + 1]; ///< right-hand side; |g[k]| is the length of the residual after k steps
    double flatness;       ///< max norm : length, of the cycle's first residual
    uint32_t steps;        ///< of this column: it may be done before others
    bool done;
} small_system;

typedef struct krylov {
    float *basis[RESTART + 1]; ///< made as they are needed: most systems converge early
    small_system *system;      ///< [columns]
    double *product, *factor;  ///< [columns]
} krylov;

/// unit = field / |field|, 0 in columns without a length. Lengths are in q->product afterwards.
static void normalise(rsv_solver_run *run, krylov *q, const float *field, float *unit)
{
    rsv_columns_dot(&run->shape, field, field, q->product);
    for (size_t c = 0; c < run->shape.columns; c++) {
        q->product[c] = sqrt(q->product[c]);
        q->factor[c] = q->product[c] > 0 ? 1 / q->product[c] : 0;
    }
    rsv_columns_scale(&run->shape, q->factor, field, unit);
}

/// Appends (I - A) basis[k], orthogonalised, as basis[k + 1]. @return false if out of memory
static bool expand(rsv_solver_run *run, krylov *q, uint32_t k)
{
    size_t columns = run->shape.columns, values = run->shape.count * columns;
    float *field = q->basis[k + 1] = rsv_run_field(run);
    if (!field) return false;
    rsv_run_apply(run, q->basis[k], field);
    for (size_t i = 0; i < values; i++)
        field[i] = q->basis[k][i] - field[i];
    for (uint32_t i = 0; i <= k; i++) {
        rsv_columns_dot(&run->shape, q->basis[i], field, q->product);
        for (size_t c = 0; c < columns; c++) {
            q->system[c].h[i][k] = q->product[c];
            q->factor[c] = -q->product[c];
        }
        rsv_columns_add(&run->shape, q->factor, q->basis[i], field);
    }
    normalise(run, q, field, field);
    for (size_t c = 0; c < columns; c++)
        q->system[c].h[k + 1][k] = q->product[c];
    return true;
}

/// Turns the new column of the Hessenberg matrix as the ones before it (Givens).
static void turn_column(small_system *s, uint32_t k)
{
    for (uint32_t i = 0; i < k; i++) {
        double upper = s->h[i][k], lower = s->h[i + 1][k];
        s->h[i][k] = s->cosine[i] * upper + s->sine[i] * lower;
        s->h[i + 1][k] = s->cosine[i] * lower - s->sine[i] * upper;
    }
}

/// One more rotation makes the matrix triangular again.
static void eliminate(small_system *s, uint32_t k, double length)
{
    s->cosine[k] = s->h[k][k] / length;
    s->sine[k] = s->h[k + 1][k] / length;
    s->h[k][k] = length;
    s->h[k + 1][k] = 0;
    s->g[k + 1] = -s->sine[k] * s->g[k];
    s->g[k] *= s->cosine[k];
    s->steps = k + 1;
}

/// One more step of a column's least-squares problem.
static void advance(rsv_solver_run *run, small_system *s, size_t c, uint32_t k)
{
    if (s->done || !rsv_run_active(run, c)) return;
    s->done = s->h[k + 1][k] <= NOTHING; // no new direction: this step solves the system ...
    turn_column(s, k);
    double length = hypot(s->h[k][k], s->h[k + 1][k]);
    if (length <= NOTHING) { // ... unless I - A maps the last direction to nothing
        run->broke_down = s->done = true;
        return;
    }
    eliminate(s, k, length);
    // the max norm is taken to keep its proportion to the length; the driver looks at it afresh
    run->size[c] = fabs(s->g[k + 1]) * s->flatness;
}

/// Adds the best combination of the basis: back substitution, then one pass per direction.
static void combine(rsv_solver_run *run, krylov *q, uint32_t steps, float *correction)
{
    for (size_t c = 0; c < run->shape.columns; c++) {
        small_system *s = &q->system[c];
        for (uint32_t i = s->steps; i-- > 0;) {
            for (uint32_t j = i + 1; j < s->steps; j++)
                s->g[i] -= s->h[i][j] * s->g[j];
            s->g[i] /= s->h[i][i];
        }
    }
    for (uint32_t i = 0; i < steps; i++) {
        for (size_t c = 0; c < run->shape.columns; c++)
            q->factor[c] = i < q->system[c].steps ? q->system[c].g[i] : 0;
        rsv_columns_add(&run->shape, q->factor, q->basis[i], correction);
    }
}

static bool cycle(rsv_solver_run *run, krylov *q, const float *residual, float *correction)
{
    normalise(run, q, residual, q->basis[0]);
    for (size_t c = 0; c < run->shape.columns; c++) {
        q->system[c].g[0] = q->product[c];
        q->system[c].flatness = q->product[c] > 0 ? run->size[c] / q->product[c] : 0;
    }
    uint32_t k = 0;
    do {
        if (!expand(run, q, k)) return false;
        for (size_t c = 0; c < run->shape.columns; c++)
            advance(run, &q->system[c], c, k);
    } while (rsv_run_goes_on(run) && ++k < RESTART);
    combine(run, q, k < RESTART ? k + 1 : RESTART, correction);
    return true;
}

static rsv_status improve(rsv_solver_run *run, float *residual, float *correction)
{
    rsv_context *context = run->shape.context;
    size_t columns = run->shape.columns;
    krylov q = { .system = rsv_alloc(context, columns, sizeof *q.system),
        .product = rsv_run_numbers(run, 2) };
    q.basis[0] = rsv_run_field(run);
    bool complete = q.system && q.product && q.basis[0];
    if (complete) {
        q.factor = q.product + columns;
        complete = cycle(run, &q, residual, correction);
    }
    for (uint32_t k = 0; k <= RESTART; k++)
        rsv_free(context, q.basis[k]);
    rsv_free(context, q.system);
    rsv_free(context, q.product);
    return complete ? RSV_OK : RSV_ERROR_MEMORY;
}

const rsv_solver_method rsv_solver_gmres = { .improve = improve };
