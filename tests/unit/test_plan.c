/// Pictures planned by error and by time: as accurate as planned, the same for any number of threads, and in time.
#include "light_fixture.h"
#include "plan/allocation.h"
#include "plan/pixel_error.h"
#include "plan/sample_sum.h"
#include "plan/selection.h"
#include "plan/spots.h"
#include "render/picture_series.h"
#include "resolvent/plan.h"
#include "slow_tests.h"

typedef struct planned {
    rsv_light *light;
    rsv_image *image;
    rsv_picture_plan plan;
} planned;

static rsv_render_desc picture_desc(uint32_t size)
{
    rsv_render_desc desc = rsv_default_render_desc();
    desc.mode = RSV_RENDER_FINAL;
    desc.width = desc.height = size;
    return desc;
}

static planned make(const world *w, const rsv_plan_desc *desc, const rsv_render_desc *picture)
{
    planned p = { .light = NULL };
    rsv_status status = rsv_render_planned(w->scene, desc, picture, &p.light, &p.image, &p.plan);
    if (status != RSV_OK) fail_msg("%s", rsv_last_error());
    return p;
}

static void destroy(planned *p)
{
    rsv_image_destroy(p->image);
    rsv_light_destroy(p->light);
}

static rsv_image *path_traced(const world *w, uint32_t size, uint32_t samples, uint32_t seed)
{
    rsv_render_desc desc = picture_desc(size);
    desc.mode = RSV_RENDER_REFERENCE;
    desc.samples = samples;
    desc.seed = seed;
    rsv_image *image;
    assert_int_equal(rsv_render_reference(w->scene, &desc, &image, NULL), RSV_OK);
    return image;
}

/// The noise of the references cancels; the planned error is met within a quarter.
static void a_picture_errs_as_much_as_was_asked_for(void **state)
{
    (void)state;
    enum { size = 64 };
    static const double errors[] = { 0.2, 0.1, 0.05 };
    static const uint32_t layers[2] = { 0 };
    world *w = world_builtin(2, "cornell-blocks");
    rsv_image *judge[2] = { path_traced(w, size, 256, 7), path_traced(w, size, 256, 8) };
    const rsv_image *const pair[2] = { judge[0], judge[1] };
    rsv_render_desc picture = picture_desc(size);
    rsv_plan_desc desc = rsv_default_plan_desc();
    double before = INFINITY;
    uint32_t samples = 0;
    for (size_t k = 0; k < sizeof errors / sizeof errors[0]; k++) {
        desc.relative_error = errors[k];
        planned p = make(w, &desc, &picture);
        rsv_image_judgement found;
        assert_int_equal(rsv_image_judge(pair, layers, p.image, 0, &found), RSV_OK);
        double error = sqrt(found.relative_mse + 2 * found.relative_mse_error);
        print_message("wanted %.3f: %.4f with %u samples, noise %.4f, elements %.4f\n", errors[k],
            error, p.plan.samples, sqrt(p.plan.noise), sqrt(p.plan.elements_error));
        assert_true(error <= 1.25 * errors[k]);
        assert_true(p.plan.is_reached);
        assert_true(error < before);
        assert_true(p.plan.samples >= samples);
        before = error;
        samples = p.plan.samples;
        destroy(&p);
    }
    rsv_image_destroy(judge[0]);
    rsv_image_destroy(judge[1]);
    world_end(w);
}

static void a_plan_does_not_depend_on_threads(void **state)
{
    (void)state;
    rsv_render_desc picture = picture_desc(32);
    rsv_plan_desc desc = rsv_default_plan_desc();
    planned p[2];
    world *w[2];
    for (int k = 0; k < 2; k++) {
        w[k] = world_builtin(k == 0 ? 1 : 3, "cornell-spheres");
        p[k] = make(w[k], &desc, &picture);
    }
    assert_memory_equal(rsv_image_const_pixels(p[0].image, 0),
        rsv_image_const_pixels(p[1].image, 0), sizeof(rsv_rgb) * 32 * 32);
    assert_int_equal(p[0].plan.samples, p[1].plan.samples);
    for (int k = 0; k < 2; k++) {
        destroy(&p[k]);
        world_end(w[k]);
    }
}

