#include "error_field.h"

#include "../solver/linear_solver.h"

#include <string.h>

/// Relative residual of the solve: samples determine s to a few percent at best.
#define ACCURACY 1e-2
/// Sets that are solved together: memory for speed.
#define SETS_AT_A_TIME 4

/// Samples of the residual, in sets that take turns.
typedef struct residual_samples {
    const rsv_residual_sample *sample;
    size_t count;
    double area; ///< that they stand for, m2
} residual_samples;

/// The residual as a field on the elements: each sample is distributed to the hat functions around it, divided by their
/// areas. (The operator's image of it is the mean over all samples of their images.)
static void project(
    const rsv_light_view *s, const residual_samples *samples, size_t set, rsv_rgb *load)
{
    const rsv_elements *e = s->elements;
    double area = samples->area * RSV_SAMPLE_SETS;
    for (size_t k = set; k < samples->count; k += RSV_SAMPLE_SETS) {
        const rsv_residual_sample *sample = &samples->sample[k];
        if (!sample->valid) continue;
        float weight[3];
        const rsv_face_point *p = &sample->point;
        const uint32_t *node = e->cell_node[rsv_elements_locate(e, p->face, p->u, p->v, weight)];
        rsv_rgb residual = rgb_scale(rgb_add(sample->at.residual[0], sample->at.residual[1]),
            (float)(0.5 * area * sample->weight));
        for (int corner = 0; corner < 3; corner++)
            load[node[corner]] = rgb_mad(load[node[corner]], weight[corner], residual);
    }
    rsv_elements_constrain_transpose(e, 1, load);
    for (size_t n = 0; n < e->node_count; n++)
        load[n] = e->node_area[n] > 0 ? rgb_scale(load[n], 1 / e->node_area[n]) : rgb_gray(0);
}

/// Solves x = A load + A x for some sets at once.
static rsv_status solve(
    const rsv_light_view *s, const rsv_rgb *load, rsv_rgb *image, rsv_rgb *error)
{
    rsv_transport_map *map = NULL;
    rsv_linear_report report;
    // a solver that was stopped too early once would be again
    bool converged = s->report.stop_reason == RSV_STOP_CONVERGED;
    rsv_linear_desc desc =
        rsv_default_linear_desc(converged ? s->report.solver : RSV_SOLVER_BICGSTAB);
    size_t columns = 3 * SETS_AT_A_TIME;
    desc.relative = ACCURACY;
    desc.spectral_radius = s->report.spectral_radius;
    rsv_status status = RSV_OK;
    RSV_TRY(rsv_operator_map(s->op, SETS_AT_A_TIME, &map));
    RSV_TRY(rsv_transport_map_prepare(map, desc.solver));
    map->linear.table->apply(map->linear.data, columns, &load->r, &image->r);
    RSV_TRY(rsv_linear_solve(&map->linear, columns, &image->r, &desc, &error->r, &report));
    if (report.stop_reason != RSV_STOP_CONVERGED)
        rsv_log(s->context, RSV_LOG_WARNING,
            "certify: the solve with the residual was not finished; the estimate of the error may "
            "be too small");
cleanup:
    rsv_transport_map_destroy(map);
    return status;
}

/// The scratch of a few sets, side by side at each node.
typedef struct batch {
    rsv_rgb *one;                  ///< [node_count]
    rsv_rgb *load, *image, *error; ///< [node_count x SETS_AT_A_TIME]
} batch;

static rsv_status predict(const rsv_light_view *s, const residual_samples *samples,
    size_t first_set, batch *b, rsv_error_field *field)
{
    size_t nodes = s->elements->node_count, sets = SETS_AT_A_TIME;
    rsv_status status = RSV_OK;
    for (size_t k = 0; k < sets; k++) {
        memset(b->one, 0, nodes * sizeof *b->one);
        project(s, samples, first_set + k, b->one);
        for (size_t n = 0; n < nodes; n++)
            b->load[n * sets + k] = b->one[n];
    }
    memset(b->error, 0, sets * nodes * sizeof *b->error);
    RSV_TRY(solve(s, b->load, b->image, b->error));
    for (size_t k = 0; k < sets; k++) {
        rsv_rgb *reflected = field->reflected[first_set + k];
        for (size_t n = 0; n < nodes; n++)
            reflected[n] = b->error[n * sets + k];
        rsv_elements_constrain(s->elements, reflected);
    }
cleanup:
    return status;
}

rsv_status rsv_error_field_create(const rsv_light_view *s, const rsv_residual_sample *sample,
    size_t count, double area, rsv_error_field *field)
{
    rsv_context *context = s->context;
    size_t nodes = s->elements->node_count, sets = SETS_AT_A_TIME;
    const residual_samples samples = { sample, count, area };
    rsv_status status = RSV_ERROR_MEMORY;
    batch b = { .one = rsv_alloc(context, nodes, sizeof *b.one),
        .load = rsv_alloc(context, sets * nodes, sizeof *b.load),
        .image = rsv_alloc(context, sets * nodes, sizeof *b.image),
        .error = rsv_alloc(context, sets * nodes, sizeof *b.error) };
    if (!b.one || !b.load || !b.image || !b.error) goto cleanup;
    for (size_t set = 0; set < RSV_SAMPLE_SETS; set++) {
        field->reflected[set] = rsv_alloc(context, nodes, sizeof *b.one);
        if (!field->reflected[set]) goto cleanup;
    }
    status = RSV_OK;
    for (size_t set = 0; set < RSV_SAMPLE_SETS; set += sets)
        RSV_TRY(predict(s, &samples, set, &b, field));
cleanup:
    rsv_free(context, b.one);
    rsv_free(context, b.load);
    rsv_free(context, b.image);
    rsv_free(context, b.error);
    return status;
}

void rsv_error_field_destroy(rsv_context *context, rsv_error_field *field)
{
    for (size_t set = 0; set < RSV_SAMPLE_SETS; set++)
        rsv_free(context, field->reflected[set]);
    *field = (rsv_error_field){ 0 };
}

rsv_rgb rsv_error_field_at(
    const rsv_light_view *s, const rsv_rgb *reflected, const rsv_face_point *p)
{
    return rsv_elements_interpolate(s->elements, reflected, p->face, p->u, p->v);
}
