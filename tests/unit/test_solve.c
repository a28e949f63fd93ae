/// The solution E = E0 + G K E: furnaces with a closed answer, a truthful report, refusals, and memory that
/// runs out anywhere.
#include "light_view.h"
#include "resolvent/render.h"

#include "light_fixture.h"
#include "slow_tests.h"

static rsv_solve_desc small_desc(uint32_t elements)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = elements;
    desc.rays_per_element = 64;
    desc.photon_count = 2000;
    desc.direct_levels = 1;
    return desc;
}

static rsv_light *solve_with(const world *w, const rsv_solve_desc *desc)
{
    rsv_light *solution;
    rsv_status status = rsv_light_create(w->scene, desc, &solution);
    if (status != RSV_OK) fail_msg("%s", rsv_last_error());
    return solution;
}

static rsv_light *solve(const world *w, uint32_t elements)
{
    rsv_solve_desc desc = small_desc(elements);
    return solve_with(w, &desc);
}

// ---- long ways ----------------------------------------------------------------------------------

/// Light in a box of perfect mirrors ends on the only thing that is none: a black patch, 1/600 of the walls. That is after
/// 600 reflections in the mean, and no photon is lost on the way.
static void light_among_mirrors_arrives_in_the_end(void **state)
{
    (void)state;
    world *w = world_begin(2);
    rsv_material mirror = rsv_default_material();
    mirror.base_color = rgb_gray(1);
    mirror.metallic = 1;
    mirror.roughness = 0;
    world_room(w, world_material(w, mirror), v3(0, 0, 0), v3(1, 1, 1));
    world_quad(w, world_lambert(w, 0, 0), v3(0.3f, 1e-4f, 0.4f), v3(0.4f, 1e-4f, 0.4f),
        v3(0.4f, 1e-4f, 0.3f), v3(0.3f, 1e-4f, 0.3f));
    rsv_punctual_light lamp = {
        .kind = RSV_PUNCTUAL_POINT, .position = v3(0.62f, 0.57f, 0.53f), .intensity = rgb_gray(1)
    };
    assert_int_equal(rsv_scene_add_light(w->scene, &lamp), RSV_OK);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    rsv_light *s = solve(w, 20);
    double arrives = rsv_light_report(s)->mean_irradiance * 0.01, sent = 4 * (double)RSV_PI;
    print_message("    %.4f of the light arrives\n", arrives / sent);
    assert_close(arrives, sent, 0.08 * sent);
    rsv_light_destroy(s);
    world_end(w);
}

// ---- furnaces -----------------------------------------------------------------------------------

/// A closed room whose walls emit 1 W/m2 and reflect `albedo`.
static world *create_furnace(float albedo)
{
    world *w = world_begin(1); // hundreds of orders on few elements: threads would only wait
    world_room(w, world_lambert(w, albedo, 1 / RSV_PI), v3(-0.3f, 0, 0), v3(1, 0.8f, 1.7f));
    world_commit(w);
    return w;
}

/// Radiosity W/m2 at a place of a triangle.
static double radiosity(const rsv_light *s, float albedo, uint32_t triangle, float u, float v)
{
    return 1 + (double)albedo * rsv_light_irradiance(s, triangle, u, v, false, RSV_NONE).g;
}

static void check_furnace(float albedo)
{
    world *w = create_furnace(albedo);
    rsv_light *s = solve(w, 150);
    const double expected = 1 / (1 - (double)albedo);
    rsv_random random = rsv_random_from(1, 2, 3);
    uint32_t triangles = (uint32_t)w->transport.view->triangle_count;
    for (uint32_t n = 0; n < 600; n++) {
        float u, v, x = rsv_random_float(&random), y = rsv_random_float(&random);
        rsv_square_to_triangle(x, y, &u, &v);
        assert_close(radiosity(s, albedo, n % triangles, u, v), expected, 2e-3 * expected);
    }
    // edges are at least 0.8 m long: at most 1 mm from each of the corners
    const float corner[3][2] = { { 3e-4f, 3e-4f }, { 1 - 6e-4f, 3e-4f }, { 3e-4f, 1 - 6e-4f } };
    for (uint32_t t = 0; t < triangles; t++)
        for (int k = 0; k < 3; k++)
            assert_close(
                radiosity(s, albedo, t, corner[k][0], corner[k][1]), expected, 2e-3 * expected);
    rsv_light_destroy(s);
    world_end(w);
}

