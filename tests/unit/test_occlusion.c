/// Modes occlusion against closed forms: configuration factors of the objects that hide the sky.
#include "builtin/builtin.h"
#include "resolvent/render.h"
#include "unit/scene_fixture.h"

#define ALBEDO 0.5f
#define FAR 1000.0f ///< half side of "infinite" walls, metres

static rsv_scene *empty_scene(fixture *f, uint32_t *material)
{
    rsv_scene *scene;
    assert_int_equal(rsv_scene_create(f->context, &scene), RSV_OK);
    scene->is_part = true; // without a light, on purpose
    assert_int_equal(
        rsv_add_lambert(scene, "grey", rgb_gray(ALBEDO), rgb_gray(0), material), RSV_OK);
    return scene;
}

static void add_quad(
    rsv_scene *scene, uint32_t material, rsv_vec3 a, rsv_vec3 b, rsv_vec3 c, rsv_vec3 d)
{
    const rsv_vec3 corner[4] = { a, b, c, d };
    assert_int_equal(rsv_add_quad((rsv_shape){ scene, "quad", material, NULL }, corner), RSV_OK);
}

static void add_floor(rsv_scene *scene, uint32_t material)
{
    add_quad(
        scene, material, v3(-FAR, 0, FAR), v3(FAR, 0, FAR), v3(FAR, 0, -FAR), v3(-FAR, 0, -FAR));
}

/// A wall in the plane x = 0 that faces +x.
static void add_wall_x(rsv_scene *scene, uint32_t material, float height)
{
    add_quad(
        scene, material, v3(0, 0, FAR), v3(0, 0, -FAR), v3(0, height, -FAR), v3(0, height, FAR));
}

/// A wall in the plane z = 0 that faces +z.
static void add_wall_z(rsv_scene *scene, uint32_t material, float height)
{
    add_quad(
        scene, material, v3(-FAR, 0, 0), v3(FAR, 0, 0), v3(FAR, height, 0), v3(-FAR, height, 0));
}

static rsv_render_desc narrow_view(rsv_scene *scene, rsv_vec3 from, rsv_vec3 target, uint32_t size)
{
    rsv_camera camera = rsv_camera_look_at("eye", from, target, size == 1 ? 1e-5f : 1, 1);
    assert_int_equal(rsv_scene_add_camera(scene, &camera), RSV_OK);
    assert_int_equal(rsv_scene_commit(scene), RSV_OK);
    rsv_render_desc desc = rsv_default_render_desc();
    desc.mode = RSV_RENDER_OCCLUSION;
    desc.width = desc.height = size;
    desc.samples = 16;
    desc.gather_rays = 1024;
    return desc;
}

/// Unoccluded share at the point that a picture of one pixel shows.
static float openness(const rsv_scene *scene, const rsv_render_desc *desc)
{
    rsv_image *image;
    assert_int_equal(rsv_render_occlusion(scene, desc, &image), RSV_OK);
    float value = rsv_image_const_pixels(image, 0)->g / ALBEDO;
    rsv_image_destroy(image);
    return value;
}

/// 16,384 stratified rays: at random they would err by 0.004; these err by less than 0.001.
#define TOLERANCE 0.002f

static void a_wall_hides_half_of_what_it_rises_above(void **state)
{
    uint32_t grey;
    rsv_scene *scene = empty_scene(*state, &grey);
    const float height = 2, distance = 1;
    add_floor(scene, grey);
    add_wall_x(scene, grey, height);
    rsv_render_desc desc = narrow_view(scene, v3(3, 2, 0.5f), v3(distance, 0, 0), 1);
    // an endless strip at a right angle: F = (1 - d / sqrt(d^2 + h^2)) / 2
    float hidden = 0.5f * (1 - distance / sqrtf(distance * distance + height * height));
    assert_float_equal(openness(scene, &desc), 1 - hidden, TOLERANCE);
    desc.occlusion_distance = 0.9f; // the wall is beyond it
    assert_float_equal(openness(scene, &desc), 1, 1e-6f);
    rsv_scene_destroy(scene);
}

static void corners_of_two_and_three_walls_see_a_half_and_a_quarter(void **state)
{
    for (int walls = 1; walls <= 2; walls++) {
        uint32_t grey;
        rsv_scene *scene = empty_scene(*state, &grey);
        add_floor(scene, grey);
        add_wall_x(scene, grey, FAR);
        if (walls == 2) add_wall_z(scene, grey, FAR);
        rsv_render_desc desc = narrow_view(scene, v3(2, 2, 2), v3(1e-3f, 0, 1e-3f), 1);
        desc.samples = 16;
        assert_float_equal(openness(scene, &desc), walls == 1 ? 0.5f : 0.25f, TOLERANCE);
        rsv_scene_destroy(scene);
    }
}

