/// E = sum (G K)^n E0. The first orders are kept separately, as layers of pictures. The rest is kept as one, and a
/// faster solver may compute it.
#include "light_internal.h"

#include "../core/team.h"
#include "../elements/curvature.h"
#include "../solver/choose_solver.h"
#include "../solver/fredholm.h"
#include "../solver/leading.h"
#include "../solver/linear_solver.h"
#include "sharpen.h"
#include "solve_constants.h"
#include "transport_map.h"

#include <stdio.h>
#include <string.h>

static double largest(const rsv_rgb *value, size_t count)
{
    double max = 0;
    for (size_t n = 0; n < count; n++)
        max = fmax(max, rgb_max(value[n]));
    return max;
}

/// Data for solving one system.
typedef struct series {
    rsv_light *s;
    rsv_transport_map *map;
    rsv_rgb *term, *next;
    double target;    ///< W/m2: a residual that is small enough
    double resolvent; ///< bound of ||(I - G K)^-1||_inf
} series;

static void apply(const series *q, const rsv_rgb *field, rsv_rgb *image)
{
    q->map->linear.table->apply(q->map, 3, &field->r, &image->r);
}

/// ||G K||_inf: the result of an irradiance of 1 everywhere.
static double operator_norm(const series *q)
{
    size_t nodes = q->s->elements->node_count;
    for (size_t n = 0; n < nodes; n++)
        q->next[n] = rgb_gray(1);
    apply(q, q->next, q->term);
    return largest(q->term, nodes);
}

/// ||E0 + G K E - E||_inf with sums in double. Hanging nodes are no unknowns.
static double residual_norm(const series *q, rsv_rgb *irradiance, rsv_rgb *residual)
{
    const rsv_light *s = q->s;
    double max = 0;
    q->map->linear.table->residual(q->map, 3, &s->field.source->r, &irradiance->r, &residual->r);
    const float *scale = rsv_operator_get_view(s->op)->transport->scale;
    for (size_t n = 0; n < s->elements->node_count; n++) {
        if (scale[n] == 0) continue;
        rsv_rgb r = residual[n];
        max = fmax(max, fmax(fabs(r.r), fmax(fabs(r.g), fabs(r.b))));
    }
    return max;
}

/// Share of the source's light that is caught in pockets: the largest of the channels.
static double caught_share(const rsv_light *s, const float *survival)
{
    double most = 0;
    for (size_t c = 0; c < 3; c++) {
        double caught = 0, all = 0;
        for (size_t n = 0; n < s->elements->node_count; n++) {
            double light = s->elements->node_area[n] * (&s->field.source[n].r)[c];
            all += light;
            caught += light * survival[3 * n + c];
        }
        if (all > 0) most = fmax(most, caught / all);
    }
    return most;
}

/// Nodes of pockets have no albedo, nor have those that hang between such nodes. @param albedo [node_count] in and out
/// @return m2
static double blacken_pockets(
    const rsv_elements *e, const float *survival, float least, rsv_rgb *albedo)
{
    double area = 0;
    for (size_t n = 0; n < e->node_count; n++) {
        const float *share = &survival[3 * n];
        if (fmaxf(share[0], fmaxf(share[1], share[2])) <= least) continue;
        albedo[n] = rgb_gray(0);
        area += (double)e->node_area[n];
    }
    for (size_t k = 0; k < e->hanging_count; k++) {
        const rsv_hanging *h = &e->hanging[k];
        bool lit = false;
        for (int p = 0; p < RSV_PARENTS; p++)
            lit = lit || (h->weight[p] > 0 && !rgb_is_black(albedo[h->parent[p]]));
        if (!lit) albedo[h->node] = rgb_gray(0);
    }
    return area;
}

/// Makes pockets dark: no light starts there, and arriving light is absorbed. This is another operator, for this light
/// only.
/// @param least fraction that a pocket keeps
static rsv_status close_pockets(rsv_light *s, const float *survival, float least)
{
    rsv_operator *closed = NULL;
    size_t nodes = s->elements->node_count;
    rsv_rgb *albedo = rsv_alloc(s->context, nodes, sizeof *albedo);
    if (!albedo) return RSV_ERROR_MEMORY;
    memcpy(albedo, rsv_operator_get_view(s->op)->albedo, nodes * sizeof *albedo);
    s->pocket_area += blacken_pockets(s->elements, survival, least, albedo);
    for (size_t n = 0; n < nodes; n++) {
        const float *share = &survival[3 * n];
        if (fmaxf(share[0], fmaxf(share[1], share[2])) > least)
            s->field.source[n] = s->field.order[0][n] = rgb_gray(0);
    }
    rsv_status status = rsv_operator_recolor(s->op, s->world, albedo, &closed);
    rsv_free(s->context, albedo);
    if (status != RSV_OK) return status;
    rsv_operator_release(s->op);
    s->op = closed;
    return RSV_OK;
}

