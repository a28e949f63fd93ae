#include "hierarchy.h"

#include "tracer_internal.h"

rsv_status rsv_tracer_hierarchy(const rsv_tracer *tracer, rsv_bvh_view *view)
{
    const rsv_tracer_head *head = rsv_tracer_head_of(tracer);
    rsv_device_hierarchy *kept = head->hierarchy;
    rsv_status status = RSV_OK;
    pthread_mutex_lock(&kept->lock);
    if (!kept->bvh.context) status = rsv_bvh_build_scene(head->scene, &kept->bvh);
    *view = kept->bvh.view;
    pthread_mutex_unlock(&kept->lock);
    return status;
}
