/// Pictures mixed from one picture per source, compared with pictures of all light together.
#include "frame_fixture.h"
#include "picture_judge.h"
#include "resolvent/lightmix.h"

/// Mode operator shows diffuse surfaces without noise. The remaining difference: each source is sharpened separately,
/// which differs from sharpening their sum at discontinuities (sharpen.h).
#define SAME 1e-3 ///< RMS, relative
#define TOLERANCE 1e-6f

/// A room with a lamp, a bulb and a picture that lights nothing.
static world *lit_room(void)
{
    world *w = world_begin(2);
    rsv_material lamp = lambert_material(0, 5), unlit = lambert_material(0.5f, 0);
    lamp.name = "lamp";
    unlit.unlit = true;
    unlit.base_color = rgb(0.3f, 0.6f, 0.2f);
    world_room(w, world_lambert(w, 0.6f, 0), v3(-3, -2, -3), v3(3, 3, 3));
    world_quad(w, world_material(w, lamp), v3(-1, 2, -1), v3(1, 2, -1), v3(1, 2, 1), v3(-1, 2, 1));
    world_quad(w, world_material(w, unlit), v3(-1, -1, -2.9f), v3(1, -1, -2.9f), v3(1, 0, -2.9f),
        v3(-1, 0, -2.9f));
    rsv_camera camera = rsv_camera_look_at("front", v3(0, 0.5f, 2.5f), v3(0, 0, 0), 0.9f, 1);
    rsv_punctual_light bulb = { .name = "bulb",
        .kind = RSV_PUNCTUAL_POINT,
        .position = { 1.5f, 0, 0.5f },
        .intensity = { 3, 2, 1 } };
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    assert_int_equal(rsv_scene_add_light(w->scene, &bulb), RSV_OK);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    return w;
}

typedef struct stage {
    world *w;
    rsv_light *light;
    rsv_relighter *relighter;
    rsv_light_mix *mix;
    rsv_render_desc desc;
} stage;

static rsv_render_desc picture_desc(rsv_render_mode mode, uint32_t samples)
{
    rsv_render_desc desc = rsv_default_render_desc();
    desc.mode = mode;
    desc.width = width;
    desc.height = height;
    desc.samples = samples;
    return desc;
}

static stage set_stage(rsv_render_mode mode, uint32_t samples, bool prepared)
{
    stage s = { .w = lit_room(), .desc = picture_desc(mode, samples) };
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = 600;
    desc.rays_per_element = 64;
    desc.tolerance = TOLERANCE;
    assert_int_equal(rsv_light_create(s.w->scene, &desc, &s.light), RSV_OK);
    assert_int_equal(rsv_relighter_create(s.light, &s.relighter), RSV_OK);
    if (prepared) assert_int_equal(rsv_relighter_prepare(s.relighter), RSV_OK);
    assert_int_equal(rsv_light_mix_create(s.relighter, &s.desc, &s.mix), RSV_OK);
    return s;
}

static void strike(stage *s)
{
    rsv_light_mix_destroy(s->mix);
    rsv_relighter_destroy(s->relighter);
    rsv_light_destroy(s->light);
    world_end(s->w);
}

static rsv_relight_desc with_factors(rsv_light_scale scale[2], rsv_rgb lamp, rsv_rgb bulb)
{
    scale[0] = (rsv_light_scale){ "lamp", lamp };
    scale[1] = (rsv_light_scale){ "bulb", bulb };
    return (rsv_relight_desc){ .size = sizeof(rsv_relight_desc), .light = scale, .light_count = 2 };
}

static rsv_image *mixed(stage *s, const rsv_relight_desc *change)
{
    rsv_image *image = NULL;
    assert_int_equal(rsv_relighter_change(s->relighter, change), RSV_OK);
    if (rsv_light_mix_take(s->mix, &image) != RSV_OK) fail_msg("%s", rsv_last_error());
    return image;
}

/// The picture of the light itself, as a mix has just left it.
static rsv_image *rendered(const stage *s, uint32_t samples, uint32_t seed)
{
    rsv_image *image = NULL;
    rsv_render_desc desc = s->desc;
    desc.samples = samples;
    desc.seed = seed;
    assert_int_equal(rsv_relighter_settle(s->relighter), RSV_OK);
    rsv_status status = desc.mode == RSV_RENDER_OPERATOR
                            ? rsv_render_operator(s->light, &desc, RSV_GLOSS_PATHS, &image)
                            : rsv_render(s->light, &desc, &image);
    assert_int_equal(status, RSV_OK);
    return image;
}

static void check_same(const rsv_image *a, const rsv_image *b)
{
    rsv_image_difference difference;
    const rsv_rgb *truth = rsv_image_const_pixels(b, 0);
    double squares = 0;
    for (size_t k = 0; k < pixel_count; k++)
        squares +=
            pow((double)truth[k].r, 2) + pow((double)truth[k].g, 2) + pow((double)truth[k].b, 2);
    assert_int_equal(rsv_image_compare(b, 0, a, 0, &difference), RSV_OK);
    double size = sqrt(squares / (3 * pixel_count));
    if (difference.rmse > SAME * size) fail_msg("RMS %g of %g", difference.rmse, size);
}