static void a_furnace_glows_by_one_over_one_minus_albedo(void **state)
{
    (void)state;
    check_furnace(0);
    check_furnace(0.5f);
    check_furnace(0.9f);
    check_furnace(0.99f);
}

/// A room whose walls glow and reflect on both sides: outside, nothing reflects anything back.
static world *create_two_sided_furnace(float albedo)
{
    world *w = world_begin(1);
    rsv_material material = lambert_material(albedo, 1 / RSV_PI);
    material.double_sided = true;
    world_room(w, world_material(w, material), v3(0, 0, 0), v3(1, 1, 1));
    world_commit(w);
    return w;
}

/// Rounding of stored floats alone leaves a residual that is not small compared with the source there.
static void hardly_absorbing_furnaces_converge(void **state)
{
    (void)state;
    const float albedo[] = { 0.98f, 0.999f, 0.9995f };
    for (int k = 0; k < 3; k++) {
        float rho = albedo[k];
        world *w = k == 0 ? create_furnace(rho) : create_two_sided_furnace(rho);
        rsv_light *s = solve(w, 150);
        assert_int_equal(rsv_light_report(s)->stop_reason, RSV_STOP_CONVERGED);
        assert_true(rsv_light_report(s)->iterations < 200);
        const double expected = 1 / (1 - (double)rho);
        assert_close(radiosity(s, rho, 0, 0.3f, 0.3f), expected, 2e-3 * expected);
        rsv_light_destroy(s);
        world_end(w);
    }
}

static void lookups_find_the_side_that_a_probe_lies_on(void **state)
{
    (void)state;
    world *w = create_two_sided_furnace(0.5f);
    rsv_light *s = solve(w, 150);
    const rsv_probe probe[2] = { { v3(0.3f, 0.4f, 0), v3(0, 0, 1) },
        { v3(0.3f, 0.4f, 0), v3(0, 0, -1) } };
    rsv_probe_reading reading[2];
    assert_int_equal(
        rsv_probe_irradiance(s, &(rsv_probe_desc){ sizeof(rsv_probe_desc), RSV_PROBE_LOOKUP, 1, 1 },
            probe, 2, reading),
        RSV_OK);
    assert_close(reading[0].irradiance.g, 2, 4e-3);
    assert_close(reading[1].irradiance.g, 0, 1e-6);
    rsv_light_destroy(s);
    world_end(w);
}

static void orders_of_a_furnace_are_powers_of_its_albedo(void **state)
{
    (void)state;
    const float albedo = 0.6f;
    world *w = create_furnace(albedo);
    rsv_light *s = solve(w, 100);
    assert_int_equal(rsv_light_order_count(s), RSV_KEPT_ORDERS);
    for (uint32_t order = 0; order + 1 < RSV_KEPT_ORDERS; order++) {
        rsv_rgb e = rsv_light_irradiance(s, 3, 0.2f, 0.3f, false, order);
        assert_close(e.r, pow(albedo, order), 1e-3 * pow(albedo, order));
    }
    // the last one holds all that is left of the geometric series
    double rest = pow(albedo, RSV_KEPT_ORDERS - 1) / (1 - albedo);
    assert_close(
        rsv_light_irradiance(s, 3, 0.2f, 0.3f, false, RSV_KEPT_ORDERS - 1).r, rest, 1e-2 * rest);
    assert_true(rgb_is_black(rsv_light_irradiance(s, 3, 0.2f, 0.3f, false, RSV_KEPT_ORDERS)));
    rsv_light_destroy(s);
    world_end(w);
}

/// Except at nodes next to discontinuities of one order that the sum does not have: sharpening treats each order
/// separately.
static void orders_sum_to_the_solution(void **state)
{
    (void)state;
    world *w = world_builtin(2, "cornell-blocks");
    rsv_light *s = solve(w, 400);
    double mean = inside(s)->report.mean_irradiance, square = 0, wrong = 0;
    for (uint32_t t = 0; t < rsv_scene_get_view(w->scene)->triangle_count; t++) {
        rsv_rgb sum = rgb_gray(0), all = rsv_light_irradiance(s, t, 0.2f, 0.3f, false, RSV_NONE);
        for (uint32_t order = 0; order < rsv_light_order_count(s); order++)
            sum = rgb_add(sum, rsv_light_irradiance(s, t, 0.2f, 0.3f, false, order));
        assert_close(sum.g, all.g, 0.02 * all.g + 4e-3 * mean);
        square += (double)(all.g * all.g);
        wrong += (double)((sum.g - all.g) * (sum.g - all.g));
    }
    assert_true(sqrt(wrong / square) < 3e-3);
    rsv_light_destroy(s);
    world_end(w);
}

