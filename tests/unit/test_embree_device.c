/// One Embree device for all hierarchies of all contexts that use it.
#include "resolvent/resolvent.h"
#include "trace/embree_internal.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <string.h>

#include <cmocka.h>

enum { SIDE = 12 };

static bool count_bytes(void *user, ssize_t bytes, bool post)
{
    (void)post;
    atomic_fetch_add((atomic_llong *)user, bytes);
    return true;
}

/// @param refuse true = there is no memory
static bool refuse_bytes(void *user, ssize_t bytes, bool post)
{
    (void)post;
    atomic_fetch_add((atomic_llong *)user, 1);
    return bytes <= 0;
}

static rsv_context *context_with(RTCDevice device)
{
    rsv_context *context = NULL;
    rsv_context_desc desc = rsv_default_context_desc();
    desc.embree_device = device;
    assert_int_equal(rsv_context_create(&desc, &context), RSV_OK);
    return context;
}

static rsv_status solve(rsv_context *context, rsv_scene **scene, rsv_light **light)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = 60;
    desc.rays_per_element = 64;
    desc.photon_count = 1000;
    assert_int_equal(rsv_scene_builtin(context, "cornell-spheres", scene), RSV_OK);
    return rsv_light_create(*scene, &desc, light);
}

/// @param pixels out, [SIDE * SIDE]
static void show(const rsv_light *light, rsv_rgb *pixels)
{
    rsv_render_desc desc = rsv_default_render_desc();
    rsv_image *image = NULL;
    desc.width = desc.height = SIDE;
    desc.samples = 4;
    assert_int_equal(rsv_render(light, &desc, &image), RSV_OK);
    memcpy(pixels, rsv_image_pixels(image, 0), SIDE * SIDE * sizeof *pixels);
    rsv_image_destroy(image);
}

static void all_hierarchies_are_of_the_device_that_is_given(void **state)
{
    (void)state;
    RTCDevice device = rtcNewDevice("threads=2");
    atomic_llong bytes = 0;
    rsv_context *context[3];
    rsv_scene *scene[3];
    rsv_light *light[3];
    rsv_rgb pixels[3][SIDE * SIDE];
    long long used[3];
    rtcSetDeviceMemoryMonitorFunction(device, count_bytes, &bytes);
    for (int k = 0; k < 3; k++) {
        context[k] = context_with(k < 2 ? device : NULL);
        assert_int_equal(solve(context[k], &scene[k], &light[k]), RSV_OK);
        show(light[k], pixels[k]);
        used[k] = bytes;
    }
    assert_true(used[0] > 1000 && used[1] >= 2 * used[0] - 1000); // both contexts build there
    assert_true(used[2] == used[1]);                              // and the third does not
    assert_memory_equal(pixels[0], pixels[1], sizeof *pixels);
    assert_memory_equal(pixels[0], pixels[2], sizeof *pixels);
    for (int k = 0; k < 3; k++) {
        rsv_light_destroy(light[k]);
        rsv_scene_destroy(scene[k]);
        rsv_context_destroy(context[k]);
    }
    RTCScene empty = rtcNewScene(device); // it is still there
    rtcCommitScene(empty);
    assert_int_equal(rtcGetDeviceError(device), RTC_ERROR_NONE);
    rtcReleaseScene(empty);
    rtcReleaseDevice(device);
    assert_true(bytes == 0);
}

static void errors_are_those_of_the_call(void **state)
{
    (void)state;
    RTCDevice device = rtcNewDevice("threads=1");
    atomic_llong calls = 0;
    rsv_context *context = context_with(device);
    rsv_scene *scene = NULL, *other = NULL;
    rsv_light *light = NULL;
    rtcSetDeviceMemoryMonitorFunction(device, refuse_bytes, &calls);
    assert_int_equal(solve(context, &scene, &light), RSV_ERROR_MEMORY);
    assert_null(light);
    assert_true(calls > 0);
    rtcSetDeviceMemoryMonitorFunction(device, NULL, NULL);
    rtcNewGeometry(device, (enum RTCGeometryType)12345); // the program's own mistake
    assert_int_equal(solve(context, &other, &light), RSV_OK);
    rsv_light_destroy(light);
    rsv_scene_destroy(scene);
    rsv_scene_destroy(other);
    rsv_context_destroy(context);
    rtcReleaseDevice(device);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_hierarchies_are_of_the_device_that_is_given),
        cmocka_unit_test(errors_are_those_of_the_call),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
