/// The filter of noisy pictures: it takes what noise is known to be there, and nothing else.
#include "denoise/denoise.h"
#include "light_fixture.h"
#include "picture_judge.h"
#include "resolvent/render.h"

#include "core/sampling.h"

enum { PIXELS = 160 * 160 };

/// Two halves of a picture of up to PIXELS pixels, and what the filter makes of them.
typedef struct pictures {
    rsv_rgb picture[2][PIXELS], diffuse[2][PIXELS], albedo[PIXELS], normal[PIXELS], place[PIXELS];
    rsv_rgb filtered[PIXELS], filtered_second[PIXELS]; ///< the first is their mean
    uint32_t width, height;
} pictures;

static rsv_context *new_context(int threads)
{
    rsv_context *context;
    rsv_context_desc desc = rsv_default_context_desc();
    desc.thread_count = threads;
    assert_int_equal(rsv_context_create(&desc, &context), RSV_OK);
    return context;
}

/// A wall seen from the front, without light.
static pictures *new_pictures(uint32_t width, uint32_t height)
{
    pictures *p = calloc(1, sizeof *p);
    assert_non_null(p);
    p->width = width;
    p->height = height;
    for (size_t k = 0; k < PIXELS; k++) {
        p->albedo[k] = rgb_gray(0.5f);
        p->normal[k] = rgb(0, 0, 1);
        p->place[k] = rgb(0.25f, 0, 0);
    }
    return p;
}

static float gaussian(rsv_random *random)
{
    float u = rsv_random_float(random), v = rsv_random_float(random);
    return sqrtf(-2 * logf(1 - u)) * cosf(2 * RSV_PI * v);
}

/// Adds noise of a standard deviation to both halves, of light that is reflected diffusely or not.
static void add_noise(pictures *p, float deviation, bool diffuse)
{
    for (int half = 0; half < 2; half++)
        for (size_t k = 0; k < (size_t)p->width * p->height; k++) {
            rsv_random random = rsv_random_from((uint32_t)k, (uint32_t)half, 5);
            rsv_rgb noise = rgb(deviation * gaussian(&random), deviation * gaussian(&random),
                deviation * gaussian(&random));
            if (diffuse) noise = rgb_mul(noise, p->albedo[k]);
            p->picture[half][k] = rgb_add(p->picture[half][k], noise);
            if (diffuse) p->diffuse[half][k] = rgb_add(p->diffuse[half][k], noise);
        }
}

/// Light of irradiance pi times `light` at a pixel, in both halves.
static void set_light(pictures *p, size_t pixel, float light)
{
    for (int half = 0; half < 2; half++)
        p->picture[half][pixel] = p->diffuse[half][pixel] = rgb_scale(p->albedo[pixel], light);
}

static void run(pictures *p, int threads)
{
    rsv_context *context = new_context(threads);
    rsv_denoise_half half[2];
    for (int k = 0; k < 2; k++)
        half[k] =
            (rsv_denoise_half){ p->picture[k], p->diffuse[k], p->albedo, p->normal, p->place };
    rsv_rgb *const filtered[2] = { p->filtered, p->filtered_second };
    assert_int_equal(rsv_denoise(context, p->width, p->height, half, filtered), RSV_OK);
    for (size_t k = 0; k < (size_t)p->width * p->height; k++)
        p->filtered[k] = rgb_positive(rgb_scale(rgb_add(filtered[0][k], filtered[1][k]), 0.5f));
    rsv_context_destroy(context);
}

static void a_picture_without_noise_stays_as_it_is(void **state)
{
    (void)state;
    pictures *p = new_pictures(70, 40);
    for (size_t k = 0; k < 2800; k++) {
        rsv_random random = rsv_random_from((uint32_t)k, 0, 1);
        p->albedo[k] = rgb(rsv_random_float(&random), rsv_random_float(&random), 0);
        set_light(p, k, 100 * rsv_random_float(&random));
        float other = rsv_random_float(&random);
        for (int half = 0; half < 2; half++)
            p->picture[half][k] = rgb_add(p->picture[half][k], rgb_gray(other));
    }
    run(p, 2);
    for (size_t k = 0; k < 2800; k++) {
        rsv_rgb off = rgb_sub(p->filtered[k], p->picture[0][k]);
        assert_true(rgb_max(off) <= 1e-5f * rgb_max(p->picture[0][k]));
        assert_true(-rgb_max(rgb_scale(off, -1)) >= -1e-5f * rgb_max(p->picture[0][k]));
    }
    free(p);
}

