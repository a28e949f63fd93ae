/// Rows of G whose rays a device traces compared with those of the CPU, on an emulated device; `test_gpu_rows cuda`
/// runs the same on a real one.
#include "copies_fixture.h"
#include "light_fixture.h"
#include "light_view.h"
#include "resolvent/device.h"

#include <stdio.h>

enum { SKIPPED = 77 };

/// Which device the tests are about.
static rsv_device_kind kind = RSV_DEVICE_EMULATED;

static rsv_device_desc device_desc(void)
{
    rsv_device_desc desc = rsv_default_device_desc();
    desc.kind = kind;
    desc.rows = true;
    return desc;
}

static rsv_device *open_device_as(const rsv_device_desc *desc)
{
    rsv_device *device = NULL;
    assert_int_equal(rsv_device_open(desc, &device), RSV_OK);
    return device;
}

static rsv_device *open_device(void)
{
    rsv_device_desc desc = device_desc();
    return open_device_as(&desc);
}

/// Elements that do not depend on what rows hold.
static rsv_status solve(const world *w, rsv_light **solution)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = 300;
    desc.rays_per_element = 128;
    desc.refinements = 0;
    desc.photon_count = 1000;
    desc.direct_level = false;
    return rsv_light_create(w->scene, &desc, solution);
}

static int compare_columns(const void *left, const void *right)
{
    uint32_t a = *(const uint32_t *)left, b = *(const uint32_t *)right;
    return (a > b) - (a < b);
}

/// Sorts the rows of an operator in place.
static void sort_rows(const rsv_transport *t)
{
    for (size_t row = 0; row < t->row_count; row++) {
        rsv_transport_row entry = rsv_transport_row_at(t, row);
        qsort((uint32_t *)(uintptr_t)entry.column, entry.count, sizeof *entry.column,
            compare_columns);
    }
}

/// Entries that only one of two operators with the same rows has: of rays that pass within rounding of an edge.
static size_t count_different(const rsv_transport *a, const rsv_transport *b)
{
    size_t different = 0;
    sort_rows(a);
    sort_rows(b);
    for (size_t row = 0; row < a->row_count; row++) {
        rsv_transport_row of_a = rsv_transport_row_at(a, row), of_b = rsv_transport_row_at(b, row);
        size_t j = 0, k = 0;
        while (j < of_a.count && k < of_b.count) {
            uint32_t left = of_a.column[j], right = of_b.column[k];
            different += left != right;
            j += left <= right;
            k += right <= left;
        }
        different += of_a.count - j + of_b.count - k;
    }
    return different;
}

static double luminance_sum(const rsv_rgb *value, size_t count)
{
    double sum = 0;
    for (size_t k = 0; k < count; k++)
        sum += (double)rgb_luminance(value[k]);
    return sum;
}

/// Solves both, compares and closes both. @param tolerance of entries that may differ
static void compare(world *here, world *there, double tolerance)
{
    rsv_light *a, *b;
    assert_int_equal(solve(here, &a), RSV_OK);
    assert_int_equal(solve(there, &b), RSV_OK);
    const rsv_transport *g = inside(a)->transport, *h = inside(b)->transport;
    size_t nodes = inside(a)->elements->node_count;
    assert_int_equal(g->row_count, h->row_count);
    assert_memory_equal(g->scale, h->scale, nodes * sizeof *g->scale);
    size_t entries = 0; // of weight 1
    for (size_t row = 0; row < nodes; row++)
        entries += rsv_transport_row_at(g, row).count;
    assert_true(entries > 1000);
    size_t different = count_different(g, h);
    if ((double)different > tolerance * (double)entries)
        fail_msg("%zu of %zu entries differ", different, entries);
    double exact = luminance_sum(inside(a)->irradiance, nodes);
    assert_true(exact > 0);
    assert_true(fabs(luminance_sum(inside(b)->irradiance, nodes) - exact) <= 1e-3 * exact);
    rsv_light_destroy(a);
    rsv_light_destroy(b);
    world_end(here);
    world_end(there);
}

static void check_builtin(const char *name, double tolerance)
{
    rsv_device *device = open_device();
    compare(world_builtin(2, name), world_builtin_on(2, device, name), tolerance);
    rsv_device_close(device);
}

static void rows_are_those_of_the_processor(void **state)
{
    (void)state;
    check_builtin("cornell-blocks", 0.001);
    check_builtin("two-rooms", 0.001);
    rsv_device *device = open_device();
    compare(create_copied_room(NULL, MIXED), create_copied_room(device, MIXED), 0.001);
    rsv_device_close(device);
}

