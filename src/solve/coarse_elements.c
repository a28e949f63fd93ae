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
static rsv_status recall_points(rsv_solution *s, uint8_t *known)
{
    rsv_elements *e = s->elements;
    uint64_t *key = NULL;
    rsv_status status;
    e->node_draw = rsv_alloc(s->context, e->node_count, sizeof *e->node_draw);
    RSV_TRY(e->node_draw ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_node_keys_create(e, &key));
#pragma omp parallel for schedule(dynamic, 256) num_threads(rsv_threads(s->context))
    for (uint32_t n = 0; n < e->node_count; n++) {
        e->node_draw[n] = n;
        if (e->node_hanging[n] != RSV_NONE) continue;
        const rsv_past_node *then = rsv_past_find_node(s->scene.past, e, n, key[n]);
        if (!then) continue;
        known[n] = 1;
        e->node_draw[n] = then->draw;
        s->valid_points[n] = (uint16_t)then->light.valid;
    }
    RSV_TRY(draw_fresh_apart(e, known));
cleanup:
    rsv_free(s->context, key);
    return status;
}

/// Points are drawn by the numbers of nodes, which each split changes: none are known from earlier elements.
static rsv_status find_valid_points(rsv_solution *s)
{
    rsv_status status;
    size_t nodes = s->elements->node_count;
    uint8_t *known = rsv_alloc(s->context, nodes, 1);
    s->valid_points = rsv_alloc(s->context, nodes, sizeof *s->valid_points);
    RSV_TRY(known && s->valid_points ? RSV_OK : RSV_ERROR_MEMORY);
    if (s->scene.past) RSV_TRY(recall_points(s, known));
    RSV_TRY(rsv_find_buried(&s->scene, s->elements, RSV_SUPPORT_POINTS, s->desc.seed, known,
        s->valid_points, &s->report.rays));
cleanup:
    rsv_free(s->context, known);
    return status;
}

/// @param earlier NULL = these are the first
static rsv_status prepare_elements(rsv_solution *s, const rsv_elements *earlier)
{
    rsv_status status;
    float part = s->desc.refinements ? CLUSTER_RADIUS : CLUSTER_RADIUS_WITHOUT_PILOTS;
    RSV_TRY(rsv_elements_separate(&s->scene, earlier, s->elements, &s->report.rays));
    RSV_TRY(rsv_elements_cluster(s->elements, part * s->elements->spacing));
    RSV_TRY(find_valid_points(s));
    RSV_TRY(rsv_elements_bridge_buried(s->elements, s->valid_points));
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
            rsv_past_find_face(past, finer, face, &halvings, &level))
            finer->face_halvings[face] = halvings;
    }
    status = rsv_elements_find_open_corners(&s->scene, s->elements, finer, &s->report.rays);
    rsv_elements_destroy(s->elements);
    s->elements = finer;
    return status;
}

/// Splits cells that other geometry cuts. @param growth NULL = none
static rsv_status refine_contacts(rsv_solution *s, const rsv_growth *growth)
{
    size_t most_nodes = (size_t)(CONTACT_NODES * sqrt(s->desc.element_target));
    return rsv_elements_refine_contacts(
        &s->scene, most_nodes, growth, &s->elements, &s->report.rays);
}

/// Grids whose cells are larger than the solution's spacing by a factor.
static rsv_status create_grids(rsv_solution *s, float coarsening)
{
    rsv_spacing spacing = s->spacing;
    spacing.metres *= coarsening;
    rsv_free(s->context, s->valid_points);
    s->valid_points = NULL;
    rsv_status status = rsv_elements_create(s->scene.scene, s->bsdf, &spacing, &s->elements);
    if (status == RSV_OK) s->elements->spacing = s->spacing.metres;
    return status;
}

rsv_status rsv_coarse_elements_create(rsv_solution *s, float coarsening)
{
    rsv_status status = create_grids(s, coarsening);
    if (status == RSV_OK) status = refine_contacts(s, NULL);
    if (status == RSV_OK && s->scene.past) status = refine_as_then(s);
    return status == RSV_OK ? prepare_elements(s, NULL) : status;
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

rsv_status rsv_coarse_elements_create_for_goal(rsv_solution *s, const rsv_goal *goal)
{
    rsv_elements *coarsest = NULL;
    goal_chooser chooser = { goal, &s->spacing };
    rsv_growth growth = { growth_for_goal, goal };
    rsv_status status;
    RSV_TRY(create_grids(s, RSV_GOAL_COARSEST));
    coarsest = s->elements;
    s->elements = NULL;
    RSV_TRY(rsv_elements_refine_where(coarsest, choose_for_goal, &chooser, &s->elements));
    RSV_TRY(refine_contacts(s, &growth));
    RSV_TRY(prepare_elements(s, NULL));
cleanup:
    rsv_elements_destroy(coarsest);
    return status;
}

rsv_status rsv_coarse_elements_split(rsv_solution *s, const uint8_t *split)
{
    rsv_elements *earlier = s->elements, *finer = NULL;
    rsv_status status = rsv_elements_refine(earlier, split, &finer);
    if (status != RSV_OK) return status;
    s->elements = finer;
    rsv_free(s->context, s->valid_points);
    s->valid_points = NULL;
    status = prepare_elements(s, earlier);
    rsv_elements_destroy(earlier);
    return status;
}
