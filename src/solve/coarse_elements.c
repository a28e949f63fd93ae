#include "coarse_elements.h"

#include "../elements/burial.h"
#include "../elements/cluster.h"
#include "../elements/contact.h"
#include "../elements/element_keys.h"
#include "../elements/elements.h"
#include "../elements/open_corners.h"
#include "../elements/past.h"

/// Where meshes are finer than the wanted spacing, nodes follow leaders within this part of it; pilots halve that where
/// light changes quickly.
#define CLUSTER_RADIUS 1.0f
#define CLUSTER_RADIUS_WITHOUT_PILOTS 0.5f

/// Splits at contacts may add this many nodes times the root of those that were asked for: they lie along lines.
#define CONTACT_NODES 300

/// Gives fresh nodes numbers that none of the recalled ones has: the same points twice would err alike.
static rsv_status draw_fresh_apart(rsv_elements *e, const uint8_t *known)
{
    uint32_t next = (uint32_t)e->node_count;
    uint8_t *taken = rsv_alloc(e->context, e->node_count, 1);
    if (!taken) return RSV_ERROR_MEMORY;
    for (uint32_t n = 0; n < e->node_count; n++) {
        if (!known[n]) continue;
        uint32_t draw = e->node_draw[n];
        if (draw < e->node_count)
            taken[draw] = 1;
        else if (draw >= next)
            next = draw + 1;
    }
    for (uint32_t n = 0; n < e->node_count; n++)
        if (!known[n] && taken[n]) e->node_draw[n] = next++;
    rsv_free(e->context, taken);
    return RSV_OK;
}

/// Points of nodes that were there before the scene was edited are drawn as they were then: those around which nothing
/// changed need not be judged. @param known [node_count], out
static rsv_status recall_points(rsv_builder *b, uint8_t *known)
{
    rsv_elements *e = b->elements;
    uint64_t *key = NULL;
    rsv_status status;
    e->node_draw = rsv_alloc(b->context, e->node_count, sizeof *e->node_draw);
    RSV_TRY(e->node_draw ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_node_keys_create(e, &key));
#pragma omp parallel for schedule(dynamic, 256) num_threads(rsv_threads(b->context))
    for (uint32_t n = 0; n < e->node_count; n++) {
        e->node_draw[n] = n;
        if (e->node_hanging[n] != RSV_NONE) continue;
        const rsv_past_node *then = rsv_past_find_node(b->scene.past, e, n, key[n]);
        if (!then) continue;
        known[n] = 1;
        e->node_draw[n] = then->draw;
        b->valid_points[n] = (uint16_t)then->light.valid;
    }
    RSV_TRY(draw_fresh_apart(e, known));
cleanup:
    rsv_free(b->context, key);
    return status;
}