static void backs_of_one_sided_surfaces_are_black(void **state)
{
    (void)state;
    world *w = create_furnace(0.5f);
    rsv_light *s = solve(w, 50);
    assert_true(rgb_is_black(rsv_light_irradiance(s, 0, 0.3f, 0.3f, true, RSV_NONE)));
    rsv_light_destroy(s);
    world_end(w);
}

// ---- report -------------------------------------------------------------------------------------

/// The Neumann series of a solution again, in double, kept simple.
typedef struct series {
    const rsv_light *s;
    size_t nodes;
    double (*term)[3], (*next)[3], (*sum)[3];
} series;

static void constrain(const series *q, double (*value)[3])
{
    const rsv_elements *e = inside(q->s)->elements;
    for (size_t h = 0; h < e->hanging_count; h++)
        for (int c = 0; c < 3; c++) {
            double sum = 0;
            for (int p = 0; p < RSV_PARENTS; p++)
                sum += e->hanging[h].weight[p] * value[e->hanging[h].parent[p]][c];
            value[e->hanging[h].node][c] = sum;
        }
}

static double channel(rsv_rgb value, int c)
{
    return c == 0 ? value.r : c == 1 ? value.g : value.b;
}

/// next = G K term
static void apply(const series *q, double (*term)[3], double (*next)[3])
{
    const rsv_transport *t = inside(q->s)->transport;
    const rsv_rgb *albedo = inside(q->s)->exitance_albedo;
    for (size_t row = 0; row < q->nodes; row++)
        for (int c = 0; c < 3; c++) {
            double sum = 0;
            rsv_transport_row entry = rsv_transport_row_at(t, row);
            for (size_t k = 0; k < entry.count; k++)
                sum += channel(albedo[entry.column[k]], c) * term[entry.column[k]][c];
            for (size_t k = 0; k < entry.tinted_count; k++) {
                uint32_t column = entry.tinted_column[k];
                sum += channel(entry.tinted_weight[k], c) * channel(albedo[column], c) *
                       term[column][c];
            }
            next[row][c] = sum * t->scale[row];
        }
    constrain(q, next);
}

static double largest(const series *q, double (*value)[3])
{
    double max = 0;
    for (size_t n = 0; n < q->nodes; n++)
        for (int c = 0; c < 3; c++)
            max = fmax(max, value[n][c]);
    return max;
}

static series create_series(const rsv_light *s)
{
    series q = { .s = s, .nodes = inside(s)->elements->node_count };
    q.term = calloc(q.nodes, sizeof *q.term);
    q.next = calloc(q.nodes, sizeof *q.next);
    q.sum = calloc(q.nodes, sizeof *q.sum);
    assert_true(q.term && q.next && q.sum);
    for (size_t n = 0; n < q.nodes; n++)
        for (int c = 0; c < 3; c++)
            q.term[n][c] = q.sum[n][c] = channel(inside(s)->source[n], c);
    return q;
}

static void destroy_series(series *q)
{
    free(q->term);
    free(q->next);
    free(q->sum);
}

static void advance(series *q)
{
    apply(q, q->term, q->next);
    for (size_t n = 0; n < q->nodes; n++)
        for (int c = 0; c < 3; c++)
            q->sum[n][c] += q->next[n][c];
    double(*swap)[3] = q->term;
    q->term = q->next;
    q->next = swap;
}

static double row_norm(series *q)
{
    double(*one)[3] = calloc(q->nodes, sizeof *one), (*sums)[3] = calloc(q->nodes, sizeof *sums);
    assert_true(one && sums);
    for (size_t n = 0; n < q->nodes; n++)
        one[n][0] = one[n][1] = one[n][2] = 1;
    apply(q, one, sums);
    double norm = largest(q, sums);
    free(one);
    free(sums);
    return norm;
}