static void a_sphere_hides_the_square_of_radius_over_distance(void **state)
{
    uint32_t grey;
    rsv_scene *scene = empty_scene(*state, &grey);
    const float radius = 1, height = 1.6f;
    add_floor(scene, grey);
    assert_int_equal(
        rsv_add_sphere((rsv_shape){ scene, "sphere", grey, NULL }, v3(0, height, 0), radius, 5),
        RSV_OK);
    rsv_render_desc desc = narrow_view(scene, v3(4, 0.4f, 0), v3(0, 0, 0), 1);
    assert_float_equal(openness(scene, &desc), 1 - radius * radius / (height * height), TOLERANCE);
    rsv_scene_destroy(scene);
}

static void the_environment_colours_surfaces_and_background(void **state)
{
    uint32_t grey;
    const rsv_rgb pixels[2] = { { 1, 2, 3 }, { 1, 2, 3 } };
    const rsv_environment environment = { "even", pixels, 2, 1, 1, 0 };
    rsv_scene *scene = empty_scene(*state, &grey);
    add_floor(scene, grey);
    assert_int_equal(rsv_scene_set_environment(scene, &environment), RSV_OK);
    rsv_render_desc desc = narrow_view(scene, v3(0, 1, 0), v3(0, 1, -1), 16);
    for (int mode = 0; mode < 2; mode++) {
        rsv_image *image;
        desc.mode = mode ? RSV_RENDER_OCCLUSION_SCREEN : RSV_RENDER_OCCLUSION;
        assert_int_equal(rsv_render_occlusion(scene, &desc, &image), RSV_OK);
        const rsv_rgb *top = rsv_image_const_pixels(image, 0), *bottom = top + 255;
        assert_float_equal(top->b, 3, 1e-5f);
        assert_float_equal(bottom->b, 3 * ALBEDO, 0.01f);
        assert_float_equal(bottom->r, 1 * ALBEDO, 0.01f);
        rsv_image_destroy(image);
    }
    rsv_scene_destroy(scene);
}

static void threads_do_not_change_occlusion(void **state)
{
    fixture *f = *state;
    rsv_image *image[2];
    for (int i = 0; i < 2; i++) {
        rsv_context_desc wish = rsv_default_context_desc();
        wish.thread_count = 1 + 2 * i;
        rsv_context *context;
        rsv_scene *scene;
        assert_int_equal(rsv_context_create(&wish, &context), RSV_OK);
        assert_int_equal(rsv_scene_builtin(context, "cornell-blocks", &scene), RSV_OK);
        rsv_render_desc desc = rsv_default_render_desc();
        desc.width = desc.height = 24;
        desc.samples = 2;
        for (int mode = 0; mode < 2; mode++) {
            desc.mode = mode ? RSV_RENDER_OCCLUSION_SCREEN : RSV_RENDER_OCCLUSION;
            rsv_image *made;
            assert_int_equal(rsv_render_occlusion(scene, &desc, &made), RSV_OK);
            if (i == 0) {
                assert_int_equal(rsv_image_create(f->context, 24, 24, 1, &image[mode]), RSV_OK);
                memcpy(rsv_image_pixels(image[mode], 0), rsv_image_const_pixels(made, 0),
                    24 * 24 * sizeof(rsv_rgb));
            } else {
                assert_memory_equal(rsv_image_pixels(image[mode], 0),
                    rsv_image_const_pixels(made, 0), 24 * 24 * sizeof(rsv_rgb));
                rsv_image_destroy(image[mode]);
            }
            rsv_image_destroy(made);
        }
        rsv_scene_destroy(scene);
        rsv_context_destroy(context);
    }
}

// ---- in screen space ------------------------------------------------------------------------------

enum { side = 64 };

static float screen_openness(const rsv_image *image, uint32_t x, uint32_t y)
{
    return rsv_image_const_pixels(image, 0)[y * side + x].g / ALBEDO;
}

static rsv_image *take_screen_picture(rsv_scene *scene, rsv_vec3 from, rsv_vec3 target)
{
    rsv_image *image;
    rsv_render_desc desc = narrow_view(scene, from, target, side);
    desc.mode = RSV_RENDER_OCCLUSION_SCREEN;
    desc.gather_rays = 64;
    desc.occlusion_distance = 0.5f;
    assert_int_equal(rsv_render_occlusion(scene, &desc, &image), RSV_OK);
    return image;
}

