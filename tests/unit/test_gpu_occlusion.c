/// Ambient occlusion computed by a device compared with that of the CPU, on an emulated device; `test_gpu_occlusion
/// cuda` runs the same on a real one.
#include "light_fixture.h"
#include "occlusion/occlusion_view.h"
#include "resolvent/device.h"
#include "resolvent/measure.h"

#include <stdio.h>

enum { SKIPPED = 77, width = 48, height = 36, pixel_count = width * height };

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

static rsv_render_desc render_desc(rsv_render_mode mode)
{
    rsv_render_desc desc = rsv_default_render_desc();
    desc.mode = mode;
    desc.width = width;
    desc.height = height;
    desc.samples = 3;
    desc.gather_rays = 20; // not a multiple of the lanes of a packet
    return desc;
}

/// @param by_device whether a device is to make it @param pixel [pixel_count] out
static void render(const world *w, const rsv_render_desc *desc, bool by_device, rsv_rgb *pixel)
{
    rsv_occlusion *occlusion;
    rsv_image *image;
    assert_int_equal(rsv_occlusion_create(w->scene, desc, &occlusion), RSV_OK);
    assert_int_equal(rsv_image_create(w->context, width, height, 1, &image), RSV_OK);
    assert_true(by_device == (occlusion->device != NULL));
    const rsv_camera *camera = rsv_scene_get_view(w->scene)->camera;
    for (int k = 0; k < 2; k++) // the second one begins anew
        assert_int_equal(rsv_occlusion_render(occlusion, camera, image), RSV_OK);
    assert_true(rsv_occlusion_seconds(occlusion) > 0);
    memcpy(pixel, rsv_image_const_pixels(image, 0), pixel_count * sizeof *pixel);
    rsv_image_destroy(image);
    rsv_occlusion_destroy(occlusion);
}

static bool alike(float a, float b) { return fabsf(a - b) <= 1e-5f * (1 + fabsf(b)); }

/// Rays that pass within rounding of an edge may differ; the mean must not.
static void compare(const rsv_rgb *there, const rsv_rgb *here, size_t allowed)
{
    double sum_there = 0, sum_here = 0;
    size_t different = 0;
    for (size_t k = 0; k < pixel_count; k++) {
        sum_there += (double)rgb_luminance(there[k]);
        sum_here += (double)rgb_luminance(here[k]);
        different += !alike(there[k].r, here[k].r) || !alike(there[k].g, here[k].g) ||
                     !alike(there[k].b, here[k].b);
    }
    assert_true(sum_here > 0);
    if (different > allowed) fail_msg("%zu pixels differ", different);
    assert_true(fabs(sum_there - sum_here) <= 0.002 * sum_here);
}

/// Both modes, on a scene that is given without and with a device.
static void check_pictures(world *here, world *there)
{
    static rsv_rgb picture_here[pixel_count], picture_there[pixel_count];
    const rsv_render_mode mode[] = { RSV_RENDER_OCCLUSION, RSV_RENDER_OCCLUSION_SCREEN };
    for (int k = 0; k < 2; k++) {
        rsv_render_desc desc = render_desc(mode[k]);
        render(here, &desc, false, picture_here);
        render(there, &desc, true, picture_there);
        compare(picture_there, picture_here, pixel_count / 100);
    }
    world_end(here);
    world_end(there);
}

// ---- the same picture ---------------------------------------------------------------------------

static void occlusion_is_that_of_the_processor(void **state)
{
    (void)state;
    rsv_device_desc desc = device_desc();
    rsv_device *device = open_device(&desc);
    check_pictures(
        world_builtin(2, "cornell-blocks"), world_builtin_on(2, device, "cornell-blocks"));
    check_pictures(
        world_builtin(2, "cornell-spheres"), world_builtin_on(2, device, "cornell-spheres"));
    rsv_device_close(device);
}