static void a_solution_that_is_there_is_used(void **state)
{
    (void)state;
    world *w = world_builtin(2, "cornell-blocks");
    rsv_render_desc picture = picture_desc(32);
    rsv_plan_desc desc = rsv_default_plan_desc();
    planned first = make(w, &desc, &picture);
    rsv_image *second = NULL;
    rsv_light *light = first.light;
    rsv_picture_plan plan;
    assert_int_equal(rsv_render_planned(w->scene, &desc, &picture, &light, &second, &plan), RSV_OK);
    assert_ptr_equal(light, first.light);
    assert_int_equal(plan.rounds, 0);
    rsv_image_destroy(second);
    destroy(&first);
    world_end(w);
}

/// A filtered picture needs fewer samples for its error, which is that of the filtered picture.
static void plans_count_on_the_filter(void **state)
{
    (void)state;
    enum { size = 64 };
    static const uint32_t layers[2] = { 0 };
    world *w = world_builtin(2, "cornell-blocks");
    rsv_light *light = NULL; // of the first picture
    rsv_image *judge[2] = { path_traced(w, size, 128, 7), path_traced(w, size, 128, 8) };
    const rsv_image *const pair[2] = { judge[0], judge[1] };
    rsv_plan_desc desc = rsv_default_plan_desc();
    desc.relative_error = 0.05;
    uint32_t samples[2];
    for (int k = 0; k < 2; k++) {
        rsv_render_desc picture = picture_desc(size);
        rsv_image *image = NULL;
        rsv_picture_plan plan;
        rsv_image_judgement found;
        picture.denoise = k == 1;
        assert_int_equal(
            rsv_render_planned(w->scene, &desc, &picture, &light, &image, &plan), RSV_OK);
        assert_int_equal(rsv_image_judge(pair, layers, image, 0, &found), RSV_OK);
        print_message("%u samples, noise %.5f, relative MSE %.5f +- %.5f\n", plan.samples,
            plan.noise, found.relative_mse, found.relative_mse_error);
        assert_true(found.relative_mse < 1.25 * 0.05 * 0.05 + found.relative_mse_error);
        samples[k] = plan.samples;
        rsv_image_destroy(image);
    }
    assert_true(samples[1] < samples[0]);
    rsv_light_destroy(light);
    rsv_image_destroy(judge[0]);
    rsv_image_destroy(judge[1]);
    world_end(w);
}

/// Not even a coarse solution fits into a millisecond: the picture is path traced.
static void a_limit_of_time_always_has_a_picture(void **state)
{
    (void)state;
    world *w = world_builtin(2, "cornell-blocks");
    rsv_render_desc picture = picture_desc(32);
    rsv_plan_desc desc = rsv_default_plan_desc();
    desc.relative_error = 0;
    desc.max_seconds = 1e-3;
    planned none = make(w, &desc, &picture);
    assert_int_equal(none.plan.mode, RSV_RENDER_REFERENCE);
    assert_null(none.light);
    assert_false(rsv_cancelled(w->context));
    // as long as a solution takes here, beside whatever else runs
    planned some = { 0 };
    for (desc.max_seconds = 1; !some.light && desc.max_seconds < 200; desc.max_seconds *= 3) {
        destroy(&some);
        some = make(w, &desc, &picture);
    }
    assert_int_equal(some.plan.mode, RSV_RENDER_FINAL);
    assert_true(some.plan.samples > none.plan.samples);
    destroy(&none);
    destroy(&some);
    world_end(w);
}

static void impossible_wishes_are_refused(void **state)
{
    (void)state;
    world *w = world_builtin(1, "cornell-blocks");
    rsv_render_desc picture = picture_desc(8);
    rsv_plan_desc desc = rsv_default_plan_desc();
    rsv_light *light = NULL;
    rsv_image *image = NULL;
    desc.relative_error = 1e-3;
    assert_int_equal(
        rsv_render_planned(w->scene, &desc, &picture, &light, &image, NULL), RSV_ERROR_ARGUMENT);
    desc = rsv_default_plan_desc();
    desc.max_seconds = 0;
    assert_int_equal(
        rsv_render_planned(w->scene, &desc, &picture, &light, &image, NULL), RSV_ERROR_ARGUMENT);
    desc = rsv_default_plan_desc();
    picture.mode = RSV_RENDER_OPERATOR;
    assert_int_equal(
        rsv_render_planned(w->scene, &desc, &picture, &light, &image, NULL), RSV_ERROR_ARGUMENT);
    assert_null(image);
    world_end(w);
}

