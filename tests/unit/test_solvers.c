/// Solvers of x = b + A x: small matrices of known solution, each solver against the others on a scene, the
/// adjoint, the spectral radius, the Fredholm alternative.
#include "light_fixture.h"

#include "dense_map.h"
#include "elements/curvature.h"
#include "light_view.h"
#include "resolvent/measure.h"
#include "solve/transport_map.h"
#include "solver/fredholm.h"
#include "solver/leading.h"
#include "solver/linear_solver.h"

static const rsv_solver all_solvers[] = { RSV_SOLVER_NEUMANN, RSV_SOLVER_GAUSS_SEIDEL,
    RSV_SOLVER_SOUTHWELL, RSV_SOLVER_CHEBYSHEV, RSV_SOLVER_BICGSTAB, RSV_SOLVER_GMRES,
    RSV_SOLVER_TWO_GRID };
enum { solver_count = sizeof all_solvers / sizeof all_solvers[0] };

// ---- small matrices -----------------------------------------------------------------------------

/// Numbers that follow no pattern, in [0, 1).
static double noise(uint32_t a, uint32_t b) { return (double)rsv_unit_float(rsv_hash2(a, b)); }

/// Nonnegative, rows summing to `norm`; symmetric up to the scaling of rows, or not at all.
static void fill_like_transport(dense_map *m, double norm, bool symmetric)
{
    size_t count = m->linear.count;
    for (size_t i = 0; i < count; i++) {
        double sum = 0;
        for (size_t j = 0; j < count; j++) {
            size_t low = i < j ? i : j, high = i < j ? j : i;
            m->a[i][j] = i == j      ? 0
                         : symmetric ? 0.2 + noise((uint32_t)low, (uint32_t)high)
                                     : 0.2 + noise((uint32_t)i, (uint32_t)j);
            sum += m->a[i][j];
        }
        for (size_t j = 0; j < count; j++)
            m->a[i][j] *= norm / sum;
    }
}

/// b = x - A x in three columns, for an x without pattern; the third one is 0.
static void known_system(dense_map *m, float *x, float *b)
{
    size_t count = m->linear.count;
    for (uint32_t n = 0; n < count; n++)
        for (uint32_t c = 0; c < 3; c++)
            x[3 * n + c] = c == 2 ? 0 : (float)(1 + noise(n, 77 + c));
    m->linear.table->apply(m, 3, x, b);
    for (size_t k = 0; k < 3 * count; k++)
        b[k] = x[k] - b[k];
}

/// |b| is below 1: an error is at most the residual times ||(I - A)^-1||. @return applications
static double check_known(dense_map *m, rsv_solver solver, double amplification)
{
    float x[3 * DENSE_MAX], b[3 * DENSE_MAX], solved[3 * DENSE_MAX] = { 0 };
    known_system(m, x, b);
    rsv_linear_desc desc = rsv_default_linear_desc(solver);
    rsv_linear_report report;
    assert_int_equal(rsv_linear_solve(&m->linear, 3, b, &desc, solved, &report), RSV_OK);
    if (report.stop_reason != RSV_STOP_CONVERGED)
        fail_msg("%s stopped for reason %d, residual %g", rsv_solver_name(solver),
            report.stop_reason, report.residual);
    for (size_t k = 0; k < 3 * m->linear.count; k++)
        if (fabs((double)solved[k] - x[k]) > desc.relative * amplification)
            fail_msg("%s: %g instead of %g", rsv_solver_name(solver), solved[k], x[k]);
    return report.applications;
}

static void solvers_find_known_solutions(void **state)
{
    (void)state;
    world *w = world_begin(1);
    for (int symmetric = 0; symmetric < 2; symmetric++)
        for (int k = 0; k < solver_count; k++) {
            dense_map *m = dense_begin(w->context, DENSE_MAX);
            fill_like_transport(m, 0.9, symmetric);
            check_known(m, all_solvers[k], 1 / (1 - 0.9));
            free(m);
        }
    world_end(w);
}

static void solvers_cope_with_a_spectral_radius_of_099(void **state)
{
    (void)state;
    world *w = world_begin(1);
    double neumann = 0;
    for (int k = 0; k < solver_count; k++) {
        dense_map *m = dense_begin(w->context, DENSE_MAX);
        fill_like_transport(m, 0.99, true);
        double applications = check_known(m, all_solvers[k], 100);
        if (k == 0) neumann = applications;
        if (all_solvers[k] != RSV_SOLVER_GAUSS_SEIDEL && all_solvers[k] != RSV_SOLVER_SOUTHWELL &&
            k > 0)
            assert_true(applications < neumann / 3);
        free(m);
    }
    world_end(w);
}

