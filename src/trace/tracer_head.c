#include "../core/core.h"
#include "../scene/material_at.h"
#include "../scene/scene.h"
#include "tracer_internal.h"

void rsv_tracer_head_find_twins(rsv_tracer_head *head)
{
    const rsv_scene_view *view = rsv_scene_get_view(head->scene);
    head->twins = view->twins ? view : NULL;
}

rsv_status rsv_tracer_head_begin(const rsv_scene *scene, rsv_tracer_head *head)
{
    head->context = rsv_scene_get_context(scene);
    head->scene = scene;
    head->blended = rsv_find_blended(rsv_scene_get_view(scene));
    rsv_tracer_head_find_twins(head);
    head->hierarchy = rsv_alloc(head->context, 1, sizeof *head->hierarchy);
    if (!head->hierarchy) return RSV_ERROR_MEMORY;
    pthread_mutex_init(&head->hierarchy->lock, NULL);
    return RSV_OK;
}

void rsv_tracer_head_end(rsv_tracer_head *head)
{
    if (!head->hierarchy) return;
    rsv_bvh_destroy(&head->hierarchy->bvh);
    pthread_mutex_destroy(&head->hierarchy->lock);
    rsv_free(head->context, head->hierarchy);
}