/// Points are drawn by the numbers of nodes, which each split changes: none are known from earlier elements.
static rsv_status find_valid_points(rsv_builder *b)
{
    rsv_status status;
    size_t nodes = b->elements->node_count;
    uint8_t *known = rsv_alloc(b->context, nodes, 1);
    b->valid_points = rsv_alloc(b->context, nodes, sizeof *b->valid_points);
    RSV_TRY(known && b->valid_points ? RSV_OK : RSV_ERROR_MEMORY);
    if (b->scene.past) RSV_TRY(recall_points(b, known));
    RSV_TRY(rsv_find_buried(&b->scene, b->elements, RSV_SUPPORT_POINTS, b->desc.seed, known,
        b->valid_points, &b->report.rays));
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

/// Cells that were split before the scene was edited, away from the edit.
static void choose_as_then(void *user, const rsv_elements *e, uint8_t *split)
{
    const rsv_past *past = user;
#pragma omp parallel for schedule(dynamic, 256) num_threads(rsv_threads(e->context))
    for (uint32_t c = 0; c < e->cell_count; c++)
        split[c] =
            rsv_past_was_cell_split(past, RSV_PAST_COARSE, e, c) && !rsv_past_is_near(past, e, c);
}

/// Splits cells and shrinks clusters like those before the scene was edited.
static rsv_status refine_as_then(rsv_builder *b)
{
    rsv_elements *finer = NULL;
    const rsv_past *past = b->scene.past;
    rsv_status status =
        rsv_elements_refine_where(b->elements, choose_as_then, (void *)(uintptr_t)past, &finer);
    if (status != RSV_OK) return status;
    for (uint32_t face = 0; face < finer->face_count; face++) {
        uint8_t halvings, level;
        if (!rsv_past_is_face_near(past, finer, face) &&
            rsv_past_find_face(past, finer, face, &halvings, &level))
            finer->face_halvings[face] = halvings;
    }
    status = rsv_elements_find_open_corners(&b->scene, b->elements, finer, &b->report.rays);
    rsv_elements_destroy(b->elements);
    b->elements = finer;
    return status;
}

/// Splits cells that other geometry cuts. @param growth NULL = none
static rsv_status refine_contacts(rsv_builder *b, const rsv_growth *growth)
{
    size_t most_nodes = (size_t)(CONTACT_NODES * sqrt(b->desc.element_target));
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
    rsv_status status = create_grids(b, coarsening);
    if (status == RSV_OK) status = refine_contacts(b, NULL);
    if (status == RSV_OK && b->scene.past) status = refine_as_then(b);
    return status == RSV_OK ? prepare_elements(b, NULL) : status;
}

/// Splits halve cells: they end up at most this much larger than wanted.
#define GOAL_TOLERANCE 1.4f

/// What chooses cells for a goal.
typedef struct goal_chooser {
    const rsv_goal *goal;
    const rsv_spacing *spacing;
} goal_chooser;

/// Cells that are too large for what they matter.
static void choose_for_goal(void *user, const rsv_elements *e, uint8_t *split)
{
    const goal_chooser *g = user;
#pragma omp parallel for schedule(dynamic, 256) num_threads(rsv_threads(e->context))
    for (uint32_t c = 0; c < e->cell_count; c++) {
        float wanted = e->spacing * rsv_goal_size_at(g->goal, e, c);
        split[c] = e->cell[c].level < RSV_MAX_LEVEL &&
                   sqrtf(2 * rsv_cell_area(e, c)) > GOAL_TOLERANCE * wanted &&
                   !rsv_spacing_lets_grow(g->spacing, e, c);
    }
}

static float growth_for_goal(const void *goal, const rsv_elements *e, uint32_t cell)
{
    return rsv_goal_size_at(goal, e, cell);
}

rsv_status rsv_coarse_elements_create_for_goal(rsv_builder *b, const rsv_goal *goal)
{
    rsv_elements *coarsest = NULL;
    goal_chooser chooser = { goal, &b->spacing };
    rsv_growth growth = { growth_for_goal, goal };
    rsv_status status;
    rsv_elements_destroy(b->elements);
    b->elements = NULL;
    RSV_TRY(create_grids(b, RSV_GOAL_COARSEST));
    coarsest = b->elements;
    b->elements = NULL;
    RSV_TRY(rsv_elements_refine_where(coarsest, choose_for_goal, &chooser, &b->elements));
    RSV_TRY(refine_contacts(b, &growth));
    RSV_TRY(prepare_elements(b, NULL));
cleanup:
    rsv_elements_destroy(coarsest);
    return status;
}

rsv_status rsv_coarse_elements_split(rsv_builder *b, const uint8_t *split)
{
    rsv_elements *earlier = b->elements, *finer = NULL;
    rsv_status status = rsv_elements_refine(earlier, split, &finer);
    if (status != RSV_OK) return status;
    b->elements = finer;
    rsv_free(b->context, b->valid_points);
    b->valid_points = NULL;
    status = prepare_elements(b, earlier);
    rsv_elements_destroy(earlier);
    return status;
}