static void every_solver_has_a_name(void **state)
{
    (void)state;
    const char *const *name = rsv_solver_names();
    for (rsv_solver solver = 0; solver <= RSV_SOLVER_PETSC; solver++)
        assert_ptr_equal(rsv_solver_name(solver), name[solver]);
    for (size_t k = 0; k < sizeof all_solvers / sizeof *all_solvers; k++)
        assert_non_null(name[all_solvers[k]]);
    assert_string_equal(name[RSV_SOLVER_AUTO], "auto");
    assert_string_equal(name[RSV_SOLVER_TWO_GRID], "two-grid");
}

static void a_zero_source_needs_no_work(void **state)
{
    (void)state;
    world *w = world_begin(1);
    for (int k = 0; k < solver_count; k++) {
        dense_map *m = dense_begin(w->context, 6);
        fill_like_transport(m, 0.5, true);
        const float b[18] = { 0 };
        float x[18] = { 0 };
        rsv_linear_desc desc = rsv_default_linear_desc(all_solvers[k]);
        rsv_linear_report report;
        assert_int_equal(rsv_linear_solve(&m->linear, 3, b, &desc, x, &report), RSV_OK);
        assert_int_equal(report.stop_reason, RSV_STOP_CONVERGED);
        assert_true(report.applications == 0);
        for (size_t n = 0; n < 18; n++)
            assert_true(x[n] == 0);
        free(m);
    }
    world_end(w);
}

static void a_good_guess_saves_work(void **state)
{
    (void)state;
    world *w = world_begin(1);
    dense_map *m = dense_begin(w->context, DENSE_MAX);
    fill_like_transport(m, 0.9, true);
    float x[3 * DENSE_MAX], b[3 * DENSE_MAX];
    known_system(m, x, b);
    rsv_linear_desc desc = rsv_default_linear_desc(RSV_SOLVER_NEUMANN);
    rsv_linear_report report;
    assert_int_equal(rsv_linear_solve(&m->linear, 3, b, &desc, x, &report), RSV_OK);
    assert_int_equal(report.stop_reason, RSV_STOP_CONVERGED);
    assert_true(report.applications == 1); // to see that there is nothing to do
    free(m);
    world_end(w);
}

/// In all cases the answer is finite and no worse than the initial guess, and its residual is reported.
static rsv_linear_report check_hopeless(dense_map *m, rsv_solver solver, double most_residual)
{
    float x[3 * DENSE_MAX] = { 0 }, b[3 * DENSE_MAX];
    for (size_t k = 0; k < 3 * m->linear.count; k++)
        b[k] = k < 3 ? 1 : 0;
    rsv_linear_desc desc = rsv_default_linear_desc(solver);
    rsv_linear_report report;
    assert_int_equal(rsv_linear_solve(&m->linear, 3, b, &desc, x, &report), RSV_OK);
    for (size_t k = 0; k < 3 * m->linear.count; k++)
        assert_true(isfinite(x[k]));
    assert_true(report.residual <= most_residual);
    return report;
}

static void a_growing_series_is_noticed(void **state)
{
    (void)state;
    world *w = world_begin(1);
    dense_map *m = dense_begin(w->context, 8);
    fill_like_transport(m, 1.5, true);
    rsv_linear_report report = check_hopeless(m, RSV_SOLVER_NEUMANN, 1);
    assert_int_equal(report.stop_reason, RSV_STOP_DIVERGED);
    report = check_hopeless(m, RSV_SOLVER_GAUSS_SEIDEL, 1);
    assert_int_equal(report.stop_reason, RSV_STOP_DIVERGED);
    free(m);
    world_end(w);
}

/// I - A is singular and the source is outside its range: nothing converges, everything ends.
static void a_singular_system_ends_with_a_reason(void **state)
{
    (void)state;
    world *w = world_begin(1);
    for (int k = 0; k < solver_count; k++) {
        dense_map *m = dense_begin(w->context, 8);
        fill_like_transport(m, 1, true);
        rsv_linear_report report = check_hopeless(m, all_solvers[k], 1);
        if (report.stop_reason == RSV_STOP_CONVERGED)
            fail_msg("%s claims to have solved it", rsv_solver_name(all_solvers[k]));
        free(m);
    }
    world_end(w);
}

/// A rotation by a right angle: with r0 = e1, <shadow, (I - A) ...> vanishes for BiCGStab's second product when
/// I - A is a permutation; GMRES needs all dimensions.
static void a_breakdown_is_named(void **state)
{
    (void)state;
    world *w = world_begin(1);
    dense_map *m = dense_begin(w->context, 2);
    m->a[0][0] = m->a[1][1] = 1; // I - A = (0 1; -1 0)
    m->a[0][1] = -1;
    m->a[1][0] = 1;
    rsv_linear_report report = check_hopeless(m, RSV_SOLVER_BICGSTAB, 1);
    assert_int_equal(report.stop_reason, RSV_STOP_BREAKDOWN);
    report = check_hopeless(m, RSV_SOLVER_GMRES, 1e-5);
    assert_int_equal(report.stop_reason, RSV_STOP_CONVERGED);
    free(m);
    world_end(w);
}

