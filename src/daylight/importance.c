#include "importance.h"

#include "../core/parallel.h"
#include "../solve/goal.h"
#include "../solver/linear_solver.h"

#define ACCURACY 1e-4 ///< residual of the adjoint, relative
#define MOST_APPLICATIONS 1000

rsv_status rsv_importance_create(const rsv_daylight *d, size_t fields, rsv_importance *m)
{
    size_t nodes = d->light->elements->node_count;
    m->fields = fields;
    m->weight = rsv_alloc(d->context, nodes * fields, sizeof *m->weight);
    m->source = rsv_alloc(d->context, nodes * fields, sizeof *m->source);
    m->worth = rsv_alloc(d->context, nodes * fields, sizeof *m->worth);
    return m->weight && m->source && m->worth ? RSV_OK : RSV_ERROR_MEMORY;
}

void rsv_importance_destroy(const rsv_daylight *d, rsv_importance *m)
{
    rsv_free(d->context, m->weight);
    rsv_free(d->context, m->source);
    rsv_free(d->context, m->worth);
    *m = (rsv_importance){ 0 };
}

/// Sensors whose weights are entered.
typedef struct weight_job {
    const rsv_operator_view *op;
    const rsv_importance *importance;
    _Atomic rsv_status result;
} weight_job;

static void enter_fields(void *data, rsv_span span)
{
    weight_job *job = data;
    const rsv_importance *m = job->importance;
    size_t nodes = job->op->elements->node_count;
    for (size_t f = span.begin; f < span.end; f++) {
        rsv_keep_failure(&job->result, rsv_goal_enter(job->op, m->weight + f * nodes));
        for (size_t n = 0; n < nodes; n++)
            m->source[n * m->fields + f] = m->worth[n * m->fields + f] = m->weight[f * nodes + n];
    }
}

/// Sensors side by side; where light scatters below surfaces, the operator's scratch memory allows one at a time.
static rsv_status enter_weights(
    const rsv_daylight *d, const rsv_operator_view *op, rsv_importance *m)
{
    weight_job job = { .op = op, .importance = m };
    rsv_parallel_for(d->context, m->fields, op->subsurface ? m->fields : 1, enter_fields, &job);
    return job.result;
}

rsv_status rsv_importance_solve(const rsv_daylight *d, rsv_transport_map *map, rsv_importance *m)
{
    const rsv_operator_view *op = rsv_operator_get_view(d->light->op);
    rsv_linear_report report;
    rsv_linear_desc desc = rsv_default_linear_desc(RSV_SOLVER_GMRES);
    desc.relative = ACCURACY;
    desc.max_applications = MOST_APPLICATIONS;
    rsv_status status = enter_weights(d, op, m);
    if (status != RSV_OK) return status;
    rsv_linear_map transposed = rsv_linear_map_transposed(&map->linear);
    return rsv_linear_solve(
        &transposed, 3 * m->fields, &m->source->r, &desc, &m->worth->r, &report);
}

void rsv_importance_add(const rsv_importance *m, const rsv_node_escapes *escapes, size_t field,
    const rsv_sensor_rays *rays, rsv_patch_share *share)
{
    for (size_t k = 0; k < escapes->count; k++) {
        const rsv_node_escape *e = &escapes->escape[k];
        rsv_rgb z = m->worth[e->node * m->fields + field];
        double worth =
            (double)(z.r * e->irradiance.r + z.g * e->irradiance.g + z.b * e->irradiance.b);
        share[e->patch].column[e->group] += (float)(worth * rays->reflected[e->group]);
    }
}