/// A sky that matters, a coat that tints, a mirror, a lattice, a lamp so large that gathering finds it.
static world *open_world(rsv_device *device)
{
    world *w = world_begin_on(2, device);
    rsv_material coated = lambert_material(0.6f, 0);
    coated.specular = 1;
    uint32_t paint = world_material(w, coated);
    world_quad(w, paint, v3(-2, 0, 2), v3(2, 0, 2), v3(2, 0, -2), v3(-2, 0, -2));
    world_quad(w, world_lambert(w, 0.5f, 0), v3(-1, 0, 0), v3(1, 0, 0), v3(1, 1, 0), v3(-1, 1, 0));
    world_quad(w, world_lambert(w, 0, 1), v3(-9, 5, -9), v3(9, 5, -9), v3(9, 5, 9), v3(-9, 5, 9));
    world_box(w, world_material(w, mirror_material(0.9f)), v3(-1, 0, 0.5f), v3(-0.5f, 1, 1));
    world_box(w, world_material(w, glass_material()), v3(0.3f, 0.1f, 0.5f), v3(0.8f, 0.9f, 1));
    world_lattice(w, v3(-2, 1, 1.5f), v3(-2, 0.1f, 1.5f), v3(2, 0.1f, 1.5f), v3(2, 1, 1.5f));
    rsv_rgb sky[2] = { { 0.5f, 0.6f, 0.9f }, { 0.2f, 0.2f, 0.1f } };
    rsv_environment environment = { .pixels = sky, .width = 1, .height = 2, .intensity = 1 };
    assert_int_equal(rsv_scene_set_environment(w->scene, &environment), RSV_OK);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    return w;
}

static void skies_coats_mirrors_and_wide_lamps_count(void **state)
{
    (void)state;
    rsv_device *device = open_device();
    compare(open_world(NULL), open_world(device), 0.002);
    rsv_device_close(device);
}

/// Light through curved glass: what hits differ by in their last places grows from surface to surface.
static void chains_go_on_from_where_the_device_leaves_them(void **state)
{
    (void)state;
    check_builtin("cornell-spheres", 0.02);
}

/// @return the status of a solve on such a device; if the device is optional, the solution is that of the CPU
static rsv_status solve_on(const rsv_device_desc *desc)
{
    rsv_device *device = open_device_as(desc);
    world *w = world_builtin_on(1, device, "cornell-blocks");
    rsv_light *solution;
    rsv_status status = solve(w, &solution);
    if (status == RSV_OK) {
        world *here = world_builtin(1, "cornell-blocks");
        rsv_light *exact;
        assert_int_equal(solve(here, &exact), RSV_OK);
        size_t nodes = inside(exact)->elements->node_count;
        double sum = luminance_sum(inside(exact)->irradiance, nodes);
        assert_true(fabs(luminance_sum(inside(solution)->irradiance, nodes) - sum) <= 1e-5 * sum);
        rsv_light_destroy(exact);
        rsv_light_destroy(solution);
        world_end(here);
    }
    world_end(w);
    rsv_device_close(device);
    return status;
}

static void a_device_that_is_too_small_says_so_or_is_done_without(void **state)
{
    (void)state;
    rsv_device_desc desc = device_desc();
    desc.max_bytes = (size_t)1 << 20;
    assert_int_equal(solve_on(&desc), RSV_ERROR_MEMORY);
    assert_non_null(strstr(rsv_last_error(), "the rays of the rows would take"));
    desc.optional = true;
    assert_int_equal(solve_on(&desc), RSV_OK);
}

static void a_device_lost_among_the_rows_is_an_error_or_none(void **state)
{
    (void)state;
    rsv_device_desc desc = device_desc();
    desc.fail_after = 1;
    assert_int_equal(solve_on(&desc), RSV_ERROR_DEVICE);
    assert_non_null(strstr(rsv_last_error(), "is lost"));
    desc.optional = true;
    assert_int_equal(solve_on(&desc), RSV_OK);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_are_those_of_the_processor),
        cmocka_unit_test(skies_coats_mirrors_and_wide_lamps_count),
        cmocka_unit_test(chains_go_on_from_where_the_device_leaves_them),
        cmocka_unit_test(a_device_that_is_too_small_says_so_or_is_done_without),
    };
    const struct CMUnitTest emulated[] = {
        cmocka_unit_test(a_device_lost_among_the_rows_is_an_error_or_none),
    };
    rsv_device *device;
    rsv_device_desc desc = rsv_default_device_desc();
    if (argc > 1 && strcmp(argv[1], "cuda") == 0) kind = RSV_DEVICE_CUDA;
    desc.kind = kind;
    if (rsv_device_open(&desc, &device) != RSV_OK) {
        printf("skipped: %s\n", rsv_last_error());
        return SKIPPED;
    }
    rsv_device_close(device);
    int failures = cmocka_run_group_tests(tests, NULL, NULL);
    if (kind == RSV_DEVICE_EMULATED) failures += cmocka_run_group_tests(emulated, NULL, NULL);
    return failures;
}