static void a_budget_of_applications_is_kept(void **state)
{
    (void)state;
    world *w = world_begin(1);
    dense_map *m = dense_begin(w->context, DENSE_MAX);
    fill_like_transport(m, 0.99, true);
    float x[3 * DENSE_MAX] = { 0 }, b[3 * DENSE_MAX], known[3 * DENSE_MAX];
    known_system(m, known, b);
    rsv_linear_desc desc = rsv_default_linear_desc(RSV_SOLVER_NEUMANN);
    desc.max_applications = 20;
    rsv_linear_report report;
    assert_int_equal(rsv_linear_solve(&m->linear, 3, b, &desc, x, &report), RSV_OK);
    assert_int_equal(report.stop_reason, RSV_STOP_MAX_ORDERS);
    assert_true(report.applications <= 21); // one to know the residual
    free(m);
    world_end(w);
}

/// Two RGB systems solved together give the same results as one by one.
static void many_columns_are_solved_like_one(void **state)
{
    (void)state;
    world *w = world_begin(1);
    for (int k = 0; k < solver_count; k++) {
        dense_map *m = dense_begin(w->context, DENSE_MAX);
        fill_like_transport(m, 0.9, false);
        float b[6 * DENSE_MAX], both[6 * DENSE_MAX] = { 0 };
        for (uint32_t n = 0; n < DENSE_MAX; n++)
            for (uint32_t c = 0; c < 6; c++)
                b[6 * n + c] = (float)(c < 3 ? noise(n, c) : 1e3 * noise(n, c) * (n == c));
        rsv_linear_desc desc = rsv_default_linear_desc(all_solvers[k]);
        rsv_linear_report report;
        assert_int_equal(rsv_linear_solve(&m->linear, 6, b, &desc, both, &report), RSV_OK);
        assert_int_equal(report.stop_reason, RSV_STOP_CONVERGED);
        for (uint32_t field = 0; field < 2; field++) {
            float one[3 * DENSE_MAX] = { 0 }, source[3 * DENSE_MAX];
            float scale = field ? 1e3f : 1;
            for (uint32_t n = 0; n < DENSE_MAX; n++)
                memcpy(source + 3 * n, b + 6 * n + 3 * field, 3 * sizeof *b);
            assert_int_equal(rsv_linear_solve(&m->linear, 3, source, &desc, one, &report), RSV_OK);
            for (uint32_t n = 0; n < DENSE_MAX; n++)
                for (uint32_t c = 0; c < 3; c++)
                    assert_close(both[6 * n + 3 * field + c], one[3 * n + c], 2e-4 * scale);
        }
        free(m);
    }
    world_end(w);
}

static void memory_that_runs_out_is_an_error(void **state)
{
    (void)state;
    world *w = world_begin(1);
    dense_map *m = dense_begin(w->context, 8);
    fill_like_transport(m, 0.9, true);
    float b[24], known[24];
    known_system(m, known, b);
    for (int k = 0; k < solver_count; k++) {
        rsv_linear_desc desc = rsv_default_linear_desc(all_solvers[k]);
        rsv_linear_report report;
        rsv_status status = RSV_ERROR_MEMORY;
        long before = w->alive;
        for (long allocations = 0; status != RSV_OK; allocations++) {
            float x[24] = { 0 };
            w->until_failure = allocations;
            status = rsv_linear_solve(&m->linear, 3, b, &desc, x, &report);
            w->until_failure = -1;
            assert_true(status == RSV_OK || status == RSV_ERROR_MEMORY);
            assert_int_equal(w->alive, before);
        }
    }
    free(m);
    world_end(w);
}

// ---- spectra ------------------------------------------------------------------------------------

static void power_iteration_brackets_the_spectral_radius(void **state)
{
    (void)state;
    world *w = world_begin(1);
    dense_map *m = dense_begin(w->context, 2);
    m->a[0][0] = 0.5, m->a[0][1] = 0.3; // eigenvalues 0.7 and 0.2
    m->a[1][0] = 0.2, m->a[1][1] = 0.4;
    float vector[6];
    rsv_spectral_radius radius;
    rsv_power_desc desc = { .max_steps = 3, .gap = 0 };
    assert_int_equal(rsv_power_iteration(&m->linear, &desc, vector, &radius), RSV_OK);
    assert_true(radius.lower < 0.7 && radius.upper > 0.7 && radius.upper - radius.lower < 0.05);
    assert_true(radius.power > 0.7);
    assert_close(radius.norm, 0.8, 1e-6);
    // ||(I - A)^-1||: rows of (0.6 0.3; 0.2 0.5) / 0.24
    assert_true(radius.resolvent >= 0.9 / 0.24 - 1e-6);
    desc.max_steps = 60;
    assert_int_equal(rsv_power_iteration(&m->linear, &desc, vector, &radius), RSV_OK);
    assert_close(radius.lower, 0.7, 1e-6);
    assert_close(radius.upper, 0.7, 1e-6);
    assert_close(radius.resolvent, 0.9 / 0.24, 1e-5);
    assert_close(vector[3] / vector[0], 2.0 / 3, 1e-5); // the eigenvector (3, 2)
    free(m);
    world_end(w);
}

