/// Frames rendered by a device compared with pictures of rsv_render, on an emulated device; `test_gpu_frames cuda` runs
/// the same on a real one.
#include "copies_fixture.h"
#include "frame/frame_device.h"
#include "frame_fixture.h"
#include "resolvent/device.h"

#include <stdio.h>

enum { SKIPPED = 77 };

/// Which device the tests are about.
static rsv_device_kind kind = RSV_DEVICE_EMULATED;

static rsv_device_desc device_desc(void)
{
    rsv_device_desc desc = rsv_default_device_desc();
    desc.kind = kind;
    return desc;
}

static rsv_device *open_device(const rsv_device_desc *desc)
{
    rsv_device *device = NULL;
    assert_int_equal(rsv_device_open(desc, &device), RSV_OK);
    return device;
}

static rsv_light *solve(const world *w) { return solve_for_frames(w, 400, 4000); }

static double luminance_sum(const rsv_rgb *pixel)
{
    double sum = 0;
    for (size_t k = 0; k < pixel_count; k++)
        sum += (double)rgb_luminance(pixel[k]);
    return sum;
}

/// Behind a few curved surfaces, rounding can send a specular path past an edge. This must not affect the mean.
static void compare(
    const rsv_frame_renderer *renderer, uint32_t eye, const rsv_rgb *picture, size_t allowed)
{
    static rsv_rgb shown[pixel_count];
    size_t different = count_different(renderer, eye, picture, shown);
    if (different > allowed) fail_msg("%zu pixels differ", different);
    double exact = luminance_sum(picture);
    assert_true(fabs(luminance_sum(shown) - exact) <= 0.002 * exact);
}

/// Checks that the device, not the CPU, makes the frames of a solution.
static bool is_shown_by_device(const rsv_light *solution)
{
    rsv_light_table table;
    rsv_frame_device *device;
    rsv_frame_desc desc = frame_desc();
    assert_int_equal(rsv_light_table_create(rsv_light_get_view(solution), NULL, &table), RSV_OK);
    assert_int_equal(rsv_frame_device_create(&table, &desc, &device), RSV_OK);
    bool made = device != NULL;
    rsv_frame_device_destroy(device);
    rsv_light_table_destroy(&table);
    return made;
}

/// Frames of one or two eyes.
static void check_frames(world *w, uint32_t samples, uint32_t eyes, size_t allowed)
{
    rsv_light *solution = solve(w);
    rsv_frame_desc desc = frame_desc();
    rsv_frame_renderer *renderer;
    rsv_frame_view view = view_of(w);
    rsv_frame_stats stats;
    desc.eyes = eyes;
    assert_true(is_shown_by_device(solution));
    assert_int_equal(rsv_frame_renderer_create(solution, &desc, &renderer), RSV_OK);
    for (uint32_t eye = 0; eye < 2 && eyes == 2; eye++)
        view.camera[eye] = rsv_camera_eye(&view.camera[eye], eye, 0.063f);
    for (uint32_t k = 0; k < samples; k++)
        assert_int_equal(rsv_frame_render(renderer, &view, &stats), RSV_OK);
    for (uint32_t eye = 0; eye < eyes; eye++) {
        rsv_image *picture = render_picture(solution, &view.camera[eye], samples, false);
        compare(renderer, eye, rsv_image_const_pixels(picture, 0), allowed);
        rsv_image_destroy(picture);
        assert_int_equal(rsv_frame_pixels(renderer, eye)[17][3], 255);
    }
    rsv_frame_renderer_destroy(renderer);
    rsv_light_destroy(solution);
    world_end(w);
}

// ---- the same picture ---------------------------------------------------------------------------

static void frames_are_the_pictures_of_the_processor(void **state)
{
    (void)state;
    rsv_device_desc desc = device_desc();
    rsv_device *device = open_device(&desc);
    check_frames(world_builtin_on(2, device, "cornell-blocks"), 3, 1, 0);
    check_frames(world_builtin_on(2, device, "cornell-blocks"), 1, 2, 0);
    check_frames(world_builtin_on(2, device, "cornell-spheres"), 2, 1, pixel_count / 200);
    check_frames(create_copied_room(device, MIXED), 1, 1, 0);
    check_frames(create_copied_room(device, INSIDE), 1, 1, 0);
    rsv_device_close(device);
}