static void the_report_tells_the_truth(void **state)
{
    (void)state;
    world *w = world_builtin(2, "cornell-blocks");
    rsv_solve_desc desc = small_desc(300);
    desc.tolerance = 1e-2f; // leaves a residual far above the rounding of floats
    rsv_light *s = solve_with(w, &desc);
    const rsv_solve_report *report = rsv_light_report(s);
    series q = create_series(s);
    double norm = row_norm(&q);
    assert_close(report->norm_inf, norm, 1e-5);
    assert_true(norm < 1);
    assert_int_equal(report->stop_reason, RSV_STOP_CONVERGED);
    for (uint32_t order = 1; order <= report->iterations; order++)
        advance(&q);
    double(*solved)[3] = calloc(q.nodes, sizeof *solved);
    assert_non_null(solved);
    memcpy(solved, q.sum, q.nodes * sizeof *solved);
    advance(&q); // the next term is the residual of the sum so far
    double residual = largest(&q, q.term);
    assert_close(report->residual_inf, residual, 0.01 * residual);
    assert_close(report->truncation_bound, residual / (1 - norm), 0.01 * residual / (1 - norm));
    assert_true(report->truncation_bound <= desc.tolerance * report->mean_irradiance);
    for (int order = 0; order < 200; order++)
        advance(&q);
    double error = 0;
    for (size_t n = 0; n < q.nodes; n++)
        for (int c = 0; c < 3; c++)
            error = fmax(error, q.sum[n][c] - solved[n][c]);
    assert_true(error <= report->truncation_bound);
    free(solved);
    destroy_series(&q);
    rsv_light_destroy(s);
    world_end(w);
}

static void the_report_counts_what_was_built(void **state)
{
    (void)state;
    world *w = world_builtin(1, "cornell-blocks");
    rsv_light *s = solve(w, 300);
    const rsv_solve_report *report = rsv_light_report(s);
    assert_int_equal(
        report->elements, inside(s)->elements->node_count - inside(s)->elements->follower_count);
    assert_int_equal(report->direct_elements, inside(s)->fine.elements->node_count);
    assert_int_equal(report->entries, rsv_transport_entries(inside(s)->transport));
    assert_true(report->rays >= report->entries);
    assert_true(report->time_bvh >= 0 && report->time_assemble > 0 && report->time_solve > 0);
    assert_ptr_equal(rsv_light_scene(s), w->scene);
    rsv_light_destroy(s);
    world_end(w);
}

static void too_few_orders_are_reported(void **state)
{
    (void)state;
    world *w = create_furnace(0.9f);
    rsv_solve_desc desc = small_desc(50);
    desc.max_orders = 3;
    rsv_light *s = solve_with(w, &desc);
    const rsv_solve_report *report = rsv_light_report(s);
    assert_int_equal(report->stop_reason, RSV_STOP_MAX_ORDERS);
    assert_int_equal(report->iterations, 3);
    // after three terms 0.9^4 is missing of the next one, and 0.9^4 / 0.1 of all
    assert_close(report->residual_inf, pow(0.9, 4), 1e-4);
    assert_close(report->truncation_bound, pow(0.9, 4) / 0.1, 1e-3);
    rsv_light_destroy(s);
    world_end(w);
}

static void caustics_do_not_depend_on_who_finds_direct_light(void **state)
{
    (void)state;
    world *w = world_builtin(2, "cornell-spheres");
    rsv_solve_desc desc = small_desc(200);
    rsv_light *with = solve_with(w, &desc);
    desc.direct_level = false;
    rsv_light *without = solve_with(w, &desc);
    size_t nodes = inside(with)->caustics.elements->node_count;
    assert_non_null(inside(with)->fine.direct);
    assert_null(inside(without)->fine.elements);
    assert_int_equal(inside(without)->caustics.elements->node_count, nodes);
    assert_memory_equal(
        inside(with)->caustics.caustic, inside(without)->caustics.caustic, nodes * sizeof(rsv_rgb));
    rsv_light_destroy(with);
    rsv_light_destroy(without);
    world_end(w);
}

static uint64_t hash_of_solution_with(int threads)
{
    world *w = world_builtin(threads, "cornell-spheres");
    rsv_solve_desc desc = small_desc(200);
    desc.refinements = 1;
    rsv_light *s = solve_with(w, &desc);
    size_t nodes = inside(s)->elements->node_count;
    uint64_t hash =
        hash_bytes(HASH_START, inside(s)->indirect, nodes * sizeof *inside(s)->indirect);
    hash = hash_bytes(hash, inside(s)->source, nodes * sizeof *inside(s)->source);
    hash = hash_bytes(
        hash, inside(s)->fine.direct, inside(s)->fine.elements->node_count * sizeof(rsv_rgb));
    hash = hash_bytes(hash, inside(s)->caustics.caustic,
        inside(s)->caustics.elements->node_count * sizeof(rsv_rgb));
    rsv_light_destroy(s);
    world_end(w);
    return hash;
}

