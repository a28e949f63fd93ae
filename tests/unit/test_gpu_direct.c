/// Direct light computed by a device compared with that of the CPU, on an emulated device; `test_gpu_direct cuda` runs
/// the same on a real one.
#include "core/device.h"
#include "direct/direct.h"
#include "light_fixture.h"
#include "light_view.h"
#include "resolvent/device.h"

#include <stdio.h>

enum { SKIPPED = 77 };

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

/// Elements and their receiver points; the device is not used.
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

/// What one pass finds.
typedef struct pass {
    rsv_rgb *irradiance; ///< [node_count], as the next one
    float *deviation;
    uint64_t rays;
} pass;

static pass begin_pass(const rsv_light *s)
{
    size_t nodes = inside(s)->elements->node_count;
    return (pass){ calloc(nodes, sizeof(rsv_rgb)), calloc(nodes, sizeof(float)), 0 };
}

static void end_pass(pass *p)
{
    free(p->irradiance);
    free(p->deviation);
}

/// @param on_device whether the context's device traces the rays
static rsv_status find(const rsv_light *s, uint32_t samples, bool on_device, pass *p)
{
    rsv_device *device = rsv_context_device(inside(s)->context);
    if (device) device->desc.rows = on_device;
    const rsv_direct_job job = { .scene = &inside(s)->scene,
        .elements = inside(s)->elements,
        .setting = { inside(s)->lights, inside(s)->scene.bsdf, RSV_SUPPORT_POINTS, 7 },
        .samples = samples,
        .valid_points = inside(s)->valid_points };
    rsv_direct_light light = { p->irradiance, p->deviation, 0 };
    rsv_status status = rsv_direct_irradiance(&job, NULL, &light);
    p->rays += light.rays;
    if (device) device->desc.rows = false;
    return status;
}

static double sum_of(const rsv_light *s, const rsv_rgb *value)
{
    double sum = 0;
    for (size_t k = 0; k < inside(s)->elements->node_count; k++)
        sum += (double)rgb_luminance(value[k]);
    return sum;
}

/// Nodes that differ by more than rounding: those with rays within rounding of an edge.
static size_t count_different(const rsv_light *s, const pass *a, const pass *b, double mean)
{
    size_t different = 0;
    for (size_t k = 0; k < inside(s)->elements->node_count; k++) {
        double e = (double)rgb_luminance(b->irradiance[k]);
        double off = fabs((double)rgb_luminance(a->irradiance[k]) - e);
        double deviation = fabs((double)(a->deviation[k] - b->deviation[k]));
        different += off > 1e-5 * (e + mean) || deviation > 1e-3 * (e + mean);
    }
    return different;
}

/// @param samples as in rsv_direct_irradiance
static void compare_pass(const rsv_light *s, uint32_t samples)
{
    pass here = begin_pass(s), there = begin_pass(s), again = begin_pass(s);
    size_t nodes = inside(s)->elements->node_count;
    assert_int_equal(find(s, samples, false, &here), RSV_OK);
    assert_int_equal(find(s, samples, true, &there), RSV_OK);
    assert_int_equal(find(s, samples, true, &again), RSV_OK);
    assert_memory_equal(there.irradiance, again.irradiance, nodes * sizeof(rsv_rgb));
    double exact = sum_of(s, here.irradiance);
    assert_true(exact > 0);
    assert_true(fabs(sum_of(s, there.irradiance) - exact) <= 2e-4 * exact);
    size_t different = count_different(s, &there, &here, exact / (double)nodes);
    if (different > nodes / 100) fail_msg("%zu of %zu nodes differ", different, nodes);
    // one sample more or less where a preview's ray passes an edge
    assert_true(fabs((double)there.rays - (double)here.rays) <= 0.005 * (double)here.rays);
    end_pass(&here), end_pass(&there), end_pass(&again);
}

static void compare(world *w)
{
    rsv_light *s = solve(w);
    compare_pass(s, 32);
    compare_pass(s, 8); // previews, and looks where they see in part
    rsv_light_destroy(s);
    world_end(w);
}

// ---- the same light -----------------------------------------------------------------------------

/// A screen that shines unevenly, the shadow of a lattice, and rough varnish.
static world *screen_world(rsv_device *device)
{
    world *w = world_begin_on(2, device);
    rsv_material varnished = lambert_material(0.5f, 0);
    varnished.clearcoat = 1;
    varnished.clearcoat_roughness = 0.4f;
    uint32_t floor = world_material(w, varnished);
    world_quad(w, floor, v3(-3, 0, 3), v3(3, 0, 3), v3(3, 0, -3), v3(-3, 0, -3));
    world_screen(w, 4, v3(-1, 3, -1), v3(1, 3, -1), v3(1, 3, 1), v3(-1, 3, 1));
    world_lattice(w, v3(-2, 1, -1), v3(-2, 1, 1), v3(1, 1, 1), v3(1, 1, -1));
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    return w;
}

