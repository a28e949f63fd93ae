/// The factors of G K as matrices equal the operator that the library applies; elements are at their stated positions.
#include "light_view.h"
#include "resolvent/render.h"

#include "light_fixture.h"
#include "slow_tests.h"

typedef struct subject {
    world *w;
    rsv_light *light;
    const rsv_operator *op;
    size_t count; ///< of elements
} subject;

static subject begin(const char *scene)
{
    subject s = { .w = world_builtin(2, scene) };
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = 300;
    desc.rays_per_element = 64;
    desc.photon_count = 2000;
    desc.direct_levels = 1;
    if (rsv_light_create(s.w->scene, &desc, &s.light) != RSV_OK) fail_msg("%s", rsv_last_error());
    s.op = rsv_light_operator(s.light);
    s.count = rsv_operator_element_count(s.op);
    return s;
}

static void end(subject *s)
{
    rsv_light_destroy(s->light);
    world_end(s->w);
}

/// Shared by several tests, which only read it.
typedef struct subjects {
    subject furnace, blocks, marble;
} subjects;

static int begin_all(void **state)
{
    static subjects all;
    all.furnace = begin("furnace");
    all.blocks = begin("cornell-blocks");
    all.marble = begin("cornell-marble");
    *state = &all;
    return 0;
}

static int end_all(void **state)
{
    subjects *all = *state;
    end(&all->furnace);
    end(&all->blocks);
    end(&all->marble);
    return 0;
}

/// image = factor * field of one channel.
static double *multiply(
    const subject *s, rsv_operator_factor factor, uint32_t channel, double *field)
{
    rsv_sparse_matrix *m = NULL;
    assert_int_equal(rsv_operator_matrix(s->op, factor, channel, &m), RSV_OK);
    double *image = calloc(m->row_count, sizeof *image);
    assert_non_null(image);
    assert_int_equal(m->row_start[0], 0);
    for (size_t r = 0; r < m->row_count; r++) {
        assert_true(m->row_start[r] <= m->row_start[r + 1]);
        for (size_t k = m->row_start[r]; k < m->row_start[r + 1]; k++) {
            assert_true(m->column[k] < m->column_count);
            image[r] += (double)m->weight[k] * field[m->column[k]];
        }
    }
    rsv_sparse_matrix_destroy(m);
    free(field);
    return image;
}

/// C G A C S M C field.
static double *multiply_all(
    const subject *s, const rsv_element *element, uint32_t channel, double *field)
{
    const rsv_operator_factor right[] = { RSV_FACTOR_INTERPOLATION, RSV_FACTOR_CLUSTERS,
        RSV_FACTOR_SUBSURFACE, RSV_FACTOR_INTERPOLATION };
    for (size_t k = 0; k < sizeof right / sizeof *right; k++)
        field = multiply(s, right[k], channel, field);
    for (size_t n = 0; n < s->count; n++)
        field[n] *= (double)(&element[n].albedo.r)[channel];
    field = multiply(s, RSV_FACTOR_PROPAGATION, channel, field);
    return multiply(s, RSV_FACTOR_INTERPOLATION, channel, field);
}

static void check_factors(subject s)
{
    rsv_element *element = calloc(s.count, sizeof *element);
    rsv_rgb *field = calloc(s.count, sizeof *field), *image = calloc(s.count, sizeof *image);
    assert_true(element && field && image);
    assert_int_equal(rsv_operator_elements(s.op, element), RSV_OK);
    rsv_random random = rsv_random_from(1, 2, 3);
    for (size_t n = 0; n < s.count; n++)
        field[n] =
            rgb(rsv_random_float(&random), rsv_random_float(&random), rsv_random_float(&random));
    assert_int_equal(rsv_operator_apply(s.op, field, image), RSV_OK);
    for (uint32_t c = 0; c < 3; c++) {
        double *own = calloc(s.count, sizeof *own), largest = 0;
        assert_non_null(own);
        for (size_t n = 0; n < s.count; n++)
            own[n] = (double)(&field[n].r)[c];
        own = multiply_all(&s, element, c, own);
        for (size_t n = 0; n < s.count; n++) // sums of floats against sums in double
            assert_close(own[n], (double)(&image[n].r)[c], 1e-5);
        for (size_t n = 0; n < s.count; n++)
            largest = fmax(largest, own[n]);
        assert_true(largest > 0.1);
        free(own);
    }
    free(element), free(field), free(image);
}

