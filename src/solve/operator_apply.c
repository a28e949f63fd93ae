#include "operator.h"

#include <string.h>

rsv_status rsv_operator_apply(const rsv_operator *op, const rsv_rgb *field, rsv_rgb *image)
{
    rsv_transport_map *map = NULL;
    rsv_status status = rsv_operator_map(op, 1, &map);
    if (status == RSV_OK) {
        map->linear.table->apply(map->linear.data, 3, &field->r, &image->r);
        rsv_elements_constrain(map->elements, image);
    }
    rsv_transport_map_destroy(map);
    return status;
}

rsv_status rsv_operator_apply_transpose(
    const rsv_operator *op, const rsv_rgb *field, rsv_rgb *image)
{
    rsv_transport_map *map = NULL;
    rsv_status status;
    rsv_context *context = rsv_operator_get_view(op)->context;
    size_t nodes = rsv_operator_element_count(op);
    rsv_rgb *weight = rsv_reserve(context, nodes, sizeof *weight);
    RSV_TRY(weight ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_operator_map(op, 1, &map));
    RSV_TRY(rsv_transport_map_transpose(map));
    memcpy(weight, field, nodes * sizeof *weight);
    rsv_elements_constrain_transpose(
        map->elements, 1, weight); // the map has no values at hanging nodes
    map->linear.table->apply_transpose(map->linear.data, 3, &weight->r, &image->r);
cleanup:
    rsv_transport_map_destroy(map);
    rsv_free(context, weight);
    return status;
}

rsv_status rsv_operator_residual(
    const rsv_operator *op, const rsv_rgb *source, const rsv_rgb *field, rsv_rgb *residual)
{
    rsv_transport_map *map = NULL;
    rsv_status status = rsv_operator_map(op, 1, &map);
    if (status == RSV_OK)
        map->linear.table->residual(map->linear.data, 3, &source->r, &field->r, &residual->r);
    rsv_transport_map_destroy(map);
    return status;
}

rsv_status rsv_operator_norm(const rsv_operator *op, double *norm_inf)
{
    rsv_status status;
    size_t nodes = rsv_operator_element_count(op);
    rsv_context *context = rsv_operator_get_view(op)->context;
    rsv_rgb *ones = rsv_alloc(context, nodes, sizeof *ones);
    rsv_rgb *sums = rsv_alloc(context, nodes, sizeof *sums);
    RSV_TRY(ones && sums ? RSV_OK : RSV_ERROR_MEMORY);
    for (size_t n = 0; n < nodes; n++)
        ones[n] = rgb_gray(1);
    RSV_TRY(rsv_operator_apply(op, ones, sums));
    *norm_inf = 0;
    for (size_t n = 0; n < nodes; n++)
        *norm_inf = fmax(*norm_inf, rgb_max(sums[n]));
cleanup:
    rsv_free(context, ones);
    rsv_free(context, sums);
    return status;
}

size_t rsv_operator_element_count(const rsv_operator *op)
{
    return rsv_operator_get_view(op)->elements->node_count;
}