/// Mean of the red channel and of the squares of its deviations over a part of the picture.
static void look(const pictures *p, uint32_t left, uint32_t right, double truth, double found[2])
{
    double sum = 0, squares = 0, count = 0;
    for (uint32_t y = 8; y + 8 < p->height; y++)
        for (uint32_t x = left; x < right; x++) {
            double value = p->filtered[(size_t)y * p->width + x].r;
            sum += value;
            squares += (value - truth) * (value - truth);
            count++;
        }
    found[0] = sum / count;
    found[1] = squares / count;
}

/// The mean of both halves has half of a half's variance, and the mean of the 11 x 11 pixels around it a 121st of that.
/// Patches of 25 pixels whose differences have a standard deviation of a third of what counts as 1 leave weights that
/// make it a little more.
static void noise_falls_by_the_pixels_that_are_alike(void **state)
{
    (void)state;
    for (int diffuse = 0; diffuse < 2; diffuse++) {
        pictures *p = new_pictures(160, 160);
        for (size_t k = 0; k < PIXELS; k++)
            set_light(p, k, 2);
        add_noise(p, 0.2f, diffuse);
        run(p, 2);
        double found[2], variance = 0.5 * 0.2 * 0.2 * (diffuse ? 0.25 : 1);
        look(p, 8, 152, 1, found);
        print_message("variance falls to 1 / %.1f, mean %.5f\n", variance / found[1], found[0]);
        assert_true(found[1] < variance / 121 * 1.5);
        assert_true(found[1] > variance / 121 * 0.7);
        assert_true(fabs(found[0] - 1) < 2e-3);
        free(p);
    }
}

/// An edge of a shadow, on one surface, that is five times the noise.
static void an_edge_of_light_stays(void **state)
{
    (void)state;
    pictures *p = new_pictures(160, 160);
    for (size_t k = 0; k < PIXELS; k++)
        set_light(p, k, k % 160 < 80 ? 1 : 2);
    add_noise(p, 0.2f, true);
    run(p, 2);
    double left[2], right[2];
    look(p, 79, 80, 0.5, left);
    look(p, 80, 81, 1, right);
    print_message("beside the edge: %.4f %.4f\n", left[0], right[0]);
    assert_true(fabs(left[0] - 0.5) < 0.01);
    assert_true(fabs(right[0] - 1) < 0.01);
    free(p);
}

/// Faint differences of light end at edges of surfaces; textures do not matter.
static void surfaces_and_textures_stay(void **state)
{
    (void)state;
    pictures *p = new_pictures(160, 160);
    for (size_t k = 0; k < PIXELS; k++) {
        bool right = k % 160 >= 80;
        p->albedo[k] = rgb_gray(k / 160 % 2 ? 0.2f : 0.8f);
        if (right) p->place[k].r = 0.3f;
        set_light(p, k, right ? 1.1f : 1);
    }
    add_noise(p, 0.2f, true);
    run(p, 2);
    for (uint32_t x = 79; x < 81; x++) {
        double sum = 0;
        for (uint32_t y = 8; y < 152; y++)
            sum += (double)(p->filtered[y * 160 + x].r / p->albedo[y * 160 + x].r);
        print_message("beside the edge: %.4f\n", sum / 144);
        assert_true(fabs(sum / 144 - (x < 80 ? 1 : 1.1)) < 0.01);
    }
    free(p);
}

