#include "solver_run.h"
#include "stagnation.h"

#include <math.h>
#include <string.h>

/// A cycle that leaves more than this of the residual has not helped; a few of those in a row are the end.
#define POOR_REDUCTION 0.9
#define POOR_CYCLES 6
/// Solvers estimate the residual on their way. A cycle after a poor one, which may have believed too early that it was
/// there, aims this much lower. Powers of two, so that goals come back as they were.
#define CAUTION 4

#define RSV_SOLVER(value, symbol, name) extern const rsv_solver_method rsv_solver_##symbol;
#include "solvers.inc"
#undef RSV_SOLVER

static const rsv_solver_method *const methods[] = {
#define RSV_SOLVER(value, symbol, name) [RSV_SOLVER_##value] = &rsv_solver_##symbol,
#include "solvers.inc"
#undef RSV_SOLVER
};

enum { METHODS = sizeof methods / sizeof *methods };

const char *const *rsv_solver_names(void)
{
    static const char *const names[METHODS + 1] = {
        [RSV_SOLVER_AUTO] = "auto",
#define RSV_SOLVER(value, symbol, name) [RSV_SOLVER_##value] = (name),
#include "solvers.inc"
#undef RSV_SOLVER
    };
    return names;
}

const char *rsv_solver_name(rsv_solver solver)
{
    return (size_t)solver < METHODS ? rsv_solver_names()[solver] : NULL;
}

/// NULL = that is none: `auto`, or a value out of range.
static const rsv_solver_method *method_of(rsv_solver solver)
{
    return (size_t)solver < METHODS ? methods[solver] : NULL;
}

rsv_solver_needs rsv_solver_needs_of(rsv_solver solver)
{
    const rsv_solver_method *method = method_of(solver);
    return method ? method->needs : (rsv_solver_needs){ 0 };
}

rsv_linear_desc rsv_default_linear_desc(rsv_solver solver)
{
    return (rsv_linear_desc){ .solver = solver, .relative = 1e-5, .max_applications = 10000 };
}

bool rsv_solver_fits(rsv_solver solver, const rsv_linear_map *map)
{
    const rsv_solver_needs needs = rsv_solver_needs_of(solver);
    const rsv_linear_map_table *has = map->table;
    return method_of(solver) && (!needs.rows || (has->gather_rows && has->scatter_rows)) &&
           (!needs.columns || has->shoot) && (!needs.groups || (has->sum_groups && map->group)) &&
           (!needs.outside || has->correct);
}

void rsv_run_apply(rsv_solver_run *run, const float *field, float *image)
{
    run->map->table->apply(run->map->data, run->shape.columns, field, image);
    run->applications += 1;
}

float *rsv_run_field(const rsv_solver_run *run)
{
    return rsv_alloc(run->shape.context, run->shape.count, run->shape.columns * sizeof(float));
}

double *rsv_run_numbers(const rsv_solver_run *run, size_t count)
{
    return rsv_alloc(run->shape.context, count * run->shape.columns, sizeof(double));
}

/// How far the worst column is from its goal, as a factor; at most 1 = all have converged.
static double excess(const rsv_solver_run *run)
{
    double worst = 0;
    for (size_t c = 0; c < run->shape.columns; c++) {
        if (run->size[c] == 0) continue;
        double factor = run->size[c] / run->goal[c];
        if (!(factor <= worst)) worst = factor;
    }
    return worst;
}

static void tell(const rsv_solver_run *run)
{
    if (!run->desc->observe) return;
    double largest = 0;
    for (size_t c = 0; c < run->shape.columns; c++)
        if (run->source_size[c] > 0) largest = fmax(largest, run->size[c] / run->source_size[c]);
    run->desc->observe(run->desc->user, run->applications, largest);
}

bool rsv_run_goes_on(rsv_solver_run *run)
{
    double now = excess(run);
    tell(run);
    if (!(now < RSV_BLOW_UP * run->best)) {
        run->blew_up = true;
        return false;
    }
    if (now < RSV_IMPROVEMENT * run->best) {
        run->best = now;
        run->waiting = 0;
    } else if (++run->waiting >= RSV_PATIENCE) {
        return false;
    }
    double budget = run->desc->max_applications;
    run->status = rsv_progress(run->shape.context, "solve", fmin(run->applications / budget, 0.99));
    return now > 1 && run->applications < budget && run->status == RSV_OK && !run->broke_down;
}

/// Residual of x and its sizes.
static void form_residual(rsv_solver_run *run, const float *source, const float *x, float *residual)
{
    const rsv_linear_map_table *table = run->map->table;
    run->applications += 1;
    if (table->residual) {
        table->residual(run->map->data, run->shape.columns, source, x, residual);
    } else {
        table->apply(run->map->data, run->shape.columns, x, residual);
        rsv_columns_sum(&run->shape, source, residual);
        rsv_columns_subtract(&run->shape, x, residual);
    }
    rsv_columns_max(&run->shape, residual, run->size);
}

/// Columns that have converged take no part in the next cycle.
static void freeze_columns(const rsv_solver_run *run, float *residual)
{
    size_t columns = run->shape.columns;
    for (size_t c = 0; c < columns; c++) {
        if (rsv_run_active(run, c)) continue;
        run->size[c] = 0;
        for (size_t n = 0; n < run->shape.count; n++)
            residual[n * columns + c] = 0;
    }
}

