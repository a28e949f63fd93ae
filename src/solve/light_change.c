#include "light_change.h"

#include "../core/parallel.h"
#include "light_internal.h"
#include "solve_constants.h"
#include "source.h"

rsv_world *rsv_light_world(rsv_light *s) { return s->world; }

rsv_light_fields *rsv_light_edit(rsv_light *s) { return &s->field; }

rsv_light_sources *rsv_light_get_sources(const rsv_light *s) { return s->sources; }

rsv_light_basis *rsv_light_edit_basis(rsv_light *s) { return s->basis; }

void rsv_light_set_basis(rsv_light *s, rsv_light_basis *basis)
{
    rsv_light_basis_destroy(s->basis);
    s->basis = basis;
    s->view.basis = basis;
}

// ---- the scene ------------------------------------------------------------------------------------

static void take_sources(rsv_light *s, rsv_light_sources *sources)
{
    rsv_following_forget_photons(s->following);
    rsv_light_sources_release(s->sources);
    s->sources = sources;
    rsv_light_publish(s);
}

rsv_status rsv_light_vary_world(rsv_light *s)
{
    return s->world->variant ? RSV_OK : rsv_light_part_world(s);
}

rsv_status rsv_light_part_world(rsv_light *s)
{
    rsv_world *own = NULL;
    rsv_status status = rsv_world_vary(s->world, &own);
    if (status != RSV_OK) return status;
    rsv_world_release(s->world);
    s->world = own;
    s->scene = own->scene;
    return rsv_light_find_sources(s, s->sources->lights);
}

rsv_status rsv_light_find_sources(rsv_light *s, const rsv_lights *like)
{
    rsv_light_sources *found = NULL;
    rsv_world_find_bsdfs(s->world);
    s->scene = s->world->scene;
    rsv_status status = rsv_light_sources_create(s->world, like, &found);
    if (status == RSV_OK) take_sources(s, found);
    return status;
}

rsv_status rsv_light_follow_strengths(rsv_light *s, bool *followed)
{
    rsv_world_find_bsdfs(s->world);
    return rsv_lights_follow_strengths(s->sources->lights, s->world->bsdf, followed);
}

rsv_status rsv_light_vary_places(rsv_light *s, const bool *moves)
{
    rsv_status status = rsv_world_vary_places(s->world, moves);
    s->scene = s->world->scene;
    rsv_light_publish(s);
    return status;
}

rsv_status rsv_light_follow_places(rsv_light *s) { return rsv_lights_follow(s->sources->lights); }

typedef struct paint_job {
    const rsv_light *light;
    const bool *changed;
    rsv_rgb *albedo;
} paint_job;

static void paint_nodes(void *data, rsv_span span)
{
    const paint_job *job = data;
    const rsv_light *s = job->light;
    const rsv_elements *e = s->elements;
    const rsv_rgb *known = s->view.exitance_albedo;
    for (uint32_t n = (uint32_t)span.begin; n < span.end; n++) {
        job->albedo[n] = known[n];
        if (e->node_face[n] == RSV_NONE) continue;
        uint32_t triangle = e->face_triangle[e->node_face[n]];
        if (job->changed[s->scene.view->triangle_material[triangle]])
            job->albedo[n] = rsv_element_albedo(&s->world->scene, e, s->desc.seed, n);
    }
}

/// Albedos of the operator, recomputed for changed materials. @param albedo out: freed by the caller
static rsv_status paint(const rsv_light *s, const bool *changed, rsv_rgb **albedo)
{
    const rsv_elements *e = s->elements;
    rsv_rgb *a = *albedo = rsv_alloc(s->context, e->node_count, sizeof *a);
    if (!a) return RSV_ERROR_MEMORY;
    rsv_parallel_for(s->context, e->node_count, 256, paint_nodes, &(paint_job){ s, changed, a });
    return RSV_OK;
}