static double leading_value(const rsv_linear_map *map)
{
    rsv_leading_value leading;
    assert_int_equal(rsv_leading_eigenvalue(map, NULL, 1e-5, 60, &leading), RSV_OK);
    assert_true(leading.residual <= 1e-5 * leading.value);
    return leading.value;
}

/// Matrices whose other eigenvalues are as large, with the opposite sign; that mix slowly; that are 0.
static void the_leading_eigenvalue_is_found(void **state)
{
    (void)state;
    world *w = world_begin(1);
    dense_map *m = dense_begin(w->context, 2);
    m->a[0][0] = 0.5, m->a[0][1] = 0.3;
    m->a[1][0] = 0.2, m->a[1][1] = 0.4;
    assert_close(leading_value(&m->linear), 0.7, 1e-6);
    m->a[0][0] = m->a[1][1] = 0; // two walls that see each other alone: +-sqrt(0.06)
    assert_close(leading_value(&m->linear), sqrt(0.06), 1e-6);
    m->a[1][0] = 0; // nilpotent
    assert_close(leading_value(&m->linear), 0, 1e-6);
    free(m);
    m = dense_begin(w->context, 20); // two rooms of ten, and hardly a door between them
    for (int i = 0; i < 20; i++)
        for (int j = 0; j < 20; j++)
            m->a[i][j] = (i < 10) == (j < 10) ? (i < 10 ? 0.06 : 0.0599) : 1e-6;
    assert_close(leading_value(&m->linear), 0.6, 1e-4);
    free(m);
    world_end(w);
}

/// Self-adjoint in an inner product whose weights reach from 1 to 1000: an early estimate is off by the square of its
/// residual over the distance to the next eigenvalue, which is more than half of the first.
static void the_leading_eigenvalue_is_of_second_order(void **state)
{
    (void)state;
    enum { count = 20 };
    world *w = world_begin(1);
    dense_map *m = dense_begin(w->context, count);
    float weight[3 * count];
    for (uint32_t i = 0; i < count; i++) {
        weight[3 * i] = weight[3 * i + 1] = weight[3 * i + 2] = powf(10, 3 * (float)noise(i, 5));
        for (uint32_t j = 0; j < count; j++)
            m->a[i][j] = (1 + noise(i < j ? i : j, i < j ? j : i)) / weight[3 * i];
    }
    rsv_leading_value exact, early;
    assert_int_equal(rsv_leading_eigenvalue(&m->linear, weight, 1e-6, 60, &exact), RSV_OK);
    for (uint32_t steps = 2; steps <= 5; steps++) {
        assert_int_equal(rsv_leading_eigenvalue(&m->linear, weight, 0, steps, &early), RSV_OK);
        double below = exact.value - early.value, square = early.residual * early.residual;
        assert_true(below >= -3e-7 && below <= 2 * square / exact.value + 3e-7);
    }
    free(m);
    world_end(w);
}

// ---- scenes -------------------------------------------------------------------------------------

/// A solved scene and its operator, columns included.
typedef struct solved {
    world *w;
    rsv_light *s;
    rsv_transport_map *map;
    rsv_rgb *source; ///< E0 without hanging nodes
    size_t values;   ///< floats of a field
} solved;

static solved solve_scene(world *w, uint32_t elements, rsv_solver solver)
{
    solved q = { .w = w };
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = elements;
    desc.rays_per_element = 64;
    desc.direct_level = false;
    desc.photon_count = 0;
    desc.solver = solver;
    if (rsv_light_create(w->scene, &desc, &q.s) != RSV_OK) fail_msg("%s", rsv_last_error());
    assert_int_equal(rsv_operator_map(inside(q.s)->op, 2, &q.map), RSV_OK);
    assert_int_equal(rsv_transport_map_transpose(q.map), RSV_OK);
    assert_int_equal(rsv_transport_map_prepare(q.map, RSV_SOLVER_TWO_GRID), RSV_OK);
    size_t nodes = inside(q.s)->elements->node_count;
    q.values = 3 * nodes;
    q.source = malloc(nodes * sizeof *q.source);
    assert_non_null(q.source);
    memcpy(q.source, inside(q.s)->source, nodes * sizeof *q.source);
    rsv_transport_map_mask(q.map, 1, q.source);
    return q;
}