static double mean_of(const rsv_image *image, uint32_t pixels)
{
    double sum = 0;
    for (uint32_t i = 0; i < pixels; i++)
        sum += (double)rgb_luminance(rsv_image_const_pixels(image, 0)[i]);
    return sum / pixels;
}

/// A picture through gather rays, which find the sky too.
static rsv_image *gathered_picture(const planned *p, const rsv_render_desc *picture)
{
    rsv_picture_series *series;
    rsv_image *image;
    rsv_render_desc desc = *picture;
    const rsv_picture_pass pass = { .gathered = RSV_GATHERED_ALL };
    desc.samples = 16;
    desc.gather_rays = 32;
    assert_int_equal(rsv_picture_series_create(p->light, &desc, &series), RSV_OK);
    assert_false(rsv_picture_series_keeps_caustics(series));
    assert_int_equal(rsv_picture_series_take(series, &desc, &pass, &image), RSV_OK);
    rsv_picture_series_destroy(series);
    return image;
}

/// A white sky shines into the open box: light that elements would store.
static void gather_rays_bring_the_light_of_the_sky(void **state)
{
    (void)state;
    enum { size = 16 };
    world *w = world_builtin(2, "cornell-blocks");
    assert_int_equal(rsv_scene_set_builtin_environment(w->scene, "white", 1, 0), RSV_OK);
    rsv_render_desc picture = picture_desc(size);
    rsv_plan_desc desc = rsv_default_plan_desc();
    desc.relative_error = 0.2;
    planned p = make(w, &desc, &picture);
    rsv_image *gathered = gathered_picture(&p, &picture), *truth = path_traced(w, size, 256, 7);
    double found = mean_of(gathered, size * size), actual = mean_of(truth, size * size);
    print_message("gathered %.5f, path traced %.5f\n", found, actual);
    assert_close(found, actual, 0.015 * actual);
    rsv_image_destroy(gathered);
    rsv_image_destroy(truth);
    destroy(&p);
    world_end(w);
}

static void samples_follow_the_noise(void **state)
{
    (void)state;
    const double stratified = RSV_STRATIFIED_FALL, gathered = RSV_GATHERED_FALL;
    assert_int_equal(rsv_samples_for(0, 4, stratified, 100), 1);
    assert_int_equal(rsv_samples_for(1, 4, stratified, 100), 4);
    assert_true(rsv_samples_for(4, 4, stratified, 100) > 8);
    assert_true(rsv_samples_for(4, 4, stratified, 100) < 16);
    assert_int_equal(rsv_samples_for(4, 4, gathered, 100), 16);
    assert_int_equal(rsv_samples_for(1e9, 4, stratified, 100), 100);
}

enum { spot_side = 192, spot_count = 2000, spot_rays = 32 };

/// What a pixel gathers with a few rays: one in a hundred brings 30 % of the light.
static float gathered_light(uint32_t pixel, uint32_t half)
{
    const float part = 0.3f, one_in = 100;
    float sum = 0;
    for (uint32_t ray = 0; ray < spot_rays; ray++) {
        bool spark = rsv_unit_float(rsv_hash3(pixel, half, ray)) * one_in < 1;
        sum += 1 - part + (spark ? one_in * part : 0);
    }
    return sum / spot_rays;
}