/// What keeps light from dying out, and what to do about it.
typedef struct lossless_cause {
    const char *what, *advice;
} lossless_cause;

static lossless_cause find_cause(const rsv_fog *fog)
{
    if (fog && (double)rgb_max(fog->albedo) >= RSV_LOSSLESS)
        return (lossless_cause){ "light in the fog of albedo 1 is hardly ever absorbed",
            "lower the albedo of the fog below 1 (--fog EXTINCTION,ALBEDO)" };
    return (lossless_cause){ "the scene is closed and absorbs nothing",
        "lower an albedo below 1 or open the scene" };
}

static rsv_status refuse_lossless(const series *q, const rsv_alternative *a)
{
    const lossless_cause cause = find_cause(q->s->scene.view->fog);
    double compatibility, lost = 1 - a->radius.power;
    if (lost > LOSS_IN_DOUBT)
        return rsv_fail(RSV_ERROR_SCENE,
            "solve: the scene is closed and absorbs only %.1g of its light per reflection, and a "
            "solution requires %.1g; %s",
            lost, 1 - RSV_LOSSLESS, cause.advice);
    rsv_status status =
        rsv_fredholm_compatibility(&q->map->linear, &q->s->field.source->r, &compatibility);
    if (status != RSV_OK) return status;
    return rsv_fail(RSV_ERROR_SCENE,
        "solve: %s (spectral radius %.6f, in single precision), so %s: E = G K E has solutions of "
        "its own, and the light is %s them; %s",
        cause.what, a->radius.power,
        compatibility > 1e-6 ? "light never dies out and there is no bounded answer"
                             : "there is more than one answer",
        compatibility > 1e-6 ? "incompatible with" : "compatible with", cause.advice);
}

/// Closes pockets and looks again whether all light dies out.
static rsv_status look_without(
    series *q, const float *survival, float least, rsv_alternative *alternative)
{
    rsv_status status;
    RSV_TRY(close_pockets(q->s, survival, least));
    rsv_transport_map_destroy(q->map);
    q->map = NULL;
    RSV_TRY(rsv_operator_map(q->s->op, 1, &q->map));
    q->s->report.norm_inf = operator_norm(q);
    RSV_TRY(rsv_fredholm_alternative(&q->map->linear, alternative, NULL));
cleanup:
    return status;
}

/// A norm of 1 gives no bound. In an open scene, later orders still die out. In a closed lossless one they do not, and
/// there is no solution. Lossless pockets that hardly any light enters, such as the inside of a white cushion, are made
/// dark: the solution next to them is bounded.
///
/// By reciprocity, the light that lasts at a node is close to the fraction of the node's own light that survives, which
/// identifies most pockets at no cost. Otherwise, computing the survival takes POCKET_ORDERS more applications.
static rsv_status check_losses(series *q)
{
    rsv_light *s = q->s;
    rsv_alternative a;
    float *share = rsv_alloc(s->context, 3 * s->elements->node_count, sizeof *share);
    rsv_status status;
    s->pocket_area = 0;
    RSV_TRY(share ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_fredholm_alternative(&q->map->linear, &a, share));
    if (!a.unique && caught_share(s, share) < POCKET_SHARE)
        RSV_TRY(look_without(q, share, POCKET_LASTING, &a));
    if (!a.unique) {
        RSV_TRY(rsv_transport_map_transpose(q->map));
        RSV_TRY(rsv_survival(&q->map->linear, s->elements->node_area, POCKET_ORDERS, share));
        RSV_TRY(caught_share(s, share) < POCKET_SHARE ? RSV_OK : refuse_lossless(q, &a));
        RSV_TRY(look_without(q, share, 0.5f, &a));
    }
    q->resolvent = a.radius.resolvent;
    RSV_TRY(a.unique ? RSV_OK : refuse_lossless(q, &a));
cleanup:
    rsv_free(s->context, share);
    return status;
}

