#include "pilot.h"

#include "../elements/burial.h"
#include "../elements/curvature.h"
#include "../elements/element_keys.h"
#include "../elements/elements.h"
#include "../elements/follower.h"
#include "../elements/past.h"
#include "budget.h"
#include "coarse_elements.h"
#include "diffused_level.h"
#include "goal.h"
#include "source.h"
#include "system.h"

#include <string.h>

#define PILOT_RAYS 128
#define PILOT_ORDERS 3
#define PILOT_BEND 0.2f
#define LARGEST_BEND 2.0f
/// Pilots may bring rows to so many times those that were asked for, or, where detailed surfaces take most of these anyway,
/// add so many times. After an edit, whose solution before had pilots of its own, they may add as many as were asked for.
#define MOST_NODES 8
#define MOST_ADDED 5
/// A pilot takes an eighth of the rays of a solution: worth it where it may add this part of the rows there are.
#define LEAST_GROWTH 0.25
#define NODES_PER_SPLIT 2 ///< that a split adds, about
/// Part of the mean indirect light below which nobody sees a relative error.
#define PILOT_DARK 0.02f

static void note_bend(void *user, uint32_t cell, uint32_t other, float bend)
{
    float *strongest = user;
    strongest[cell] = f_max(strongest[cell], bend);
    strongest[other] = f_max(strongest[other], bend);
}

/// Rows that refining the marked cells adds, about.
static double rows_for(const rsv_elements *e, const uint8_t *marked, bool *any)
{
    double rows = 0;
    *any = false;
    for (uint32_t c = 0; c < e->cell_count; c++) {
        if (!marked[c]) continue;
        *any = true;
        rows += rsv_cell_follows(e, c) ? (double)rsv_cell_new_leaders(e, c) : NODES_PER_SPLIT;
    }
    return rows;
}

/// Where a mesh is finer than its clusters, these shrink rather than its triangles.
static void shrink_clusters(rsv_elements *e, uint8_t *marked)
{
    for (uint32_t c = 0; c < e->cell_count; c++) {
        if (!marked[c] || !rsv_cell_follows(e, c)) continue;
        e->face_halvings[e->cell[c].face]++;
        marked[c] = 0;
    }
}

/// Weighs bends by what light matters to the goal where they are. What they err counts with the root of that, which is
/// one over the size squared.
static void weigh_bends(const rsv_goal *goal, const rsv_elements *e, float *bend)
{
    if (!goal->elements) return;
#pragma omp parallel for schedule(dynamic, 256) num_threads(rsv_threads(e->context))
    for (uint32_t c = 0; c < e->cell_count; c++) {
        if (bend[c] == 0) continue;
        float size = rsv_goal_size_at(goal, e, c);
        bend[c] /= size * size;
    }
}

/// Of a bend no more is seen than survives the diffusion below a translucent surface.
static void diffuse_bends(const rsv_elements *e, float *bend)
{
#pragma omp parallel for schedule(static) num_threads(rsv_threads(e->context))
    for (uint32_t c = 0; c < e->cell_count; c++)
        if (bend[c] > 0) bend[c] *= rgb_luminance(rsv_diffused_share(e, c));
}

/// What is known from before an edit that left sources as they were: other ones bend light elsewhere. NULL = nothing
static const rsv_past *settled(const rsv_solution *s)
{
    const rsv_past *past = s->scene.past;
    return past && !rsv_past_has_other_sources(past) ? past : NULL;
}

/// Leaves cells alone that an edit of the scene is far from: they are split as they were before.
static void unmark_settled(const rsv_past *past, const rsv_elements *e, uint8_t *split)
{
    for (uint32_t c = 0; past && c < e->cell_count; c++)
        if (split[c] && !rsv_past_is_near(past, e, c)) split[c] = 0;
}

/// Rows that pilots may bring the solution to. @param first rows before them
static size_t most_rows(const rsv_solution *s, size_t first)
{
    size_t target = s->desc.element_target, budget = rsv_budget_rows(s);
    size_t most = first + (s->scene.past ? 1 : MOST_ADDED) * target;
    if (most < MOST_NODES * target) most = MOST_NODES * target;
    return most < budget ? most : budget;
}

/// Mean luminance of the light that has no finer level. @param far [node_count] nodes for which nothing is gathered
static float mean_arriving(const rsv_solution *s, const uint8_t *far)
{
    const rsv_elements *e = s->elements;
    double gathered = 0, area = 0;
    for (size_t n = 0; n < e->node_count; n++) {
        if (far[n]) continue;
        gathered += (double)(e->node_area[n] * rgb_luminance(s->gathered[n]));
        area += (double)e->node_area[n];
    }
    return (float)(rsv_elements_mean_luminance(e, s->indirect) + (area > 0 ? gathered / area : 0));
}