static void discard(solved *q)
{
    free(q->source);
    rsv_transport_map_destroy(q->map);
    rsv_light_destroy(q->s);
    world_end(q->w);
}

/// A closed box of one albedo with a lamp in it: the slowest of series.
static world *create_bright_box(int threads, float albedo)
{
    world *w = world_begin(threads);
    world_room(w, world_lambert(w, albedo, 0), v3(0, 0, 0), v3(1, 1, 1.5f));
    world_box(w, world_lambert(w, albedo, 0), v3(0.2f, 0.1f, 0.2f), v3(0.5f, 0.6f, 0.5f));
    rsv_punctual_light lamp = { .name = "lamp",
        .kind = RSV_PUNCTUAL_POINT,
        .position = v3(0.7f, 0.8f, 1),
        .intensity = rgb(1, 0.5f, 0) };
    assert_int_equal(rsv_scene_add_light(w->scene, &lamp), RSV_OK);
    world_commit(w);
    return w;
}

static float *solve_with(const solved *q, rsv_solver solver, rsv_linear_report *report)
{
    float *x = calloc(q->values, sizeof *x);
    assert_non_null(x);
    rsv_linear_desc desc = rsv_default_linear_desc(solver);
    assert_int_equal(rsv_linear_solve(&q->map->linear, 3, &q->source->r, &desc, x, report), RSV_OK);
    if (report->stop_reason != RSV_STOP_CONVERGED)
        fail_msg("%s stopped for reason %d", rsv_solver_name(solver), report->stop_reason);
    return x;
}

/// Two solutions whose residuals are below r differ by at most 2 r / (1 - norm).
static void check_agreement(solved q)
{
    rsv_linear_report report;
    double largest = 0;
    for (size_t k = 0; k < q.values; k++)
        largest = fmax(largest, (&q.source->r)[k]);
    double apart = 2e-5 * largest / (1 - inside(q.s)->report.norm_inf);
    float *series = solve_with(&q, RSV_SOLVER_NEUMANN, &report);
    double terms = report.applications;
    for (int k = 1; k < solver_count; k++) {
        float *x = solve_with(&q, all_solvers[k], &report);
        for (size_t i = 0; i < q.values; i++)
            if (fabs((double)x[i] - series[i]) > apart)
                fail_msg("%s: %g instead of %g", rsv_solver_name(all_solvers[k]), x[i], series[i]);
        assert_true(report.applications < terms);
        free(x);
    }
    free(series);
    discard(&q);
}

static void solvers_agree_on_scenes(void **state)
{
    (void)state;
    check_agreement(solve_scene(world_builtin(2, "cornell-blocks"), 400, RSV_SOLVER_AUTO));
    check_agreement(solve_scene(create_bright_box(2, 0.95f), 400, RSV_SOLVER_AUTO));
}

static void the_automatic_solver_needs_a_third_of_the_series(void **state)
{
    (void)state;
    solved q = solve_scene(create_bright_box(2, 0.95f), 400, RSV_SOLVER_AUTO);
    rsv_solver_cost cost, series;
    assert_int_equal(rsv_measure_solver(q.s, RSV_SOLVER_AUTO, 1e-5, NULL, NULL, &cost), RSV_OK);
    assert_int_equal(
        rsv_measure_solver(q.s, RSV_SOLVER_NEUMANN, 1e-5, NULL, NULL, &series), RSV_OK);
    assert_int_equal(cost.stop_reason, RSV_STOP_CONVERGED);
    assert_int_equal(series.stop_reason, RSV_STOP_CONVERGED);
    assert_true(cost.residual <= 1e-5 && series.residual <= 1e-5);
    assert_true(3 * cost.applications <= series.applications);
    discard(&q);
}

static void the_report_names_solver_and_reason(void **state)
{
    (void)state;
    solved fast = solve_scene(create_bright_box(2, 0.95f), 400, RSV_SOLVER_AUTO);
    solved slow = solve_scene(create_bright_box(2, 0.95f), 400, RSV_SOLVER_NEUMANN);
    const rsv_solve_report *f = &inside(fast.s)->report, *s = &inside(slow.s)->report;
    assert_int_equal(f->solver, RSV_SOLVER_GMRES);
    assert_non_null(strstr(f->solver_reason, "spectral radius 0.9"));
    assert_int_equal(s->solver, RSV_SOLVER_NEUMANN);
    assert_non_null(strstr(s->solver_reason, "asked for"));
    assert_int_equal(f->stop_reason, RSV_STOP_CONVERGED);
    assert_true(3 * f->iterations <= s->iterations);
    // the prediction from the first orders is right
    assert_close(s->neumann_terms, s->iterations, 0.05 * s->iterations);
    assert_close(s->spectral_radius, 0.95, 2e-3);
    // both stop within the tolerance, 1e-4 of the mean source; layers are the same series
    double apart = 2e-4 *
                   rsv_elements_mean_luminance(inside(fast.s)->elements, inside(fast.s)->source) /
                   0.2126;
    for (size_t n = 0; n < inside(fast.s)->elements->node_count; n++) {
        assert_close(inside(fast.s)->indirect[n].r, inside(slow.s)->indirect[n].r, apart);
        assert_close(inside(fast.s)->order[3][n].r, inside(slow.s)->order[3][n].r, 0);
    }
    discard(&fast);
    discard(&slow);
}

