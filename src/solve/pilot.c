#include "pilot.h"

#include "../core/parallel.h"
#include "../elements/burial.h"
#include "../elements/curvature.h"
#include "../elements/elements.h"
#include "../elements/follower.h"
#include "budget.h"
#include "coarse_elements.h"
#include "diffused_level.h"
#include "goal.h"
#include "pilot_near.h"
#include "solve_constants.h"
#include "solve_desc.h"
#include "source.h"

#include <string.h>

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
        rows += rsv_cell_follows(e, c) ? (double)rsv_cell_new_leaders(e, c) : RSV_NODES_PER_SPLIT;
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

/// How much light bends over each cell.
typedef struct bend_job {
    const rsv_goal *goal;
    const rsv_elements *elements;
    float *bend; ///< [cell_count]
} bend_job;

static void weigh_span(void *data, rsv_span span)
{
    const bend_job *job = data;
    for (uint32_t c = (uint32_t)span.begin; c < span.end; c++) {
        if (job->bend[c] == 0) continue;
        float size = rsv_goal_size_at(job->goal, job->elements, c);
        job->bend[c] /= size * size;
    }
}

/// Weights curvature by the importance of light for the goal. Its error counts with the root of that, which is one over
/// the size squared.
static void weigh_bends(const rsv_goal *goal, const rsv_elements *e, float *bend)
{
    bend_job job = { goal, e, bend };
    if (goal->elements) rsv_parallel_for(e->context, e->cell_count, 256, weigh_span, &job);
}

static void diffuse_span(void *data, rsv_span span)
{
    const bend_job *job = data;
    for (uint32_t c = (uint32_t)span.begin; c < span.end; c++)
        if (job->bend[c] > 0) job->bend[c] *= rgb_luminance(rsv_diffused_share(job->elements, c));
}

/// Of a bend no more is seen than survives the diffusion below a translucent surface.
static void diffuse_bends(const rsv_elements *e, float *bend)
{
    bend_job job = { .elements = e, .bend = bend };
    rsv_parallel_for(e->context, e->cell_count, 0, diffuse_span, &job);
}

/// Leaves cells far from an edit of the scene alone: they are split as before.
static void unmark_settled(const rsv_history *history, const rsv_elements *e, uint8_t *split)
{
    for (uint32_t c = 0; history && c < e->cell_count; c++)
        if (split[c] && !rsv_history_is_near(history, e, c)) split[c] = 0;
}

/// Rows that pilots may bring the solution to. @param first rows before them
static size_t most_rows(const rsv_builder *b, size_t first)
{
    size_t target = b->desc.element_target, budget = rsv_budget_rows(b);
    size_t most = first + (rsv_history_of(&b->scene) ? 1 : MOST_ADDED) * target;
    if (most < MOST_NODES * target) most = MOST_NODES * target;
    return most < budget ? most : budget;
}

/// Mean luminance of the light that has no finer level. @param far [node_count] nodes for which nothing is gathered
static float mean_arriving(const rsv_light *light, const uint8_t *far)
{
    const rsv_elements *e = light->elements;
    double gathered = 0, area = 0;
    for (size_t n = 0; n < e->node_count; n++) {
        if (far[n]) continue;
        gathered += (double)(e->node_area[n] * rgb_luminance(light->field.gathered[n]));
        area += (double)e->node_area[n];
    }
    return (float)(rsv_elements_mean_luminance(e, light->field.indirect) +
                   (area > 0 ? gathered / area : 0));
}

/// Marks cells over which light without a finer level curves; only the strongest ones if all would take more than
/// `most` rows.
/// @param arriving that light @param any out: false if none are marked
static rsv_status mark_bends(const rsv_builder *b, const rsv_goal *goal, size_t most,
    const rsv_curvature_field *arriving, uint8_t *split, bool *any)
{
    const rsv_elements *e = b->elements;
    size_t rows = rsv_builder_rows(b);
    rsv_status status;
    *any = false;
    float *bend = rsv_alloc(b->context, e->cell_count, sizeof *bend);
    if (!bend) return RSV_ERROR_MEMORY;
    RSV_TRY(rsv_find_curved_edges(e, arriving, RSV_CURVED_EDGES_AND_BORDERS, note_bend, bend));
    rsv_find_cluster_curvature(e, arriving, note_bend, bend);
    diffuse_bends(e, bend);
    weigh_bends(goal, e, bend);
    bool marked = true;
    for (float least = PILOT_BEND; least < LARGEST_BEND && marked && !*any; least *= 1.5f) {
        for (size_t c = 0; c < e->cell_count; c++)
            split[c] = bend[c] > least;
        unmark_settled(rsv_pilot_settled(b), e, split);
        *any = (double)rows + rows_for(e, split, &marked) <= (double)most && marked;
    }
cleanup:
    rsv_free(b->context, bend);
    return status;
}

/// The first few orders of light, with rows of few rays.
static rsv_status solve_roughly(rsv_builder *b, rsv_light **light)
{
    rsv_status status;
    rsv_operator *op = NULL;
    RSV_TRY(rsv_builder_trace(b, NULL, RSV_PILOT_RAYS, &op));
    RSV_TRY(rsv_light_begin(op, b->sources, &b->scene, &b->desc, light));
    RSV_TRY(rsv_source_create(*light));
    RSV_TRY(rsv_solve_orders(*light, RSV_PILOT_ORDERS));
cleanup:
    rsv_operator_release(op);
    return status;
}

