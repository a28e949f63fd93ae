/// Films: depth of field against the circle of confusion, all directions around, a shifted film.
#include "scene_fixture.h"

#include "resolvent/render.h"
#include "trace/film.h"

// ---- rays -------------------------------------------------------------------------------------------

static rsv_camera level_camera(void)
{
    return rsv_camera_look_at("eye", v3(1, 2, 3), v3(1, 2, 0), 0.8f, 2);
}

static void assert_direction(const rsv_film *film, float x, float y, rsv_vec3 expected)
{
    const float uv[2] = { 0.5f, 0.5f };
    rsv_ray ray;
    assert_true(rsv_film_ray(film, x, y, uv, &ray));
    if (v3_max_abs(v3_sub(ray.direction, expected)) > 1e-5f)
        fail_msg("(%g, %g): (%g %g %g), not (%g %g %g)", (double)x, (double)y,
            (double)ray.direction.x, (double)ray.direction.y, (double)ray.direction.z,
            (double)expected.x, (double)expected.y, (double)expected.z);
    assert_true(v3_max_abs(v3_sub(ray.origin, v3(1, 2, 3))) == 0);
}

static void equirectangular_films_see_all_around(void **state)
{
    (void)state;
    const rsv_camera camera = level_camera(); // looks along -z
    const rsv_film_desc desc = { .projection = RSV_PROJECTION_EQUIRECTANGULAR };
    const rsv_film film = rsv_film_of(NULL, &desc, &camera, 400, 200);
    assert_direction(&film, 200, 100, v3(0, 0, -1));
    assert_direction(&film, 300, 100, v3(1, 0, 0));
    assert_direction(&film, 100, 100, v3(-1, 0, 0));
    assert_direction(&film, 0, 100, v3(0, 0, 1));
    assert_direction(&film, 400, 100, v3(0, 0, 1));
    assert_direction(&film, 123, 0, v3(0, 1, 0));
    assert_direction(&film, 321, 200, v3(0, -1, 0));
    assert_direction(&film, 250, 50, v3(0.5f, sqrtf(0.5f), -0.5f));
}

static void fisheye_films_see_the_half_space_ahead(void **state)
{
    (void)state;
    const rsv_camera camera = level_camera();
    const rsv_film_desc desc = { .projection = RSV_PROJECTION_FISHEYE };
    const rsv_film film = rsv_film_of(NULL, &desc, &camera, 300, 200);
    const float uv[2] = { 0.5f, 0.5f }, s = sqrtf(0.5f);
    rsv_ray ray;
    assert_direction(&film, 150, 100, v3(0, 0, -1));
    assert_direction(&film, 250, 100, v3(1, 0, 0));
    assert_direction(&film, 150, 0, v3(0, 1, 0));
    assert_direction(&film, 200, 100, v3(s, 0, -s)); // half way is 45 degrees
    assert_false(rsv_film_ray(&film, 255, 100, uv, &ray));
    assert_false(rsv_film_ray(&film, 10, 10, uv, &ray));
}

/// A film shifted by a quarter of its width sees there what an unshifted one sees a quarter further on.
static void shifted_films_see_beside(void **state)
{
    (void)state;
    const rsv_camera camera = level_camera();
    const rsv_film_desc plain = { 0 }, desc = { .shift = { 0.25f, -0.5f } };
    const rsv_film film = rsv_film_of(NULL, &desc, &camera, 400, 200);
    const rsv_film straight = rsv_film_of(NULL, &plain, &camera, 400, 200);
    const float uv[2] = { 0.5f, 0.5f };
    rsv_ray a, b;
    rsv_film_ray(&film, 30, 40, uv, &a);
    rsv_film_ray(&straight, 130, 140, uv, &b);
    assert_true(v3_max_abs(v3_sub(a.direction, b.direction)) < 1e-6f);
    assert_true(rsv_film_is_plain(&plain) && !rsv_film_is_plain(&desc));
}