/// Marks the cells over which light bends that has no finer level, the strongest bends alone where all of them would
/// take more than `most` rows. @param arriving [node_count] that light @param dark too little of it to be seen
/// @param any out: false if none are marked
static rsv_status mark_bends(const rsv_solution *s, const rsv_goal *goal, size_t most,
    const rsv_rgb *arriving, float dark, const float *deviation, uint8_t *split, bool *any)
{
    const rsv_elements *e = s->elements;
    size_t rows = rsv_solution_rows(s);
    rsv_status status;
    *any = false;
    float *bend = rsv_alloc(s->context, e->cell_count, sizeof *bend);
    if (!bend) return RSV_ERROR_MEMORY;
    RSV_TRY(rsv_find_curved_edges(
        e, arriving, deviation, PILOT_BEND, dark, RSV_CURVED_EDGES_AND_BORDERS, note_bend, bend));
    rsv_find_cluster_curvature(e, arriving, deviation, PILOT_BEND, dark, note_bend, bend);
    diffuse_bends(e, bend);
    weigh_bends(goal, e, bend);
    bool marked = true;
    for (float least = PILOT_BEND; least < LARGEST_BEND && marked && !*any; least *= 1.5f) {
        for (size_t c = 0; c < e->cell_count; c++)
            split[c] = bend[c] > least;
        unmark_settled(settled(s), e, split);
        *any = (double)rows + rows_for(e, split, &marked) <= (double)most && marked;
    }
cleanup:
    rsv_free(s->context, bend);
    return status;
}

/// The first few orders of light, with rows of few rays.
static rsv_status solve_roughly(rsv_solution *s)
{
    rsv_status status;
    RSV_TRY(rsv_system_assemble(s, PILOT_RAYS));
    RSV_TRY(rsv_source_create(s));
    RSV_TRY(rsv_solve_orders(s, PILOT_ORDERS));
cleanup:
    return status;
}

/// Sorts nodes into those that an edit of the scene is far from, whose light from before will do, and those that are
/// looked at again. @param far [node_count], out @param indirect [node_count], out
static rsv_status recall_far(const rsv_solution *s, uint8_t *far, rsv_rgb *indirect)
{
    const rsv_elements *e = s->elements;
    uint64_t *key = NULL;
    rsv_status status = rsv_node_keys_create(e, &key);
#pragma omp parallel for schedule(dynamic, 256) num_threads(rsv_threads(s->context))
    for (uint32_t n = 0; n < e->node_count; n++) {
        if (status != RSV_OK || e->node_hanging[n] != RSV_NONE) continue;
        const rsv_past_node *then = rsv_past_find_node(s->scene.past, e, n, key[n]);
        far[n] = !s->valid_points[n] || (then && !rsv_past_is_node_near(s->scene.past, e, n));
        if (!then) continue;
        indirect[n] = then->indirect;
        if (far[n]) s->source[n] = then->source; // nothing is gathered without a row
    }
    rsv_free(s->context, key);
    return status;
}

/// Rows of nodes that are not far from an edit.
static rsv_status assemble_near(rsv_solution *s, const uint8_t *far)
{
    size_t nodes = s->elements->node_count;
    rsv_transport_scene scene = s->scene;
    scene.checkpoint = scene.earlier = NULL;
    uint16_t *valid = rsv_alloc(s->context, nodes, sizeof *valid);
    if (!valid) return RSV_ERROR_MEMORY;
    for (size_t n = 0; n < nodes; n++)
        valid[n] = far[n] ? 0 : s->valid_points[n];
    rsv_status status = rsv_transport_create(
        &scene, s->lights, s->elements, valid, PILOT_RAYS, s->desc.seed, &s->transport);
    rsv_free(s->context, valid);
    if (status != RSV_OK) return status;
    s->report.rays += s->transport->rays;
    s->report.row_rays += s->transport->rays;
    return status;
}

/// One more order of light for nodes near an edit, from the light of all.
/// @param then [node_count] indirect light before it
static void gather_near(rsv_solution *s, const uint8_t *far, const rsv_rgb *then, rsv_rgb *exitance)
{
    const rsv_elements *e = s->elements;
    for (size_t n = 0; n < e->node_count; n++)
        exitance[n] = rgb_mul(s->exitance_albedo[n], rgb_add(s->source[n], s->indirect[n]));
    rsv_transport_apply(s->transport, exitance, s->indirect);
    for (size_t n = 0; n < e->node_count; n++)
        if (far[n]) s->indirect[n] = then[n];
    rsv_elements_constrain(e, s->indirect);
}