/// Light without a finer level (indirect light, and gathered light of the sky and lamps), and its standard deviation;
/// INFINITY where none was gathered.
static void note_arriving(const rsv_builder *b, const rsv_light *light, const uint8_t *far,
    rsv_rgb *arriving, float *deviation)
{
    size_t nodes = b->elements->node_count;
    const rsv_light_fields *f = &light->field;
    rsv_rgb *exitance = arriving;
    for (size_t n = 0; n < nodes; n++)
        exitance[n] =
            rgb_mul(light->view.exitance_albedo[n], rgb_add(f->source[n], f->indirect[n]));
    rsv_transport_deviation(
        light->view.transport, exitance, light->sources->bin_radiance, deviation);
    for (size_t n = 0; n < nodes; n++)
        if (far[n]) deviation[n] = INFINITY;
    rsv_mark_buried(b->elements, b->valid_points, deviation);
    for (size_t n = 0; n < nodes; n++)
        arriving[n] = rgb_add(f->gathered[n], f->indirect[n]);
}

/// Marks coarse cells over which the first few orders of a pilot solution bend.
/// @param most rows afterwards @param split [cell_count] out @param any out: false if none are marked
static rsv_status mark_by_pilot(
    rsv_builder *b, const rsv_goal *goal, size_t most, uint8_t *split, bool *any)
{
    rsv_status status;
    rsv_light *light = NULL;
    size_t nodes = b->elements->node_count;
    uint8_t *far = rsv_alloc(b->context, nodes, 1);
    float *deviation = rsv_alloc(b->context, nodes, sizeof *deviation);
    rsv_rgb *arriving = rsv_alloc(b->context, nodes, sizeof *arriving);
    RSV_TRY(far && deviation && arriving ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_pilot_settled(b) ? rsv_pilot_solve_near(b, far, &light) : solve_roughly(b, &light));
    b->report.rays += light->report.rays;
    note_arriving(b, light, far, arriving, deviation);
    const rsv_curvature_field field = { arriving, deviation, PILOT_BEND,
        PILOT_DARK * mean_arriving(light, far), NULL };
    RSV_TRY(mark_bends(b, goal, most, &field, split, any));
cleanup:
    rsv_light_destroy(light);
    rsv_free(b->context, far);
    rsv_free(b->context, deviation);
    rsv_free(b->context, arriving);
    return status;
}

/// Splits coarse cells over which the light of a pilot bends.
/// @param most rows afterwards @param refined out: false if there are none
static rsv_status refine_by_pilot(rsv_builder *b, const rsv_goal *goal, size_t most, bool *refined)
{
    rsv_status status;
    uint8_t *split = rsv_alloc(b->context, b->elements->cell_count, 1);
    RSV_TRY(split ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(mark_by_pilot(b, goal, most, split, refined));
    if (!*refined) goto cleanup;
    shrink_clusters(b->elements, split);
    RSV_TRY(rsv_coarse_elements_split(b, split));
cleanup:
    rsv_free(b->context, split);
    return status;
}

/// Finds importance for the goal on coarse elements, and creates elements for it.
static rsv_status remake_for_goal(rsv_builder *b, rsv_goal *goal)
{
    rsv_status status;
    rsv_operator *op = NULL;
    RSV_TRY(rsv_builder_trace(b, NULL, RSV_PILOT_RAYS, &op));
    RSV_TRY(rsv_goal_create(op, &b->desc, goal));
    RSV_TRY(rsv_coarse_elements_create_for_goal(b, goal));
cleanup:
    rsv_operator_release(op);
    return status;
}

bool rsv_pilot_has_goal(const rsv_builder *b)
{
    rsv_goal_aim aim = rsv_goal_aim_of(&b->desc);
    return rsv_goal_is_wanted(&aim) && rsv_reflects_diffusely(&b->scene);
}

rsv_status rsv_pilot_refine(rsv_builder *b)
{
    rsv_status status = RSV_OK;
    rsv_goal goal = { 0 };
    bool refined = rsv_reflects_diffusely(&b->scene) && rsv_builder_rows(b) <= rsv_budget_rows(b);
    if (rsv_pilot_has_goal(b) && refined) {
        rsv_progress_part(b->context, "goal", 0);
        RSV_TRY(remake_for_goal(b, &goal));
    }
    size_t first = rsv_builder_rows(b);
    for (uint32_t pilot = 0; refined && pilot < b->desc.refinements; pilot++) {
        size_t rows = rsv_builder_rows(b), most = most_rows(b, first);
        if (!rsv_pilot_settled(b) && (double)most < (1 + LEAST_GROWTH) * (double)rows) break;
        rsv_progress_part(b->context, "pilot", pilot + 1);
        RSV_TRY(refine_by_pilot(b, &goal, most, &refined));
    }
cleanup:
    rsv_progress_part(b->context, NULL, 0);
    rsv_goal_destroy(&goal);
    return status;
}