/// What spots find of the error of a stored picture that is wrong in some pixels, twice as bright.
static double error_at_spots(
    const world *w, bool (*is_wrong)(uint32_t x, uint32_t y), double *uncertainty)
{
    rsv_image *stored, *gathered[2];
    uint32_t *spots = malloc(sizeof *spots * spot_side * spot_side);
    assert_non_null(spots);
    rsv_choose_spots(spot_side, spot_side, spot_count, 5, 1, spots);
    assert_int_equal(rsv_image_create(w->context, spot_side, spot_side, 1, &stored), RSV_OK);
    for (uint32_t k = 0; k < 2; k++)
        assert_int_equal(
            rsv_image_create(w->context, spot_side, spot_side, 1, &gathered[k]), RSV_OK);
    for (uint32_t i = 0; i < spot_side * spot_side; i++) {
        bool wrong = is_wrong(i % spot_side, i / spot_side);
        rsv_image_pixels(stored, 0)[i] = rgb_gray(wrong ? 2 : 1);
        for (uint32_t k = 0; k < 2 && spots[i]; k++)
            rsv_image_pixels(gathered[k], 0)[i] = rgb_gray(gathered_light(i, k));
    }
    const rsv_image *const a[2] = { stored, stored };
    const rsv_image *const b[2] = { gathered[0], gathered[1] };
    double error = rsv_pixel_error(a, b, (rsv_pixel_error_desc){ INFINITY, a, spots }, uncertainty);
    rsv_image_destroy(stored);
    rsv_image_destroy(gathered[0]);
    rsv_image_destroy(gathered[1]);
    free(spots);
    return error;
}

static bool is_nowhere(uint32_t x, uint32_t y) { return x + y == UINT32_MAX; }
static bool is_on_line(uint32_t x, uint32_t y) { return x % 16 == 8 && y < UINT32_MAX; }
static bool is_point(uint32_t x, uint32_t y) { return x % 6 == 3 && y % 6 == 3; }

/// Skewed noise of gather rays is no error, and errors along lines and at points count as much as wide ones.
static void a_few_pixels_show_the_error_of_elements(void **state)
{
    (void)state;
    static bool (*const wrong[])(uint32_t, uint32_t) = { is_nowhere, is_on_line, is_point };
    static const double share[] = { 0, 1 / 16.0, 1 / 36.0 };
    world *w = world_begin(1);
    for (int k = 0; k < 3; k++) {
        double uncertainty, error = error_at_spots(w, wrong[k], &uncertainty);
        double around = 1 + (k == 1 ? 0.2 : k == 2 ? 1 / 25.0 : 0); // brightness of 5x5 pixels
        double actual = share[k] / (around * around + 0.01);
        print_message("%d: %.4f +- %.4f, actually %.4f\n", k, error, uncertainty, actual);
        assert_true(uncertainty < 0.015);
        assert_close(error, actual, 3 * uncertainty);
    }
    world_end(w);
}

enum { noisy_side = 64 };

/// A picture of 1 that is too bright in a block, and one with the noise of gather rays.
static void fill_pair(rsv_image *stored, rsv_image *gathered, float error, uint32_t seed)
{
    for (uint32_t i = 0; i < noisy_side * noisy_side; i++) {
        uint32_t x = i % noisy_side, y = i / noisy_side;
        bool wrong = x >= 8 && x < 24 && y >= 8 && y < 24;
        float noise = 0.5f * (rsv_unit_float(rsv_hash2(i, seed)) - 0.5f);
        rsv_image_pixels(stored, 0)[i] = rgb_gray(wrong ? 1 + error : 1);
        rsv_image_pixels(gathered, 0)[i] = rgb_gray(1 + noise);
    }
}

/// Of pixels whose error is above the limit, nearly all are chosen, of the others few, whatever the noise.
static void pixels_gather_where_stored_light_is_wrong(void **state)
{
    (void)state;
    world *w = world_begin(1);
    rsv_image *image[4];
    uint8_t chosen[noisy_side * noisy_side];
    for (int k = 0; k < 4; k++)
        assert_int_equal(
            rsv_image_create(w->context, noisy_side, noisy_side, 1, &image[k]), RSV_OK);
    for (int k = 0; k < 2; k++)
        fill_pair(image[k], image[2 + k], 0.3f, 7 + (uint32_t)k);
    const rsv_image *const stored[2] = { image[0], image[1] }, *const truth[2] = { image[2],
        image[3] };
    const rsv_selection_desc desc = { 0.01, 32 };
    double share = rsv_select_pixels(stored, truth, &desc, chosen);
    uint32_t right = 0, all = 0;
    for (uint32_t i = 0; i < noisy_side * noisy_side; i++) {
        uint32_t x = i % noisy_side, y = i / noisy_side;
        all += chosen[i];
        right += chosen[i] && x >= 8 && x < 24 && y >= 8 && y < 24;
    }
    print_message("%u of 256 chosen, %u of the others\n", right, all - right);
    assert_close(share, all / (double)(noisy_side * noisy_side), 1e-12);
    assert_true(right >= 250);
    assert_true(all - right <= 70 + 80); // those around the block see its error too
    for (int k = 0; k < 4; k++)
        rsv_image_destroy(image[k]);
    world_end(w);
}

