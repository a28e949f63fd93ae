#include "light_internal.h"
#include "resolvent/measure.h"

rsv_status rsv_measure_assembly(const rsv_light *s, rsv_assembly_cost *cost)
{
    rsv_transport *again = NULL;
    rsv_ray_cost rays;
    const rsv_transport_desc desc = { &s->scene, s->sources->lights, s->elements,
        s->view.valid_points, s->desc.rays_per_element, s->desc.seed };
    double start = rsv_seconds();
    rsv_status status = rsv_transport_create(&desc, &again);
    if (status != RSV_OK) return status;
    cost->assembly_seconds = rsv_seconds() - start;
    rsv_transport_destroy(again);
    status = rsv_transport_trace_only(&desc, &rays);
    if (status != RSV_OK) return status;
    cost->rays = rays.rays;
    cost->tracing_seconds = rays.packet_seconds;
    cost->single_seconds = rays.single_seconds;
    return RSV_OK;
}