/// Whether all but little of the light dies out. @param alternative of the map
static rsv_status look_for_losses(series *q, const rsv_alternative *alternative, float *share)
{
    const rsv_light *s = q->s;
    rsv_status status = RSV_OK;
    if (alternative->unique || caught_share(s, share) < POCKET_SHARE) return RSV_OK;
    RSV_TRY(rsv_transport_map_transpose(q->map));
    RSV_TRY(rsv_survival(&q->map->linear, s->elements->node_area, POCKET_ORDERS, share));
    if (caught_share(s, share) >= POCKET_SHARE) RSV_TRY(refuse_lossless(q, alternative));
cleanup:
    return status;
}

rsv_status rsv_light_check_bounded(rsv_light *s)
{
    rsv_status status;
    size_t nodes = s->elements->node_count;
    rsv_alternative alternative;
    series q = { .s = s,
        .term = rsv_alloc(s->context, nodes, sizeof *q.term),
        .next = rsv_alloc(s->context, nodes, sizeof *q.next) };
    float *share = rsv_alloc(s->context, 3 * nodes, sizeof *share);
    RSV_TRY(q.term && q.next && share ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_operator_map(s->op, 1, &q.map));
    if (operator_norm(&q) < RSV_LOSSLESS) goto cleanup;
    RSV_TRY(rsv_fredholm_alternative(&q.map->linear, &alternative, share));
    RSV_TRY(look_for_losses(&q, &alternative, share));
cleanup:
    rsv_transport_map_destroy(q.map);
    rsv_free(s->context, q.term);
    rsv_free(s->context, q.next);
    rsv_free(s->context, share);
    return status;
}

static void add_term(rsv_light *s, const rsv_rgb *term)
{
    uint32_t last = RSV_KEPT_ORDERS - 1;
    uint32_t slot = s->field.order_count > last ? last : s->field.order_count;
    for (size_t n = 0; n < s->elements->node_count; n++) {
        s->field.order[slot][n] = rgb_add(s->field.order[slot][n], term[n]);
        s->field.indirect[n] = rgb_add(s->field.indirect[n], term[n]);
    }
    s->field.order_count = slot + 1;
}

/// Adds the result of another solver, beyond the present term, to the last order. Its rounding must not darken
/// anything.
static void add_rest(series *q, const rsv_rgb *sum)
{
    for (size_t n = 0; n < q->s->elements->node_count; n++) {
        rsv_rgb rest = rgb_sub(sum[n], q->term[n]);
        q->next[n] = rgb_positive(rest);
    }
    rsv_elements_constrain(q->s->elements, q->next);
    add_term(q->s, q->next);
}

/// Solves rest = term + G K rest by the solver of the report; if that was our own choice and it fails, by GMRES or, if
/// that was it, by the series.
static rsv_status solve_rest(series *q, uint32_t max_applications)
{
    rsv_solve_report *report = &q->s->report;
    rsv_linear_report linear;
    size_t nodes = q->s->elements->node_count;
    rsv_rgb *rest = rsv_alloc(q->s->context, nodes, sizeof *rest);
    if (!rest) return RSV_ERROR_MEMORY;
    rsv_linear_desc desc = {
        .solver = report->solver, .absolute = q->target, .max_applications = max_applications
    };
    rsv_status status = RSV_OK;
    RSV_TRY(rsv_transport_map_prepare(q->map, report->solver));
    rsv_transport_map_mask(q->map, 1, q->term);
    RSV_TRY(rsv_linear_solve(&q->map->linear, 3, &q->term->r, &desc, &rest->r, &linear));
    report->iterations += (uint32_t)ceil(linear.applications);
    bool failed = linear.stop_reason > RSV_STOP_NO_LIGHT;
    if (failed && q->s->desc.solver == RSV_SOLVER_AUTO) {
        size_t length = strlen(report->solver_reason);
        snprintf(report->solver_reason + length, sizeof report->solver_reason - length,
            "; %s failed", rsv_solver_name(report->solver));
        report->solver = desc.solver =
            report->solver == RSV_SOLVER_GMRES ? RSV_SOLVER_NEUMANN : RSV_SOLVER_GMRES;
        RSV_TRY(rsv_transport_map_prepare(q->map, report->solver));
        RSV_TRY(rsv_linear_solve(&q->map->linear, 3, &q->term->r, &desc, &rest->r, &linear));
        report->iterations += (uint32_t)ceil(linear.applications);
    }
    report->stop_reason = linear.stop_reason;
    add_rest(q, rest);
cleanup:
    rsv_free(q->s->context, rest);
    return status;
}