static bool is_right_half(uint32_t x) { return x >= noisy_side / 2; }
static bool is_edge(uint32_t x) { return x % 8 == 4; }

/// A picture with columns that are `contrast` times as noisy as the others. @param seed of the pass
static rsv_image *noisy_pass(const world *w, uint32_t seed, bool (*is_noisy)(uint32_t x),
    float contrast, const uint32_t *count)
{
    rsv_image *pass;
    assert_int_equal(rsv_image_create(w->context, noisy_side, noisy_side, 1, &pass), RSV_OK);
    for (uint32_t i = 0; i < noisy_side * noisy_side; i++) {
        float deviation = 0.02f * (is_noisy(i % noisy_side) ? contrast : 1), sum = 0;
        uint32_t samples = count ? count[i] : 1;
        for (uint32_t k = 0; k < samples; k++)
            sum += 1 + deviation * sqrtf(12) * (rsv_unit_float(rsv_hash3(i, k, seed)) - 0.5f);
        rsv_image_pixels(pass, 0)[i] = rgb_gray(samples ? sum / (float)samples : 0);
    }
    return pass;
}

/// Mean squared difference from 1.
static double error_of(const rsv_image *image)
{
    double sum = 0;
    for (uint32_t i = 0; i < noisy_side * noisy_side; i++)
        sum += pow((double)rsv_image_const_pixels(image, 0)[i].g - 1, 2);
    return sum / (noisy_side * noisy_side);
}

/// Samples of one of the two passes of an allocation. @param half [noisy_side^2] gets them
static const uint32_t *half_of(const rsv_allocation *found, int k, uint32_t *half)
{
    assert_non_null(half);
    for (uint32_t i = 0; i < noisy_side * noisy_side; i++)
        half[i] = rsv_uneven_half(found->extra[i], k);
    return half;
}

static void add_allocated(
    const world *w, rsv_sample_sum *sum, const rsv_allocation *found, rsv_image *pass[2])
{
    const rsv_uneven_pair uneven = { found->extra, found->renewed, found->fall };
    assert_int_equal(rsv_sample_sum_add_uneven(w->context, sum, &uneven, pass), RSV_OK);
}

/// 62 further samples per pixel on average, where two tell the noise. @return what is left of the error that as many
/// samples everywhere would leave, where independent ones deviate by s and 10 s
static double share_left(const world *w, bool (*is_noisy)(uint32_t x))
{
    const float contrast = 10;
    rsv_sample_sum sum = { 0 };
    rsv_allocation found;
    double even = 0;
    for (uint32_t k = 0; k < 2; k++)
        assert_int_equal(
            rsv_sample_sum_add(w->context, &sum, 1, noisy_pass(w, k, is_noisy, contrast, NULL)),
            RSV_OK);
    assert_int_equal(rsv_allocate_samples(w->context, &sum, 1, 0, 62, &found), RSV_OK);
    assert_close(found.mean, 62, 0.7);
    rsv_image *pass[2];
    uint32_t *half = malloc(sizeof *half * noisy_side * noisy_side);
    for (int k = 0; k < 2; k++)
        pass[k] = noisy_pass(w, 7 + (uint32_t)k, is_noisy, contrast, half_of(&found, k, half));
    free(half);
    add_allocated(w, &sum, &found, pass);
    assert_int_equal(sum.samples, 64);
    for (uint32_t x = 0; x < noisy_side; x++)
        even += pow(0.02 * (is_noisy(x) ? contrast : 1), 2) / noisy_side / 64;
    double error = error_of(sum.mean);
    print_message("%.3g of %.3g, foretold %.3g\n", error, even, found.noise);
    assert_close(error, found.noise, 0.15 * found.noise);
    rsv_allocation_clear(w->context, &found);
    rsv_sample_sum_clear(w->context, &sum);
    return error / even;
}