static void impossible_films_are_refused(void **state)
{
    (void)state;
    static const rsv_film_desc cases[] = { { .projection = (rsv_projection)9 }, { .f_number = -1 },
        { .f_number = NAN }, { .f_number = INFINITY }, { .f_number = 2, .focus_distance = -1 },
        { .f_number = 2, .focus_distance = NAN }, { .shift = { NAN, 0 } },
        { .projection = RSV_PROJECTION_FISHEYE, .f_number = 2 },
        { .projection = RSV_PROJECTION_FISHEYE, .shift = { 1, 0 } } };
    const rsv_camera camera = level_camera();
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++)
        assert_int_equal(rsv_film_check(&cases[k], &camera), RSV_ERROR_ARGUMENT);
    rsv_camera flat = camera;
    flat.vertical_fov = 0;
    flat.vertical_extent = 1;
    assert_int_equal(rsv_film_check(&(rsv_film_desc){ .f_number = 2 }, &flat), RSV_ERROR_ARGUMENT);
    assert_int_equal(rsv_film_check(&(rsv_film_desc){ 0 }, &flat), RSV_OK);
}

// ---- depth of field -----------------------------------------------------------------------------------

#define DEPTH 4.0f ///< of the lamp, metres
#define SIDE 0.3f
enum { PIXELS = 40 };

