#include "importance.h"

#include "../core/parallel.h"
#include "../solve/goal.h"
#include "../solver/linear_solver.h"

#define ACCURACY 1e-4 ///< residual of the adjoint, relative
#define MOST_APPLICATIONS 1000

#define ROUNDING 1e-5f ///< of weights, relative

/// The parts that channels of a gray light have in its luminance.
static rsv_rgb parts_of(float luminance)
{
    return rgb(rgb_luminance(rgb(luminance, 0, 0)), rgb_luminance(rgb(0, luminance, 0)),
        rgb_luminance(rgb(0, 0, luminance)));
}

static float sum_of(rsv_rgb parts) { return parts.r + parts.g + parts.b; }

/// Whether weights of channels are those of a gray surface.
static bool are_parts_of_gray(rsv_rgb w)
{
    float sum = sum_of(w);
    rsv_rgb off = rgb_sub(w, parts_of(sum));
    return fmaxf(fmaxf(fabsf(off.r), fabsf(off.g)), fabsf(off.b)) <= ROUNDING * fabsf(sum);
}

rsv_status rsv_importance_create(const rsv_daylight *d, size_t sensors, rsv_importance *m)
{
    size_t nodes = d->light->elements->node_count;
    m->sensors = m->fields = sensors;
    m->weight = rsv_alloc(d->context, nodes * sensors, sizeof *m->weight);
    m->source = rsv_reserve(d->context, nodes * sensors, sizeof *m->source);
    m->worth = rsv_reserve(d->context, nodes * sensors, sizeof *m->worth);
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
    atomic_bool colored;
    _Atomic rsv_status result;
} weight_job;

static void enter_weights(void *data, rsv_span span)
{
    weight_job *job = data;
    size_t nodes = job->op->elements->node_count;
    for (size_t s = span.begin; s < span.end; s++) {
        rsv_rgb *weight = job->importance->weight + s * nodes;
        rsv_keep_failure(&job->result, rsv_goal_enter(job->op, weight));
        for (size_t n = 0; n < nodes && !job->colored; n++)
            if (!are_parts_of_gray(weight[n])) job->colored = true;
    }
}

/// Fields node by node, from weights sensor by sensor.
static void fill_fields(void *data, rsv_span span)
{
    const weight_job *job = data;
    const rsv_importance *m = job->importance;
    size_t nodes = job->op->elements->node_count;
    bool shared = m->fields < m->sensors;
    for (size_t n = span.begin; n < span.end; n++)
        for (size_t f = 0; f < m->fields; f++) {
            rsv_rgb w = rgb_gray(0);
            for (size_t c = 0; shared && c < 3 && 3 * f + c < m->sensors; c++)
                (&w.r)[c] = sum_of(m->weight[(3 * f + c) * nodes + n]);
            if (!shared) w = m->weight[f * nodes + n];
            m->source[n * m->fields + f] = m->worth[n * m->fields + f] = w;
        }
}

/// Sensors side by side; where light scatters below surfaces, the operator's scratch memory allows one at a time.
static rsv_status enter_all(
    const rsv_daylight *d, const rsv_operator_view *op, bool gray, rsv_importance *m)
{
    weight_job job = { .op = op, .importance = m };
    rsv_parallel_for(d->context, m->sensors, op->subsurface ? m->sensors : 1, enter_weights, &job);
    if (job.result != RSV_OK) return job.result;
    m->fields = gray && !job.colored ? (m->sensors + 2) / 3 : m->sensors;
    rsv_parallel_for(d->context, op->elements->node_count, 0, fill_fields, &job);
    return RSV_OK;
}

rsv_status rsv_importance_solve(
    const rsv_daylight *d, rsv_transport_map *map, bool gray, rsv_importance *m)
{
    const rsv_operator_view *op = rsv_operator_get_view(d->light->op);
    rsv_linear_report report;
    rsv_linear_desc desc = rsv_default_linear_desc(RSV_SOLVER_GMRES);
    desc.relative = ACCURACY;
    desc.max_applications = MOST_APPLICATIONS;
    rsv_status status = enter_all(d, op, gray, m);
    if (status != RSV_OK) return status;
    rsv_linear_map transposed = rsv_linear_map_transposed(&map->linear);
    return rsv_linear_solve(
        &transposed, 3 * m->fields, &m->source->r, &desc, &m->worth->r, &report);
}

static rsv_rgb worth_of(const rsv_importance *m, size_t node, size_t sensor)
{
    const rsv_rgb *worth = m->worth + node * m->fields;
    if (m->fields == m->sensors) return worth[sensor];
    return parts_of((&worth[sensor / 3].r)[sensor % 3]);
}

void rsv_importance_add(const rsv_importance *m, const rsv_node_escapes *escapes, size_t sensor,
    const rsv_sensor_rays *rays, rsv_patch_share *share)
{
    for (size_t k = 0; k < escapes->count; k++) {
        const rsv_node_escape *e = &escapes->escape[k];
        rsv_rgb z = worth_of(m, e->node, sensor);
        double worth =
            (double)(z.r * e->irradiance.r + z.g * e->irradiance.g + z.b * e->irradiance.b);
        share[e->patch].column[e->group] += (float)(worth * rays->reflected[e->group]);
    }
}