/// In halves, n and 10 n samples are best: the mean squared error is then 0.6 of what as many everywhere leave. The
/// predicted error must be the actual one, also for lines one pixel wide, whose neighbours are different.
static void samples_go_where_noise_is(void **state)
{
    (void)state;
    world *w = world_begin(1);
    assert_true(share_left(w, is_right_half) < 0.75);
    assert_true(share_left(w, is_edge) < 1);
    world_end(w);
}

/// Outlines of a picture of a room, after one camera ray per pixel. @param out [side^2]
static void find_outlines(const world *w, uint32_t side, uint8_t *is_outline, rsv_image **image)
{
    rsv_light *light;
    rsv_picture_series *series;
    rsv_render_desc desc = picture_desc(side);
    rsv_solve_desc solve = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    solve.element_target = 500;
    assert_int_equal(rsv_light_create(w->scene, &solve, &light), RSV_OK);
    assert_int_equal(rsv_picture_series_create(light, &desc, &series), RSV_OK);
    assert_int_equal(rsv_picture_series_take(series, &desc, NULL, image), RSV_OK);
    assert_int_equal(rsv_picture_series_find_outlines(series, *image, is_outline), RSV_OK);
    rsv_picture_series_destroy(series);
    rsv_light_destroy(light);
}

/// The border of the lamp is found on all sides, nothing is found within walls, and such pixels get their samples.
static void outlines_get_enough_samples(void **state)
{
    (void)state;
    enum { side = noisy_side };
    world *w = world_builtin(2, "cornell-blocks");
    rsv_sample_sum sum = { 0 };
    rsv_allocation found;
    uint32_t number = 0, bright = 0;
    sum.is_outline = rsv_alloc(w->context, side * side, 1);
    for (uint32_t k = 0; k < 2; k++) {
        rsv_image *pass;
        find_outlines(w, side, sum.is_outline, &pass);
        assert_int_equal(rsv_sample_sum_add(w->context, &sum, 1, pass), RSV_OK);
    }
    for (uint32_t k = side; k < side * side - side; k++) {
        const rsv_rgb *pixel = &rsv_image_const_pixels(sum.mean, 0)[k];
        bool lit = pixel->g > 4, below = pixel[side].g > 4;
        if (lit != below) assert_true(sum.is_outline[k] || sum.is_outline[k + side]);
        bright += lit;
        number += sum.is_outline[k];
    }
    print_message("%u of %u pixels are on outlines\n", number, side * side);
    assert_true(bright > 10);
    assert_in_range(number, 4 * side, 12 * side); // the box and its edges, the blocks and the lamp
    assert_int_equal(rsv_allocate_samples(w->context, &sum, 1, 1, 64, &found), RSV_OK);
    for (uint32_t k = 0; k < side * side; k++)
        assert_true(found.extra[k] + 2 >= (sum.is_outline[k] ? RSV_OUTLINE_SAMPLES : 0));
    rsv_allocation_clear(w->context, &found);
    rsv_sample_sum_clear(w->context, &sum);
    world_end(w);
}

/// One column in 16 shows half of its light only in one sample of 40, the rest has little noise.
static rsv_image *rare_pass(const world *w, uint32_t seed, const uint32_t *count)
{
    rsv_image *pass;
    assert_int_equal(rsv_image_create(w->context, noisy_side, noisy_side, 1, &pass), RSV_OK);
    for (uint32_t i = 0; i < noisy_side * noisy_side; i++) {
        uint32_t samples = count ? count[i] : 1;
        float sum = 0;
        for (uint32_t k = 0; k < samples; k++) {
            float u = rsv_unit_float(rsv_hash3(i, k, seed));
            sum += i % 16 == 8 ? 0.5f + (u * 40 < 1 ? 20 : 0) : 0.7f + 0.6f * u;
        }
        rsv_image_pixels(pass, 0)[i] = rgb_gray(samples ? sum / (float)samples : 0);
    }
    return pass;
}