static void any_size_and_light_gives_numbers(void **state)
{
    (void)state;
    static const uint32_t sizes[][2] = { { 0, 0 }, { 0, 3 }, { 1, 1 }, { 1, 9 }, { 9, 1 },
        { 65, 17 }, { 3, 40 } };
    static const float lights[] = { 0, 1e-30f, 1, 1e15f };
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
        for (size_t l = 0; l < sizeof lights / sizeof *lights; l++) {
            pictures *p = new_pictures(sizes[s][0], sizes[s][1]);
            size_t count = (size_t)p->width * p->height;
            for (size_t k = 0; k < count; k++) {
                if (k % 3 == 0) p->albedo[k] = rgb_gray(0);
                if (k % 5 == 0) p->place[k] = p->normal[k] = rgb_gray(0);
                set_light(p, k, lights[l]);
            }
            add_noise(p, lights[l], true);
            add_noise(p, lights[l], false);
            run(p, 1);
            for (size_t k = 0; k < count; k++)
                assert_true(isfinite(p->filtered[k].r) && p->filtered[k].r >= 0 &&
                            isfinite(p->filtered[k].g) && isfinite(p->filtered[k].b));
            free(p);
        }
}

static void threads_do_not_matter(void **state)
{
    (void)state;
    pictures *p = new_pictures(150, 100), *q = new_pictures(150, 100);
    for (size_t k = 0; k < 15000; k++) {
        set_light(p, k, 1);
        set_light(q, k, 1);
    }
    add_noise(p, 0.3f, true);
    add_noise(q, 0.3f, true);
    run(p, 1);
    run(q, 3);
    assert_memory_equal(p->filtered, q->filtered, 15000 * sizeof(rsv_rgb));
    free(p);
    free(q);
}

static rsv_image *render(const rsv_light *light, rsv_render_desc desc)
{
    rsv_image *image;
    if (rsv_render(light, &desc, &image) != RSV_OK) fail_msg("%s", rsv_last_error());
    return image;
}

/// A picture of the box with gathered light, at the same number of camera rays: half of the error, the same
/// brightness.
static void a_rendered_picture_gets_better(void **state)
{
    (void)state;
    world *w = world_builtin(2, "cornell-blocks");
    rsv_solve_desc solve = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    solve.direct_level = false;
    rsv_light *light;
    assert_int_equal(rsv_light_create(w->scene, &solve, &light), RSV_OK);
    rsv_render_desc desc = rsv_default_render_desc();
    desc.width = desc.height = 64;
    desc.samples = 16;
    desc.gather_rays = 4;
    rsv_image *judge[2];
    for (uint32_t k = 0; k < 2; k++) {
        desc.seed = 7 + k;
        judge[k] = render(light, desc);
    }
    const rsv_image *const pair[2] = { judge[0], judge[1] };
    const uint32_t layers[2] = { 0 };
    rsv_image_judgement before, after;
    rsv_image_difference difference;
    desc.seed = 1;
    desc.samples = 4;
    rsv_image *noisy = render(light, desc);
    desc.denoise = true;
    rsv_image *filtered = render(light, desc);
    assert_int_equal(rsv_image_layer_count(filtered), 1);
    assert_int_equal(rsv_image_judge(pair, layers, noisy, 0, &before), RSV_OK);
    assert_int_equal(rsv_image_judge(pair, layers, filtered, 0, &after), RSV_OK);
    assert_int_equal(rsv_image_compare(noisy, 0, filtered, 0, &difference), RSV_OK);
    print_message("relative MSE %.5f, filtered %.5f; brightness %.5f\n", before.relative_mse,
        after.relative_mse, difference.mean_ratio);
    assert_true(after.relative_mse < 0.5 * before.relative_mse);
    assert_true(fabs(difference.mean_ratio - 1) < 1e-3);
    desc.layers = true;
    rsv_image *none = NULL;
    assert_int_equal(rsv_render(light, &desc, &none), RSV_ERROR_ARGUMENT);
    assert_null(none);
    rsv_image_destroy(noisy);
    rsv_image_destroy(filtered);
    rsv_image_destroy(judge[0]);
    rsv_image_destroy(judge[1]);
    rsv_light_destroy(light);
    world_end(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_picture_without_noise_stays_as_it_is),
        cmocka_unit_test(noise_falls_by_the_pixels_that_are_alike),
        cmocka_unit_test(an_edge_of_light_stays),
        cmocka_unit_test(surfaces_and_textures_stay),
        cmocka_unit_test(any_size_and_light_gives_numbers),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(a_rendered_picture_gets_better),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