/// A mirror, a back side, a thin sheet, a sky, a lamp that cameras see less of, and a camera inside glass that dims.
static world *mixed_world(rsv_device *device, bool inside)
{
    world *w = world_begin_on(2, device);
    rsv_material sheet = glass_material(), dim_glass = glass_material();
    sheet.thickness = 0;
    sheet.base_color = rgb(0.5f, 0.9f, 0.9f);
    sheet.opacity = 0.7f;
    dim_glass.attenuation_color = rgb(0.9f, 0.5f, 0.7f);
    dim_glass.attenuation_distance = 1;
    rsv_material lamp = rsv_default_material();
    lamp.specular = 0;
    lamp.base_color = rgb_gray(0);
    lamp.emission = rgb_gray(5);
    lamp.double_sided = true;
    lamp.camera_emission = 0.3f;
    uint32_t white = world_lambert(w, 0.7f, 0);
    world_quad(w, white, v3(-3, -1, 3), v3(3, -1, 3), v3(3, -1, -3), v3(-3, -1, -3));
    world_quad(w, world_material(w, lamp), v3(-1, 2, -1), v3(1, 2, -1), v3(1, 2, 1), v3(-1, 2, 1));
    world_quad(w, white, v3(2, -1, 0), v3(2, 1, 0), v3(1, 1, -1), v3(1, -1, -1));
    world_quad(w, world_material(w, sheet), v3(0, -1, 1), v3(1, -1, 1), v3(1, 0, 1), v3(0, 0, 1));
    world_box(w, world_material(w, mirror_material(0.9f)), v3(-2, -1, -2), v3(-1, 1, -1));
    if (inside) world_sphere(w, world_material(w, dim_glass), v3(0, 0.5f, 5), 1.5f, 3);
    rsv_camera camera = rsv_camera_look_at("front", v3(0, 0.5f, 5), v3(0, 0, 0), 0.9f, 1);
    rsv_rgb sky[2] = { { 0.5f, 0.6f, 0.9f }, { 0.2f, 0.2f, 0.1f } };
    rsv_environment environment = { .pixels = sky, .width = 1, .height = 2, .intensity = 1 };
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    assert_int_equal(rsv_scene_set_environment(w->scene, &environment), RSV_OK);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    return w;
}

static void mirrors_sheets_skies_and_glass_are_shown(void **state)
{
    (void)state;
    rsv_device_desc desc = device_desc();
    rsv_device *device = open_device(&desc);
    check_frames(mixed_world(device, false), 2, 1, pixel_count / 200);
    check_frames(mixed_world(device, true), 1, 1, pixel_count / 200);
    rsv_device_close(device);
}

/// Memory for a few hundred branches only: waves go in many parts.
static void small_memory_changes_nothing(void **state)
{
    (void)state;
    rsv_device_desc desc = device_desc();
    desc.max_bytes = (size_t)12 << 20;
    rsv_device *device = open_device(&desc);
    check_frames(world_builtin_on(2, device, "cornell-spheres"), 1, 1, pixel_count / 200);
    rsv_device_close(device);
}

static void layers_are_shown(void **state)
{
    (void)state;
    rsv_device_desc device_settings = device_desc();
    rsv_device *device = open_device(&device_settings);
    world *w = world_builtin_on(2, device, "cornell-blocks");
    rsv_light *solution = solve(w);
    rsv_frame_desc desc = frame_desc();
    rsv_frame_renderer *renderer;
    rsv_frame_view view = view_of(w);
    rsv_image *picture = render_picture(solution, NULL, 1, true);
    assert_int_equal(rsv_frame_renderer_create(solution, &desc, &renderer), RSV_OK);
    for (uint32_t layer = 0; layer < 3; layer++) {
        rsv_frame_renderer_show(renderer, layer);
        assert_int_equal(rsv_frame_render(renderer, &view, NULL), RSV_OK);
        compare(renderer, 0, rsv_image_const_pixels(picture, 1 + layer), 0);
    }
    rsv_image_destroy(picture);
    rsv_frame_renderer_destroy(renderer);
    rsv_light_destroy(solution);
    world_end(w);
    rsv_device_close(device);
}

// ---- textures and rough lobes -------------------------------------------------------------------

/// A square of two metres that faces +z.
static void add_textured(
    world *w, rsv_material m, rsv_vec3 centre, const rsv_texture_role *role, size_t role_count)
{
    rsv_vec3 corner[4] = { { -1, 1, 0 }, { -1, -1, 0 }, { 1, -1, 0 }, { 1, 1, 0 } };
    for (int k = 0; k < 4; k++)
        corner[k] = v3_add(corner[k], centre);
    world_pattern(w, m, corner, role, role_count);
}