/// Passes of samples where the picture is noisy, until the noise found is as small as was asked for.
static double error_of_rare(const world *w, uint32_t seed, double wanted, double *noise)
{
    rsv_sample_sum sum = { 0 };
    uint32_t *half = malloc(sizeof *half * noisy_side * noisy_side);
    double left = 1;
    for (uint32_t k = 0; k < 2; k++)
        assert_int_equal(
            rsv_sample_sum_add(w->context, &sum, 1, rare_pass(w, seed + k, NULL)), RSV_OK);
    for (uint32_t pass = 2; pass < 10 && left > 0; pass++) {
        rsv_allocation found;
        assert_int_equal(rsv_allocate_samples(w->context, &sum, 1, wanted, 1e6, &found), RSV_OK);
        rsv_image *pair[2];
        left = found.mean;
        for (int k = 0; k < 2 && left > 0; k++)
            pair[k] = rare_pass(w, seed + 2 * pass + (uint32_t)k, half_of(&found, k, half));
        if (left > 0) add_allocated(w, &sum, &found, pair);
        rsv_allocation_clear(w->context, &found);
    }
    double error = error_of(sum.mean);
    *noise = rsv_uneven_noise(&sum);
    print_message(
        "wanted %.4f: %.4f with %u samples, noise %.4f\n", wanted, error, sum.samples, *noise);
    rsv_sample_sum_clear(w->context, &sum);
    free(half);
    return error;
}

/// Most pixels with rare light look calm in their first samples, and the others like sparks.
static void rare_light_errs_as_much_as_was_asked_for(void **state)
{
    (void)state;
    world *w = world_begin(1);
    double wanted = 0.004, sum = 0;
    enum { runs = 4 };
    for (uint32_t k = 0; k < runs; k++) {
        double noise, error = error_of_rare(w, 20 * k, wanted, &noise);
        assert_true(noise < 1.1 * wanted);
        sum += error / runs;
    }
    assert_true(sum < 1.21 * wanted); // 1.1 times in the root
    assert_true(sum > 0.25 * wanted);
    world_end(w);
}

static void plan_room_without_light(bool unlit)
{
    world *w = world_begin(1);
    rsv_material material = lambert_material(0.5f, 0);
    material.unlit = unlit;
    world_room(w, world_material(w, material), v3(0, 0, 0), v3(1, 1, 1));
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    const rsv_camera camera = rsv_camera_frame_sphere("inside", v3(0.5f, 0.5f, 0.5f), 0.1f);
    rsv_render_desc picture = picture_desc(8);
    rsv_plan_desc desc = rsv_default_plan_desc();
    picture.viewpoint = &camera;
    planned p = make(w, &desc, &picture);
    double mean = mean_of(p.image, 8 * 8);
    assert_true(unlit ? mean > 0.1 : mean == 0);
    assert_true((p.light != NULL) == unlit);
    assert_true(p.plan.is_reached);
    destroy(&p);
    world_end(w);
}

/// Scenes without light are not solved, but what shines without lighting anything is seen.
static void nothing_is_solved_without_light(void **state)
{
    (void)state;
    plan_room_without_light(false);
    plan_room_without_light(true);
}

/// The error of light that fog scatters is known too, from gather rays that begin in the air.
static void a_picture_of_fog_errs_as_much_as_was_asked_for(void **state)
{
    (void)state;
    enum { size = 32 };
    static const uint32_t layers[2] = { 0 };
    world *w = world_builtin(2, "cornell-blocks");
    rsv_fog fog = rsv_default_fog();
    fog.extinction = rgb_gray(0.4f);
    fog.albedo = rgb_gray(0.9f);
    assert_int_equal(rsv_scene_set_fog(w->scene, &fog), RSV_OK);
    rsv_image *judge[2] = { path_traced(w, size, 256, 7), path_traced(w, size, 256, 8) };
    const rsv_image *const pair[2] = { judge[0], judge[1] };
    rsv_render_desc picture = picture_desc(size);
    rsv_plan_desc desc = rsv_default_plan_desc();
    desc.relative_error = 0.06;
    planned p = make(w, &desc, &picture);
    rsv_image_judgement found;
    assert_int_equal(rsv_image_judge(pair, layers, p.image, 0, &found), RSV_OK);
    double error = sqrt(found.relative_mse + 2 * found.relative_mse_error);
    print_message("fog, wanted 0.06: %.4f, %u samples, elements %.4f\n", error, p.plan.samples,
        sqrt(p.plan.elements_error));
    assert_false(isnan(p.plan.elements_error));
    assert_true(p.plan.is_reached);
    assert_true(error <= 1.25 * desc.relative_error);
    rsv_image_destroy(judge[0]);
    rsv_image_destroy(judge[1]);
    destroy(&p);
    world_end(w);
}