/// A sky, a lamp, something unlit, backs of one and of two sides, a painted lattice.
static world *open_world(rsv_device *device)
{
    world *w = world_begin_on(2, device);
    rsv_material sign = lambert_material(0.4f, 0), leaf = lambert_material(0.6f, 1);
    sign.unlit = true;
    leaf.double_sided = true;
    uint32_t grey = world_lambert(w, 0.5f, 0);
    world_quad(w, grey, v3(-3, -1, 3), v3(3, -1, 3), v3(3, -1, -3), v3(-3, -1, -3));
    world_box(w, grey, v3(-1.5f, -1, -1), v3(-0.5f, 0.5f, 0));
    world_quad(w, grey, v3(1, -1, 0), v3(0, -1, 0), v3(0, 0, 0), v3(1, 0, 0));
    world_quad(w, world_material(w, leaf), v3(2, 0, 1), v3(1, 0, 1), v3(1, 1, 1), v3(2, 1, 1));
    world_quad(w, world_material(w, sign), v3(-1, 1, 0), v3(0, 1, 0), v3(0, 2, 0), v3(-1, 2, 0));
    world_lattice(w, v3(-2, 0, 1), v3(-2, -1, 1), v3(0, -1, 1), v3(0, 0, 1));
    rsv_camera camera = rsv_camera_look_at("front", v3(0, 0.5f, 5), v3(0, 0, 0), 0.9f, 1);
    rsv_rgb sky[2] = { { 0.5f, 0.6f, 0.9f }, { 0.2f, 0.2f, 0.1f } };
    rsv_environment environment = { .pixels = sky, .width = 1, .height = 2, .intensity = 1 };
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    assert_int_equal(rsv_scene_set_environment(w->scene, &environment), RSV_OK);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    return w;
}

static void skies_lamps_and_backs_count(void **state)
{
    (void)state;
    rsv_device_desc desc = device_desc();
    rsv_device *device = open_device(&desc);
    check_pictures(open_world(NULL), open_world(device));
    rsv_device_close(device);
}

// ---- what the device cannot do ------------------------------------------------------------------

/// @return the status of a picture on such a device; if the device is optional, the picture is that of the CPU
static rsv_status render_on(const rsv_device_desc *desc)
{
    rsv_device *device = open_device(desc);
    world *w = world_builtin_on(1, device, "cornell-blocks");
    world *here = world_builtin(1, "cornell-blocks");
    rsv_render_desc picture = render_desc(RSV_RENDER_OCCLUSION);
    static rsv_rgb expected[pixel_count];
    rsv_image *image = NULL;
    rsv_status status = rsv_render_occlusion(w->scene, &picture, &image);
    if (status == RSV_OK) {
        render(here, &picture, false, expected);
        assert_memory_equal(rsv_image_const_pixels(image, 0), expected, sizeof expected);
    }
    rsv_image_destroy(image);
    world_end(here);
    world_end(w);
    rsv_device_close(device);
    return status;
}

static void a_device_that_is_too_small_says_so_or_is_done_without(void **state)
{
    (void)state;
    rsv_device_desc desc = device_desc();
    desc.max_bytes = (size_t)64 << 10;
    assert_int_equal(render_on(&desc), RSV_ERROR_MEMORY);
    assert_non_null(strstr(rsv_last_error(), "the picture of the occlusion would take"));
    desc.max_bytes = 1 << 10;
    assert_int_equal(render_on(&desc), RSV_ERROR_MEMORY);
    assert_non_null(strstr(rsv_last_error(), "the scene of the occlusion would take"));
    desc.optional = true;
    assert_int_equal(render_on(&desc), RSV_OK);
}

static void a_device_lost_in_a_picture_is_an_error_or_none(void **state)
{
    (void)state;
    for (uint64_t launches = 1; launches < 9; launches += 3) { // three of each camera ray
        rsv_device_desc desc = device_desc();
        desc.fail_after = launches;
        assert_int_equal(render_on(&desc), RSV_ERROR_DEVICE);
        assert_non_null(strstr(rsv_last_error(), "is lost"));
        desc.optional = true;
        assert_int_equal(render_on(&desc), RSV_OK);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(occlusion_is_that_of_the_processor),
        cmocka_unit_test(skies_lamps_and_backs_count),
        cmocka_unit_test(a_device_that_is_too_small_says_so_or_is_done_without),
    };
    const struct CMUnitTest emulated[] = {
        cmocka_unit_test(a_device_lost_in_a_picture_is_an_error_or_none),
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