/// Textures in most roles, a lattice, metal, marble, frosted glass, varnish and velvet, under a lamp, a sky and a point
/// light.
/// @param device NULL = the CPU
static world *textured_world(rsv_device *device)
{
    static const rsv_texture_role paint[] = { RSV_TEXTURE_BASE_COLOR, RSV_TEXTURE_NORMAL },
                                  metal[] = { RSV_TEXTURE_METALLIC_ROUGHNESS,
                                      RSV_TEXTURE_BASE_COLOR };
    world *w = world_begin_on(2, device);
    rsv_material marble, plain = rsv_default_material(), shiny = mirror_material(1),
                         frosted = glass_material(), velvet = rsv_default_material();
    shiny.metallic = shiny.roughness = 0.7f;
    frosted.roughness = 0.3f;
    velvet.sheen_color = rgb(0.6f, 0.2f, 0.3f);
    velvet.clearcoat = 0.5f;
    velvet.clearcoat_roughness = 0.2f;
    uint32_t white = world_lambert(w, 0.7f, 0);
    world_quad(w, white, v3(-4, -1, 3), v3(4, -1, 3), v3(4, -1, -3), v3(-4, -1, -3));
    world_quad(w, world_lambert(w, 0, 5), v3(-1, 3, -1), v3(1, 3, -1), v3(1, 3, 1), v3(-1, 3, 1));
    add_textured(w, plain, v3(-2.1f, 0, -1), paint, 2);
    add_textured(w, shiny, v3(0, 0, -2), metal, 2);
    world_screen(w, 2, v3(1.1f, 1, -1), v3(1.1f, -1, -1), v3(3.1f, -1, -1), v3(3.1f, 1, -1));
    world_lattice(w, v3(-2, 0, 1.5f), v3(-2, -1, 1.5f), v3(0, -1, 1.5f), v3(0, 0, 1.5f));
    world_sphere(w, world_material(w, frosted), v3(-0.9f, -0.4f, 0.5f), 0.6f, 2);
    world_sphere(w, world_material(w, velvet), v3(0.9f, -0.4f, 0.5f), 0.6f, 2);
    assert_true(rsv_material_preset("marble", &marble));
    world_box(w, world_material(w, marble), v3(-0.4f, -1, 1.2f), v3(0.4f, -0.5f, 1.6f));
    rsv_camera camera = rsv_camera_look_at("front", v3(0, 0.5f, 5), v3(0, 0, 0), 0.9f, 1);
    rsv_rgb sky[2] = { { 0.5f, 0.6f, 0.9f }, { 0.2f, 0.2f, 0.1f } };
    rsv_environment environment = { .pixels = sky, .width = 1, .height = 2, .intensity = 1 };
    rsv_punctual_light bulb = {
        .kind = RSV_PUNCTUAL_POINT, .position = v3(0, 1.5f, 2), .intensity = rgb(2, 2, 3)
    };
    assert_int_equal(rsv_scene_add_light(w->scene, &bulb), RSV_OK);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    assert_int_equal(rsv_scene_set_environment(w->scene, &environment), RSV_OK);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    return w;
}

/// The mean of eight frames. @param radiance [pixel_count] out
static void show_textured(rsv_device *device, rsv_rgb *radiance)
{
    world *w = textured_world(device);
    rsv_light *solution = solve(w);
    rsv_frame_desc desc = frame_desc();
    rsv_frame_renderer *renderer;
    rsv_frame_view view = view_of(w);
    if (device) assert_true(is_shown_by_device(solution));
    assert_int_equal(rsv_frame_renderer_create(solution, &desc, &renderer), RSV_OK);
    for (int k = 0; k < 8; k++)
        assert_int_equal(rsv_frame_render(renderer, &view, NULL), RSV_OK);
    rsv_frame_radiance(renderer, 0, radiance);
    rsv_frame_renderer_destroy(renderer);
    rsv_light_destroy(solution);
    world_end(w);
}

