/// Pictures of mode operator made from frames, compared with those of rsv_render.
#include "frame_fixture.h"
#include "picture_judge.h"

enum { samples = 16, judge_samples = 64 };

static rsv_render_desc picture_desc(void)
{
    rsv_render_desc desc = rsv_default_render_desc();
    desc.mode = RSV_RENDER_OPERATOR;
    desc.width = width;
    desc.height = height;
    desc.samples = samples;
    return desc;
}

/// A matt room with a mirror or, if `rough`, a brushed one.
static world *mirror_world(bool rough)
{
    world *w = world_begin(2);
    rsv_material mirror = mirror_material(0.9f);
    mirror.roughness = rough ? 0.3f : 0;
    world_room(w, world_lambert(w, 0.6f, 0), v3(-3, -2, -3), v3(3, 3, 3));
    world_quad(w, world_lambert(w, 0, 5), v3(-1, 2, -1), v3(1, 2, -1), v3(1, 2, 1), v3(-1, 2, 1));
    world_quad(
        w, world_material(w, mirror), v3(-2, -1, 0), v3(-2, 1, 0), v3(-1, 1, -2), v3(-1, -1, -2));
    rsv_camera camera = rsv_camera_look_at("front", v3(0, 0.5f, 2.5f), v3(0, 0, 0), 0.9f, 1);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    return w;
}

static rsv_image *take(const rsv_light *light, const rsv_render_desc *desc, rsv_frame_gloss gloss)
{
    rsv_image *image = NULL;
    if (rsv_render_operator(light, desc, gloss, &image) != RSV_OK) fail_msg("%s", rsv_last_error());
    return image;
}

/// Pictures by frames err no more than those of rsv_render with as many samples, in the mean and in each pixel.
static void check_error(world *w)
{
    rsv_light *light = solve_for_frames(w, 600, 20000);
    rsv_image *judge[2], *frames, *paths;
    rsv_render_desc desc = picture_desc();
    for (uint32_t k = 0; k < 2; k++) {
        desc.samples = judge_samples;
        desc.seed = 1 + k;
        assert_int_equal(rsv_render(light, &desc, &judge[k]), RSV_OK);
    }
    desc = picture_desc();
    frames = take(light, &desc, RSV_GLOSS_PATHS);
    assert_int_equal(rsv_render(light, &desc, &paths), RSV_OK);
    assert_errs_no_more(judge, frames, paths);
    for (int k = 0; k < 2; k++)
        rsv_image_destroy(judge[k]);
    rsv_image_destroy(frames);
    rsv_image_destroy(paths);
    rsv_light_destroy(light);
    world_end(w);
}

static void frames_err_no_more_than_paths(void **state)
{
    (void)state;
    check_error(world_builtin(2, "cornell-blocks"));
    check_error(world_builtin(2, "cornell-spheres"));
    check_error(mirror_world(false));
}

static bool same_bytes(const rsv_image *a, const rsv_image *b)
{
    return memcmp(rsv_image_const_pixels(a, 0), rsv_image_const_pixels(b, 0),
               pixel_count * sizeof(rsv_rgb)) == 0;
}

/// Whether a picture comes from rsv_render, byte by byte.
static bool is_rendered(const rsv_light *light, const rsv_render_desc *desc, rsv_frame_gloss gloss)
{
    rsv_image *own = take(light, desc, gloss), *rendered;
    assert_int_equal(rsv_render(light, desc, &rendered), RSV_OK);
    bool same =
        rsv_image_layer_count(own) == rsv_image_layer_count(rendered) && same_bytes(own, rendered);
    rsv_image_destroy(own);
    rsv_image_destroy(rendered);
    return same;
}

static void what_frames_cannot_show_is_rendered(void **state)
{
    (void)state;
    world *w = mirror_world(false);
    rsv_light *light = solve_for_frames(w, 600, 20000);
    rsv_render_desc desc = picture_desc();
    assert_false(is_rendered(light, &desc, RSV_GLOSS_PATHS));
    rsv_render_desc odd[] = { desc, desc, desc, desc, desc };
    odd[0].layers = true;
    odd[1].film.f_number = 2;
    odd[2].film.projection = RSV_PROJECTION_FISHEYE;
    odd[3].film.shift[0] = 0.1f;
    odd[4].noise = 0.05f;
    for (size_t k = 0; k < sizeof odd / sizeof odd[0]; k++)
        assert_true(is_rendered(light, &odd[k], RSV_GLOSS_PATHS));
    rsv_light_destroy(light);
    world_end(w);
}

static void rough_surfaces_are_rendered_unless_reused_light_is_wanted(void **state)
{
    (void)state;
    world *w = mirror_world(true);
    rsv_light *light = solve_for_frames(w, 600, 20000);
    rsv_render_desc desc = picture_desc();
    assert_true(is_rendered(light, &desc, RSV_GLOSS_PATHS));
    assert_false(is_rendered(light, &desc, RSV_GLOSS_REUSED));
    rsv_image *reused = take(light, &desc, RSV_GLOSS_REUSED), *rendered;
    desc.samples = judge_samples;
    assert_int_equal(rsv_render(light, &desc, &rendered), RSV_OK);
    rsv_image_difference difference;
    assert_int_equal(rsv_image_compare(rendered, 0, reused, 0, &difference), RSV_OK);
    if (fabs(difference.mean_ratio - 1) > 0.02) fail_msg("mean %g", difference.mean_ratio);
    rsv_image_destroy(reused);
    rsv_image_destroy(rendered);
    rsv_light_destroy(light);
    world_end(w);
}

static uint64_t hash_with_threads(int threads)
{
    world *w = world_builtin(threads, "cornell-spheres");
    rsv_light *light = solve_for_frames(w, 600, 20000);
    rsv_render_desc desc = picture_desc();
    rsv_image *image = take(light, &desc, RSV_GLOSS_PATHS);
    uint64_t hash =
        hash_bytes(HASH_START, rsv_image_const_pixels(image, 0), pixel_count * sizeof(rsv_rgb));
    rsv_image_destroy(image);
    rsv_light_destroy(light);
    world_end(w);
    return hash;
}

static void any_number_of_threads_gives_the_same_bytes(void **state)
{
    (void)state;
    assert_true(hash_with_threads(1) == hash_with_threads(3));
}

static void unusable_wishes_are_refused(void **state)
{
    (void)state;
    world *w = mirror_world(false);
    rsv_light *light = solve_for_frames(w, 600, 20000);
    rsv_render_desc desc = picture_desc();
    rsv_render_desc bad[] = { desc, desc, desc, desc };
    rsv_camera nowhere = rsv_scene_get_view(w->scene)->camera[0];
    nowhere.position.x = NAN;
    bad[0].width = 0;
    bad[1].samples = 0;
    bad[2].camera = 7;
    bad[3].viewpoint = &nowhere;
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
        rsv_image *image = NULL;
        assert_int_equal(
            rsv_render_operator(light, &bad[k], RSV_GLOSS_PATHS, &image), RSV_ERROR_ARGUMENT);
        assert_null(image);
    }
    rsv_light_destroy(light);
    world_end(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_err_no_more_than_paths),
        cmocka_unit_test(what_frames_cannot_show_is_rendered),
        cmocka_unit_test(rough_surfaces_are_rendered_unless_reused_light_is_wanted),
        cmocka_unit_test(any_number_of_threads_gives_the_same_bytes),
        cmocka_unit_test(unusable_wishes_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
