/// The GPU's code, on a GPU emulated on the CPU: everything except the launches themselves. `test_gpu cuda` runs the
/// same on a real device and is skipped where there is none.
#include "resolvent/device.h"

#include "light_view.h"
#include "resolvent/measure.h"
#include "scene_fixture.h"
#include "solve/light_change.h"
#include "solve/transport_map.h"
#include "solver/linear_solver.h"

enum { SKIPPED = 77 };

/// Which device the tests are about.
static rsv_device_kind kind = RSV_DEVICE_EMULATED;

static rsv_device_desc device_desc(void)
{
    rsv_device_desc desc = rsv_default_device_desc();
    desc.kind = kind;
    return desc;
}

/// A small solution, and the device it was found on.
typedef struct rig {
    fixture f;
    rsv_device *device;
    rsv_scene *scene;
    rsv_light *solution;
} rig;

/// @param desc NULL = no device @return what solving says
static rsv_status start(rig *r, const char *scene, const rsv_device_desc *desc)
{
    rsv_context_desc context = rsv_default_context_desc();
    rsv_solve_desc solve = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    *r = (rig){ .f = { .allocations_left = SIZE_MAX } };
    if (desc) assert_int_equal(rsv_device_open(desc, &r->device), RSV_OK);
    context.log = fixture_log;
    context.allocate = fixture_allocate;
    context.release = fixture_release;
    context.user = &r->f;
    context.device = r->device;
    assert_int_equal(rsv_context_create(&context, &r->f.context), RSV_OK);
    rsv_builtin_desc builtin = rsv_default_builtin_desc();
    builtin.body_triangles = 1000;
    assert_int_equal(rsv_scene_builtin_with(r->f.context, scene, &builtin, &r->scene), RSV_OK);
    solve.element_target = 200;
    solve.rays_per_element = 64;
    solve.refinements = 1;
    solve.photon_count = 1000;
    solve.direct_level = false;
    solve.solver = RSV_SOLVER_BICGSTAB;
    solve.tolerance = 1e-6f;
    return rsv_light_create(r->scene, &solve, &r->solution);
}

static void finish(rig *r)
{
    rsv_light_destroy(r->solution);
    rsv_scene_destroy(r->scene);
    rsv_context_destroy(r->f.context);
    rsv_device_close(r->device);
    assert_int_equal(r->f.allocations_alive, 0);
}

/// Largest difference of two fields, relative to the largest value.
static double difference(const rsv_rgb *a, const rsv_rgb *b, size_t count)
{
    double most = 0, size = 0;
    for (size_t k = 0; k < 3 * count; k++) {
        most = fmax(most, fabs((double)(&a->r)[k] - (double)(&b->r)[k]));
        size = fmax(size, fabs((double)(&b->r)[k]));
    }
    return most / size;
}

static rsv_rgb *noise(size_t count)
{
    rsv_rgb *field = malloc(count * sizeof *field);
    for (size_t k = 0; k < count; k++)
        field[k] = rgb((float)(k * 7919 % 1009) / 1009, (float)(k * 104729 % 997) / 997, 0.5f);
    return field;
}

// ---- products ------------------------------------------------------------------------------------

/// Float sums of some hundred terms in another order.
#define ROUNDING 1e-6

/// A and the residual of three fields at once, on the device and on the CPU.
static void compare_products(const char *scene)
{
    rig r;
    rsv_device_desc desc = device_desc();
    rsv_transport_map *map;
    assert_int_equal(start(&r, scene, &desc), RSV_OK);
    const rsv_light *s = r.solution;
    size_t values = 3 * inside(s)->elements->node_count;
    assert_true(inside(s)->elements->hanging_count > 0);
    assert_int_equal(rsv_operator_map(inside(s)->op, 3, &map), RSV_OK);
    assert_non_null(map->device);
    const rsv_linear_map_table *table = map->linear.table;
    rsv_device_map *device = map->device;
    rsv_rgb *field = noise(values), *source = noise(values);
    rsv_rgb *here = calloc(values, sizeof *here), *there = calloc(values, sizeof *there);
    table->apply(map, 9, &field->r, &there->r);
    map->device = NULL;
    table->apply(map, 9, &field->r, &here->r);
    assert_true(difference(there, here, values) < ROUNDING);
    table->residual(map, 9, &source->r, &field->r, &here->r);
    map->device = device;
    table->residual(map, 9, &source->r, &field->r, &there->r);
    // G's sums are rounded once, at the end; diffusion's are in float
    assert_true(difference(there, here, values) < (inside(s)->subsurface ? ROUNDING : 1e-7));
    free(field), free(source), free(here), free(there);
    rsv_transport_map_destroy(map);
    finish(&r);
}

