/// Automatic exposure of pictures.
#include "scene_fixture.h"

#include "resolvent/image.h"

#include <float.h>

enum { WIDTH = 40, HEIGHT = 25 };

static rsv_image *new_picture(fixture *f, float value)
{
    rsv_image *image;
    assert_int_equal(rsv_image_create(f->context, WIDTH, HEIGHT, 1, &image), RSV_OK);
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        rsv_image_pixels(image, 0)[i] = rgb(value, value, value);
    return image;
}

static void well_lit_pictures_stay_as_they_are(void **state)
{
    for (float value = 0.14f; value < 0.36f; value += 0.02f) {
        rsv_image *image = new_picture(*state, value);
        assert_true(rsv_image_exposure(image) == 0);
        rsv_image_destroy(image);
    }
}

/// To the nearer end of the range, in steps of a 20th of a stop.
static void others_are_brought_there_steadily(void **state)
{
    float before = 100;
    for (float stops = -40; stops < 40; stops += 0.21f) {
        rsv_image *image = new_picture(*state, exp2f(stops));
        float change = rsv_image_exposure(image), shown = exp2f(stops + change);
        assert_true(change <= before);
        before = change;
        assert_true(shown > 0.13f * 0.98f && shown < 0.36f * 1.02f);
        assert_float_equal(change * 20, roundf(change * 20), 1e-4);
        rsv_image_destroy(image);
    }
}

static void black_pictures_and_what_is_no_number_are_shown_as_they_are(void **state)
{
    const float values[] = { 0, -1, NAN, INFINITY };
    for (size_t k = 0; k < sizeof values / sizeof *values; k++) {
        rsv_image *image = new_picture(*state, values[k]);
        assert_true(rsv_image_exposure(image) == 0);
        rsv_image_destroy(image);
    }
}

/// Black backgrounds, visible lamps and dark corners do not get too much weight.
static void a_few_pixels_change_little(void **state)
{
    static const float few[] = { 0, 1e-30f, 1e6f, FLT_MAX, NAN };
    rsv_image *plain = new_picture(*state, 0.01f);
    float expected = rsv_image_exposure(plain);
    for (size_t k = 0; k < sizeof few / sizeof *few; k++) {
        rsv_image *image = new_picture(*state, 0.01f);
        for (int i = 0; i < WIDTH * HEIGHT / 100; i++)
            rsv_image_pixels(image, 0)[i] = rgb(few[k], few[k], few[k]);
        assert_true(fabsf(rsv_image_exposure(image) - expected) < 1.5f);
        rsv_image_destroy(image);
    }
    rsv_image_destroy(plain);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(well_lit_pictures_stay_as_they_are),
        cmocka_unit_test(others_are_brought_there_steadily),
        cmocka_unit_test(black_pictures_and_what_is_no_number_are_shown_as_they_are),
        cmocka_unit_test(a_few_pixels_change_little),
    };
    return cmocka_run_group_tests(tests, fixture_setup, fixture_teardown);
}