/// If little is absorbed, irradiance grows so far beyond its source that the target residual is below rounding. Raises
/// the target accordingly. @param rest what irradiance can still grow by, W/m2
static void keep_target_in_reach(series *q, double rest)
{
    const rsv_light *s = q->s;
    double most = 0;
    for (size_t n = 0; n < s->elements->node_count; n++)
        most = fmax(most, (double)rgb_max(rgb_add(s->field.source[n], s->field.indirect[n])));
    q->target = fmax(q->target, ROUNDING * (most + rest));
}

/// The sum of the orders beyond a term, if they fall by the spectral radius.
static double size_of_rest(const rsv_light *s, const rsv_rgb *term)
{
    double radius = fmin(fmax(s->report.spectral_radius, 0), RSV_LOSSLESS);
    return radius / (1 - radius) * largest(term, s->elements->node_count);
}

/// Chooses the solver of all orders beyond those kept one by one.
static void choose_solver(series *q, double size)
{
    rsv_solve_report *report = &q->s->report;
    rsv_solver_question question = { .wanted = q->s->desc.solver,
        .norm_inf = report->norm_inf,
        .spectral_radius = report->spectral_radius,
        .terms = rsv_neumann_terms(report->spectral_radius, size, q->target),
        .node_count = q->s->elements->node_count,
        .on_device = rsv_device_map_solves(q->map->device, RSV_SOLVER_BICGSTAB) };
    report->solver =
        rsv_choose_solver(&question, report->solver_reason, sizeof report->solver_reason);
}

/// Weights area x albedo of the inner product in which G K is self-adjoint, by reciprocity.
static rsv_rgb weight_of(const rsv_light *s, size_t node)
{
    return rgb_scale(rsv_operator_get_view(s->op)->albedo[node], s->elements->node_area[node]);
}

/// <term, G K term> / <term, term>, a Rayleigh quotient: below the spectral radius, by the square of the distance from
/// the slowest mode.
static double rayleigh_quotient(const rsv_light *s, const rsv_rgb *term, const rsv_rgb *next)
{
    double image[3] = { 0 }, square[3] = { 0 }, most = 0;
    for (size_t n = 0; n < s->elements->node_count; n++) {
        rsv_rgb weighted = rgb_mul(weight_of(s, n), term[n]);
        const rsv_rgb to[2] = { rgb_mul(weighted, next[n]), rgb_mul(weighted, term[n]) };
        image[0] += (double)to[0].r, image[1] += (double)to[0].g, image[2] += (double)to[0].b;
        square[0] += (double)to[1].r, square[1] += (double)to[1].g, square[2] += (double)to[1].b;
    }
    for (int c = 0; c < 3; c++)
        if (square[c] > 0) most = fmax(most, image[c] / square[c]);
    return most;
}

/// Notes how fast the orders fall, from the last two of them.
static void note_radius(series *q, uint32_t order, const rsv_rgb *term, const rsv_rgb *next)
{
    rsv_solve_report *report = &q->s->report;
    double size = largest(next, q->s->elements->node_count);
    report->spectral_radius = rayleigh_quotient(q->s, term, next);
    report->neumann_terms = order + rsv_neumann_terms(report->spectral_radius, size, q->target);
}

static rsv_status sum_series(series *q, uint32_t max_orders)
{
    rsv_light *s = q->s;
    rsv_solve_report *report = &s->report;
    size_t nodes = s->elements->node_count;
    memcpy(q->term, s->field.source, nodes * sizeof *q->term);
    report->stop_reason = RSV_STOP_MAX_ORDERS;
    for (uint32_t order = 1; order <= max_orders; order++) {
        apply(q, q->term, q->next);
        rsv_elements_constrain(s->elements, q->next);
        add_term(s, q->next);
        report->iterations = order;
        double size = largest(q->next, nodes);
        rsv_rgb *swap = q->term;
        q->term = q->next;
        q->next = swap;
        if (order < RSV_KEPT_ORDERS) note_radius(q, order, q->next, q->term);
        if (size <= q->target) {
            report->stop_reason = RSV_STOP_CONVERGED;
            break;
        }
        if (order == RSV_KEPT_ORDERS - 2) {
            keep_target_in_reach(q, size_of_rest(s, q->term));
            choose_solver(q, size);
        }
        if (order == RSV_KEPT_ORDERS - 2 && report->solver != RSV_SOLVER_NEUMANN &&
            order < max_orders)
            return solve_rest(q, max_orders - order);
        rsv_status status = rsv_progress(s->context, "solve", (double)order / (double)max_orders);
        if (status != RSV_OK) return status;
    }
    return rsv_progress(s->context, "solve", 1);
}

