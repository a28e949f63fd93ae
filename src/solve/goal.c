#include "goal.h"

#include "../elements/elements.h"
#include "../solver/linear_solver.h"
#include "solve_constants.h"

rsv_status rsv_goal_importance(
    const rsv_operator *op, uint32_t max_orders, const rsv_rgb *weight, rsv_rgb *importance)
{
    rsv_transport_map *map = NULL;
    rsv_linear_report report;
    rsv_linear_desc desc = rsv_default_linear_desc(RSV_SOLVER_GMRES);
    desc.relative = GOAL_ACCURACY;
    desc.max_applications = max_orders;
    rsv_status status;
    RSV_TRY(rsv_operator_map(op, 1, &map));
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

/// Replaces densities by sizes. Linear elements err by a multiple of their area h^2, and of a reading, which is linear
/// in that, by density d times it: for a given number of elements the sum is least where d h^2 times an element's area,
/// d h^4, is the same all over.
static void set_sizes(const rsv_elements *e, rsv_rgb *density)
{
    float usual = FULL_SIZE * typical_density(e, density);
    for (size_t n = 0; n < e->node_count; n++) {
        float d = f_max(sum_of(density[n]), 0);
        float size = d > 0 ? sqrtf(sqrtf(usual / d)) : RSV_GOAL_COARSEST;
        density[n] = rgb_gray(usual > 0 ? f_min(f_max(size, 1), RSV_GOAL_COARSEST) : 1);
    }
}

rsv_status rsv_goal_create(const rsv_operator *op, const rsv_solve_desc *desc, rsv_goal *goal)
{
    rsv_goal_aim aim = rsv_goal_aim_of(desc);
    rsv_context *context = rsv_operator_get_view(op)->context;
    rsv_elements *elements = rsv_operator_get_view(op)->elements;
    rsv_status status = RSV_ERROR_MEMORY;
    rsv_rgb *weight = rsv_alloc(context, elements->node_count, sizeof *weight);
    rsv_rgb *importance = rsv_alloc(context, elements->node_count, sizeof *importance);
    if (!weight || !importance) goto cleanup;
    RSV_TRY(rsv_goal_weights(op, &aim, GOAL_SIDE, desc->seed, weight));
    RSV_TRY(rsv_goal_importance(op, desc->max_orders, weight, importance));
    rsv_goal_density(elements, importance);
    set_sizes(elements, importance);
    goal->elements = rsv_elements_retain(elements);
    goal->size = importance;
    importance = NULL;
cleanup:
    rsv_free(context, weight);
    rsv_free(context, importance);
    return status;
}

void rsv_goal_destroy(rsv_goal *goal)
{
    if (goal->elements) rsv_free(goal->elements->context, goal->size);
    rsv_elements_destroy(goal->elements);
    *goal = (rsv_goal){ 0 };
}

/// At about as many places as the elements have where that was found out.
float rsv_goal_size_at(const rsv_goal *goal, const rsv_elements *e, uint32_t cell)
{
    float u[3], v[3], least = INFINITY;
    float ratio = sqrtf(2 * rsv_cell_area(e, cell)) / (RSV_GOAL_LEARNED * e->spacing);
    int side = (int)f_min(f_max(ceilf(ratio), 1), MOST_PLACES);
    for (int k = 0; k < 3; k++)
        rsv_cell_corner(&e->cell[cell], k, &u[k], &v[k]);
    for (int j = 0; j < side; j++) {
        for (int i = 0; i + j < side; i++) {
            float a = ((float)i + 1.0f / 3) / (float)side, b = ((float)j + 1.0f / 3) / (float)side;
            rsv_rgb size = rsv_elements_interpolate(goal->elements, goal->size, e->cell[cell].face,
                u[0] + a * (u[1] - u[0]) + b * (u[2] - u[0]),
                v[0] + a * (v[1] - v[0]) + b * (v[2] - v[0]));
            least = f_min(least, size.g);
        }
    }
    return least;
}
