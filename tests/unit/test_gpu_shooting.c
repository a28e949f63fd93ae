/// Photons shot by a device compared with those of the CPU, on an emulated device; `test_gpu_shooting cuda` runs the
/// same on a real one.
#include "core/device.h"
#include "direct/photons.h"
#include "light_fixture.h"
#include "light_view.h"
#include "resolvent/device.h"

#include <stdio.h>

enum { SKIPPED = 77, PHOTONS = 20000 };

/// Which device the tests are about.
static rsv_device_kind kind = RSV_DEVICE_EMULATED;

static rsv_device *open_device(const rsv_device_desc *wish)
{
    rsv_device *device = NULL;
    rsv_device_desc desc = wish ? *wish : rsv_default_device_desc();
    desc.kind = kind;
    assert_int_equal(rsv_device_open(&desc, &device), RSV_OK);
    return device;
}

/// Elements to land on; the device is not used.
static rsv_light *solve(const world *w)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_light *solution;
    desc.element_target = 300;
    desc.rays_per_element = 64;
    desc.refinements = 0;
    desc.photon_count = 100;
    desc.direct_level = false;
    assert_int_equal(rsv_light_create(w->scene, &desc, &solution), RSV_OK);
    return solution;
}

/// What one shot leaves on two maps.
typedef struct shot {
    rsv_photon_map map[2];
    uint64_t rays;
} shot;

/// @param on_device whether the context's device traces the rays
static rsv_status shoot(const rsv_light *s, bool on_device, shot *found)
{
    const rsv_elements *const elements[2] = { inside(s)->elements, inside(s)->elements };
    rsv_device *device = rsv_context_device(inside(s)->context);
    if (device) device->desc.rows = on_device;
    rsv_status status = rsv_photons_shoot(&inside(s)->scene, inside(s)->lights, PHOTONS, 7,
        &(rsv_photon_targets){ elements, found->map, 2 }, &found->rays);
    if (device) device->desc.rows = false;
    return status;
}

static void destroy_shot(shot *s)
{
    for (int m = 0; m < 2; m++)
        rsv_photon_map_destroy(&s->map[m]);
}

static double flux_of(const rsv_photon_map *map)
{
    double sum = 0;
    for (size_t n = 0; n < map->elements->node_count; n++)
        for (int c = 0; c < 3; c++)
            sum += (double)map->flux[n][c] * map->unit;
    return sum;
}

/// Flux that lies at other nodes, as a share of all: of photons that rounding sends beyond an edge.
static double share_elsewhere(const rsv_photon_map *a, const rsv_photon_map *b)
{
    double off = 0;
    for (size_t n = 0; n < a->elements->node_count; n++)
        for (int c = 0; c < 3; c++)
            off += fabs((double)(a->flux[n][c] - b->flux[n][c])) * a->unit;
    return off / flux_of(b);
}

static void compare(world *w)
{
    rsv_light *s = solve(w);
    size_t nodes = inside(s)->elements->node_count;
    shot here = { .rays = 0 }, there = { .rays = 0 }, again = { .rays = 0 };
    assert_int_equal(shoot(s, false, &here), RSV_OK);
    assert_int_equal(shoot(s, true, &there), RSV_OK);
    assert_int_equal(shoot(s, true, &again), RSV_OK);
    assert_memory_equal(there.map[1].flux, again.map[1].flux, nodes * sizeof *again.map[1].flux);
    assert_memory_equal(there.map[0].flux, there.map[1].flux, nodes * sizeof *again.map[1].flux);
    assert_memory_equal(there.map[0].hits, again.map[0].hits, nodes * sizeof *again.map[0].hits);
    double exact = flux_of(&here.map[0]);
    assert_true(exact > 0);
    assert_true(fabs(flux_of(&there.map[0]) - exact) <= 2e-3 * exact);
    double elsewhere = share_elsewhere(&there.map[0], &here.map[0]);
    if (elsewhere > 0.01) fail_msg("%g of the flux lies elsewhere", elsewhere);
    assert_true(fabs((double)there.rays - (double)here.rays) <= 0.002 * (double)here.rays);
    destroy_shot(&here), destroy_shot(&there), destroy_shot(&again);
    rsv_light_destroy(s);
    world_end(w);
}

// ---- the same light -----------------------------------------------------------------------------

static void glass_focuses_as_on_the_processor(void **state)
{
    (void)state;
    rsv_device *device = open_device(NULL);
    compare(world_builtin_on(2, device, "cornell-spheres"));
    rsv_device_close(device);
}