static void factors_make_the_operator(void **state) { check_factors(((subjects *)*state)->blocks); }

static void factors_make_it_where_glass_is_coloured(void **state)
{
    (void)state;
    subject s = begin("cornell-glass");
    check_factors(s);
    end(&s);
}

static void factors_make_it_where_light_diffuses(void **state)
{
    check_factors(((subjects *)*state)->marble);
}

/// If the values of a field are the coordinates of the nodes, a probe reads its own position, because hat functions are
/// linear.
static void elements_around_probes_are_where_these_are(void **state)
{
    subject s = ((subjects *)*state)->furnace;
    enum { COUNT = 500 };
    rsv_element *element = calloc(s.count, sizeof *element);
    static rsv_probe probe[COUNT];
    static rsv_element_weights around[COUNT];
    assert_non_null(element);
    assert_int_equal(rsv_operator_elements(s.op, element), RSV_OK);
    rsv_random random = rsv_random_from(4, 5, 6);
    for (size_t k = 0; k < COUNT; k++) { // on the floor, where nothing stands
        const rsv_scene_view *view = rsv_scene_get_view(s.w->scene);
        float x = rsv_random_float(&random), z = rsv_random_float(&random);
        probe[k].position = v3(view->bounds_min.x + x * (view->bounds_max.x - view->bounds_min.x),
            view->bounds_min.y, view->bounds_min.z + z * (view->bounds_max.z - view->bounds_min.z));
        probe[k].normal = v3(0, 1, 0);
    }
    assert_int_equal(rsv_operator_locate_probes(s.op, probe, COUNT, around), RSV_OK);
    for (size_t k = 0; k < COUNT; k++) {
        rsv_vec3 place = v3(0, 0, 0);
        for (int i = 0; i < 3; i++) {
            place = v3_mad(place, around[k].weight[i], element[around[k].element[i]].position);
            assert_close(element[around[k].element[i]].normal.y, 1, 1e-5);
        }
        assert_close(v3_length(v3_sub(place, probe[k].position)), 0, 1e-4);
    }
    free(element);
}

/// A point of a triangle is where the weighted places of the elements around it are; sides that reflect nothing have none.
static void elements_around_points_of_triangles_are_where_these_are(void **state)
{
    subject s = ((subjects *)*state)->furnace;
    const rsv_scene_view *view = rsv_scene_get_view(s.w->scene);
    rsv_element *element = calloc(s.count, sizeof *element);
    assert_non_null(element);
    assert_int_equal(rsv_operator_elements(s.op, element), RSV_OK);
    rsv_random random = rsv_random_from(7, 8, 9);
    uint32_t found = 0;
    for (uint32_t t = 0; t < view->triangle_count; t++)
        for (int k = 0; k < 20; k++) {
            float a = sqrtf(rsv_random_float(&random)), b = rsv_random_float(&random);
            float u = a * (1 - b), v = a * b;
            rsv_element_weights around;
            assert_false(rsv_operator_locate(s.op, t, u, v, true, &around)); // single-sided
            if (!rsv_operator_locate(s.op, t, u, v, false, &around)) continue;
            const uint32_t *corner = view->triangle[t];
            rsv_vec3 place = v3_scale(view->position[corner[0]], 1 - u - v), mean = v3(0, 0, 0);
            place =
                v3_mad(v3_mad(place, u, view->position[corner[1]]), v, view->position[corner[2]]);
            float sum = 0;
            for (int i = 0; i < 3; i++) {
                mean = v3_mad(mean, around.weight[i], element[around.element[i]].position);
                sum += around.weight[i];
                assert_true(around.weight[i] >= 0);
                assert_false(element[around.element[i]].back_side);
            }
            assert_close(sum, 1, 1e-5);
            assert_close(v3_length(v3_sub(mean, place)), 0, 1e-4);
            found++;
        }
    assert_true(found > 10 * view->triangle_count);
    free(element);
}