static void screens_shine_through_lattices_as_on_the_processor(void **state)
{
    (void)state;
    rsv_device *device = open_device(NULL);
    compare(screen_world(device));
    rsv_device_close(device);
}

static void lamps_light_as_on_the_processor(void **state)
{
    (void)state;
    rsv_device *device = open_device(NULL);
    compare(world_builtin_on(2, device, "cornell-blocks"));
    rsv_device_close(device);
}

/// A floor, a coated one next to it, a block on both, and a lamp inside tinted glass.
static void build_yard(world *w)
{
    rsv_material coated = lambert_material(0.6f, 0), dim = glass_material();
    coated.specular = 1;
    dim.attenuation_color = rgb(0.9f, 0.5f, 0.7f);
    dim.attenuation_distance = 1;
    world_quad(
        w, world_lambert(w, 0.5f, 0), v3(-4, 0, 4), v3(0, 0, 4), v3(0, 0, -4), v3(-4, 0, -4));
    world_quad(w, world_material(w, coated), v3(0, 0, 4), v3(4, 0, 4), v3(4, 0, -4), v3(0, 0, -4));
    world_box(w, world_lambert(w, 0.3f, 0), v3(-1, 0.1f, -1), v3(1, 2, 1));
    world_box(w, world_material(w, dim), v3(2, -0.5f, 1), v3(3, 1, 3));
}

/// A bright sky, uneven enough to be sampled, and a sun in it.
static world *sunny_world(rsv_device *device)
{
    enum { columns = 64, rows = 32 };
    static rsv_rgb sky[rows * columns];
    world *w = world_begin_on(2, device);
    build_yard(w);
    for (int k = 0; k < rows * columns; k++)
        sky[k] = rgb_gray(k < columns * rows / 2 ? 0.3f : 0.1f);
    for (int row = 6; row < 10; row++)
        for (int column = 10; column < 20; column++)
            sky[row * columns + column] = rgb(6, 5, 4); // a bright cloud
    sky[7 * columns + 40] = rgb(3000, 2500, 2000);
    rsv_environment environment = {
        .pixels = sky, .width = columns, .height = rows, .intensity = 1
    };
    assert_int_equal(rsv_scene_set_environment(w->scene, &environment), RSV_OK);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    return w;
}

static void skies_and_suns_light_as_on_the_processor(void **state)
{
    (void)state;
    rsv_device *device = open_device(NULL);
    world *w = sunny_world(device);
    rsv_light *s = solve(w);
    assert_true(inside(s)->lights->environment->sun_count > 0);
    assert_true(inside(s)->lights->environment->sampler.flux > 0);
    compare_pass(s, 64);
    rsv_light_destroy(s);
    world_end(w);
    rsv_device_close(device);
}

/// One from a point and one from an opening, with all planes around and of type B.
static void add_luminaires(world *w)
{
    float c_planes[5] = { 0, 90, 180, 270, 360 }, gamma[3] = { 0, 45, 90 };
    float round[15] = { 9000, 5000, 0, 9000, 3000, 0, 9000, 6000, 0, 9000, 2000, 0, 9000, 5000, 0 };
    float b_angles[3] = { -90, 0, 90 }, b[9] = { 0, 0, 0, 100, 8000, 3000, 0, 0, 0 };
    const rsv_luminaire luminaire[2] = { { .type = RSV_PHOTOMETRY_C,
                                             .vertical_count = 3,
                                             .horizontal_count = 5,
                                             .vertical = gamma,
                                             .horizontal = c_planes,
                                             .intensity = round,
                                             .width = 0.5,
                                             .length = 1 },
        { .type = RSV_PHOTOMETRY_B,
            .vertical_count = 3,
            .horizontal_count = 3,
            .vertical = b_angles,
            .horizontal = b_angles,
            .intensity = b } };
    for (int k = 0; k < 2; k++) {
        uint32_t id;
        assert_int_equal(rsv_scene_add_luminaire(w->scene, &luminaire[k], &id), RSV_OK);
        rsv_punctual_light light = rsv_luminaire_light(&luminaire[k], id);
        light.position = v3(-1.5f + (float)k, 3.5f, 1.2f);
        assert_int_equal(rsv_scene_add_light(w->scene, &light), RSV_OK);
    }
}