/// The same as solve_roughly where the light of all that an edit is far from is taken for what it was.
/// @param far [node_count], out: nodes that it is far from, for which nothing is gathered
static rsv_status solve_near(rsv_solution *s, uint8_t *far)
{
    rsv_status status;
    size_t nodes = s->elements->node_count;
    rsv_rgb *then = rsv_alloc(s->context, nodes, sizeof *then);
    rsv_rgb *exitance = rsv_alloc(s->context, nodes, sizeof *exitance);
    s->indirect = rsv_alloc(s->context, nodes, sizeof *s->indirect);
    RSV_TRY(then && exitance && s->indirect ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(recall_far(s, far, then));
    memcpy(s->indirect, then, nodes * sizeof *then);
    rsv_elements_constrain(s->elements, s->indirect);
    RSV_TRY(assemble_near(s, far));
    RSV_TRY(rsv_source_estimate(s, far));
    rsv_source_add_gathered(s);
    for (uint32_t order = 0; order < PILOT_ORDERS; order++)
        gather_near(s, far, then, exitance);
cleanup:
    rsv_free(s->context, then);
    rsv_free(s->context, exitance);
    return status;
}

/// Splits coarse cells over which the first few orders of a pilot solution bend.
/// @param most rows afterwards @param refined out: false if there are none
static rsv_status refine_by_pilot(rsv_solution *s, const rsv_goal *goal, size_t most, bool *refined)
{
    rsv_status status = RSV_OK;
    uint8_t *split = rsv_alloc(s->context, s->elements->cell_count, 1);
    size_t nodes = s->elements->node_count;
    uint8_t *far = rsv_alloc(s->context, nodes, 1);
    float *deviation = rsv_alloc(s->context, nodes, sizeof *deviation);
    rsv_rgb *exitance = rsv_alloc(s->context, nodes, sizeof *exitance);
    if (!split || !far || !deviation || !exitance) {
        status = RSV_ERROR_MEMORY;
        goto cleanup;
    }
    RSV_TRY(rsv_system_create_fields(s));
    RSV_TRY(settled(s) ? solve_near(s, far) : solve_roughly(s));
    for (size_t n = 0; n < nodes; n++)
        exitance[n] = rgb_mul(s->exitance_albedo[n], rgb_add(s->source[n], s->indirect[n]));
    rsv_transport_deviation(s->transport, exitance, s->bin_radiance, deviation);
    for (size_t n = 0; n < nodes; n++)
        if (far[n]) deviation[n] = INFINITY;
    rsv_mark_buried(s->elements, s->valid_points, deviation);
    // light without a finer level: indirect, and what is gathered of the sky and of lamps
    rsv_rgb *arriving = exitance;
    for (size_t n = 0; n < nodes; n++)
        arriving[n] = rgb_add(s->gathered[n], s->indirect[n]);
    float dark = PILOT_DARK * mean_arriving(s, far);
    RSV_TRY(mark_bends(s, goal, most, arriving, dark, deviation, split, refined));
    rsv_system_destroy(s);
    if (!*refined) goto cleanup;
    shrink_clusters(s->elements, split);
    RSV_TRY(rsv_coarse_elements_split(s, split));
cleanup:
    rsv_free(s->context, split);
    rsv_free(s->context, far);
    rsv_free(s->context, deviation);
    rsv_free(s->context, exitance);
    return status;
}

/// Learns on coarse elements what matters to the goal, and makes elements anew for that.
static rsv_status remake_for_goal(rsv_solution *s, rsv_goal *goal)
{
    rsv_status status;
    RSV_TRY(rsv_system_create_fields(s));
    RSV_TRY(rsv_system_assemble(s, PILOT_RAYS));
    RSV_TRY(rsv_goal_create(s, goal));
    rsv_system_destroy(s);
    RSV_TRY(rsv_coarse_elements_create_for_goal(s, goal));
cleanup:
    return status;
}

bool rsv_pilot_has_goal(const rsv_solution *s)
{
    rsv_goal_aim aim = rsv_goal_aim_of(s);
    return rsv_goal_is_wanted(&aim) && rsv_reflects_diffusely(s);
}

rsv_status rsv_pilot_refine(rsv_solution *s)
{
    rsv_status status = RSV_OK;
    rsv_goal goal = { 0 };
    bool refined = rsv_reflects_diffusely(s) && rsv_solution_rows(s) <= rsv_budget_rows(s);
    if (rsv_pilot_has_goal(s) && refined) {
        rsv_progress_part(s->context, "goal", 0);
        RSV_TRY(remake_for_goal(s, &goal));
    }
    size_t first = rsv_solution_rows(s);
    for (uint32_t pilot = 0; refined && pilot < s->desc.refinements; pilot++) {
        size_t rows = rsv_solution_rows(s), most = most_rows(s, first);
        if (!settled(s) && (double)most < (1 + LEAST_GROWTH) * (double)rows) break;
        rsv_progress_part(s->context, "pilot", pilot + 1);
        RSV_TRY(refine_by_pilot(s, &goal, most, &refined));
    }
cleanup:
    rsv_progress_part(s->context, NULL, 0);
    rsv_goal_destroy(&goal);
    return status;
}
