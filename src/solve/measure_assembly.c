#include "light_internal.h"

rsv_status rsv_measure_assembly(const rsv_light *s, rsv_assembly_cost *cost)
{
    rsv_transport *again = NULL;
    uint32_t rays = s->desc.rays_per_element;
    double start = rsv_seconds();
    rsv_status status = rsv_transport_create(&s->scene, s->sources->lights, s->elements,
        s->view.valid_points, rays, s->desc.seed, &again);
    if (status != RSV_OK) return status;
    cost->assembly_seconds = rsv_seconds() - start;
    rsv_transport_destroy(again);
    return rsv_transport_trace_only(&s->scene, s->elements, s->view.valid_points, rays,
        s->desc.seed, &cost->rays, &cost->tracing_seconds, &cost->single_seconds);
}