static void scale_goals(const rsv_solver_run *run, double factor)
{
    for (size_t c = 0; c < run->shape.columns; c++)
        run->goal[c] *= factor;
}

static bool is_zero(const float *field, size_t values)
{
    for (size_t k = 0; k < values; k++)
        if (field[k] != 0) return false;
    return true;
}

static rsv_stop_reason reason_to_fail(const rsv_solver_run *run)
{
    return run->broke_down ? RSV_STOP_BREAKDOWN
           : run->blew_up  ? RSV_STOP_DIVERGED
                           : RSV_STOP_STAGNATED;
}

/// A correction. @param caution how far below the goals to aim
static rsv_status improve(rsv_solver_run *run, double caution, float *residual, float *correction)
{
    freeze_columns(run, residual);
    scale_goals(run, 1 / caution);
    run->best = excess(run);
    run->waiting = 0;
    run->broke_down = run->blew_up = false;
    rsv_status status = run->map->outside
                            ? rsv_improve_outside(run, residual, correction)
                            : methods[run->desc->solver]->improve(run, residual, correction);
    scale_goals(run, caution);
    return status == RSV_OK ? run->status : status;
}

/// Fields of the cycles.
typedef struct cycle_fields {
    const float *source;
    float *solution, *residual, *trial;
} cycle_fields;

/// One cycle: a correction, kept if it helps. @param left out: the part of the excess that it left
static rsv_status run_cycle(
    rsv_solver_run *run, double caution, const cycle_fields *f, double *left)
{
    size_t bytes = run->shape.count * run->shape.columns * sizeof *f->trial;
    double before = excess(run);
    memset(f->trial, 0, bytes);
    rsv_status status = improve(run, caution, f->residual, f->trial);
    if (status != RSV_OK) return status;
    rsv_columns_sum(&run->shape, f->solution, f->trial);
    form_residual(run, f->source, f->trial, f->residual);
    *left = excess(run) / before;
    if (*left <= 1)
        memcpy(f->solution, f->trial, bytes);
    else
        form_residual(run, f->source, f->solution, f->residual);
    tell(run);
    return RSV_OK;
}

static rsv_status iterate(
    rsv_solver_run *run, const cycle_fields *fields, rsv_linear_report *report)
{
    uint32_t poor = 0;
    double caution = 1;
    while (excess(run) > 1) {
        double left;
        if (run->applications >= run->desc->max_applications) {
            report->stop_reason = RSV_STOP_MAX_ORDERS;
            return RSV_OK;
        }
        rsv_status status = run_cycle(run, caution, fields, &left);
        if (status != RSV_OK) return status;
        report->cycles++;
        poor = left < POOR_REDUCTION ? 0 : poor + 1;
        caution = poor ? caution * CAUTION : 1;
        bool lost = !(left <= 1) && (run->broke_down || run->blew_up);
        if (lost || poor >= POOR_CYCLES) {
            report->stop_reason = reason_to_fail(run);
            return RSV_OK;
        }
    }
    report->stop_reason = RSV_STOP_CONVERGED;
    return RSV_OK;
}

/// Residual and sizes of the first guess; the zero field needs no application.
static void start(rsv_solver_run *run, const float *source, const float *solution, float *residual)
{
    size_t values = run->shape.count * run->shape.columns;
    rsv_columns_max(&run->shape, source, run->source_size);
    for (size_t c = 0; c < run->shape.columns; c++)
        run->goal[c] = fmax(run->desc->relative * run->source_size[c], run->desc->absolute);
    if (is_zero(solution, values)) {
        memcpy(residual, source, values * sizeof *residual);
        memcpy(run->size, run->source_size, run->shape.columns * sizeof *run->size);
    } else {
        form_residual(run, source, solution, residual);
    }
    tell(run);
}

rsv_status rsv_linear_solve(const rsv_linear_map *map, size_t columns, const float *source,
    const rsv_linear_desc *desc, float *solution, rsv_linear_report *report)
{
    rsv_status status = RSV_OK;
    rsv_solver_run run = { .map = map,
        .desc = desc,
        .shape = { .context = map->context, .count = map->count, .columns = columns } };
    *report = (rsv_linear_report){ 0 };
    if (!rsv_solver_fits(desc->solver, map))
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "solve: solver '%s' does not fit this operator; choose another one or 'auto'",
            rsv_solver_name(desc->solver));
    float *residual = rsv_run_field(&run), *trial = rsv_run_field(&run);
    run.source_size = rsv_run_numbers(&run, 1);
    run.goal = rsv_run_numbers(&run, 1);
    run.size = rsv_run_numbers(&run, 1);
    run.shape.partial =
        rsv_alloc(map->context, rsv_partial_length(map->count, columns), sizeof(double));
    if (!residual || !trial || !run.source_size || !run.goal || !run.size || !run.shape.partial) {
        status = RSV_ERROR_MEMORY;
        goto cleanup;
    }
    start(&run, source, solution, residual);
    RSV_TRY(iterate(&run, &(cycle_fields){ source, solution, residual, trial }, report));
    report->applications = run.applications;
    for (size_t c = 0; c < columns; c++)
        report->residual = fmax(report->residual, run.size[c]);
cleanup:
    if (run.kept) methods[desc->solver]->forget(run.kept);
    rsv_free(map->context, residual);
    rsv_free(map->context, trial);
    rsv_free(map->context, run.source_size);
    rsv_free(map->context, run.goal);
    rsv_free(map->context, run.size);
    rsv_free(map->context, run.shape.partial);
    return status;
}
