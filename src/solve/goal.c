#include "goal.h"

#include "../solver/linear_solver.h"
#include "solution.h"
#include "transport_map.h"

/// Rays each way that weigh what is seen.
#define PILOT_SIDE 128
/// Relative residual of the adjoint solve.
#define ACCURACY 1e-4
/// Part of the typical density of importance from which on elements have their usual size.
#define FULL_SIZE 0.5f

rsv_status rsv_goal_importance(const rsv_solution *s, const rsv_rgb *weight, rsv_rgb *importance)
{
    rsv_transport_map *map = NULL;
    rsv_linear_report report;
    rsv_linear_desc desc = rsv_default_linear_desc(RSV_SOLVER_GMRES);
    desc.relative = ACCURACY;
    desc.max_applications = s->desc.max_orders;
    rsv_status status;
    RSV_TRY(rsv_transport_map_create(
        s->elements, s->transport, s->subsurface, s->exitance_albedo, 1, &map));
    RSV_TRY(rsv_transport_map_transpose(map));
    rsv_linear_map transposed = rsv_linear_map_transposed(&map->linear);
    RSV_TRY(rsv_linear_solve(&transposed, 3, &weight->r, &desc, &importance->r, &report));
cleanup:
    rsv_transport_map_destroy(map);
    return status;
}

void rsv_goal_density(const rsv_elements *e, rsv_rgb *importance)
{
    for (size_t n = 0; n < e->node_count; n++)
        importance[n] =
            e->node_area[n] > 0 ? rgb_scale(importance[n], 1 / e->node_area[n]) : rgb_gray(0);
    rsv_elements_constrain(e, importance);
}

static float sum_of(rsv_rgb c) { return c.r + c.g + c.b; }

/// Mean density where the importance lies.
static float typical_density(const rsv_elements *e, const rsv_rgb *density)
{
    double sum = 0, weights = 0;
    for (size_t n = 0; n < e->node_count; n++) {
        double d = (double)sum_of(density[n]);
        weights += d * (double)e->node_area[n];
        sum += d * d * (double)e->node_area[n];
    }
    return weights > 0 ? (float)(sum / weights) : 0;
}

static void set_sizes(const rsv_elements *e, rsv_rgb *density)
{
    float usual = FULL_SIZE * typical_density(e, density);
    for (size_t n = 0; n < e->node_count; n++) {
        float d = f_max(sum_of(density[n]), 0);
        float size = d > 0 ? sqrtf(usual / d) : RSV_GOAL_COARSEST;
        density[n] = rgb_gray(usual > 0 ? f_min(f_max(size, 1), RSV_GOAL_COARSEST) : 1);
    }
}

/// A copy of elements as they are.
static rsv_status copy_elements(const rsv_elements *e, rsv_elements **copy)
{
    uint8_t *nothing = rsv_alloc(e->context, e->cell_count, 1);
    rsv_status status = nothing ? rsv_elements_refine(e, nothing, copy) : RSV_ERROR_MEMORY;
    rsv_free(e->context, nothing);
    return status;
}

rsv_status rsv_goal_create(const rsv_solution *s, rsv_goal *goal)
{
    rsv_goal_aim aim = rsv_goal_aim_of(s);
    size_t nodes = s->elements->node_count;
    rsv_status status = RSV_ERROR_MEMORY;
    rsv_rgb *weight = rsv_alloc(s->context, nodes, sizeof *weight);
    rsv_rgb *importance = rsv_alloc(s->context, nodes, sizeof *importance);
    rsv_rgb *size = NULL;
    if (!weight || !importance) goto cleanup;
    RSV_TRY(rsv_goal_weights(s, &aim, PILOT_SIDE, weight));
    RSV_TRY(rsv_goal_importance(s, weight, importance));
    rsv_goal_density(s->elements, importance);
    set_sizes(s->elements, importance);
    RSV_TRY(copy_elements(s->elements, &goal->elements));
    size = rsv_alloc(s->context, goal->elements->node_count, sizeof *size);
    RSV_TRY(size ? RSV_OK : RSV_ERROR_MEMORY);
    // copies number their nodes anew
    for (uint32_t n = 0; n < goal->elements->node_count; n++) {
        uint32_t face;
        float u, v;
        rsv_elements_place_node(goal->elements, n, &face, &u, &v);
        size[n] = rsv_elements_interpolate(s->elements, importance, face, u, v);
    }
    goal->size = size;
cleanup:
    rsv_free(s->context, weight);
    rsv_free(s->context, importance);
    return status;
}

void rsv_goal_destroy(rsv_goal *goal)
{
    if (goal->elements) rsv_free(goal->elements->context, goal->size);
    rsv_elements_destroy(goal->elements);
    *goal = (rsv_goal){ 0 };
}

float rsv_goal_size_at(const rsv_goal *goal, const rsv_elements *e, uint32_t cell)
{
    float u[3], v[3];
    for (int k = 0; k < 3; k++)
        rsv_cell_corner(&e->cell[cell], k, &u[k], &v[k]);
    return rsv_elements_interpolate(goal->elements, goal->size, e->cell[cell].face,
        (u[0] + u[1] + u[2]) / 3, (v[0] + v[1] + v[2]) / 3)
        .g;
}
