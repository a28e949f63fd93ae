#include "coarse_elements.h"

#include "../operator/burial.h"
#include "../operator/cluster.h"
#include "../operator/contact.h"

/// Where meshes are finer than the wanted spacing, nodes follow leaders within this part of it; pilots halve that where
/// light changes quickly.
#define CLUSTER_RADIUS 1.0f
#define CLUSTER_RADIUS_WITHOUT_PILOTS 0.5f

static rsv_status prepare_elements(rsv_solution *s)
{
    rsv_status status = rsv_elements_separate(s->tracer, s->elements, &s->report.rays);
    if (status == RSV_OK)
        status = rsv_elements_cluster(s->elements,
            s->elements->spacing *
                (s->desc.refinements ? CLUSTER_RADIUS : CLUSTER_RADIUS_WITHOUT_PILOTS));
    if (status != RSV_OK) return status;
    rsv_free(s->context, s->valid_points);
    s->valid_points = rsv_alloc(s->context, s->elements->node_count, sizeof *s->valid_points);
    if (!s->valid_points) return RSV_ERROR_MEMORY;
    status = rsv_find_buried(
        &s->scene, s->elements, RSV_SUPPORT_POINTS, s->desc.seed, s->valid_points, &s->report.rays);
    return status == RSV_OK ? rsv_elements_bridge_buried(s->elements, s->valid_points) : status;
}

rsv_status rsv_coarse_elements_create(rsv_solution *s, float spacing, float largest)
{
    rsv_status status = rsv_elements_create(s->scene.scene, s->bsdf, largest, &s->elements);
    if (status != RSV_OK) return status;
    s->elements->spacing = spacing;
    status = rsv_elements_refine_contacts(&s->scene, &s->elements, &s->report.rays);
    return status == RSV_OK ? prepare_elements(s) : status;
}

rsv_status rsv_coarse_elements_split(rsv_solution *s, const uint8_t *split)
{
    rsv_elements *finer = NULL;
    rsv_status status = rsv_elements_refine(s->elements, split, &finer);
    if (status != RSV_OK) return status;
    rsv_elements_destroy(s->elements);
    s->elements = finer;
    return prepare_elements(s);
}
