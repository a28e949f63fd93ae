#include "../operator/transport_rows.h"
#include "../solver/choose_solver.h"
#include "../solver/linear_solver.h"
#include "../solver/spectrum.h"
#include "light_internal.h"
#include "resolvent/measure.h"
#include "solve_constants.h"

/// Passes on a solver's reports, offset by what happened before it.
typedef struct listener {
    void (*observe)(void *user, double applications, double residual);
    void *user;
    double before;   ///< applications of an earlier solver
    double residual; ///< the last one
} listener;

static void listen(void *user, double applications, double residual)
{
    listener *l = user;
    l->residual = residual;
    if (l->observe) l->observe(l->user, l->before + applications, residual);
}

static rsv_status run(rsv_transport_map *map, const rsv_light *s, rsv_linear_desc *desc,
    listener *l, rsv_rgb *irradiance, rsv_solver_cost *cost)
{
    rsv_linear_report report;
    desc->observe = listen;
    desc->user = l;
    l->before = cost->applications;
    rsv_status status =
        rsv_linear_solve(&map->linear, 3, &s->field.source->r, desc, &irradiance->r, &report);
    cost->solver = desc->solver;
    cost->stop_reason = report.stop_reason;
    cost->applications += report.applications;
    cost->residual = l->residual;
    return status;
}

/// A few orders of light, then the choice that they suggest.
static rsv_status scout(rsv_transport_map *map, const rsv_light *s, rsv_linear_desc *desc,
    listener *l, rsv_rgb *irradiance, rsv_solver_cost *cost)
{
    char reason[sizeof s->report.solver_reason];
    desc->solver = RSV_SOLVER_NEUMANN;
    desc->max_applications = SCOUT_TERMS;
    rsv_status status = run(map, s, desc, l, irradiance, cost);
    if (status != RSV_OK || cost->stop_reason == RSV_STOP_CONVERGED) return status;
    double radius = s->report.spectral_radius;
    rsv_solver_question question = { .norm_inf = s->report.norm_inf,
        .spectral_radius = radius,
        .terms = rsv_neumann_terms(radius, l->residual, desc->relative),
        .node_count = map->linear.count,
        .on_device = rsv_device_map_solves(map->device, RSV_SOLVER_BICGSTAB) };
    desc->solver = rsv_choose_solver(&question, reason, sizeof reason);
    desc->max_applications = s->desc.max_orders;
    status = rsv_transport_map_prepare(map, desc->solver);
    return status != RSV_OK ? status : run(map, s, desc, l, irradiance, cost);
}

rsv_status rsv_measure_solver(const rsv_light *s, rsv_solver solver, double tolerance,
    void (*observe)(void *user, double applications, double residual), void *user,
    rsv_solver_cost *cost)
{
    double start = rsv_seconds();
    rsv_transport_map *map = NULL;
    rsv_status status = RSV_OK;
    listener l = { .observe = observe, .user = user };
    rsv_rgb *irradiance = rsv_alloc(s->context, s->elements->node_count, sizeof *irradiance);
    if (!irradiance) return RSV_ERROR_MEMORY;
    RSV_TRY(rsv_operator_map(s->op, 1, &map));
    RSV_TRY(rsv_transport_map_prepare(map, solver));
    rsv_linear_desc desc = rsv_default_linear_desc(solver);
    desc.relative = tolerance;
    desc.max_applications = s->desc.max_orders;
    *cost = (rsv_solver_cost){ 0 };
    RSV_TRY((solver == RSV_SOLVER_AUTO ? scout : run)(map, s, &desc, &l, irradiance, cost));
    cost->seconds = rsv_seconds() - start;
cleanup:
    rsv_transport_map_destroy(map);
    rsv_free(s->context, irradiance);
    return status;
}

rsv_status rsv_measure_application(const rsv_light *s, uint32_t repetitions, double *ratio)
{
    rsv_status status = RSV_ERROR_MEMORY;
    size_t nodes = s->elements->node_count;
    rsv_transport_map *map = NULL;
    rsv_rgb *image = rsv_alloc(s->context, nodes, sizeof *image);
    rsv_rgb *bare = rsv_alloc(s->context, nodes, sizeof *bare);
    if (!image || !bare) goto cleanup;
    RSV_TRY(rsv_operator_map(s->op, 1, &map));
    for (uint32_t k = 0; k < repetitions; k++) {
        double start = rsv_seconds();
        map->linear.table->apply(map, 3, &s->field.irradiance->r, &image->r);
        double applied = rsv_seconds();
        rsv_transport_gather_only(s->view.transport, s->field.irradiance, bare);
        ratio[k] = (rsv_seconds() - applied) / (applied - start);
    }
cleanup:
    rsv_transport_map_destroy(map);
    rsv_free(s->context, image);
    rsv_free(s->context, bare);
    return status;
}

rsv_status rsv_measure_device(
    const rsv_light *s, uint32_t repetitions, double *copy_rate, double *seconds, size_t *bytes)
{
    rsv_transport_map *map = NULL;
    rsv_status status = rsv_operator_map(s->op, 1, &map);
    if (status == RSV_OK)
        status = rsv_device_map_measure(map->device, repetitions, copy_rate, seconds, bytes);
    rsv_transport_map_destroy(map);
    return status;
}