static void products_are_those_of_the_processor(void **state)
{
    (void)state;
    compare_products("cornell-spheres"); // tinted rows
    compare_products("two-rooms");
    compare_products("cornell-marble"); // light leaves elsewhere than it entered
}

static void a_product_moves_each_of_its_arrays_once_at_least(void **state)
{
    (void)state;
    rig r;
    rsv_device_desc desc = device_desc();
    double rate[2], seconds[2];
    size_t bytes;
    assert_int_equal(start(&r, "cornell-blocks", &desc), RSV_OK);
    assert_int_equal(rsv_measure_device(r.solution, 2, rate, seconds, &bytes), RSV_OK);
    assert_true(rate[1] > 0 && seconds[1] > 0);
    assert_true(bytes > rsv_transport_entries(inside(r.solution)->transport) * 4);
    assert_true(bytes < 2 * inside(r.solution)->report.bytes);
    finish(&r);
    assert_int_equal(start(&r, "cornell-blocks", NULL), RSV_OK);
    assert_int_equal(
        rsv_measure_device(r.solution, 2, rate, seconds, &bytes), RSV_ERROR_UNSUPPORTED);
    finish(&r);
}

// ---- solvers -------------------------------------------------------------------------------------

/// Solves E = E0 + A E. @return applications of A
static double solve_with(
    const rsv_light *s, rsv_transport_map *map, rsv_solver solver, rsv_rgb *solution)
{
    rsv_linear_desc desc = rsv_default_linear_desc(solver);
    rsv_linear_report report;
    desc.relative = 1e-6;
    memset(solution, 0, map->linear.count * sizeof *solution);
    assert_int_equal(rsv_transport_map_prepare(map, solver), RSV_OK);
    assert_int_equal(
        rsv_linear_solve(&map->linear, 3, &inside(s)->source->r, &desc, &solution->r, &report),
        RSV_OK);
    assert_int_equal(report.stop_reason, RSV_STOP_CONVERGED);
    return report.applications;
}

static void solvers_find_what_those_of_the_processor_find(void **state)
{
    (void)state;
    const rsv_solver solvers[] = { RSV_SOLVER_NEUMANN, RSV_SOLVER_CHEBYSHEV, RSV_SOLVER_BICGSTAB };
    rig r;
    rsv_device_desc desc = device_desc();
    rsv_transport_map *map;
    assert_int_equal(start(&r, "cornell-spheres", &desc), RSV_OK);
    const rsv_light *s = r.solution;
    size_t nodes = inside(s)->elements->node_count;
    assert_int_equal(rsv_operator_map(inside(s)->op, 1, &map), RSV_OK);
    rsv_rgb *here = calloc(nodes, sizeof *here), *there = calloc(nodes, sizeof *there);
    rsv_rgb *again = calloc(nodes, sizeof *again);
    rsv_transport_map_mask(
        map, 1, rsv_light_edit(r.solution)->source); // hanging nodes are no unknowns
    for (size_t k = 0; k < sizeof solvers / sizeof solvers[0]; k++) {
        rsv_device_map *device = map->device;
        double on_device = solve_with(s, map, solvers[k], there);
        solve_with(s, map, solvers[k], again);
        assert_memory_equal(there, again, nodes * sizeof *there);
        map->device = NULL;
        double on_processor = solve_with(s, map, solvers[k], here);
        map->device = device;
        assert_true(difference(there, here, nodes) < 1e-5); // residuals of 1e-6, norm 0.7
        // the device checks the residual only every four applications, and aims at a fifth of it
        assert_in_range((size_t)on_device, (size_t)on_processor - 4, (size_t)on_processor + 8);
    }
    free(here), free(there), free(again);
    rsv_transport_map_destroy(map);
    finish(&r);
}

static void solutions_are_those_of_the_processor(void **state)
{
    (void)state;
    rig there, here;
    rsv_device_desc desc = device_desc();
    assert_int_equal(start(&there, "two-rooms", &desc), RSV_OK);
    assert_int_equal(start(&here, "two-rooms", NULL), RSV_OK);
    size_t nodes = inside(here.solution)->elements->node_count;
    assert_int_equal(inside(there.solution)->elements->node_count, nodes);
    // both solve to a residual of 1e-6 of the mean; the pilot's splits are the same
    assert_true(difference(inside(there.solution)->irradiance, inside(here.solution)->irradiance,
                    nodes) < 1e-5);
    finish(&there);
    finish(&here);
}

// ---- relighting by factors -----------------------------------------------------------------------