/// The bounds of Collatz and Wielandt enclose it, as do those of Gelfand and of the mean of the orders.
static void the_reported_radius_is_the_true_one(void **state)
{
    (void)state;
    solved q = solve_scene(world_builtin(2, "cornell-blocks"), 400, RSV_SOLVER_AUTO);
    size_t nodes = inside(q.s)->elements->node_count;
    float *vector = calloc(3 * nodes, sizeof *vector);
    rsv_spectral_radius radius;
    rsv_power_desc desc = { .max_steps = 400 };
    assert_non_null(vector);
    assert_int_equal(rsv_power_iteration(&q.map->linear, &desc, vector, &radius), RSV_OK);
    assert_true(radius.upper - radius.lower < 1e-3);
    assert_close(inside(q.s)->report.spectral_radius, radius.lower, 1e-3);
    free(vector);
    discard(&q);
}

/// Two light sources at once, on one pass over the entries.
static void lights_are_solved_side_by_side(void **state)
{
    (void)state;
    solved q = solve_scene(world_builtin(2, "cornell-blocks"), 400, RSV_SOLVER_AUTO);
    size_t nodes = inside(q.s)->elements->node_count;
    rsv_rgb *both = calloc(2 * nodes, sizeof *both), *x = calloc(2 * nodes, sizeof *x);
    assert_true(both && x);
    for (size_t n = 0; n < nodes; n++) {
        both[2 * n] = q.source[n];
        both[2 * n + 1] = n % 2 ? q.source[n] : rgb_gray(0);
    }
    rsv_linear_desc desc = rsv_default_linear_desc(RSV_SOLVER_GMRES);
    rsv_linear_report report;
    assert_int_equal(rsv_linear_solve(&q.map->linear, 6, &both->r, &desc, &x->r, &report), RSV_OK);
    assert_int_equal(report.stop_reason, RSV_STOP_CONVERGED);
    float *first = solve_with(&q, RSV_SOLVER_GMRES, &report);
    for (size_t n = 0; n < nodes; n++) {
        q.source[n] = both[2 * n + 1];
        assert_close(x[2 * n].g, first[3 * n + 1], 1e-4 * (1 + (double)first[3 * n + 1]));
    }
    float *second = solve_with(&q, RSV_SOLVER_NEUMANN, &report);
    for (size_t n = 0; n < nodes; n++)
        assert_close(x[2 * n + 1].g, second[3 * n + 1], 1e-4 * (1 + (double)second[3 * n + 1]));
    free(both), free(x), free(first), free(second);
    discard(&q);
}

static uint64_t hash_of_solvers(int threads)
{
    solved q = solve_scene(create_bright_box(threads, 0.8f), 1500, RSV_SOLVER_AUTO);
    uint64_t hash = HASH_START;
    for (int k = 0; k < solver_count; k++) {
        rsv_linear_report report;
        float *x = solve_with(&q, all_solvers[k], &report);
        hash = hash_bytes(hash, x, q.values * sizeof *x);
        free(x);
    }
    discard(&q);
    return hash;
}

static void solvers_give_the_same_bytes_for_any_thread_count(void **state)
{
    (void)state;
    uint64_t one = hash_of_solvers(1);
    assert_true(one == hash_of_solvers(2));
    assert_true(one == hash_of_solvers(3));
}

// ---- adjoint ------------------------------------------------------------------------------------

static double product(const float *a, const float *b, size_t values)
{
    double sum = 0;
    for (size_t k = 0; k < values; k++)
        sum += (double)a[k] * b[k];
    return sum;
}