/// <y, G K x> = <(G K)* y, x>, whatever y is at elements that hang.
static void the_transposed_operator_is_the_adjoint(void **state)
{
    subject s = ((subjects *)*state)->marble;
    rsv_rgb *x = calloc(s.count, sizeof *x), *y = calloc(s.count, sizeof *y);
    rsv_rgb *ax = calloc(s.count, sizeof *ax), *ay = calloc(s.count, sizeof *ay);
    assert_true(x && y && ax && ay);
    for (uint32_t n = 0; n < s.count; n++) {
        x[n] = rgb_gray(rsv_unit_float(rsv_hash2(1, n)));
        y[n] = rgb_gray(rsv_unit_float(rsv_hash2(2, n)));
    }
    assert_int_equal(rsv_operator_apply(s.op, x, ax), RSV_OK);
    assert_int_equal(rsv_operator_apply_transpose(s.op, y, ay), RSV_OK);
    double left = 0, right = 0;
    for (size_t n = 0; n < s.count; n++) {
        left += (double)y[n].r * (double)ax[n].r;
        right += (double)ay[n].r * (double)x[n].r;
    }
    assert_close(left, right, 1e-4 * right);
    free(x), free(y), free(ax), free(ay);
}

static void wrong_requests_are_refused(void **state)
{
    subject s = ((subjects *)*state)->blocks;
    rsv_sparse_matrix *m = NULL;
    assert_int_equal(rsv_operator_matrix(s.op, RSV_FACTOR_PROPAGATION, 3, &m), RSV_ERROR_ARGUMENT);
    assert_int_equal(rsv_operator_matrix(s.op, (rsv_operator_factor)17, 0, &m), RSV_ERROR_ARGUMENT);
    rsv_probe probe = { v3(0, NAN, 0), v3(0, 1, 0) };
    rsv_element_weights around;
    assert_int_equal(rsv_operator_locate_probes(s.op, &probe, 1, &around), RSV_ERROR_ARGUMENT);
    assert_null(m);
    rsv_sparse_matrix_destroy(NULL);
}

static void memory_that_runs_out_is_an_error(void **state)
{
    subject s = ((subjects *)*state)->marble;
    for (int factor = RSV_FACTOR_INTERPOLATION; factor <= RSV_FACTOR_CLUSTERS; factor++) {
        rsv_status status = RSV_ERROR_MEMORY;
        for (long left = 0; status != RSV_OK; left++) {
            rsv_sparse_matrix *m = NULL;
            assert_true(left < 1000);
            s.w->until_failure = left;
            status = rsv_operator_matrix(s.op, (rsv_operator_factor)factor, 1, &m);
            s.w->until_failure = -1;
            assert_true(status == RSV_OK || status == RSV_ERROR_MEMORY);
            assert_true((status == RSV_OK) == (m != NULL));
            rsv_sparse_matrix_destroy(m);
        }
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest slow[] = {
        cmocka_unit_test(factors_make_the_operator),
        cmocka_unit_test(factors_make_it_where_glass_is_coloured),
    };
    const struct CMUnitTest quick[] = {
        cmocka_unit_test(factors_make_it_where_light_diffuses),
        cmocka_unit_test(elements_around_probes_are_where_these_are),
        cmocka_unit_test(elements_around_points_of_triangles_are_where_these_are),
        cmocka_unit_test(the_transposed_operator_is_the_adjoint),
        cmocka_unit_test(wrong_requests_are_refused),
        cmocka_unit_test(memory_that_runs_out_is_an_error),
    };
    return RUN_HALF_WITH(argc, argv, quick, slow, begin_all, end_all);
}
