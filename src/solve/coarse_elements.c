#include "coarse_elements.h"

#include "../operator/burial.h"
#include "../operator/cluster.h"
#include "../operator/contact.h"
#include "../operator/element_keys.h"
#include "../operator/open_corners.h"
#include "../operator/past.h"

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

/// What is known of points from before the scene was edited.
static rsv_status recall_points(const rsv_solution *s, uint8_t *known)
{
    const rsv_elements *e = s->elements;
    rsv_status status;
    uint64_t *key = NULL;
    RSV_TRY(rsv_node_keys_create(e, &key));
#pragma omp parallel for schedule(dynamic, 256) num_threads(rsv_threads(s->context))
    for (uint32_t n = 0; n < e->node_count; n++) {
        const rsv_past_node *then =
            e->node_hanging[n] == RSV_NONE && !known[n]
                ? rsv_past_find_node(s->scene.past, RSV_PAST_COARSE, e, n, key[n])
                : NULL;
        if (!then || !holds_for_all_points((uint16_t)then->valid)) continue;
        known[n] = 1;
        s->valid_points[n] = (uint16_t)then->valid;
    }
cleanup:
    rsv_free(s->context, key);
    return status;
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
    if (s->scene.past) RSV_TRY(recall_points(s, known));
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

/// Cells that were split before the scene was edited, away from the edit.
static void choose_as_then(void *user, const rsv_elements *e, uint8_t *split)
{
    const rsv_past *past = user;
#pragma omp parallel for schedule(dynamic, 256) num_threads(rsv_threads(e->context))
    for (uint32_t c = 0; c < e->cell_count; c++) {
        uint64_t key = rsv_cell_key_on(rsv_face_key(e, e->cell[c].face), &e->cell[c]);
        split[c] = rsv_past_was_split(past, RSV_PAST_COARSE, key) && !rsv_past_is_near(past, e, c);
    }
}

/// Splits cells and shrinks clusters like those before the scene was edited.
static rsv_status refine_as_then(rsv_solution *s)
{
    rsv_elements *finer = NULL;
    const rsv_past *past = s->scene.past;
    rsv_status status =
        rsv_elements_refine_where(s->elements, choose_as_then, (void *)(uintptr_t)past, &finer);
    if (status != RSV_OK) return status;
    for (uint32_t face = 0; face < finer->face_count; face++) {
        uint8_t halvings, level;
        if (!rsv_past_is_face_near(past, finer, face) &&
            rsv_past_find_face(past, rsv_face_key(finer, face), &halvings, &level))
            finer->face_halvings[face] = halvings;
    }
    status = rsv_elements_find_open_corners(&s->scene, s->elements, finer, &s->report.rays);
    rsv_elements_destroy(s->elements);
    s->elements = finer;
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
    if (status == RSV_OK && s->scene.past) status = refine_as_then(s);
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