static void check_mix(stage *s, const rsv_relight_desc *change)
{
    rsv_image *mix = mixed(s, change), *truth = rendered(s, s->desc.samples, 0);
    check_same(mix, truth);
    rsv_image_destroy(mix);
    rsv_image_destroy(truth);
}

static void check_strengths(bool prepared)
{
    static const rsv_rgb factors[][2] = { { { 1, 1, 1 }, { 1, 1, 1 } },
        { { 0.5f, 0.5f, 0.5f }, { 0.5f, 0.5f, 0.5f } }, { { 0.2f, 1, 3 }, { 2, 0, 0.5f } },
        { { 0, 0, 0 }, { 1, 1, 1 } }, { { 1, 1, 1 }, { 0, 0, 0 } }, { { 0, 0, 0 }, { 0, 0, 0 } },
        { { 4, 3, 2 }, { 1, 2, 3 } } };
    static const size_t pictures[] = { 2, 2, 4, 4, 4, 4, 4 }; // that of the unlit surface is one
    stage s = set_stage(RSV_RENDER_OPERATOR, 4, prepared);
    for (size_t k = 0; k < sizeof factors / sizeof factors[0]; k++) {
        rsv_light_scale scale[2];
        rsv_relight_desc change = with_factors(scale, factors[k][0], factors[k][1]);
        check_mix(&s, &change);
        assert_int_equal(rsv_light_mix_rendered(s.mix), pictures[k]);
    }
    strike(&s);
}

static void any_strengths_are_a_sum(void **state)
{
    (void)state;
    check_strengths(true);
    check_strengths(false);
}

/// Sources that are off at first are rendered once they shine. Without any light, pictures are black.
static void sources_are_rendered_when_they_shine(void **state)
{
    (void)state;
    stage s = set_stage(RSV_RENDER_OPERATOR, 4, true);
    rsv_light_scale scale[2];
    rsv_relight_desc change = with_factors(scale, rgb_gray(0), rgb_gray(1));
    check_mix(&s, &change);
    assert_int_equal(rsv_light_mix_rendered(s.mix), 2);
    change = with_factors(scale, rgb_gray(0.5f), rgb_gray(1));
    check_mix(&s, &change);
    assert_int_equal(rsv_light_mix_rendered(s.mix), 3);
    strike(&s);
}

static void moves_and_colors_start_over(void **state)
{
    (void)state;
    stage s = set_stage(RSV_RENDER_OPERATOR, 4, true);
    rsv_light_scale scale[2];
    rsv_relight_desc change = with_factors(scale, rgb_gray(1), rgb_gray(2));
    const rsv_light_move move = { "bulb", { -1, 0.5f, 0 } };
    check_mix(&s, &change);
    size_t before = rsv_light_mix_rendered(s.mix);
    change.move = &move;
    change.move_count = 1;
    assert_int_equal(rsv_relighter_change(s.relighter, &change), RSV_OK);
    assert_int_equal(rsv_relighter_settle(s.relighter), RSV_OK);
    check_mix(&s, &change);
    assert_true(rsv_light_mix_rendered(s.mix) > before);
    strike(&s);
}

/// Mode final: no more error than the picture that is rendered anew.
static void mixed_noise_is_no_more(void **state)
{
    (void)state;
    stage s = set_stage(RSV_RENDER_FINAL, 16, true);
    rsv_light_scale scale[2];
    rsv_relight_desc change = with_factors(scale, rgb(2, 1, 0.5f), rgb(0.5f, 1, 2));
    rsv_image *mix = mixed(&s, &change), *fresh = rendered(&s, 16, 7);
    rsv_image *judge[2] = { rendered(&s, 64, 8), rendered(&s, 64, 9) };
    assert_errs_no_more(judge, mix, fresh);
    for (int k = 0; k < 2; k++)
        rsv_image_destroy(judge[k]);
    rsv_image_destroy(mix);
    rsv_image_destroy(fresh);
    strike(&s);
}

static void unusable_wishes_are_refused(void **state)
{
    (void)state;
    stage s = set_stage(RSV_RENDER_FINAL, 1, false);
    rsv_light_mix *mix = NULL;
    rsv_image *image = NULL;
    rsv_render_desc desc = picture_desc(RSV_RENDER_REFERENCE, 1);
    assert_int_equal(rsv_light_mix_create(s.relighter, &desc, &mix), RSV_ERROR_ARGUMENT);
    desc = picture_desc(RSV_RENDER_FINAL, 1);
    desc.layers = true;
    assert_int_equal(rsv_light_mix_create(s.relighter, &desc, &mix), RSV_ERROR_ARGUMENT);
    desc = picture_desc(RSV_RENDER_FINAL, 0);
    assert_int_equal(rsv_light_mix_create(s.relighter, &desc, &mix), RSV_OK);
    assert_int_equal(rsv_light_mix_take(mix, &image), RSV_ERROR_ARGUMENT);
    assert_null(image);
    rsv_light_mix_destroy(mix);
    rsv_light_mix_destroy(NULL);
    strike(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(any_strengths_are_a_sum),
        cmocka_unit_test(sources_are_rendered_when_they_shine),
        cmocka_unit_test(moves_and_colors_start_over),
        cmocka_unit_test(mixed_noise_is_no_more),
        cmocka_unit_test(unusable_wishes_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
