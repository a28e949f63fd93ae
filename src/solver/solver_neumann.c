/// d = sum A^n r: the Neumann series, bounce after bounce. Its next term is the residual of the sum so far.
#include "solver_run.h"

static rsv_status improve(rsv_solver_run *run, float *residual, float *correction)
{
    rsv_status status = RSV_OK;
    float *term = residual, *next = rsv_run_field(run), *const owned = next;
    double *factor = rsv_run_numbers(run, 1);
    if (!next || !factor) {
        status = RSV_ERROR_MEMORY;
        goto cleanup;
    }
    do {
        for (size_t c = 0; c < run->shape.columns; c++)
            factor[c] = rsv_run_active(run, c);
        rsv_columns_add(&run->shape, factor, term, correction);
        rsv_run_apply(run, term, next);
        rsv_columns_max(&run->shape, next, run->size);
        float *swap = term;
        term = next;
        next = swap;
    } while (rsv_run_goes_on(run));
cleanup:
    rsv_free(run->shape.context, owned);
    rsv_free(run->shape.context, factor);
    return status;
}

const rsv_solver_method rsv_solver_neumann = { .improve = improve };