rsv_status rsv_light_recolor(rsv_light *s, const bool *changed)
{
    rsv_operator *op = NULL, *before = s->op;
    rsv_rgb *albedo = NULL;
    rsv_status status;
    rsv_world_find_bsdfs(s->world);
    RSV_TRY(paint(s, changed, &albedo));
    RSV_TRY(rsv_operator_recolor(s->op, s->world, albedo, &op));
    s->op = op;
    status = rsv_light_check_bounded(s);
    if (status != RSV_OK) s->op = before;
    rsv_operator_release(status == RSV_OK ? before : op);
    rsv_light_publish(s);
cleanup:
    rsv_free(s->context, albedo);
    return status;
}

// ---- E0 and E -------------------------------------------------------------------------------------

void rsv_light_gather(rsv_light *s, rsv_rgb scale)
{
    s->gathered_scale = scale;
    rsv_source_add_gathered(s);
    rsv_light_publish(s);
}

void rsv_light_restore_gathered(rsv_light *s, rsv_rgb scale)
{
    s->gathered_scale = scale;
    rsv_light_publish(s);
}

rsv_status rsv_light_diffuse(rsv_light *s)
{
    rsv_light_fields *f = &s->field;
    // all bounces stand in for the first one
    f->order[1] = f->indirect;
    f->order_count = 2;
    rsv_diffused_level_destroy(s->context, &f->diffused);
    rsv_status status = rsv_diffused_level_create(s);
    f->order[1] = NULL;
    f->order_count = 0;
    rsv_light_publish(s);
    return status;
}

static void drop_fields(rsv_light *s)
{
    rsv_light_drop_orders(s);
    rsv_free(s->context, s->field.irradiance);
    rsv_free(s->context, s->field.indirect);
    s->field.irradiance = s->field.indirect = NULL;
}

/// @param solve E on the coarse elements
static rsv_status solve_by(rsv_light *s, rsv_status (*solve)(rsv_light *light))
{
    rsv_status status;
    double start = rsv_seconds();
    drop_fields(s);
    RSV_TRY(solve(s));
    rsv_diffused_level_destroy(s->context, &s->field.diffused);
    RSV_TRY(rsv_diffused_level_create(s));
    s->report.time_solve = rsv_seconds() - start;
cleanup:
    rsv_light_publish(s);
    return status;
}

static rsv_status solve_alone(rsv_light *s) { return rsv_solve_orders(s, s->desc.max_orders); }

rsv_status rsv_light_solve(rsv_light *s) { return solve_by(s, solve_alone); }

rsv_status rsv_light_solve_again(rsv_light *s)
{
    rsv_status status = solve_by(s, rsv_solve_and_measure);
    if (status == RSV_OK) rsv_light_warn_if_unbounded(s);
    return status;
}

void rsv_light_warn_if_unbounded(const rsv_light *s)
{
    const rsv_solve_report *report = &s->report;
    if (s->pocket_area > 0)
        rsv_log(s->context, RSV_LOG_WARNING,
            "solve: %.3g m2 of surfaces that absorb nothing enclose pockets that hardly any light "
            "enters; they stay dark there; lower their albedo below 1",
            s->pocket_area);
    if (report->stop_reason == RSV_STOP_MAX_ORDERS)
        rsv_log(s->context, RSV_LOG_WARNING,
            "solve: stopped after %u orders of light with a residual of %.3g W/m2",
            report->iterations, report->residual_inf);
    else if (report->stop_reason > RSV_STOP_NO_LIGHT)
        rsv_log(s->context, RSV_LOG_WARNING,
            "solve: solver %s gave up after %u applications with a residual of %.3g W/m2; use "
            "'auto'",
            rsv_solver_name(report->solver), report->iterations, report->residual_inf);
    else if (report->stop_reason == RSV_STOP_CONVERGED && report->norm_inf > WORRYING_RADIUS &&
             report->spectral_radius > WORRYING_RADIUS)
        rsv_log(s->context, RSV_LOG_WARNING,
            "solve: the scene absorbs almost nothing (spectral radius %.4f): small errors of the operator have "
            "large effects; use a higher quality or lower the albedos",
            report->spectral_radius);
}