static void solutions_are_the_same_bytes_for_any_thread_count(void **state)
{
    (void)state;
    uint64_t one = hash_of_solution_with(1);
    assert_true(one == hash_of_solution_with(2));
    assert_true(one == hash_of_solution_with(3));
}

// ---- scenes without a bounded or bright answer ------------------------------------------------------

/// A room of albedo 1 with a small lamp; without its ceiling if `open`.
static world *create_lossless(bool open)
{
    world *w = world_begin(1);
    uint32_t white = world_lambert(w, 1, 0);
    if (open) {
        world_quad(w, white, v3(0, 0, 0), v3(0, 0, 1), v3(1, 0, 1), v3(1, 0, 0));
        world_quad(w, white, v3(0, 0, 0), v3(1, 0, 0), v3(1, 1, 0), v3(0, 1, 0));
        world_quad(w, white, v3(0, 0, 0), v3(0, 1, 0), v3(0, 1, 1), v3(0, 0, 1));
        world_quad(w, white, v3(1, 0, 0), v3(1, 0, 1), v3(1, 1, 1), v3(1, 1, 0));
        world_quad(w, white, v3(0, 0, 1), v3(0, 1, 1), v3(1, 1, 1), v3(1, 0, 1));
    } else {
        world_room(w, white, v3(0, 0, 0), v3(1, 1, 1));
    }
    rsv_punctual_light lamp = { .name = "lamp",
        .kind = RSV_PUNCTUAL_POINT,
        .position = v3(0.5f, 0.6f, 0.4f),
        .intensity = rgb_gray(1) };
    assert_int_equal(rsv_scene_add_light(w->scene, &lamp), RSV_OK);
    world_commit(w);
    return w;
}

/// Irradiance on average in a cube of albedo 0.5 with a light of 1 W/sr that far from one of its walls.
static double mean_by_light_near_wall(float distance)
{
    world *w = world_begin(1);
    world_room(w, world_lambert(w, 0.5f, 0), v3(0, 0, 0), v3(1, 1, 1));
    rsv_punctual_light lamp = { .name = "lamp",
        .kind = RSV_PUNCTUAL_POINT,
        .position = v3(0.43f, 1 - distance, 0.54f),
        .intensity = rgb_gray(1) };
    assert_int_equal(rsv_scene_add_light(w->scene, &lamp), RSV_OK);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    rsv_light *s = solve(w, 200);
    double mean = rsv_light_report(s)->mean_irradiance;
    rsv_light_destroy(s);
    world_end(w);
    return mean;
}

/// Walls absorb as much as the light sends out, however little of a wall most of it lands on. What a light on a wall sends
/// into that is not seen.
static void lights_close_to_walls_lose_nothing(void **state)
{
    (void)state;
    static const float distance[] = { 0.3f, 0.1f, 0.03f, 0.01f, 1e-3f, 1e-4f };
    const double right = 4 * (double)RSV_PI / (6 * 0.5);
    for (size_t k = 0; k < sizeof distance / sizeof *distance; k++)
        assert_close(mean_by_light_near_wall(distance[k]), right, 0.01 * right);
    assert_close(mean_by_light_near_wall(0), right / 2, 0.005 * right);
}

static void a_closed_lossless_scene_is_refused(void **state)
{
    (void)state;
    world *w = create_lossless(false);
    rsv_solve_desc desc = small_desc(60);
    rsv_light *s = NULL;
    assert_int_equal(rsv_light_create(w->scene, &desc, &s), RSV_ERROR_SCENE);
    assert_null(s);
    assert_non_null(strstr(rsv_last_error(), "closed"));
    assert_non_null(strstr(rsv_last_error(), "albedo"));
    assert_non_null(strstr(rsv_last_error(), "spectral radius 1.0"));
    assert_non_null(strstr(rsv_last_error(), "incompatible"));
    world_end(w);
}

