/// The elements of an operator: where they are, and which of them surround a point.
#include "../core/parallel.h"
#include "../elements/voxels.h"
#include "goal.h"
#include "operator.h"

bool rsv_operator_locate(const rsv_operator *op, uint32_t triangle, float u, float v,
    bool back_side, rsv_element_weights *around)
{
    const rsv_elements *e = rsv_operator_get_view(op)->elements;
    uint32_t face = e->face_of[back_side][triangle];
    if (face == RSV_NONE) return false;
    const uint32_t *node = e->cell_node[rsv_elements_locate(e, face, u, v, around->weight)];
    for (int k = 0; k < 3; k++)
        around->element[k] = node[k];
    return true;
}

/// Weights are 0 where nothing reflects diffusely.
static rsv_element_weights locate_probe(const rsv_operator *op, const rsv_probe *probe)
{
    const rsv_transport_scene *scene = &rsv_operator_get_view(op)->world->scene;
    const rsv_element_weights none = { { 0 }, { 0 } };
    rsv_hit hit;
    if (!rsv_tracer_nearest(scene->tracer, probe->position, probe->normal, &hit)) return none;
    const uint32_t *corner = scene->view->triangle[hit.triangle];
    const rsv_vec3 *position = scene->view->position;
    rsv_vec3 front = v3_cross(v3_sub(position[corner[1]], position[corner[0]]),
        v3_sub(position[corner[2]], position[corner[0]]));
    bool back_side = v3_dot(front, probe->normal) < 0;
    rsv_element_weights around;
    return rsv_operator_locate(op, hit.triangle, hit.u, hit.v, back_side, &around) ? around : none;
}

typedef struct locate_job {
    const rsv_operator *op;
    const rsv_probe *probes;
    rsv_element_weights *around;
} locate_job;

static void locate_span(void *data, rsv_span span)
{
    const locate_job *job = data;
    const rsv_context *context = rsv_operator_get_view(job->op)->context;
    for (size_t k = span.begin; k < span.end && !rsv_cancelled(context); k++)
        job->around[k] = locate_probe(job->op, &job->probes[k]);
}

rsv_status rsv_operator_locate_probes(
    const rsv_operator *op, const rsv_probe *probes, size_t count, rsv_element_weights *around)
{
    rsv_context *context = rsv_operator_get_view(op)->context;
    rsv_status status = rsv_check_probes(probes, count);
    if (status != RSV_OK) return status;
    locate_job job = { op, probes, around };
    rsv_parallel_for(context, count, 256, locate_span, &job);
    return rsv_progress(context, "probe", 1);
}

static rsv_element in_air(const rsv_operator_view *view, size_t node)
{
    const rsv_elements *e = view->elements;
    size_t voxel = node - rsv_elements_surface_nodes(e);
    return (rsv_element){ .position = rsv_voxel_centre(e->voxels, (uint32_t)voxel),
        .albedo = view->albedo[node],
        .area = e->node_area[node],
        .triangle = RSV_NONE };
}

static rsv_element on_surface(const rsv_operator_view *view, uint32_t node)
{
    const rsv_elements *e = view->elements;
    rsv_surface_point point = rsv_elements_node_point(view->world->scene.view, e, node);
    uint32_t face = e->node_face[node];
    return (rsv_element){ .position = point.position,
        .normal = point.normal,
        .albedo = view->albedo[node],
        .area = e->node_area[node],
        .triangle = e->face_triangle[face],
        .back_side = e->face_back[face] };
}

typedef struct elements_job {
    const rsv_operator_view *view;
    rsv_element *element;
} elements_job;

static void describe_elements(void *data, rsv_span span)
{
    const elements_job *job = data;
    const rsv_operator_view *view = job->view;
    for (uint32_t n = (uint32_t)span.begin; n < span.end; n++)
        job->element[n] =
            view->elements->node_face[n] == RSV_NONE ? in_air(view, n) : on_surface(view, n);
}

rsv_status rsv_operator_elements(const rsv_operator *op, rsv_element *element)
{
    const rsv_operator_view *view = rsv_operator_get_view(op);
    elements_job job = { view, element };
    rsv_parallel_for(view->context, view->elements->node_count, 0, describe_elements, &job);
    return RSV_OK;
}