static void relit_receivers_get_every_light_times_its_scale(void **state)
{
    (void)state;
    enum { lights = 5, receivers = 1237 };
    const rsv_rgb scale[lights] = { { 1, 0, 2 }, { 0, 0, 0 }, { 0.5f, 3, 1 }, { 2, 1, 1 },
        { 0.125f, 7, 0.3f } };
    rsv_device_desc desc = device_desc();
    rsv_device *device;
    rsv_device_basis *basis;
    double seconds[3];
    assert_int_equal(rsv_device_open(&desc, &device), RSV_OK);
    rsv_rgb *value = noise((size_t)lights * receivers), *light = calloc(receivers, sizeof *light);
    assert_int_equal(rsv_device_basis_create(device, lights, receivers, &value->r, &basis), RSV_OK);
    assert_int_equal(rsv_device_basis_relight(basis, scale, light), RSV_OK);
    for (size_t k = 0; k < receivers; k++) {
        rsv_rgb sum = rgb_gray(0);
        for (size_t l = 0; l < lights; l++)
            sum = rgb_add(sum, rgb_mul(scale[l], value[l * receivers + k]));
        assert_memory_equal(&light[k], &sum, sizeof sum); // in the same order
    }
    assert_int_equal(rsv_device_basis_relight(basis, scale, NULL), RSV_OK);
    assert_non_null(rsv_device_basis_address(basis));
    assert_int_equal(rsv_device_basis_measure(basis, 3, seconds), RSV_OK);
    assert_true(seconds[0] > 0 && seconds[0] < 10);
    assert_int_equal(
        rsv_device_basis_create(device, 1, SIZE_MAX / 8, NULL, &basis), RSV_ERROR_UNSUPPORTED);
    rsv_device_basis_destroy(basis);
    rsv_device_close(device);
    free(value), free(light);
}

// ---- what can go wrong ---------------------------------------------------------------------------

static void a_device_that_is_too_small_is_an_error_that_says_how_small(void **state)
{
    (void)state;
    rig r;
    rsv_device_desc desc = device_desc();
    desc.max_bytes = 3 << 20; // the draft's operator takes some 100 kB, its fields little more
    assert_int_equal(start(&r, "cornell-blocks", &desc), RSV_OK);
    finish(&r);
    desc.max_bytes = 16 << 10;
    assert_int_equal(start(&r, "cornell-blocks", &desc), RSV_ERROR_MEMORY);
    assert_mentions(rsv_last_error(), "the operator would take");
    assert_mentions(rsv_last_error(), "0 MiB free");
    finish(&r);
}

static void memory_of_the_host_that_runs_out_is_an_error_and_nothing_leaks(void **state)
{
    (void)state;
    rig r;
    rsv_device_desc desc = device_desc();
    rsv_transport_map *map = NULL;
    assert_int_equal(start(&r, "cornell-marble", &desc), RSV_OK);
    const rsv_light *s = r.solution;
    for (size_t left = 0; !map; left++) {
        r.f.allocations_left = left;
        rsv_status status = rsv_operator_map(inside(s)->op, 1, &map);
        assert_int_equal(status, map ? RSV_OK : RSV_ERROR_MEMORY);
    }
    assert_non_null(map->device);
    r.f.allocations_left = SIZE_MAX;
    rsv_transport_map_destroy(map);
    finish(&r);
}

static void less_may_go_well_after_too_much(void **state)
{
    (void)state;
    rsv_device_desc desc = device_desc();
    rsv_device *device;
    rsv_device_basis *basis = NULL;
    desc.max_bytes = 1 << 20;
    rsv_rgb *value = noise(1 << 16);
    assert_int_equal(rsv_device_open(&desc, &device), RSV_OK);
    for (size_t receivers = 1 << 16; !basis; receivers /= 2) {
        rsv_status status = rsv_device_basis_create(device, 1, receivers, &value->r, &basis);
        assert_int_equal(status, receivers > 1 << 15 ? RSV_ERROR_MEMORY : RSV_OK);
    }
    rsv_device_basis_destroy(basis);
    rsv_device_close(device);
    free(value);
}

static void where_the_device_is_optional_the_processor_steps_in(void **state)
{
    (void)state;
    rig r, here;
    rsv_device_desc desc = device_desc();
    desc.max_bytes = 16 << 10;
    desc.optional = true;
    assert_int_equal(start(&r, "cornell-blocks", &desc), RSV_OK);
    assert_int_equal(start(&here, "cornell-blocks", NULL), RSV_OK);
    assert_mentions(r.f.log, "warning: device: the operator would take");
    size_t bytes = inside(here.solution)->elements->node_count * sizeof(rsv_rgb);
    assert_memory_equal(inside(r.solution)->irradiance, inside(here.solution)->irradiance, bytes);
    finish(&r);
    finish(&here);
}