static void an_open_lossless_scene_is_solved(void **state)
{
    (void)state;
    world *w = create_lossless(true);
    rsv_light *s = solve(w, 60);
    assert_int_equal(rsv_light_report(s)->stop_reason, RSV_STOP_CONVERGED);
    rsv_rgb e = rsv_light_irradiance(s, 0, 0.3f, 0.3f, false, RSV_NONE);
    rsv_rgb direct = rsv_light_irradiance(s, 0, 0.3f, 0.3f, false, 0);
    assert_true(isfinite(e.g) && e.g > 1.5f * direct.g && e.g < 20 * direct.g);
    rsv_light_destroy(s);
    world_end(w);
}

/// Irradiance on the walls of a room around a box. @param sealed whether it absorbs nothing
static float light_around_pocket(bool sealed)
{
    world *w = world_begin(2);
    world_room(w, world_lambert(w, 0.5f, 0), v3(0, 0, 0), v3(1, 1, 1));
    world_room(
        w, world_lambert(w, sealed ? 1 : 0.5f, 0), v3(0.3f, 0.2f, 0.3f), v3(0.6f, 0.5f, 0.6f));
    rsv_punctual_light lamp = { .name = "lamp",
        .kind = RSV_PUNCTUAL_POINT,
        .position = v3(0.5f, 0.8f, 0.4f),
        .intensity = rgb_gray(1) };
    assert_int_equal(rsv_scene_add_light(w->scene, &lamp), RSV_OK);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    rsv_light *s = solve(w, 200);
    assert_int_equal(rsv_light_report(s)->stop_reason, RSV_STOP_CONVERGED);
    float outside = rsv_light_irradiance(s, 0, 0.3f, 0.3f, false, RSV_NONE).g;
    assert_close(inside(s)->pocket_area, sealed ? 6 * 0.09 : 0, 1e-3);
    assert_true(rgb_is_black(rsv_light_irradiance(s, 12, 0.3f, 0.3f, false, RSV_NONE)));
    rsv_light_destroy(s);
    world_end(w);
    return outside;
}

/// A sealed white room inside another one: it does not affect the light outside.
static void lossless_pockets_are_left_dark(void **state)
{
    (void)state;
    double open = light_around_pocket(false);
    assert_close(light_around_pocket(true), open, 1e-5 * open);
}

static void a_scene_without_light_is_black_and_says_so(void **state)
{
    (void)state;
    world *w = world_begin(1);
    world_room(w, world_lambert(w, 0.5f, 0), v3(0, 0, 0), v3(1, 1, 1));
    world_commit(w);
    rsv_light *s = solve(w, 50);
    assert_int_equal(rsv_light_report(s)->stop_reason, RSV_STOP_NO_LIGHT);
    assert_int_equal(rsv_light_report(s)->iterations, 0);
    for (uint32_t t = 0; t < 12; t++)
        assert_true(rgb_is_black(rsv_light_irradiance(s, t, 0.2f, 0.2f, false, RSV_NONE)));
    rsv_light_destroy(s);
    world_end(w);
}

static void a_scene_of_glass_alone_is_no_trouble(void **state)
{
    (void)state;
    world *w = world_begin(1);
    world_sphere(w, world_material(w, glass_material()), v3(0, 0, 0), 1, 2);
    world_commit(w);
    rsv_light *s = solve(w, 50);
    assert_int_equal(rsv_light_report(s)->elements, 0);
    assert_int_equal(rsv_light_report(s)->stop_reason, RSV_STOP_NO_LIGHT);
    rsv_light_destroy(s);
    world_end(w);
}

// ---- bad arguments and memory -------------------------------------------------------------------

static void expect_refusal(const world *w, const rsv_solve_desc *desc, const char *word)
{
    rsv_light *s = NULL;
    assert_int_equal(rsv_light_create(w->scene, desc, &s), RSV_ERROR_ARGUMENT);
    assert_null(s);
    if (!strstr(rsv_last_error(), word))
        fail_msg("'%s' does not mention %s", rsv_last_error(), word);
}

