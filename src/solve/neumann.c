/// E = sum (G K)^n E0. The series converges because ||G K|| < 1; its last term is also the residual of
/// the sum so far, so the truncation bound costs nothing.
#include "solution.h"

#include "../operator/bend.h"

#include <string.h>

/// exitance = K irradiance
static void scatter(const rsv_solution *s, const rsv_rgb *irradiance, rsv_rgb *exitance)
{
    rsv_subsurface_apply(s->subsurface, s->elements, irradiance, exitance);
    for (size_t n = 0; n < s->elements->node_count; n++)
        exitance[n] = rgb_mul(s->exitance_albedo[n], exitance[n]);
}

/// next = G K term, on all nodes.
static void apply(const rsv_solution *s, const rsv_rgb *term, rsv_rgb *exitance, rsv_rgb *next)
{
    scatter(s, term, exitance);
    rsv_transport_apply(s->transport, exitance, next);
    rsv_elements_constrain(s->elements, next);
}

static double largest(const rsv_rgb *value, size_t count)
{
    double max = 0;
    for (size_t n = 0; n < count; n++)
        max = fmax(max, rgb_max(value[n]));
    return max;
}

/// ||G K||_inf: what comes of an irradiance of 1 everywhere.
static double operator_norm(const rsv_solution *s, rsv_rgb *exitance, rsv_rgb *sums)
{
    for (size_t n = 0; n < s->elements->node_count; n++)
        sums[n] = rgb_gray(1);
    scatter(s, sums, exitance);
    rsv_transport_apply(s->transport, exitance, sums);
    return largest(sums, s->elements->node_count);
}

/// ||E0 + G K E - E||_inf with sums in double.
/// @param diffused P irradiance
static double residual_norm(
    const rsv_solution *s, const rsv_rgb *irradiance, const rsv_rgb *diffused)
{
    const rsv_transport *t = s->transport;
    double max = 0;
#pragma omp parallel for reduction(max : max) num_threads(rsv_threads(s->context))
    for (size_t row = 0; row < t->row_count; row++) {
        if (t->scale[row] == 0) continue;
        double sum[3] = { 0, 0, 0 };
        for (size_t k = t->row_begin[row]; k < t->row_begin[row + 1]; k++) {
            rsv_rgb e = diffused[t->column[k]], a = s->exitance_albedo[t->column[k]];
            sum[0] += (double)e.r * a.r, sum[1] += (double)e.g * a.g, sum[2] += (double)e.b * a.b;
        }
        for (size_t k = t->tinted_begin[row]; k < t->tinted_begin[row + 1]; k++) {
            rsv_rgb e = diffused[t->tinted_column[k]], a = s->exitance_albedo[t->tinted_column[k]];
            rsv_rgb w = t->tinted_weight[k];
            sum[0] += (double)e.r * a.r * w.r, sum[1] += (double)e.g * a.g * w.g;
            sum[2] += (double)e.b * a.b * w.b;
        }
        rsv_rgb e = irradiance[row], e0 = s->source[row];
        max = fmax(max, fabs(e0.r + sum[0] * t->scale[row] - e.r));
        max = fmax(max, fabs(e0.g + sum[1] * t->scale[row] - e.g));
        max = fmax(max, fabs(e0.b + sum[2] * t->scale[row] - e.b));
    }
    return max;
}

/// A norm of 1 leaves the series without a bound. It still converges in an open scene, term by term
/// smaller; in a closed lossless one the terms stay as they are.
#define LOSSLESS_ORDERS 64
#define LOSSLESS_RATIO 0.9999

static rsv_status refuse_lossless(void)
{
    return rsv_fail(RSV_ERROR_SCENE,
        "solve: the scene is closed and absorbs nothing (albedo 1): light never dies out and there "
        "is "
        "no bounded answer; lower an albedo below 1 or open the scene");
}

static void add_term(rsv_solution *s, const rsv_rgb *term)
{
    uint32_t last = RSV_KEPT_ORDERS - 1;
    uint32_t slot = s->order_count > last ? last : s->order_count;
    for (size_t n = 0; n < s->elements->node_count; n++) {
        s->order[slot][n] = rgb_add(s->order[slot][n], term[n]);
        s->indirect[n] = rgb_add(s->indirect[n], term[n]);
    }
    s->order_count = slot + 1;
}