static void a_plane_does_not_occlude_itself_on_the_screen(void **state)
{
    uint32_t grey;
    rsv_scene *scene = empty_scene(*state, &grey);
    add_floor(scene, grey);
    rsv_image *image = take_screen_picture(scene, v3(1, 3, 1), v3(0, 0, 0));
    for (uint32_t y = 0; y < side; y++)
        for (uint32_t x = 0; x < side; x++)
            assert_float_equal(screen_openness(image, x, y), 1, 1e-6f);
    rsv_image_destroy(image);
    rsv_scene_destroy(scene);
}

static void a_corner_is_darker_on_the_screen_within_the_reach_alone(void **state)
{
    uint32_t grey;
    rsv_scene *scene = empty_scene(*state, &grey);
    add_floor(scene, grey);
    add_wall_z(scene, grey, FAR);
    rsv_image *image = take_screen_picture(scene, v3(0, 3, 3), v3(0, 0, 0));
    // the crease runs through the middle of the picture; half of the hemisphere is hidden there, of which
    // blur and coarse pixels leave a part
    float crease = screen_openness(image, side / 2, side / 2);
    assert_true(crease > 0.5f && crease < 0.9f);
    assert_float_equal(screen_openness(image, side / 2, side - 2), 1, 1e-6f);
    assert_float_equal(screen_openness(image, side / 2, 1), 1, 1e-6f);
    rsv_image_destroy(image);
    rsv_scene_destroy(scene);
}

static void what_is_far_in_front_casts_no_halo(void **state)
{
    uint32_t grey;
    rsv_scene *scene = empty_scene(*state, &grey);
    add_floor(scene, grey);
    // a card of 1 m, 4 m above the floor and far beyond the reach of 0.5 m
    add_quad(scene, grey, v3(-0.5f, 4, 0.5f), v3(0.5f, 4, 0.5f), v3(0.5f, 4, -0.5f),
        v3(-0.5f, 4, -0.5f));
    rsv_image *image = take_screen_picture(scene, v3(0, 8, 0), v3(0, 0, 0));
    for (uint32_t i = 0; i < side * side; i++)
        assert_true(screen_openness(image, i % side, i / side) > 0.95f);
    rsv_image_destroy(image);
    rsv_scene_destroy(scene);
}

static void wrong_wishes_are_refused(void **state)
{
    fixture *f = *state;
    rsv_scene *scene;
    rsv_image *image;
    assert_int_equal(rsv_scene_builtin(f->context, "furnace", &scene), RSV_OK);
    rsv_render_desc sound = rsv_default_render_desc(), desc;
    sound.mode = RSV_RENDER_OCCLUSION;
    desc = sound;
    desc.occlusion_distance = -1;
    assert_int_equal(rsv_render_occlusion(scene, &desc, &image), RSV_ERROR_ARGUMENT);
    desc.occlusion_distance = NAN;
    assert_int_equal(rsv_render_occlusion(scene, &desc, &image), RSV_ERROR_ARGUMENT);
    desc = sound;
    desc.width = 0;
    assert_int_equal(rsv_render_occlusion(scene, &desc, &image), RSV_ERROR_ARGUMENT);
    desc = sound;
    desc.camera = 7;
    assert_int_equal(rsv_render_occlusion(scene, &desc, &image), RSV_ERROR_ARGUMENT);
    desc = sound;
    desc.mode = RSV_RENDER_FINAL;
    assert_int_equal(rsv_render_occlusion(scene, &desc, &image), RSV_ERROR_ARGUMENT);
    rsv_scene_destroy(scene);
}

int main(void)
{
#define CASE(name) cmocka_unit_test_setup_teardown(name, fixture_setup, fixture_teardown)
    const struct CMUnitTest tests[] = {
        CASE(a_wall_hides_half_of_what_it_rises_above),
        CASE(corners_of_two_and_three_walls_see_a_half_and_a_quarter),
        CASE(a_sphere_hides_the_square_of_radius_over_distance),
        CASE(the_environment_colours_surfaces_and_background),
        CASE(threads_do_not_change_occlusion),
        CASE(a_plane_does_not_occlude_itself_on_the_screen),
        CASE(a_corner_is_darker_on_the_screen_within_the_reach_alone),
        CASE(what_is_far_in_front_casts_no_halo),
        CASE(wrong_wishes_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