static void bad_descriptors_are_refused_by_name(void **state)
{
    (void)state;
    world *w = create_furnace(0.5f);
    const rsv_solve_desc good = small_desc(50);
    rsv_solve_desc desc = good;
    desc.element_target = 0;
    expect_refusal(w, &desc, "element_target");
    const uint32_t rays[] = { 0, 32, 100, 8192 };
    for (int k = 0; k < 4; k++) {
        desc = good;
        desc.rays_per_element = rays[k];
        expect_refusal(w, &desc, "rays_per_element");
    }
    const uint32_t samples[] = { 0, 8, 24 };
    for (int k = 0; k < 3; k++) {
        desc = good;
        desc.light_samples = samples[k];
        expect_refusal(w, &desc, "light_samples");
    }
    const float tolerance[] = { 0, -1, NAN };
    for (int k = 0; k < 3; k++) {
        desc = good;
        desc.tolerance = tolerance[k];
        expect_refusal(w, &desc, "tolerance");
    }
    const float share[] = { -1, 2, NAN };
    for (int k = 0; k < 3; k++) {
        desc = good;
        desc.contact_share = share[k];
        expect_refusal(w, &desc, "contact_share");
    }
    world_end(w);
}

/// Blocks stand on a floor: a smaller share of contacts takes fewer elements there.
static void a_share_of_contacts_takes_fewer_rows(void **state)
{
    (void)state;
    static const float share[] = { 0, 1, 0.01f };
    size_t rows[3];
    world *w = world_builtin(2, "cornell-blocks");
    for (int k = 0; k < 3; k++) {
        rsv_solve_desc desc = small_desc(400);
        rsv_light *light = NULL;
        desc.contact_share = share[k];
        assert_int_equal(rsv_light_create(w->scene, &desc, &light), RSV_OK);
        rows[k] = rsv_light_report(light)->rows;
        rsv_light_destroy(light);
    }
    print_message("%zu rows, %zu with a hundredth of the contacts\n", rows[1], rows[2]);
    assert_int_equal(rows[0], rows[1]);
    assert_true(rows[2] < rows[1]);
    world_end(w);
}

/// Few rows get more rays, many do not, and budgets of memory come first.
static void few_rows_get_more_rays(void **state)
{
    (void)state;
    static const struct {
        uint64_t wanted; ///< rays of a row times rows, in units of what there is without
        size_t bytes;
        uint32_t raised;
    } cases[] = { { 0, 0, 1 }, { 1, 0, 1 }, { 3, 0, 4 }, { 1000, 0, 8 },
        { 1000, (size_t)1 << 40, 1 } };
    world *w = world_builtin(2, "cornell-blocks");
    uint64_t usual = 0;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        rsv_solve_desc desc = small_desc(100);
        rsv_light *light = NULL;
        desc.row_rays = usual * cases[k].wanted;
        desc.max_bytes = cases[k].bytes;
        assert_int_equal(rsv_light_create(w->scene, &desc, &light), RSV_OK);
        const rsv_solve_report *report = rsv_light_report(light);
        assert_int_equal(report->rays_per_row, cases[k].raised * desc.rays_per_element);
        assert_true(report->row_rays >= report->rows * report->rays_per_row);
        usual = report->rows * desc.rays_per_element;
        rsv_light_destroy(light);
    }
    world_end(w);
}

/// Lambert, glass, an area light and a point light: every part of the solver has work.
static world *create_varied_room(void)
{
    world *w = world_begin(1);
    world_room(w, world_lambert(w, 0.5f, 0), v3(0, 0, 0), v3(1, 1, 1));
    rsv_material tinted = glass_material();
    tinted.base_color = rgb(0.9f, 0.5f, 0.7f);
    world_sphere(w, world_material(w, tinted), v3(0.5f, 0.4f, 0.5f), 0.2f, 0);
    world_quad(w, world_lambert(w, 0, 5), v3(0.4f, 0.99f, 0.4f), v3(0.6f, 0.99f, 0.4f),
        v3(0.6f, 0.99f, 0.6f), v3(0.4f, 0.99f, 0.6f));
    rsv_punctual_light lamp = { .name = "lamp",
        .kind = RSV_PUNCTUAL_POINT,
        .position = v3(0.2f, 0.8f, 0.2f),
        .intensity = rgb_gray(1) };
    assert_int_equal(rsv_scene_add_light(w->scene, &lamp), RSV_OK);
    world_commit(w);
    return w;
}

