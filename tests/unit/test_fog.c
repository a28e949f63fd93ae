/// Fog: its formulas against sums, valid and invalid settings, and commands that refuse it.
#include "media/fog_run.h"
#include "media/phase.h"
#include "resolvent/render.h"
#include "scene/variant.h"
#include "unit/light_fixture.h"

/// Relative error of the sums that formulas are compared with.
#define SUM_TOLERANCE 2e-5

static rsv_fog layer(float scale_height, float base_height)
{
    rsv_fog fog = rsv_default_fog();
    fog.extinction = rgb(0.3f, 0.1f, 0);
    fog.scale_height = scale_height;
    fog.base_height = base_height;
    fog.bounds_min = v3(-50, -40, -INFINITY);
    fog.bounds_max = v3(60, 30, INFINITY);
    return fog;
}

static double density_at(const rsv_fog *fog, rsv_vec3 p)
{
    bool inside = p.x >= fog->bounds_min.x && p.x <= fog->bounds_max.x &&
                  p.y >= fog->bounds_min.y && p.y <= fog->bounds_max.y;
    if (!inside) return 0;
    return exp(-fmax((double)p.y - (double)fog->base_height, 0) / (double)fog->scale_height);
}

/// A column is the sum of what lies along the ray, and its place is found again.
static void columns_are_integrals_of_density(void **state)
{
    (void)state;
    rsv_random random = rsv_random_from(1, 2, 3);
    for (int k = 0; k < 200; k++) {
        rsv_fog fog = layer(k % 3 ? (k % 3 == 1 ? 2.0f : 30.0f) : INFINITY, (float)(k % 7) - 3);
        rsv_vec3 origin = v3(100 * rsv_random_float(&random) - 50,
            100 * rsv_random_float(&random) - 50, 3 * rsv_random_float(&random));
        rsv_vec3 way = rsv_square_to_sphere(rsv_random_float(&random), rsv_random_float(&random));
        if (k % 5 == 0) way = v3_normalize(v3(way.x, 0, way.z));
        float length = 120 * rsv_random_float(&random);
        rsv_fog_run run = rsv_fog_run_of(&fog, origin, way, length);
        enum { STEPS = 20000 };
        double sum = 0, step = (run.end - run.begin) / STEPS;
        for (int i = 0; i < STEPS; i++)
            sum +=
                step * density_at(&fog, v3_mad(origin, (float)(run.begin + (i + 0.5) * step), way));
        assert_close(run.column, sum, SUM_TOLERANCE * sum + 1e-4);
        if (!(run.column > 1e-6)) continue;
        double s = run.begin + (double)rsv_random_float(&random) * (run.end - run.begin);
        double column = rsv_fog_column(&run, s), found = rsv_fog_find(&run, column);
        assert_close(rsv_fog_column(&run, found), column, 1e-9 * run.column);
        assert_close(
            rsv_fog_density(&run, s), density_at(&fog, v3_mad(origin, (float)s, way)), 1e-4);
    }
}

/// Outside its box there is none, and rays without an end have closed forms, too.
static void rays_without_an_end_have_columns(void **state)
{
    (void)state;
    rsv_fog fog = layer(10, 0);
    fog.bounds_min = v3(-INFINITY, -INFINITY, -INFINITY);
    fog.bounds_max = v3(INFINITY, INFINITY, INFINITY);
    rsv_fog_run up = rsv_fog_run_of(&fog, v3(0, 5, 0), v3(0, 1, 0), INFINITY);
    assert_close(up.column, 10 * exp(-0.5), 1e-9);
    assert_close(rsv_fog_find(&up, up.column / 2), 10 * log(2), 1e-9);
    rsv_fog_run across = rsv_fog_run_of(&fog, v3(0, 5, 0), v3(1, 0, 0), INFINITY);
    assert_true(isinf(across.column));
    assert_close(rsv_fog_find(&across, 2), 2 * exp(0.5), 1e-6);
    rsv_fog_run down = rsv_fog_run_of(&fog, v3(0, 1e6f, 0), v3(0, -1, 0), INFINITY);
    assert_true(isinf(down.column));
    assert_close(rsv_fog_find(&down, 10), 1e6, 1e-3);
    assert_close(rsv_fog_find(&down, 13), 1e6 + 3, 1e-3);
    assert_close(rsv_fog_column(&down, 1e6 + 3), 13, 1e-3);
    rsv_rgb passed = rsv_fog_transmittance(&fog, across.column);
    assert_true(passed.r == 0 && passed.g == 0 && passed.b == 1);
    rsv_fog box = layer(INFINITY, 0);
    assert_true(rsv_fog_run_of(&box, v3(70, 0, 0), v3(0, 1, 0), INFINITY).column == 0);
    assert_true(rsv_fog_run_of(&box, v3(70, 0, 0), v3(1, 0, 0), INFINITY).column == 0);
    assert_close(rsv_fog_run_of(&box, v3(70, 0, 0), v3(-1, 0, 0), INFINITY).column, 110, 1e-9);
}