/// @param count of point lights
static void add_lights(world *w, int count)
{
    const rsv_punctual_light spot = { .kind = RSV_PUNCTUAL_SPOT,
        .position = { 2, 4, 1 },
        .direction = { 0, -1, 0 },
        .intensity = { 20, 30, 10 },
        .inner_cone_angle = 0.3f,
        .outer_cone_angle = 0.6f };
    const rsv_punctual_light distant = { .kind = RSV_PUNCTUAL_DIRECTIONAL,
        .direction = v3_normalize(v3(1, -2, 0.5f)),
        .intensity = { 1, 1, 1 } };
    assert_int_equal(rsv_scene_add_light(w->scene, &spot), RSV_OK);
    assert_int_equal(rsv_scene_add_light(w->scene, &distant), RSV_OK);
    for (int k = 0; k < count; k++) {
        rsv_punctual_light point = { .kind = RSV_PUNCTUAL_POINT, .intensity = { 2, 3, 4 } };
        point.position = v3(-3 + 0.7f * (float)(k % 9), 3, -2 + (float)(k / 9));
        assert_int_equal(rsv_scene_add_light(w->scene, &point), RSV_OK);
    }
}

static void points_and_spots_light_as_on_the_processor(void **state)
{
    (void)state;
    rsv_device *device = open_device(NULL);
    for (int count = 3; count < 40; count += 30) { // each of them, or those that a tree picks
        world *w = world_begin_on(2, device);
        build_yard(w);
        add_lights(w, count);
        add_luminaires(w);
        assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
        compare(w);
    }
    rsv_device_close(device);
}

static void many_lamps_light_as_on_the_processor(void **state)
{
    (void)state;
    rsv_device *device = open_device(NULL);
    world *w = world_begin_on(2, device);
    uint32_t lamp = world_lambert(w, 0, 9);
    build_yard(w);
    for (int k = 0; k < 50; k++) {
        float x = -3 + 0.6f * (float)(k % 10), z = -2 + (float)(k / 10);
        world_quad(w, lamp, v3(x, 3, z), v3(x + 0.2f, 3, z), v3(x + 0.2f, 3, z + 0.2f),
            v3(x, 3, z + 0.2f));
    }
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    rsv_light *s = solve(w);
    assert_non_null(inside(s)->lights->emitter_tree);
    compare_pass(s, 64);
    rsv_light_destroy(s);
    world_end(w);
    rsv_device_close(device);
}

// ---- what can go wrong --------------------------------------------------------------------------

/// A pass on a device that fails at some point.
/// @param fail_after launches after which it fails, once there is a solution; 0 = never
/// @return its status; if the device is optional, the result is that of the CPU
static rsv_status find_on(const rsv_device_desc *desc, uint64_t fail_after)
{
    rsv_device *device = open_device(desc);
    world *w = world_builtin_on(1, device, "cornell-blocks");
    rsv_light *s = solve(w);
    pass expected = begin_pass(s), found = begin_pass(s);
    assert_int_equal(find(s, 8, false, &expected), RSV_OK);
    device->desc.fail_after = fail_after;
    rsv_status status = find(s, 8, true, &found);
    if (status == RSV_OK)
        assert_memory_equal(found.irradiance, expected.irradiance,
            inside(s)->elements->node_count * sizeof(rsv_rgb));
    end_pass(&expected), end_pass(&found);
    rsv_light_destroy(s);
    world_end(w);
    rsv_device_close(device);
    return status;
}

static void a_device_that_is_too_small_says_so_or_is_done_without(void **state)
{
    (void)state;
    rsv_device_desc desc = rsv_default_device_desc();
    // the scene takes less, and so does what the solver needs
    desc.max_bytes = sizeof(rsv_bsdf_tables) + ((size_t)165 << 10);
    assert_int_equal(find_on(&desc, 0), RSV_ERROR_MEMORY);
    assert_non_null(strstr(rsv_last_error(), "the receivers of the direct light would take"));
    desc.optional = true;
    assert_int_equal(find_on(&desc, 0), RSV_OK);
}

static void a_device_lost_on_the_way_is_an_error_or_none(void **state)
{
    (void)state;
    rsv_device_desc desc = rsv_default_device_desc();
    assert_int_equal(find_on(&desc, 1), RSV_ERROR_DEVICE); // more than that have been
    assert_non_null(strstr(rsv_last_error(), "is lost"));
    desc.optional = true;
    assert_int_equal(find_on(&desc, 1), RSV_OK);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lamps_light_as_on_the_processor),
        cmocka_unit_test(screens_shine_through_lattices_as_on_the_processor),
        cmocka_unit_test(skies_and_suns_light_as_on_the_processor),
        cmocka_unit_test(points_and_spots_light_as_on_the_processor),
        cmocka_unit_test(many_lamps_light_as_on_the_processor),
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