static void check_allocations(bool fail_once, long stride)
{
    world *w = create_varied_room();
    rsv_solve_desc desc = small_desc(12);
    desc.refinements = 1;
    desc.photon_count = 64;
    w->fail_once = fail_once;
    long before = w->alive, allocations = 0;
    for (rsv_status status = RSV_ERROR_MEMORY; status != RSV_OK; allocations += stride) {
        rsv_light *s = NULL;
        w->until_failure = allocations;
        status = rsv_light_create(w->scene, &desc, &s);
        w->until_failure = -1;
        if (status != RSV_OK) {
            assert_int_equal(status, RSV_ERROR_MEMORY);
            assert_null(s);
        }
        rsv_light_destroy(s);
        assert_int_equal(w->alive, before);
    }
    assert_true(allocations > 100);
    world_end(w);
}

static void memory_that_runs_out_is_an_error_and_nothing_leaks(void **state)
{
    (void)state;
    check_allocations(false, 1);
}

/// Only some allocations, so that the test is quick enough to run with every change.
static void memory_may_run_out_here_and_there(void **state)
{
    (void)state;
    check_allocations(false, 7);
    check_allocations(true, 29);
}

static void a_single_failed_allocation_is_an_error_and_nothing_leaks(void **state)
{
    (void)state;
    check_allocations(true, 1);
}

static bool cancel_while_assembling(void *user, const char *phase, double fraction)
{
    (void)fraction;
    const bool *wanted = user;
    return !*wanted || strcmp(phase, "assemble") != 0;
}

static void cancelled_work_can_begin_again(void **state)
{
    (void)state;
    bool cancel = true;
    rsv_context *context;
    rsv_context_desc desc = rsv_default_context_desc();
    desc.progress = cancel_while_assembling;
    desc.user = &cancel;
    assert_int_equal(rsv_context_create(&desc, &context), RSV_OK);
    rsv_scene *scene;
    assert_int_equal(rsv_scene_builtin(context, "cornell-blocks", &scene), RSV_OK);
    rsv_solve_desc settings = small_desc(200);
    rsv_light *s = NULL;
    assert_int_equal(rsv_light_create(scene, &settings, &s), RSV_ERROR_CANCELLED);
    assert_null(s);

    cancel = false;
    assert_int_equal(rsv_light_create(scene, &settings, &s), RSV_ERROR_CANCELLED);
    assert_int_equal(rsv_context_reset_cancel(context), RSV_OK);
    assert_int_equal(rsv_light_create(scene, &settings, &s), RSV_OK);
    rsv_light_destroy(s);
    rsv_scene_destroy(scene);
    rsv_context_destroy(context);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest quick[] = {
        cmocka_unit_test(light_among_mirrors_arrives_in_the_end),
        cmocka_unit_test(a_furnace_glows_by_one_over_one_minus_albedo),
        cmocka_unit_test(hardly_absorbing_furnaces_converge),
        cmocka_unit_test(lookups_find_the_side_that_a_probe_lies_on),
        cmocka_unit_test(orders_of_a_furnace_are_powers_of_its_albedo),
        cmocka_unit_test(orders_sum_to_the_solution),
        cmocka_unit_test(backs_of_one_sided_surfaces_are_black),
        cmocka_unit_test(the_report_tells_the_truth),
        cmocka_unit_test(the_report_counts_what_was_built),
        cmocka_unit_test(too_few_orders_are_reported),
        cmocka_unit_test(caustics_do_not_depend_on_who_finds_direct_light),
        cmocka_unit_test(solutions_are_the_same_bytes_for_any_thread_count),
        cmocka_unit_test(lights_close_to_walls_lose_nothing),
        cmocka_unit_test(a_closed_lossless_scene_is_refused),
        cmocka_unit_test(an_open_lossless_scene_is_solved),
        cmocka_unit_test(lossless_pockets_are_left_dark),
        cmocka_unit_test(a_scene_without_light_is_black_and_says_so),
        cmocka_unit_test(a_scene_of_glass_alone_is_no_trouble),
        cmocka_unit_test(bad_descriptors_are_refused_by_name),
        cmocka_unit_test(a_share_of_contacts_takes_fewer_rows),
        cmocka_unit_test(few_rows_get_more_rays),
        cmocka_unit_test(memory_may_run_out_here_and_there),
        cmocka_unit_test(cancelled_work_can_begin_again),
    };
    const struct CMUnitTest longest[] = {
        cmocka_unit_test(memory_that_runs_out_is_an_error_and_nothing_leaks),
        cmocka_unit_test(a_single_failed_allocation_is_an_error_and_nothing_leaks),
    };
    return RUN_HALF(argc, argv, quick, longest);
}