/// A small square that shines, ahead of a camera, before a grey wall.
static rsv_scene *lamp_scene(fixture *f, float wall)
{
    rsv_scene *scene;
    rsv_material material = rsv_default_material();
    const float h = SIDE / 2, w = 6;
    const rsv_vec3 lamp[4] = { { -h, -h, -DEPTH }, { h, -h, -DEPTH }, { h, h, -DEPTH },
        { -h, h, -DEPTH } };
    const rsv_vec3 back[4] = { { -w, -w, -7 }, { w, -w, -7 }, { w, w, -7 }, { -w, w, -7 } };
    static const uint32_t index[6] = { 0, 1, 2, 0, 2, 3 };
    const rsv_camera camera = rsv_camera_look_at("eye", v3(0, 0, 0), v3(0, 0, -1), 0.8f, 1);
    uint32_t id;
    assert_int_equal(rsv_scene_create(f->context, &scene), RSV_OK);
    material.emission = rgb_gray(50);
    material.base_color = rgb_gray(0);
    material.specular = 0;
    assert_int_equal(rsv_scene_add_material(scene, &material, &id), RSV_OK);
    material.emission = rgb_gray(0);
    material.base_color = rgb_gray(wall);
    assert_int_equal(rsv_scene_add_material(scene, &material, &id), RSV_OK);
    for (uint32_t k = 0; k < 2; k++) {
        const rsv_mesh_desc mesh = { .size = sizeof mesh,
            .positions = k ? back : lamp,
            .vertex_count = 4,
            .indices = index,
            .triangle_count = 2,
            .material = k };
        static const float at[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
        assert_int_equal(rsv_scene_add_mesh(scene, &mesh, &id), RSV_OK);
        assert_int_equal(rsv_scene_add_instance(scene, id, at, NULL), RSV_OK);
    }
    assert_int_equal(rsv_scene_add_camera(scene, &camera), RSV_OK);
    assert_int_equal(rsv_scene_commit(scene), RSV_OK);
    return scene;
}

static rsv_image *take(const rsv_scene *scene, const rsv_film_desc *film, rsv_render_mode mode)
{
    rsv_image *image = NULL;
    rsv_light *light = NULL;
    rsv_render_desc desc = rsv_default_render_desc();
    rsv_solve_desc solve = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.film = *film;
    desc.mode = mode;
    desc.width = desc.height = PIXELS;
    desc.samples = 150;
    if (mode == RSV_RENDER_REFERENCE) {
        assert_int_equal(rsv_render_reference(scene, &desc, &image, NULL), RSV_OK);
    } else {
        assert_int_equal(rsv_light_create(scene, &solve, &light), RSV_OK);
        assert_int_equal(rsv_render(light, &desc, &image), RSV_OK);
    }
    rsv_light_destroy(light);
    return image;
}

/// Sum of a picture, and the mean square distance from its middle, in units of the plane at a distance of 1.
static void measure(const rsv_image *image, double *sum, double *spread)
{
    double unit = 2 * tan(0.4) / PIXELS;
    *sum = *spread = 0;
    for (int y = 0; y < PIXELS; y++)
        for (int x = 0; x < PIXELS; x++) {
            double value = (double)rsv_image_const_pixels(image, 0)[y * PIXELS + x].g;
            double dx = unit * (x + 0.5 - PIXELS / 2.0), dy = unit * (y + 0.5 - PIXELS / 2.0);
            *sum += value;
            *spread += value * (dx * dx + dy * dy);
        }
    *spread /= *sum;
}

/// What is out of focus is spread over a disc of radius R |1 / focus - 1 / depth|: its mean square radius is half of that squared, added
/// to what the sharp picture has. As much light arrives as without.
static void blur_is_that_of_the_circle_of_confusion(void **state)
{
    static const rsv_render_mode modes[] = { RSV_RENDER_REFERENCE, RSV_RENDER_FINAL,
        RSV_RENDER_OPERATOR };
    static const float focuses[] = { 2, DEPTH, 20 };
    rsv_scene *scene = lamp_scene(*state, 0);
    const double radius = 0.3;
    for (size_t m = 0; m < sizeof modes / sizeof *modes; m++)
        for (size_t k = 0; k < sizeof focuses / sizeof *focuses; k++) {
            const rsv_film_desc sharp = { 0 },
                                film = { .f_number = (float)(0.012 / tan(0.4) / (2 * radius)),
                                    .focus_distance = focuses[k] };
            double plain, own, sum, spread,
                confusion = radius * fabs(1 / (double)focuses[k] - 1 / (double)DEPTH);
            rsv_image *image = take(scene, &sharp, modes[m]);
            measure(image, &plain, &own);
            rsv_image_destroy(image);
            image = take(scene, &film, modes[m]);
            measure(image, &sum, &spread);
            rsv_image_destroy(image);
            // some thousand rays meet the lamp: 2 % of standard error
            double expected = confusion * confusion / 2 + own;
            if (fabs(sum / plain - 1) > 0.04 || fabs(spread / expected - 1) > 0.05)
                fail_msg("mode %d, focus %g: light %.4f of 1, spread %.6f, not %.6f", (int)modes[m],
                    (double)focuses[k], sum / plain, spread, expected);
        }
    rsv_scene_destroy(scene);
}

/// Without a focus distance, the middle of the picture is in focus.
static void the_middle_is_in_focus_by_default(void **state)
{
    rsv_scene *scene = lamp_scene(*state, 0);
    rsv_tracer *tracer;
    assert_int_equal(rsv_tracer_create(scene, &tracer), RSV_OK);
    const rsv_film_desc desc = { .f_number = 2 };
    const rsv_film film = rsv_film_of(tracer, &desc, &rsv_scene_get_view(scene)->camera[0], 64, 64);
    assert_float_equal(film.focus, DEPTH, 1e-5);
    rsv_tracer_destroy(tracer);
    rsv_scene_destroy(scene);
}

/// A lit wall, all around and through an open aperture: modes agree.
static void modes_agree_on_every_film(void **state)
{
    static const rsv_film_desc films[] = { { .projection = RSV_PROJECTION_EQUIRECTANGULAR },
        { .projection = RSV_PROJECTION_FISHEYE }, { .f_number = 0.1f, .focus_distance = 2 },
        { .shift = { 0.25f, 0.1f } } };
    rsv_scene *scene = lamp_scene(*state, 0.6f);
    assert_int_equal(rsv_scene_set_builtin_environment(scene, "white", 0.5f, 0), RSV_OK);
    for (size_t k = 0; k < sizeof films / sizeof *films; k++) {
        rsv_image_difference difference;
        rsv_image *reference = take(scene, &films[k], RSV_RENDER_REFERENCE);
        rsv_image *final = take(scene, &films[k], RSV_RENDER_FINAL);
        assert_int_equal(rsv_image_compare(reference, 0, final, 0, &difference), RSV_OK);
        assert_float_equal(difference.mean_ratio, 1, 0.02);
        assert_true(difference.median_relative_error < 0.03);
        rsv_image_destroy(reference);
        rsv_image_destroy(final);
    }
    rsv_scene_destroy(scene);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, fixture_setup, fixture_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equirectangular_films_see_all_around),
        cmocka_unit_test(fisheye_films_see_the_half_space_ahead),
        cmocka_unit_test(shifted_films_see_beside),
        cmocka_unit_test(impossible_films_are_refused),
        TEST(blur_is_that_of_the_circle_of_confusion),
        TEST(the_middle_is_in_focus_by_default),
        TEST(modes_agree_on_every_film),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
