#include "error_field.h"

#include "../solver/linear_solver.h"

/// Relative residual of the solve: samples know s itself to a few percent at best.
#define ACCURACY 1e-2

/// The residual as a field on the elements: each sample is handed to the hats around it, over their areas. (What the
/// operator makes of it is the mean over all samples of what it makes of each.)
static void project(const rsv_solution *s, const rsv_residual_sample *sample, size_t count,
    size_t set, float area, rsv_rgb *load)
{
    const rsv_elements *e = s->elements;
    for (size_t k = set; k < count; k += RSV_SAMPLE_SETS) {
        if (!sample[k].valid) continue;
        float weight[3];
        const rsv_face_point *p = &sample[k].point;
        const uint32_t *node = e->cell_node[rsv_elements_locate(e, p->face, p->u, p->v, weight)];
        rsv_rgb residual =
            rgb_scale(rgb_add(sample[k].at.residual[0], sample[k].at.residual[1]), 0.5f * area);
        for (int corner = 0; corner < 3; corner++)
            load[node[corner]] = rgb_mad(load[node[corner]], weight[corner], residual);
    }
    rsv_elements_constrain_transpose(e, load);
    for (size_t n = 0; n < e->node_count; n++)
        load[n] = e->node_area[n] > 0 ? rgb_scale(load[n], 1 / e->node_area[n]) : rgb_gray(0);
}

/// Solves x = A load + A x for all sets at once.
static rsv_status solve(const rsv_solution *s, const rsv_rgb *load, rsv_rgb *image, rsv_rgb *error)
{
    rsv_transport_map *map = NULL;
    rsv_linear_report report;
    rsv_linear_desc desc = rsv_default_linear_desc(s->report.solver);
    size_t columns = 3 * RSV_SAMPLE_SETS;
    desc.relative = ACCURACY;
    desc.max_applications = s->desc.max_orders;
    desc.spectral_radius = s->report.spectral_radius;
    rsv_status status = RSV_OK;
    RSV_TRY(rsv_transport_map_create(
        s->elements, s->transport, s->subsurface, s->exitance_albedo, RSV_SAMPLE_SETS, &map));
    RSV_TRY(rsv_transport_map_prepare(map, desc.solver));
    map->linear.table->apply(map->linear.data, columns, &load->r, &image->r);
    RSV_TRY(rsv_linear_solve(&map->linear, columns, &image->r, &desc, &error->r, &report));
cleanup:
    rsv_transport_map_destroy(map);
    return status;
}

rsv_status rsv_error_field_create(const rsv_solution *s, const rsv_residual_sample *sample,
    size_t count, double area, rsv_error_field *field)
{
    rsv_context *context = s->context;
    size_t nodes = s->elements->node_count, sets = RSV_SAMPLE_SETS;
    rsv_status status = RSV_ERROR_MEMORY;
    rsv_rgb *one = rsv_alloc(context, nodes, sizeof *one);
    rsv_rgb *load = rsv_alloc(context, sets * nodes, sizeof *load);
    rsv_rgb *image = rsv_alloc(context, sets * nodes, sizeof *image);
    rsv_rgb *error = rsv_alloc(context, sets * nodes, sizeof *error);
    if (!one || !load || !image || !error) goto cleanup;
    for (size_t set = 0; set < sets; set++) {
        field->reflected[set] = rsv_alloc(context, nodes, sizeof *one);
        if (!field->reflected[set]) goto cleanup;
        for (size_t n = 0; n < nodes; n++)
            one[n] = rgb_gray(0);
        project(s, sample, count, set, (float)(area * RSV_SAMPLE_SETS), one);
        for (size_t n = 0; n < nodes; n++)
            load[n * sets + set] = one[n];
    }
    RSV_TRY(solve(s, load, image, error));
    for (size_t set = 0; set < sets; set++) {
        for (size_t n = 0; n < nodes; n++)
            field->reflected[set][n] = error[n * sets + set];
        rsv_elements_constrain(s->elements, field->reflected[set]);
    }
cleanup:
    rsv_free(context, one);
    rsv_free(context, load);
    rsv_free(context, image);
    rsv_free(context, error);
    return status;
}

void rsv_error_field_destroy(rsv_context *context, rsv_error_field *field)
{
    for (size_t set = 0; set < RSV_SAMPLE_SETS; set++)
        rsv_free(context, field->reflected[set]);
    *field = (rsv_error_field){ 0 };
}

rsv_rgb rsv_error_field_at(const rsv_solution *s, const rsv_rgb *reflected, const rsv_face_point *p)
{
    return rsv_elements_interpolate(s->elements, reflected, p->face, p->u, p->v);
}