static rsv_status sum_series(
    rsv_solution *s, uint32_t max_orders, rsv_rgb *term, rsv_rgb *next, rsv_rgb *exitance)
{
    rsv_solve_report *report = &s->report;
    size_t nodes = s->elements->node_count;
    double mean = rsv_elements_mean_luminance(s->elements, s->source), previous = 0;
    bool bounded = report->norm_inf < 1;
    double margin = bounded ? 1 - report->norm_inf : 1e-3;
    memcpy(term, s->source, nodes * sizeof *term);
    report->stop_reason = RSV_STOP_MAX_ORDERS;
    for (uint32_t order = 1; order <= max_orders; order++) {
        apply(s, term, exitance, next);
        add_term(s, next);
        report->iterations = order;
        double size = largest(next, nodes);
        if (!isfinite(size)) return refuse_lossless();
        if (!bounded && order == LOSSLESS_ORDERS && size > LOSSLESS_RATIO * previous)
            return refuse_lossless();
        // what the missing terms can still add, on the scale of the light there is
        if (size / margin <= s->desc.tolerance * mean) {
            report->stop_reason = RSV_STOP_CONVERGED;
            break;
        }
        previous = size;
        rsv_rgb *swap = term;
        term = next;
        next = swap;
        rsv_status status = rsv_progress(s->context, "solve", (double)order / (double)max_orders);
        if (status != RSV_OK) return status;
    }
    return rsv_progress(s->context, "solve", 1);
}

typedef struct luminance_range {
    float low, high;
} luminance_range;

/// Luminance of a node and its neighbours.
static luminance_range range_around(const rsv_elements *e, const rsv_rgb *value, size_t node)
{
    float own = rgb_luminance(value[node]);
    luminance_range range = { own, own };
    for (uint32_t s = e->support_begin[node]; s < e->support_begin[node + 1]; s++) {
        for (int k = 0; k < 3; k++) {
            float luminance = rgb_luminance(value[e->cell_node[e->support[s] / 4][k]]);
            range.low = f_min(range.low, luminance);
            range.high = f_max(range.high, luminance);
        }
    }
    return range;
}

/// Rows average over their node's hat function, so what was solved is M E rather than E, with M =
/// rsv_elements_average. 3 M - 2 M^2 times it is E again to second order (M (3 M - 2 M^2) = I +
/// O((I - M)^2)), most visibly at the borders of surfaces, and unlike 2 I - M it does not amplify noise.
/// Next to a jump it would overshoot: nodes there keep what was solved.
#define SMOOTH_CONTRAST 2

static void sharpen(const rsv_elements *e, rsv_rgb *value, rsv_rgb *once, rsv_rgb *twice)
{
    rsv_elements_average(e, value, once);
    rsv_elements_average(e, once, twice);
    for (size_t n = 0; n < e->node_count; n++) {
        luminance_range range = range_around(e, value, n);
        rsv_rgb sharp = rgb_sub(rgb_scale(once[n], 3), rgb_scale(twice[n], 2));
        float luminance = rgb_luminance(sharp);
        bool smooth = range.high <= SMOOTH_CONTRAST * range.low && luminance >= range.low &&
                      luminance <= range.high;
        once[n] = smooth ? sharp : value[n]; // `once` is free as soon as it is read
    }
    memcpy(value, once, e->node_count * sizeof *value);
    rsv_elements_constrain(e, value);
}

rsv_status rsv_solve_neumann(rsv_solution *s, uint32_t max_orders)
{
    rsv_status status = RSV_OK;
    size_t nodes = s->elements->node_count;
    rsv_rgb *a = rsv_alloc(s->context, nodes, sizeof *a),
            *b = rsv_alloc(s->context, nodes, sizeof *b);
    rsv_rgb *exitance = rsv_alloc(s->context, nodes, sizeof *exitance);
    s->indirect = rsv_alloc(s->context, nodes, sizeof *s->indirect);
    bool complete = a && b && exitance && s->indirect;
    for (uint32_t k = 0; k < RSV_KEPT_ORDERS; k++) {
        s->order[k] = rsv_alloc(s->context, nodes, sizeof *s->order[k]);
        complete = complete && s->order[k];
    }
    if (!complete) {
        status = RSV_ERROR_MEMORY;
        goto cleanup;
    }
    memcpy(s->order[0], s->source, nodes * sizeof *s->source);
    s->order_count = 1;
    s->report.norm_inf = operator_norm(s, exitance, a);
    if (largest(s->source, nodes) == 0)
        s->report.stop_reason = RSV_STOP_NO_LIGHT;
    else
        RSV_TRY(sum_series(s, max_orders, a, b, exitance));
    for (size_t n = 0; n < nodes; n++)
        a[n] = rgb_add(s->source[n], s->indirect[n]);
    rsv_subsurface_apply(s->subsurface, s->elements, a, b);
    s->report.residual_inf = residual_norm(s, a, b);
    s->report.truncation_bound =
        s->report.norm_inf < 1 ? s->report.residual_inf / (1 - s->report.norm_inf) : INFINITY;
    s->report.mean_irradiance = rsv_elements_mean_luminance(s->elements, a);
    for (uint32_t order = 1; order < s->order_count; order++)
        sharpen(s->elements, s->order[order], a, b);
    sharpen(s->elements, s->indirect, a, b);
cleanup:
    rsv_free(s->context, a);
    rsv_free(s->context, b);
    rsv_free(s->context, exitance);
    return status;
}
