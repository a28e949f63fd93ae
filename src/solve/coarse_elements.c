#include "coarse_elements.h"

#include "../core/parallel.h"
#include "../elements/burial.h"
#include "../elements/cluster.h"
#include "../elements/contact.h"
#include "../elements/elements.h"
#include "../elements/open_corners.h"
#include "../update/kept_elements.h"
#include "../update/update.h"
#include "solve_constants.h"

/// Points are drawn by the numbers of nodes, which each split changes: none are known from earlier elements.
static rsv_status find_valid_points(rsv_builder *b)
{
    rsv_status status;
    const rsv_history *history = rsv_history_of(&b->scene);
    size_t nodes = b->elements->node_count;
    uint8_t *known = rsv_alloc(b->context, nodes, 1);
    b->valid_points = rsv_alloc(b->context, nodes, sizeof *b->valid_points);
    RSV_TRY(known && b->valid_points ? RSV_OK : RSV_ERROR_MEMORY);
    if (history) RSV_TRY(rsv_kept_points(history, b->elements, b->valid_points, known));
    RSV_TRY(rsv_find_buried(&b->scene, b->elements,
        (rsv_support_draw){ RSV_SUPPORT_POINTS, b->desc.seed }, known, b->valid_points,
        &b->report.rays));
    b->kept.kept_elements = 0;
    for (size_t n = 0; n < nodes; n++)
        b->kept.kept_elements += known[n] && b->valid_points[n];
cleanup:
    rsv_free(b->context, known);
    return status;
}

/// @param earlier NULL = these are the first
static rsv_status prepare_elements(rsv_builder *b, const rsv_elements *earlier)
{
    rsv_status status;
    float part = b->desc.refinements ? CLUSTER_RADIUS : CLUSTER_RADIUS_WITHOUT_PILOTS;
    RSV_TRY(rsv_elements_separate(&b->scene, earlier, b->elements, &b->report.rays));
    RSV_TRY(rsv_elements_cluster(b->elements, part * b->elements->spacing));
    RSV_TRY(find_valid_points(b));
    RSV_TRY(rsv_elements_bridge_buried(b->elements, b->valid_points));
cleanup:
    return status;
}

/// Splits cells that other geometry cuts. @param growth NULL = none
static rsv_status refine_contacts(rsv_builder *b, const rsv_growth *growth)
{
    float share = b->desc.contact_share > 0 ? b->desc.contact_share : 1;
    size_t most_nodes = (size_t)(share * CONTACT_NODES * sqrt(b->desc.element_target));
    size_t budget = b->desc.max_elements;
    if (budget && most_nodes > budget) most_nodes = budget;
    if (most_nodes == 0) return RSV_OK;
    return rsv_elements_refine_contacts(
        &b->scene, most_nodes, growth, &b->elements, &b->report.rays);
}

/// Grids whose cells are larger than the builder's spacing by a factor.
static rsv_status create_grids(rsv_builder *b, float coarsening)
{
    rsv_spacing spacing = b->spacing;
    spacing.metres *= coarsening;
    rsv_free(b->context, b->valid_points);
    b->valid_points = NULL;
    rsv_status status = rsv_elements_create(b->scene.scene, b->world->bsdf, &spacing, &b->elements);
    if (status == RSV_OK) b->elements->spacing = b->spacing.metres;
    return status;
}

rsv_status rsv_coarse_elements_create(rsv_builder *b, float coarsening)
{
    const rsv_history *history = rsv_history_of(&b->scene);
    rsv_status status = create_grids(b, coarsening);
    if (status == RSV_OK) status = refine_contacts(b, NULL);
    if (status == RSV_OK && history)
        status = rsv_kept_splits(history, &b->scene, &b->elements, &b->report.rays);
    return status == RSV_OK ? prepare_elements(b, NULL) : status;
}

/// Input for choosing cells for a goal.
typedef struct goal_chooser {
    const rsv_goal *goal;
    const rsv_spacing *spacing;
    const rsv_elements *elements; ///< while it chooses
    uint8_t *split;               ///< [cell_count] out
} goal_chooser;

static void choose_span(void *job, rsv_span span)
{
    const goal_chooser *g = job;
    const rsv_elements *e = g->elements;
    for (uint32_t c = (uint32_t)span.begin; c < span.end; c++) {
        float wanted = e->spacing * rsv_goal_size_at(g->goal, e, c);
        g->split[c] = e->cell[c].level < RSV_MAX_LEVEL &&
                      sqrtf(2 * rsv_cell_area(e, c)) > RSV_GROWTH_TOLERANCE * wanted &&
                      !rsv_spacing_lets_grow(g->spacing, e, c);
    }
}

/// Marks cells that are too large for their importance.
static void choose_for_goal(void *user, const rsv_elements *e, uint8_t *split)
{
    goal_chooser *g = user;
    g->elements = e;
    g->split = split;
    rsv_parallel_for(e->context, e->cell_count, 256, choose_span, g);
}

static float growth_for_goal(const void *goal, const rsv_elements *e, uint32_t cell)
{
    return rsv_goal_size_at(goal, e, cell);
}

rsv_status rsv_coarse_elements_create_for_goal(rsv_builder *b, const rsv_goal *goal)
{
    rsv_elements *coarsest = NULL;
    goal_chooser chooser = { .goal = goal, .spacing = &b->spacing };
    rsv_growth growth = { growth_for_goal, goal };
    rsv_status status;
    rsv_elements_destroy(b->elements);
    b->elements = NULL;
    RSV_TRY(create_grids(b, RSV_GOAL_COARSEST));
    coarsest = b->elements;
    b->elements = NULL;
    RSV_TRY(rsv_elements_refine_where(coarsest, choose_for_goal, &chooser, &b->elements));
    // where it was learned, cells of the same size have been judged
    RSV_TRY(rsv_elements_find_open_corners(
        &b->scene, goal->elements, b->elements, &b->report.rays));
    RSV_TRY(refine_contacts(b, &growth));
    RSV_TRY(prepare_elements(b, NULL));
cleanup:
    rsv_elements_destroy(coarsest);
    return status;
}

/// Splits cells. The caller frees the previous elements.
static rsv_status split_cells(rsv_builder *b, const uint8_t *split)
{
    rsv_elements *earlier = b->elements;
    b->elements = NULL;
    b->valid_points = NULL;
    rsv_status status = rsv_elements_refine(earlier, split, &b->elements);
    return status == RSV_OK ? prepare_elements(b, earlier) : status;
}

rsv_status rsv_coarse_elements_split(rsv_builder *b, const uint8_t *split)
{
    rsv_elements *earlier = b->elements;
    rsv_free(b->context, b->valid_points);
    rsv_status status = split_cells(b, split);
    rsv_elements_destroy(earlier);
    return status;
}

rsv_status rsv_coarse_elements_try(
    rsv_builder *b, const uint8_t *split, bool (*fits)(const rsv_builder *), bool *kept)
{
    rsv_elements *earlier = b->elements, *other;
    uint16_t *earlier_points = b->valid_points, *other_points;
    rsv_status status = split_cells(b, split);
    *kept = status == RSV_OK && fits(b);
    other = *kept ? earlier : b->elements;
    other_points = *kept ? earlier_points : b->valid_points;
    b->elements = *kept ? b->elements : earlier;
    b->valid_points = *kept ? b->valid_points : earlier_points;
    rsv_elements_destroy(other);
    rsv_free(b->context, other_points);
    return status;
}