/// Density sigma exp(-sigma c): the share that has met the medium by then is the number drawn.
static void free_paths_are_exponential(void **state)
{
    (void)state;
    for (int k = 0; k < 64; k++) {
        float u = ((float)k + 0.5f) / 64, sigma = 0.01f * (float)(k + 1);
        double column = rsv_fog_free_column(sigma, u);
        assert_close(1 - exp(-(double)sigma * column), (double)u, 1e-9);
    }
    assert_true(isinf(rsv_fog_free_column(0, 0.5f)));
}

static void equiangular_density_is_that_of_its_samples(void **state)
{
    (void)state;
    rsv_random random = rsv_random_from(4, 5, 6);
    for (int k = 0; k < 50; k++) {
        rsv_vec3 way = rsv_square_to_sphere(rsv_random_float(&random), rsv_random_float(&random));
        rsv_vec3 point = v3_scale(rsv_square_to_sphere(rsv_random_float(&random), 0.3f), 4);
        double begin = 3 * (double)rsv_random_float(&random), end = k % 4 ? begin + 8 : INFINITY;
        rsv_equiangular e = rsv_equiangular_of(v3(0, 0, 0), way, point, begin, end);
        // the density over the distances between two samples holds the share of numbers between them
        double a = rsv_equiangular_sample(&e, 0.2f), b = rsv_equiangular_sample(&e, 0.7f), sum = 0;
        enum { STEPS = 20000 };
        for (int i = 0; i < STEPS; i++)
            sum += rsv_equiangular_pdf(&e, a + (b - a) * (i + 0.5) / STEPS) * (b - a) / STEPS;
        assert_true(a >= begin - 1e-6 && b <= end);
        assert_close(sum, 0.5, 1e-5);
    }
}

/// It integrates to 1, its mean cosine is g, and samples follow it.
static void phase_function_is_a_density_with_mean_cosine_g(void **state)
{
    (void)state;
    static const float anisotropy[] = { -0.95f, -0.5f, 0, 1e-4f, 0.3f, 0.85f };
    const rsv_vec3 forward = v3_normalize(v3(1, -2, 0.5f));
    for (size_t k = 0; k < sizeof anisotropy / sizeof *anisotropy; k++) {
        float g = anisotropy[k];
        enum { STEPS = 100000, SIDE = 256 };
        double sum = 0, mean = 0, drawn = 0;
        for (int i = 0; i < STEPS; i++) {
            double cos = 2 * (i + 0.5) / STEPS - 1;
            double share = 2 * M_PI * (double)rsv_phase(g, (float)cos) * 2 / STEPS;
            sum += share;
            mean += share * cos;
        }
        assert_close(sum, 1, 1e-4);
        assert_close(mean, (double)g, 1e-4);
        for (int i = 0; i < SIDE * SIDE; i++) {
            float u1 = ((float)(i % SIDE) + 0.5f) / SIDE, u2 = ((float)(i / SIDE) + 0.5f) / SIDE;
            rsv_vec3 turned = rsv_phase_sample(g, forward, u1, u2);
            assert_close((double)v3_length(turned), 1, 1e-5);
            drawn += (double)v3_dot(turned, forward) / (SIDE * SIDE);
        }
        assert_close(drawn, (double)g, 2e-3);
    }
}

// ---- scenes -----------------------------------------------------------------------------------------

/// A floor, a lamp above it, and a camera next to it.
static world *small_scene(void)
{
    world *w = world_begin(1);
    world_quad(
        w, world_lambert(w, 0.5f, 0), v3(-1, 0, 1), v3(1, 0, 1), v3(1, 0, -1), v3(-1, 0, -1));
    rsv_punctual_light lamp = { .position = v3(0, 3, 0), .intensity = rgb_gray(1) };
    rsv_camera camera = rsv_camera_look_at("eye", v3(0, 1, 5), v3(0, 0, 0), 1, 1);
    assert_int_equal(rsv_scene_add_light(w->scene, &lamp), RSV_OK);
    assert_int_equal(rsv_scene_add_camera(w->scene, &camera), RSV_OK);
    world_commit(w);
    return w;
}

static void assert_refused(rsv_scene *scene, rsv_fog fog, const char *part)
{
    assert_int_equal(rsv_scene_set_fog(scene, &fog), RSV_ERROR_ARGUMENT);
    if (!strstr(rsv_last_error(), part))
        fail_msg("'%s' does not mention '%s'", rsv_last_error(), part);
    assert_null(rsv_scene_get_view(scene)->fog);
}

