/// Two grids (Brakhage 1960; Atkinson 1997, "The numerical solution of integral equations of the second kind").
///
/// Transport smooths: A of a field is well represented on groups of nodes. With R the mean over a group, P constant
/// continuation and C = R A P, the map B = P C R is close to A, and
///
///     (I - B)^-1 r = r + P ((I - C)^-1 - I) R r
///
/// requires one small dense solve. Each step d += (I - B)^-1 (r - (I - A) d) then leaves (A - B)(I - B)^-1 of a
/// residual, however slowly the Neumann series converges.
#include "solver_run.h"

#include <math.h>
#include <string.h>

typedef struct coarse_level {
    rsv_context *context;
    size_t groups;
    double *inverse_size;   ///< [groups] 1 / nodes
    double *factor;         ///< [3 x groups x groups] L and U of I - C, channel by channel
    uint32_t *pivot;        ///< [3 x groups]
    bool singular;          ///< I - C of some channel
    double *means, *solved; ///< [groups]
} coarse_level;

static void forget_coarse_level(void *kept)
{
    coarse_level *coarse = kept;
    rsv_free(coarse->context, coarse->inverse_size);
    rsv_free(coarse->context, coarse->factor);
    rsv_free(coarse->context, coarse->pivot);
    rsv_free(coarse->context, coarse->means);
    rsv_free(coarse->context, coarse->solved);
    rsv_free(coarse->context, coarse);
}

static void swap_rows(double *a, double *b, size_t count)
{
    for (size_t k = 0; k < count; k++) {
        double keep = a[k];
        a[k] = b[k];
        b[k] = keep;
    }
}

/// L U with row exchanges, in place. @return whether the matrix is regular
static bool factorise(double *a, size_t n, uint32_t *pivot)
{
    for (size_t k = 0; k < n; k++) {
        size_t best = k;
        for (size_t i = k + 1; i < n; i++)
            if (fabs(a[i * n + k]) > fabs(a[best * n + k])) best = i;
        pivot[k] = (uint32_t)best;
        if (!(fabs(a[best * n + k]) > 1e-12)) return false;
        if (best != k) swap_rows(a + k * n, a + best * n, n);
        for (size_t i = k + 1; i < n; i++) {
            double factor = a[i * n + k] /= a[k * n + k];
            for (size_t j = k + 1; factor != 0 && j < n; j++)
                a[i * n + j] -= factor * a[k * n + j];
        }
    }
    return true;
}

static void solve_factored(const double *a, size_t n, const uint32_t *pivot, double *x)
{
    for (size_t k = 0; k < n; k++) {
        double keep = x[pivot[k]];
        x[pivot[k]] = x[k];
        x[k] = keep;
    }
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < i; j++)
            x[i] -= a[i * n + j] * x[j];
    for (size_t i = n; i-- > 0;) {
        for (size_t j = i + 1; j < n; j++)
            x[i] -= a[i * n + j] * x[j];
        x[i] /= a[i * n + i];
    }
}

/// Factors of I - C for the three channels.
static void form_matrices(rsv_solver_run *run, coarse_level *coarse)
{
    const rsv_linear_map *map = run->map;
    size_t groups = coarse->groups;
    map->table->sum_groups(map->data, coarse->factor);
    run->applications += 1; // every entry was read once
    for (size_t channel = 0; channel < 3; channel++) {
        double *matrix = coarse->factor + channel * groups * groups;
        for (size_t i = 0; i < groups; i++)
            for (size_t j = 0; j < groups; j++)
                matrix[i * groups + j] =
                    (i == j) - matrix[i * groups + j] * coarse->inverse_size[i];
        if (!factorise(matrix, groups, coarse->pivot + channel * groups)) coarse->singular = true;
    }
}

static rsv_status create_coarse_level(rsv_solver_run *run)
{
    rsv_context *context = run->shape.context;
    coarse_level *coarse = run->kept = rsv_alloc(context, 1, sizeof *coarse);
    if (!coarse) return RSV_ERROR_MEMORY;
    size_t groups = coarse->groups = run->map->group_count;
    coarse->context = context;
    coarse->inverse_size = rsv_alloc(context, groups, sizeof(double));
    coarse->factor = rsv_alloc(context, 3 * groups * groups, sizeof(double));
    coarse->pivot = rsv_alloc(context, 3 * groups, sizeof *coarse->pivot);
    coarse->means = rsv_alloc(context, groups, sizeof(double));
    coarse->solved = rsv_alloc(context, groups, sizeof(double));
    if (!coarse->inverse_size || !coarse->factor || !coarse->pivot || !coarse->means ||
        !coarse->solved)
        return RSV_ERROR_MEMORY;
    for (size_t n = 0; n < run->map->count; n++)
        if (run->map->group[n] != RSV_NONE) coarse->inverse_size[run->map->group[n]] += 1;
    for (size_t g = 0; g < groups; g++)
        if (coarse->inverse_size[g] > 0) coarse->inverse_size[g] = 1 / coarse->inverse_size[g];
    form_matrices(run, coarse);
    return RSV_OK;
}

/// step = (I - B)^-1 residual, in the columns that need it
static void precondition(rsv_solver_run *run, const float *residual, float *step)
{
    const coarse_level *coarse = run->kept;
    const uint32_t *group = run->map->group;
    size_t columns = run->shape.columns, groups = coarse->groups;
    for (size_t c = 0; c < columns; c++) {
        memset(coarse->means, 0, groups * sizeof(double));
        for (size_t n = 0; n < run->shape.count; n++)
            if (group[n] != RSV_NONE) coarse->means[group[n]] += (double)residual[n * columns + c];
        for (size_t g = 0; g < groups; g++)
            coarse->means[g] *= coarse->inverse_size[g];
        memcpy(coarse->solved, coarse->means, groups * sizeof(double));
        solve_factored(coarse->factor + (c % 3) * groups * groups, groups,
            coarse->pivot + (c % 3) * groups, coarse->solved);
        for (size_t n = 0; n < run->shape.count; n++) {
            uint32_t g = group[n];
            float smooth = g == RSV_NONE ? 0 : (float)(coarse->solved[g] - coarse->means[g]);
            step[n * columns + c] = rsv_run_active(run, c) ? residual[n * columns + c] + smooth : 0;
        }
    }
}

static rsv_status improve(rsv_solver_run *run, float *residual, float *correction)
{
    rsv_status status = RSV_OK;
    float *step = rsv_run_field(run), *image = rsv_run_field(run);
    if (!step || !image) {
        status = RSV_ERROR_MEMORY;
        goto cleanup;
    }
    if (!run->kept) RSV_TRY(create_coarse_level(run));
    run->broke_down = ((const coarse_level *)run->kept)->singular;
    if (run->broke_down) goto cleanup;
    do {
        precondition(run, residual, step);
        rsv_columns_sum(&run->shape, step, correction);
        rsv_run_apply(run, step, image);
        rsv_columns_subtract(&run->shape, step, residual);
        rsv_columns_sum(&run->shape, image, residual);
        rsv_columns_max(&run->shape, residual, run->size);
    } while (rsv_run_goes_on(run));
cleanup:
    rsv_free(run->shape.context, step);
    rsv_free(run->shape.context, image);
    return status;
}

const rsv_solver_method rsv_solver_two_grid = {
    .improve = improve, .needs.groups = true, .forget = forget_coarse_level
};