/// <w, A x> = <A* w, x>, and with solutions of both equations <w, (I - A)^-1 e> = <(I - A*)^-1 w, e>.
static void check_adjoint(solved q)
{
    float *w = calloc(q.values, sizeof *w), *x = calloc(q.values, sizeof *x);
    float *z = calloc(q.values, sizeof *z), *image = calloc(q.values, sizeof *image);
    assert_true(w && x && z && image);
    for (uint32_t k = 0; k < q.values; k++)
        w[k] = k < q.values / 5 ? (float)noise(k, 5) : 0; // a sensor that sees a part of the scene
    rsv_transport_map_mask(q.map, 1, (rsv_rgb *)w);
    const rsv_linear_map_table *table = q.map->linear.table;
    table->apply(q.map, 3, &q.source->r, image);
    double forward = product(w, image, q.values);
    table->apply_transpose(q.map, 3, w, image);
    assert_close(product(image, &q.source->r, q.values), forward, 1e-6 * forward);

    rsv_linear_map transposed = rsv_linear_map_transposed(&q.map->linear);
    rsv_linear_desc desc = rsv_default_linear_desc(RSV_SOLVER_GMRES);
    rsv_linear_report report;
    desc.relative = 1e-6;
    assert_int_equal(rsv_linear_solve(&q.map->linear, 3, &q.source->r, &desc, x, &report), RSV_OK);
    assert_int_equal(report.stop_reason, RSV_STOP_CONVERGED);
    assert_int_equal(rsv_linear_solve(&transposed, 3, w, &desc, z, &report), RSV_OK);
    assert_int_equal(report.stop_reason, RSV_STOP_CONVERGED);
    double reading = product(w, x, q.values);
    assert_true(reading > 0);
    assert_close(product(z, &q.source->r, q.values), reading, 1e-5 * reading);
    free(w), free(x), free(z), free(image);
    discard(&q);
}

static solved solve_room_with_tinted_glass(void)
{
    world *w = world_begin(2);
    world_room(w, world_lambert(w, 0.7f, 0), v3(0, 0, 0), v3(1, 1, 1));
    world_box(w, world_lambert(w, 0.6f, 0), v3(0.6f, 0, 0.1f), v3(0.9f, 0.4f, 0.4f));
    rsv_material tinted = glass_material();
    tinted.base_color = rgb(0.9f, 0.5f, 0.7f);
    world_sphere(w, world_material(w, tinted), v3(0.3f, 0.4f, 0.5f), 0.2f, 2);
    world_quad(w, world_lambert(w, 0, 5), v3(0.4f, 0.99f, 0.4f), v3(0.6f, 0.99f, 0.4f),
        v3(0.6f, 0.99f, 0.6f), v3(0.4f, 0.99f, 0.6f));
    world_commit(w);
    return solve_scene(w, 500, RSV_SOLVER_AUTO);
}

/// GMRES shortens the residual's length and guesses the largest value from it: wherever a cycle stops for that guess,
/// the next one has to go on.
static void gmres_reaches_every_goal(void **state)
{
    (void)state;
    solved q = solve_room_with_tinted_glass();
    rsv_linear_map transposed = rsv_linear_map_transposed(&q.map->linear);
    rsv_linear_desc desc = rsv_default_linear_desc(RSV_SOLVER_GMRES);
    float *w = calloc(q.values, sizeof *w), *z = calloc(q.values, sizeof *z);
    assert_true(w && z);
    for (desc.relative = 0.1; desc.relative > 5e-7; desc.relative *= 0.9) {
        for (uint32_t k = 0; k < q.values; k++) {
            w[k] = k < q.values / 5 ? (float)noise(k, 5) : 0;
            z[k] = 0;
        }
        rsv_transport_map_mask(q.map, 1, (rsv_rgb *)w);
        rsv_linear_report report;
        assert_int_equal(rsv_linear_solve(&transposed, 3, w, &desc, z, &report), RSV_OK);
        assert_int_equal(report.stop_reason, RSV_STOP_CONVERGED);
    }
    free(w), free(z);
    discard(&q);
}

static void importance_and_light_give_the_same_reading(void **state)
{
    (void)state;
    check_adjoint(solve_scene(world_builtin(2, "cornell-blocks"), 3000, RSV_SOLVER_AUTO));
}

static void importance_follows_tinted_glass_and_hanging_nodes(void **state)
{
    (void)state;
    solved q = solve_room_with_tinted_glass();
    assert_true(inside(q.s)->elements->hanging_count > 0);
    size_t tinted = 0;
    for (size_t row = 0; row < inside(q.s)->transport->row_count; row++)
        tinted += rsv_transport_row_at(inside(q.s)->transport, row).tinted_count;
    assert_true(tinted > 0);
    check_adjoint(q);
}