static void values_out_of_range_are_refused(void **state)
{
    (void)state;
    static const float bad[] = { -1e-6f, INFINITY, NAN, 2e6f };
    world *w = small_scene();
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        rsv_fog fog = layer(INFINITY, 0);
        fog.extinction.g = bad[k];
        assert_refused(w->scene, fog, "extinction");
        fog = layer(INFINITY, 0);
        fog.albedo.b = bad[k];
        assert_refused(w->scene, fog, "albedo");
        fog = layer(INFINITY, 0);
        fog.emission.r = bad[k] == 2e6f ? 2e12f : bad[k];
        assert_refused(w->scene, fog, "emission");
        fog = layer(INFINITY, 0);
        fog.anisotropy = k == 0 ? -1 : k == 3 ? 1 : bad[k];
        assert_refused(w->scene, fog, "anisotropy");
        if (k == 0 || k == 2) assert_refused(w->scene, layer(bad[k], 0), "scale height");
        if (k == 1 || k == 2) assert_refused(w->scene, layer(2, bad[k]), "base height");
    }
    rsv_fog fog = layer(INFINITY, 0);
    fog.albedo.r = 1.001f;
    assert_refused(w->scene, fog, "albedo");
    fog = layer(INFINITY, 0);
    fog.emission.b = 1;
    assert_refused(w->scene, fog, "without extinction");
    fog = layer(INFINITY, 0);
    fog.bounds_max.x = NAN;
    assert_refused(w->scene, fog, "box");
    world_end(w);
    w = world_begin(1);
    assert_refused(w->scene, layer(2, 0), "committed");
    world_end(w);
}

/// Without a box of its own, fog fills the scene, including lamps and cameras. Fog that thins with height fills all of
/// space.
static void fog_finds_its_box(void **state)
{
    (void)state;
    world *w = small_scene();
    rsv_fog fog = rsv_default_fog();
    assert_int_equal(rsv_scene_set_fog(w->scene, &fog), RSV_OK);
    assert_null(rsv_scene_get_view(w->scene)->fog);
    fog.extinction = rgb_gray(0.1f);
    assert_int_equal(rsv_scene_set_fog(w->scene, &fog), RSV_OK);
    const rsv_fog *found = rsv_scene_get_view(w->scene)->fog;
    assert_non_null(found);
    assert_true(found->bounds_min.y == 0 && found->bounds_max.y == 3 && found->bounds_max.z == 5);
    assert_true(found->bounds_min.x == -1 && found->bounds_max.x == 1);
    fog.scale_height = 4;
    assert_int_equal(rsv_scene_set_fog(w->scene, &fog), RSV_OK);
    assert_true(isinf(found->bounds_min.x) && isinf(found->bounds_max.y));
    rsv_scene *variant;
    assert_int_equal(rsv_scene_vary(w->scene, &variant), RSV_OK);
    assert_ptr_not_equal(rsv_scene_get_view(variant)->fog, found);
    assert_true(rsv_scene_get_view(variant)->fog->scale_height == 4);
    rsv_scene_destroy(variant);
    assert_int_equal(rsv_scene_set_fog(w->scene, NULL), RSV_OK);
    assert_null(rsv_scene_get_view(w->scene)->fog);
    world_end(w);
}

/// No command ignores fog silently.
static void who_cannot_follow_light_through_fog_says_so(void **state)
{
    (void)state;
    world *w = small_scene();
    rsv_fog fog = layer(INFINITY, 0);
    rsv_light *light = NULL;
    rsv_image *image = NULL;
    assert_int_equal(rsv_scene_set_fog(w->scene, &fog), RSV_OK);
    assert_int_equal(rsv_light_create(w->scene, NULL, &light), RSV_ERROR_UNSUPPORTED);
    assert_non_null(strstr(rsv_last_error(), "mode reference"));
    rsv_render_desc picture = rsv_default_render_desc();
    picture.mode = RSV_RENDER_OCCLUSION;
    assert_int_equal(rsv_render_occlusion(w->scene, &picture, &image), RSV_ERROR_UNSUPPORTED);
    assert_true(!light && !image);
    world_end(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(columns_are_integrals_of_density),
        cmocka_unit_test(rays_without_an_end_have_columns),
        cmocka_unit_test(free_paths_are_exponential),
        cmocka_unit_test(equiangular_density_is_that_of_its_samples),
        cmocka_unit_test(phase_function_is_a_density_with_mean_cosine_g),
        cmocka_unit_test(values_out_of_range_are_refused),
        cmocka_unit_test(fog_finds_its_box),
        cmocka_unit_test(who_cannot_follow_light_through_fog_says_so),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