/// With the same random numbers, the picture is the same, except where rounding sends a ray past an edge.
static void textures_and_rough_lobes_are_shown(void **state)
{
    (void)state;
    static rsv_rgb there[pixel_count], here[pixel_count];
    rsv_device_desc desc = device_desc();
    rsv_device *device = open_device(&desc);
    show_textured(device, there);
    show_textured(NULL, here);
    size_t different = 0;
    for (size_t k = 0; k < pixel_count; k++) {
        double a = (double)rgb_luminance(there[k]), b = (double)rgb_luminance(here[k]);
        different += fabs(a - b) > 1e-3 * (1 + b);
    }
    double exact = luminance_sum(here);
    assert_true(exact > 0.1 * pixel_count);
    assert_true(fabs(luminance_sum(there) - exact) <= 0.002 * exact);
    if (different > pixel_count / 50) fail_msg("%zu pixels differ", different);
    rsv_device_close(device);
}

// ---- what the device cannot do ------------------------------------------------------------------

static void a_device_too_small_for_frames_is_an_error_or_none(void **state)
{
    (void)state;
    for (int optional = 0; optional < 2; optional++) {
        rsv_device_desc desc = device_desc();
        desc.max_bytes = (size_t)640 << 10; // enough to solve with
        desc.optional = optional;
        rsv_device *device = open_device(&desc);
        world *w = world_builtin_on(2, device, "cornell-blocks");
        rsv_light *solution = solve(w);
        rsv_frame_desc small = frame_desc();
        rsv_frame_renderer *renderer = NULL;
        rsv_frame_view view = view_of(w);
        rsv_status status = rsv_frame_renderer_create(solution, &small, &renderer);
        assert_int_equal(status, optional ? RSV_OK : RSV_ERROR_MEMORY);
        if (optional)
            assert_int_equal(rsv_frame_render(renderer, &view, NULL), RSV_OK);
        else
            assert_non_null(strstr(rsv_last_error(), "the scene of the frames would take"));
        rsv_frame_renderer_destroy(renderer);
        rsv_light_destroy(solution);
        world_end(w);
        rsv_device_close(device);
    }
}

/// Frames on a device that is lost sooner or later. @return what the frame says during which that happens
static rsv_status render_until_lost(bool optional)
{
    rsv_device_desc desc = device_desc();
    desc.optional = optional;
    desc.fail_after = 6000; // some hundred of them for the solution
    rsv_device *device = open_device(&desc);
    world *w = world_builtin_on(1, device, "cornell-blocks");
    rsv_light *solution = solve(w);
    rsv_frame_desc small = frame_desc();
    rsv_frame_renderer *renderer;
    rsv_frame_view view = view_of(w);
    rsv_frame_stats stats = { 0 };
    rsv_status status = RSV_OK;
    small.width = small.height = 8;
    assert_true(is_shown_by_device(solution));
    assert_int_equal(rsv_frame_renderer_create(solution, &small, &renderer), RSV_OK);
    uint32_t frames = 0;
    for (; frames < 1000 && status == RSV_OK; frames++)
        status = rsv_frame_render(renderer, &view, &stats);
    assert_true(frames > 1);
    assert_true(!optional || stats.samples < frames); // the sums were lost with the device
    if (!optional) assert_non_null(strstr(rsv_last_error(), "is lost"));
    rsv_frame_renderer_destroy(renderer);
    rsv_light_destroy(solution);
    world_end(w);
    rsv_device_close(device);
    return status;
}

static void a_device_lost_between_frames_is_an_error_or_none(void **state)
{
    (void)state;
    assert_int_equal(render_until_lost(false), RSV_ERROR_DEVICE);
    assert_int_equal(render_until_lost(true), RSV_OK);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_are_the_pictures_of_the_processor),
        cmocka_unit_test(mirrors_sheets_skies_and_glass_are_shown),
        cmocka_unit_test(small_memory_changes_nothing),
        cmocka_unit_test(layers_are_shown),
        cmocka_unit_test(textures_and_rough_lobes_are_shown),
        cmocka_unit_test(a_device_too_small_for_frames_is_an_error_or_none),
    };
    const struct CMUnitTest emulated[] = {
        cmocka_unit_test(a_device_lost_between_frames_is_an_error_or_none),
    };
    rsv_device_desc desc;
    rsv_device *device;
    if (argc > 1 && strcmp(argv[1], "cuda") == 0) kind = RSV_DEVICE_CUDA;
    desc = device_desc();
    if (rsv_device_open(&desc, &device) != RSV_OK) {
        printf("skipped: %s\n", rsv_last_error());
        return SKIPPED;
    }
    rsv_device_close(device);
    int failures = cmocka_run_group_tests(tests, NULL, NULL);
    if (kind == RSV_DEVICE_EMULATED) failures += cmocka_run_group_tests(emulated, NULL, NULL);
    return failures;
}