/// At any launch: an error, or the same answer where the device is optional.
static void a_lost_device_is_an_error_or_none(void **state)
{
    (void)state;
    rig r, here;
    rsv_device_desc desc = device_desc();
    assert_int_equal(start(&here, "cornell-blocks", NULL), RSV_OK);
    size_t nodes = inside(here.solution)->elements->node_count;
    const uint64_t launches[] = { 1, 15, 20, 60 }; // the orders, then a solver
    for (size_t k = 0; k < sizeof launches / sizeof launches[0]; k++) {
        desc.fail_after = launches[k];
        desc.optional = false;
        assert_int_equal(start(&r, "cornell-blocks", &desc), RSV_ERROR_DEVICE);
        assert_mentions(rsv_last_error(), "device: emulated device is lost");
        finish(&r);
        desc.optional = true;
        assert_int_equal(start(&r, "cornell-blocks", &desc), RSV_OK);
        assert_mentions(r.f.log, "warning: device: emulated device is lost");
        assert_true(difference(inside(r.solution)->irradiance, inside(here.solution)->irradiance,
                        nodes) < 1e-5);
        finish(&r);
    }
    finish(&here);
}

// ---- opening -------------------------------------------------------------------------------------

static void a_device_that_is_not_there_is_refused(void **state)
{
    (void)state;
    rsv_device *device = NULL;
    rsv_device_desc desc = rsv_default_device_desc();
    desc.kind = RSV_DEVICE_CUDA;
    if (rsv_device_open(&desc, &device) == RSV_OK) {
        assert_true(strlen(rsv_device_get_info(device)->name) > 0);
        rsv_device_close(device);
        skip(); // there is one
    }
    assert_mentions(rsv_last_error(), "device: ");
    assert_true(strstr(rsv_last_error(), "nvcc") || strstr(rsv_last_error(), "driver"));
}

static void a_device_that_is_too_old_is_refused(void **state)
{
    (void)state;
    rsv_device *device = NULL;
    rsv_device_desc desc = device_desc();
    desc.capability = 6;
    assert_int_equal(rsv_device_open(&desc, &device), RSV_ERROR_UNSUPPORTED);
    assert_null(device);
    assert_mentions(rsv_last_error(),
        "device: emulated device has compute capability 6.0; it takes 7.0 or newer");
    desc.capability = 7;
    assert_int_equal(rsv_device_open(&desc, &device), RSV_OK);
    assert_string_equal(rsv_device_get_info(device)->capability, "7.0");
    rsv_device_close(device);
}

/// Whether a real device can be tested; says why not.
static bool is_there(void)
{
    rsv_device *device = NULL;
    rsv_device_desc desc = device_desc();
    if (rsv_device_open(&desc, &device) != RSV_OK) {
        printf("skipped: %s\n", rsv_last_error());
        return false;
    }
    rsv_device_close(device);
    return true;
}

int main(int argc, char **argv)
{
    const struct CMUnitTest any[] = {
        cmocka_unit_test(products_are_those_of_the_processor),
        cmocka_unit_test(a_product_moves_each_of_its_arrays_once_at_least),
        cmocka_unit_test(solvers_find_what_those_of_the_processor_find),
        cmocka_unit_test(solutions_are_those_of_the_processor),
        cmocka_unit_test(relit_receivers_get_every_light_times_its_scale),
        cmocka_unit_test(a_device_that_is_too_small_is_an_error_that_says_how_small),
        cmocka_unit_test(memory_of_the_host_that_runs_out_is_an_error_and_nothing_leaks),
        cmocka_unit_test(less_may_go_well_after_too_much),
        cmocka_unit_test(where_the_device_is_optional_the_processor_steps_in),
    };
    const struct CMUnitTest emulated[] = {
        cmocka_unit_test(a_lost_device_is_an_error_or_none),
        cmocka_unit_test(a_device_that_is_not_there_is_refused),
        cmocka_unit_test(a_device_that_is_too_old_is_refused),
    };
    if (argc > 1 && strcmp(argv[1], "cuda") == 0) kind = RSV_DEVICE_CUDA;
    if (!is_there()) return SKIPPED;
    int failures = cmocka_run_group_tests(any, NULL, NULL);
    if (kind == RSV_DEVICE_EMULATED) failures += cmocka_run_group_tests(emulated, NULL, NULL);
    return failures;
}