static rsv_status create_orders(rsv_light *s)
{
    size_t nodes = s->elements->node_count;
    s->field.irradiance = rsv_alloc(s->context, nodes, sizeof *s->field.irradiance);
    s->field.indirect = rsv_alloc(s->context, nodes, sizeof *s->field.indirect);
    if (!s->field.irradiance || !s->field.indirect) return RSV_ERROR_MEMORY;
    for (uint32_t k = 0; k < RSV_KEPT_ORDERS; k++) {
        s->field.order[k] = rsv_alloc(s->context, nodes, sizeof *s->field.order[k]);
        if (!s->field.order[k]) return RSV_ERROR_MEMORY;
    }
    memcpy(s->field.order[0], s->field.source, nodes * sizeof *s->field.source);
    s->field.order_count = 1;
    return RSV_OK;
}

/// Sums the orders, after finding out by how much a residual can be amplified.
static rsv_status solve(series *q, uint32_t max_orders)
{
    rsv_light *s = q->s;
    rsv_solve_report *report = &s->report;
    double mean = rsv_elements_mean_luminance(s->elements, s->field.source);
    report->solver = RSV_SOLVER_NEUMANN;
    snprintf(report->solver_reason, sizeof report->solver_reason, "few orders are enough");
    report->norm_inf = operator_norm(q);
    q->resolvent = 1 / (1 - report->norm_inf);
    if (largest(s->field.source, s->elements->node_count) == 0) {
        report->stop_reason = RSV_STOP_NO_LIGHT;
        return RSV_OK;
    }
    rsv_status status = report->norm_inf >= RSV_LOSSLESS ? check_losses(q) : RSV_OK;
    if (status != RSV_OK) return status;
    // what the missing terms can still add, relative to the present light
    q->target = s->desc.tolerance * mean / q->resolvent;
    return sum_series(q, max_orders);
}

static void report_error(const series *q, rsv_rgb *scratch)
{
    rsv_light *s = q->s;
    for (size_t n = 0; n < s->elements->node_count; n++)
        s->field.irradiance[n] = rgb_add(s->field.source[n], s->field.indirect[n]);
    s->report.residual_inf = residual_norm(q, s->field.irradiance, scratch);
    s->report.truncation_bound = s->report.residual_inf * q->resolvent;
    s->report.mean_irradiance = rsv_elements_mean_luminance(s->elements, s->field.irradiance);
    // a solver stopped by rounding has converged if its residual is small enough
    if (s->report.stop_reason == RSV_STOP_STAGNATED && s->report.residual_inf <= q->target)
        s->report.stop_reason = RSV_STOP_CONVERGED;
}

static rsv_rgb *kept_field(rsv_light *s, uint32_t k)
{
    return k < s->field.order_count ? s->field.order[k] : s->field.indirect;
}

/// The orders after the first, and their sum. Processes take fields in turns.
static void sharpen_fields(series *q)
{
    rsv_light *s = q->s;
    rsv_team_place place = rsv_team_place_of(s->context);
    for (uint32_t k = 1; k <= s->field.order_count; k++)
        if (k % place.size == place.rank)
            rsv_sharpen(s->elements, kept_field(s, k), q->term, q->next);
    for (uint32_t k = 1; k <= s->field.order_count; k++)
        rsv_team_copy(s->context, k % place.size, kept_field(s, k),
            s->elements->node_count * sizeof(rsv_rgb));
}

/// The radius that the orders suggest is a Rayleigh quotient, below the true one; this is the leading eigenvalue.
/// @param weight scratch, [node_count]
static rsv_status find_radius(const series *q, rsv_rgb *weight)
{
    rsv_leading_value leading;
    for (size_t n = 0; n < q->s->elements->node_count; n++)
        weight[n] = weight_of(q->s, n);
    rsv_status status = rsv_leading_eigenvalue(
        &q->map->linear, &weight->r, RADIUS_TOLERANCE, RADIUS_STEPS, &leading);
    if (status == RSV_OK) q->s->report.spectral_radius = leading.value;
    return status;
}