/// Plans a picture on a solution with too few elements. @return its relative error
static double error_on_few_elements(
    const world *w, double wanted, const rsv_image *const judge[2], rsv_picture_plan *plan)
{
    static const uint32_t layers[2] = { 0 };
    rsv_render_desc picture = picture_desc(rsv_image_width(judge[0]));
    rsv_plan_desc desc = rsv_default_plan_desc();
    rsv_solve_desc coarse = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    planned p = { .light = NULL };
    rsv_image_judgement found;
    coarse.element_target = 100;
    coarse.contact_share = 0.01f;
    coarse.refinements = 0;
    coarse.direct_level = false;
    desc.relative_error = wanted;
    assert_int_equal(rsv_light_create(w->scene, &coarse, &p.light), RSV_OK);
    assert_int_equal(
        rsv_render_planned(w->scene, &desc, &picture, &p.light, &p.image, plan), RSV_OK);
    assert_int_equal(rsv_image_judge(judge, layers, p.image, 0, &found), RSV_OK);
    double error = sqrt(found.relative_mse + 2 * found.relative_mse_error);
    print_message("wanted %g: %.4f, %u samples%s, by elements %.4f\n", wanted, error, plan->samples,
        plan->gathers ? " gathered" : "", sqrt(plan->elements_error));
    destroy(&p);
    return error;
}

/// A solution with too few elements is gathered through where that is what an error takes, but not where more samples
/// make up for them.
static void coarse_solutions_are_gathered_through(void **state)
{
    (void)state;
    enum { size = 48 };
    static const double wanted[] = { 0.04, 0.08 };
    world *w = world_builtin(2, "cornell-blocks");
    rsv_image *judge[2] = { path_traced(w, size, 256, 7), path_traced(w, size, 256, 8) };
    const rsv_image *const pair[2] = { judge[0], judge[1] };
    for (int k = 0; k < 2; k++) {
        rsv_picture_plan plan;
        double error = error_on_few_elements(w, wanted[k], pair, &plan);
        assert_true(plan.gathers == (k == 0));
        assert_true(plan.is_reached);
        assert_true(error <= 1.25 * wanted[k]);
    }
    rsv_image_destroy(judge[0]);
    rsv_image_destroy(judge[1]);
    world_end(w);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_few_pixels_show_the_error_of_elements),
        cmocka_unit_test(a_plan_does_not_depend_on_threads),
        cmocka_unit_test(a_solution_that_is_there_is_used),
        cmocka_unit_test(impossible_wishes_are_refused),
        cmocka_unit_test(gather_rays_bring_the_light_of_the_sky),
        cmocka_unit_test(pixels_gather_where_stored_light_is_wrong),
        cmocka_unit_test(samples_follow_the_noise),
        cmocka_unit_test(plans_count_on_the_filter),
        cmocka_unit_test(samples_go_where_noise_is),
        cmocka_unit_test(outlines_get_enough_samples),
        cmocka_unit_test(nothing_is_solved_without_light),
        cmocka_unit_test(rare_light_errs_as_much_as_was_asked_for),
    };
    const struct CMUnitTest longest[] = {
        cmocka_unit_test(a_picture_errs_as_much_as_was_asked_for),
        cmocka_unit_test(a_picture_of_fog_errs_as_much_as_was_asked_for),
        cmocka_unit_test(coarse_solutions_are_gathered_through),
        cmocka_unit_test(a_limit_of_time_always_has_a_picture),
    };
    return RUN_HALF(argc, argv, tests, longest);
}