/// Rough metal, frosted and clear glass, varnish, a lattice; a lamp, a spot, a point, a distant light and a sun.
static world *shiny_world(rsv_device *device)
{
    enum { columns = 64, rows = 32 };
    static rsv_rgb sky[rows * columns];
    world *w = world_begin_on(2, device);
    rsv_material metal = mirror_material(0.9f), frosted = glass_material(),
                 varnish = lambert_material(0.4f, 0);
    metal.roughness = 0.3f;
    frosted.roughness = 0.4f;
    varnish.specular = 1;
    varnish.clearcoat = 1;
    world_room(w, world_lambert(w, 0.6f, 0), v3(-3, 0, -3), v3(3, 0.1f, 3));
    world_quad(w, world_lambert(w, 0, 9), v3(-0.5f, 3, -0.5f), v3(0.5f, 3, -0.5f),
        v3(0.5f, 3, 0.5f), v3(-0.5f, 3, 0.5f));
    world_sphere(w, world_material(w, metal), v3(-1.5f, 0.8f, 0), 0.6f, 3);
    world_sphere(w, world_material(w, frosted), v3(0, 0.8f, 0.8f), 0.6f, 3);
    world_sphere(w, world_material(w, glass_material()), v3(1.5f, 0.8f, 0), 0.6f, 3);
    world_box(w, world_material(w, varnish), v3(-0.3f, 0.2f, -2), v3(0.3f, 1, -1.4f));
    world_lattice(w, v3(-2, 1.8f, -1), v3(-2, 1.8f, 1), v3(1, 1.8f, 1), v3(1, 1.8f, -1));
    const rsv_punctual_light light[] = {
        { .kind = RSV_PUNCTUAL_POINT, .position = { 0, 2, 0 }, .intensity = { 2, 3, 4 } },
        { .kind = RSV_PUNCTUAL_SPOT,
            .position = { 2, 3, 1 },
            .direction = { 0, -1, 0 },
            .intensity = { 20, 30, 10 },
            .inner_cone_angle = 0.3f,
            .outer_cone_angle = 0.6f },
        { .kind = RSV_PUNCTUAL_DIRECTIONAL,
            .direction = v3_normalize(v3(1, -2, 0.5f)),
            .intensity = { 1, 1, 1 } }
    };
    for (size_t k = 0; k < 3; k++)
        assert_int_equal(rsv_scene_add_light(w->scene, &light[k]), RSV_OK);
    for (int k = 0; k < rows * columns; k++)
        sky[k] = rgb_gray(0.1f);
    sky[7 * columns + 40] = rgb(3000, 2500, 2000);
    rsv_environment environment = {
        .pixels = sky, .width = columns, .height = rows, .intensity = 1
    };
    assert_int_equal(rsv_scene_set_environment(w->scene, &environment), RSV_OK);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    return w;
}

static void rough_lobes_pass_light_on_as_on_the_processor(void **state)
{
    (void)state;
    rsv_device *device = open_device(NULL);
    compare(shiny_world(device));
    rsv_device_close(device);
}

// ---- what can go wrong --------------------------------------------------------------------------

/// A shot on a device that may fail.
/// @param fail_after launches after which it fails, once there is a solution; 0 = never
/// @return its status; if the device is optional, the result is that of the CPU
static rsv_status shoot_on(const rsv_device_desc *desc, uint64_t fail_after)
{
    rsv_device *device = open_device(desc);
    world *w = world_builtin_on(1, device, "cornell-spheres");
    rsv_light *s = solve(w);
    shot expected = { .rays = 0 }, found = { .rays = 0 };
    assert_int_equal(shoot(s, false, &expected), RSV_OK);
    device->desc.fail_after = fail_after;
    if (fail_after) assert_int_equal(shoot(s, true, &found), RSV_OK); // one launch
    destroy_shot(&found);
    rsv_status status = shoot(s, true, &found);
    if (status == RSV_OK)
        assert_memory_equal(found.map[0].flux, expected.map[0].flux,
            inside(s)->elements->node_count * sizeof *found.map[0].flux);
    destroy_shot(&expected), destroy_shot(&found);
    rsv_light_destroy(s);
    world_end(w);
    rsv_device_close(device);
    return status;
}

static void a_device_that_is_too_small_says_so_or_is_done_without(void **state)
{
    (void)state;
    rsv_device_desc desc = rsv_default_device_desc();
    desc.max_bytes = (size_t)600 << 10; // enough to solve with
    assert_int_equal(shoot_on(&desc, 0), RSV_ERROR_MEMORY);
    assert_non_null(strstr(rsv_last_error(), "the scene of the photons would take"));
    desc.optional = true;
    assert_int_equal(shoot_on(&desc, 0), RSV_OK);
}

static void a_device_lost_on_the_way_is_an_error_or_none(void **state)
{
    (void)state;
    rsv_device_desc desc = rsv_default_device_desc();
    assert_int_equal(shoot_on(&desc, 1), RSV_ERROR_DEVICE); // more than that have been
    assert_non_null(strstr(rsv_last_error(), "is lost"));
    desc.optional = true;
    assert_int_equal(shoot_on(&desc, 1), RSV_OK);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(glass_focuses_as_on_the_processor),
        cmocka_unit_test(rough_lobes_pass_light_on_as_on_the_processor),
        cmocka_unit_test(a_device_that_is_too_small_says_so_or_is_done_without),
    };
    const struct CMUnitTest emulated[] = {
        cmocka_unit_test(a_device_lost_on_the_way_is_an_error_or_none),
    };
    rsv_device_desc desc = rsv_default_device_desc();
    rsv_device *device;
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