static void importance_follows_light_below_translucent_surfaces(void **state)
{
    (void)state;
    world *w = world_begin(2);
    world_room(w, world_lambert(w, 0.7f, 0), v3(0, 0, 0), v3(1, 1, 1));
    rsv_material marble = lambert_material(0.8f, 0);
    marble.scatter_distance = rgb(0.1f, 0.05f, 0.03f);
    world_sphere(w, world_material(w, marble), v3(0.4f, 0.4f, 0.5f), 0.3f, 2);
    world_quad(w, world_lambert(w, 0, 5), v3(0.4f, 0.99f, 0.4f), v3(0.6f, 0.99f, 0.4f),
        v3(0.6f, 0.99f, 0.6f), v3(0.4f, 0.99f, 0.6f));
    world_commit(w);
    solved q = solve_scene(w, 500, RSV_SOLVER_AUTO);
    assert_non_null(inside(q.s)->subsurface);
    rsv_linear_report report;
    float *series = solve_with(&q, RSV_SOLVER_NEUMANN, &report);
    float *swept = solve_with(&q, RSV_SOLVER_GAUSS_SEIDEL, &report);
    for (size_t k = 0; k < q.values; k++)
        assert_close(swept[k], series[k], 1e-4 * (1 + (double)series[k]));
    free(series), free(swept);
    assert_false(rsv_solver_fits(RSV_SOLVER_SOUTHWELL, &q.map->linear));
    check_adjoint(q);
}

// ---- Fredholm's alternative -------------------------------------------------------------------------

static void a_lossy_scene_has_one_answer(void **state)
{
    (void)state;
    solved q = solve_scene(create_bright_box(2, 0.95f), 200, RSV_SOLVER_AUTO);
    rsv_alternative a;
    assert_int_equal(rsv_fredholm_alternative(&q.map->linear, &a, NULL), RSV_OK);
    assert_true(a.unique);
    assert_true(a.radius.lower <= 0.95 + 1e-5 && a.radius.upper >= 0.95 - 1e-5);
    assert_true(a.radius.resolvent >= 1 / (1 - 0.95) - 1e-3);
    discard(&q);
}

/// A closed lossless class of nodes next to an open one: solutions of the homogeneous equation are in the first, and do
/// not disturb light that is only in the second.
static void a_lossless_part_is_compatible_with_light_elsewhere(void **state)
{
    (void)state;
    world *w = world_begin(1);
    dense_map *m = dense_begin(w->context, 4);
    m->a[0][1] = m->a[1][0] = 1;
    m->a[2][3] = m->a[3][2] = 0.5;
    const float inside[12] = { 1 }, outside[12] = { 0, 0, 0, 0, 0, 0, 1 };
    rsv_alternative a;
    double compatibility;
    float lasting[12];
    assert_int_equal(rsv_fredholm_alternative(&m->linear, &a, lasting), RSV_OK);
    assert_false(a.unique);
    for (int k = 0; k < 12; k++)
        assert_close(lasting[k], k < 6 ? 1 : 0, 1e-6);
    assert_int_equal(rsv_fredholm_compatibility(&m->linear, inside, &compatibility), RSV_OK);
    assert_true(compatibility > 0.1);
    assert_int_equal(rsv_fredholm_compatibility(&m->linear, outside, &compatibility), RSV_OK);
    assert_true(compatibility < 1e-6);
    free(m);
    world_end(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(solvers_find_known_solutions),
        cmocka_unit_test(solvers_cope_with_a_spectral_radius_of_099),
        cmocka_unit_test(every_solver_has_a_name),
        cmocka_unit_test(a_zero_source_needs_no_work),
        cmocka_unit_test(a_good_guess_saves_work),
        cmocka_unit_test(a_growing_series_is_noticed),
        cmocka_unit_test(a_singular_system_ends_with_a_reason),
        cmocka_unit_test(a_breakdown_is_named),
        cmocka_unit_test(a_budget_of_applications_is_kept),
        cmocka_unit_test(many_columns_are_solved_like_one),
        cmocka_unit_test(memory_that_runs_out_is_an_error),
        cmocka_unit_test(power_iteration_brackets_the_spectral_radius),
        cmocka_unit_test(the_leading_eigenvalue_is_found),
        cmocka_unit_test(the_leading_eigenvalue_is_of_second_order),
        cmocka_unit_test(the_reported_radius_is_the_true_one),
        cmocka_unit_test(solvers_agree_on_scenes),
        cmocka_unit_test(the_automatic_solver_needs_a_third_of_the_series),
        cmocka_unit_test(the_report_names_solver_and_reason),
        cmocka_unit_test(lights_are_solved_side_by_side),
        cmocka_unit_test(solvers_give_the_same_bytes_for_any_thread_count),
        cmocka_unit_test(gmres_reaches_every_goal),
        cmocka_unit_test(importance_and_light_give_the_same_reading),
        cmocka_unit_test(importance_follows_tinted_glass_and_hanging_nodes),
        cmocka_unit_test(importance_follows_light_below_translucent_surfaces),
        cmocka_unit_test(a_lossy_scene_has_one_answer),
        cmocka_unit_test(a_lossless_part_is_compatible_with_light_elsewhere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
