#include "coarse_elements.h"

#include "../operator/burial.h"
#include "../operator/cluster.h"
#include "../operator/contact.h"

/// Where meshes are finer than the wanted spacing, nodes follow leaders within this part of it; pilots halve that where
/// light changes quickly.
#define CLUSTER_RADIUS 1.0f
#define CLUSTER_RADIUS_WITHOUT_PILOTS 0.5f

/// Splits at contacts may add this many nodes times the root of those that were asked for: they lie along lines.
#define CONTACT_NODES 300

/// Where all points of a node or none are buried, those drawn for another number of the same node are as well.
static bool holds_for_all_points(uint16_t valid)
{
    return valid == 0 || valid == (1u << RSV_SUPPORT_POINTS) - 1;
}

/// Finds the receiver points that are not buried, anew where the cells around a node are not those of `earlier`.
/// @param earlier NULL = everywhere @param earlier_points of those elements
static rsv_status find_valid_points(
    rsv_solution *s, const rsv_elements *earlier, const uint16_t *earlier_points)
{
    const rsv_elements *e = s->elements;
    rsv_status status;
    uint8_t *known = rsv_alloc(s->context, e->node_count, 1);
    uint16_t *valid = s->valid_points =
        rsv_alloc(s->context, e->node_count, sizeof *s->valid_points);
    RSV_TRY(known && valid ? RSV_OK : RSV_ERROR_MEMORY);
#pragma omp parallel for schedule(static) num_threads(rsv_threads(s->context))
    for (size_t n = 0; n < e->node_count; n++) {
        uint32_t twin = earlier ? rsv_elements_find_twin(e, (uint32_t)n, earlier) : RSV_NONE;
        known[n] = twin != RSV_NONE && earlier->node_hanging[twin] == RSV_NONE &&
                   e->node_hanging[n] == RSV_NONE && holds_for_all_points(earlier_points[twin]);
        if (known[n]) valid[n] = earlier_points[twin];
    }
    RSV_TRY(rsv_find_buried(
        &s->scene, e, RSV_SUPPORT_POINTS, s->desc.seed, known, valid, &s->report.rays));
cleanup:
    rsv_free(s->context, known);
    return status;
}

static rsv_status prepare_elements(
    rsv_solution *s, const rsv_elements *earlier, const uint16_t *earlier_points)
{
    rsv_status status;
    float part = s->desc.refinements ? CLUSTER_RADIUS : CLUSTER_RADIUS_WITHOUT_PILOTS;
    RSV_TRY(rsv_elements_separate(&s->scene, earlier, s->elements, &s->report.rays));
    RSV_TRY(rsv_elements_cluster(s->elements, part * s->elements->spacing));
    RSV_TRY(find_valid_points(s, earlier, earlier_points));
    RSV_TRY(rsv_elements_bridge_buried(s->elements, s->valid_points));
cleanup:
    return status;
}

rsv_status rsv_coarse_elements_create(rsv_solution *s, float coarsening)
{
    rsv_spacing first = s->spacing;
    first.metres *= coarsening;
    rsv_status status = rsv_elements_create(s->scene.scene, s->bsdf, &first, &s->elements);
    if (status != RSV_OK) return status;
    s->elements->spacing = s->spacing.metres;
    rsv_free(s->context, s->valid_points);
    s->valid_points = NULL;
    size_t most_nodes = (size_t)(CONTACT_NODES * sqrt(s->desc.element_target));
    status = rsv_elements_refine_contacts(&s->scene, most_nodes, &s->elements, &s->report.rays);
    return status == RSV_OK ? prepare_elements(s, NULL, NULL) : status;
}

rsv_status rsv_coarse_elements_split(rsv_solution *s, const uint8_t *split)
{
    rsv_elements *earlier = s->elements, *finer = NULL;
    uint16_t *earlier_points = s->valid_points;
    rsv_status status = rsv_elements_refine(earlier, split, &finer);
    if (status != RSV_OK) return status;
    s->elements = finer;
    s->valid_points = NULL;
    status = prepare_elements(s, earlier, earlier_points);
    rsv_free(s->context, earlier_points);
    rsv_elements_destroy(earlier);
    return status;
}