static rsv_status solve_orders(rsv_light *s, uint32_t max_orders, bool measures)
{
    rsv_status status;
    size_t nodes = s->elements->node_count;
    series q = { .s = s,
        .term = rsv_alloc(s->context, nodes, sizeof *q.term),
        .next = rsv_alloc(s->context, nodes, sizeof *q.next) };
    RSV_TRY(q.term && q.next ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(create_orders(s));
    RSV_TRY(rsv_operator_map(s->op, 1, &q.map));
    RSV_TRY(solve(&q, max_orders));
    report_error(&q, q.next);
    sharpen_fields(&q);
    if (measures) RSV_TRY(find_radius(&q, q.next));
cleanup:
    rsv_transport_map_destroy(q.map);
    rsv_free(s->context, q.term);
    rsv_free(s->context, q.next);
    return status;
}

rsv_status rsv_solve_orders(rsv_light *s, uint32_t max_orders)
{
    return solve_orders(s, max_orders, false);
}

rsv_status rsv_solve_and_measure(rsv_light *s) { return solve_orders(s, s->desc.max_orders, true); }

// ---- going on -------------------------------------------------------------------------------------

/// Bound of the resolvent: by the norm where that says anything, else by the radius of before.
static double resolvent_of(const rsv_solve_report *report)
{
    if (report->norm_inf < RSV_LOSSLESS) return 1 / (1 - report->norm_inf);
    return 1 / (1 - fmin(fmax(report->spectral_radius, 0), RSV_LOSSLESS));
}

/// Where few orders are wanted, the series: each adds the light that arrives next. Otherwise GMRES, which takes half as
/// many applications (docs/benchmarks/solver.md) and needs no setup.
static rsv_solver solver_to_go_on(const rsv_light *s, uint32_t max_orders)
{
    if (s->desc.solver != RSV_SOLVER_AUTO) return s->desc.solver;
    if (s->report.solver != RSV_SOLVER_AUTO && s->report.solver != RSV_SOLVER_NEUMANN)
        return s->report.solver;
    return max_orders < s->desc.max_orders ? RSV_SOLVER_NEUMANN : RSV_SOLVER_GMRES;
}

/// @param guess [node_count] E of before in, E out
static rsv_status solve_from(series *q, rsv_rgb *guess, uint32_t max_orders)
{
    rsv_light *s = q->s;
    rsv_solve_report *report = &s->report;
    size_t nodes = s->elements->node_count;
    rsv_linear_report linear;
    rsv_status status;
    memcpy(q->term, s->field.source, nodes * sizeof *q->term);
    rsv_transport_map_mask(q->map, 1, q->term);
    rsv_transport_map_mask(q->map, 1, guess);
    const rsv_linear_desc desc = { .solver = solver_to_go_on(s, max_orders),
        .absolute = q->target,
        .max_applications = max_orders };
    RSV_TRY(rsv_transport_map_prepare(q->map, desc.solver));
    RSV_TRY(rsv_linear_solve(&q->map->linear, 3, &q->term->r, &desc, &guess->r, &linear));
    report->iterations = (uint32_t)ceil(linear.applications);
    report->stop_reason = linear.stop_reason;
    for (size_t n = 0; n < nodes; n++)
        s->field.indirect[n] = rgb_positive(rgb_sub(guess[n], q->term[n]));
    rsv_elements_constrain(s->elements, s->field.indirect);
cleanup:
    return status;
}

rsv_status rsv_solve_on(rsv_light *s, uint32_t max_orders)
{
    rsv_status status;
    size_t nodes = s->elements->node_count;
    series q = { .s = s,
        .term = rsv_alloc(s->context, nodes, sizeof *q.term),
        .next = rsv_alloc(s->context, nodes, sizeof *q.next) };
    RSV_TRY(q.term && q.next ? RSV_OK : RSV_ERROR_MEMORY);
    rsv_light_drop_orders(s);
    RSV_TRY(rsv_operator_map(s->op, 1, &q.map));
    s->report.norm_inf = operator_norm(&q);
    q.resolvent = resolvent_of(&s->report);
    q.target =
        s->desc.tolerance * rsv_elements_mean_luminance(s->elements, s->field.source) / q.resolvent;
    keep_target_in_reach(&q, 0);
    RSV_TRY(solve_from(&q, s->field.irradiance, max_orders));
    report_error(&q, q.next);
    rsv_sharpen(s->elements, s->field.indirect, q.term, q.next);
cleanup:
    rsv_transport_map_destroy(q.map);
    rsv_free(s->context, q.term);
    rsv_free(s->context, q.next);
    return status;
}
