#include "hierarchy.h"

#include "tracer_internal.h"

rsv_status rsv_tracer_hierarchy(const rsv_tracer *tracer, rsv_bvh_view *view)
{
    rsv_bvh *kept = rsv_tracer_head_of(tracer)->hierarchy;
    rsv_status status = RSV_OK;
#pragma omp critical(rsv_tracer_hierarchy)
    {
        if (!kept->context) status = rsv_bvh_build_scene(rsv_tracer_head_of(tracer)->scene, kept);
        *view = kept->view;
    }
    return status;
}
