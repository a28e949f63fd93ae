/// Fog whose density varies on a grid: columns against sums, light against exact answers, and mode reference, which tracks
/// collisions, against what integrates.
#include "media/fog_run.h"
#include "unit/fog_fixture.h"
#include "unit/slow_tests.h"

enum { X = 7, Y = 9, Z = 6 };

/// Rough densities between 0 and 2, in the box from -1 to 1. @param density [Z * Y * X] out
static rsv_volume_grid rough_grid(float *density)
{
    for (uint32_t k = 0; k < X * Y * Z; k++) {
        float u = rsv_unit_float(rsv_hash(k + 1));
        density[k] = u < 0.4f ? 0 : 2 * u;
    }
    return (rsv_volume_grid){
        .side = { X, Y, Z }, .low = { -1, -1, -1 }, .high = { 1, 1, 1 }, .density = density
    };
}

static rsv_fog medium(rsv_rgb extinction, rsv_rgb albedo)
{
    rsv_fog fog = rsv_default_fog();
    fog.extinction = extinction;
    fog.albedo = albedo;
    return fog;
}

static void fill_rough(world *w, rsv_fog fog)
{
    float density[X * Y * Z];
    const rsv_volume_grid grid = rough_grid(density);
    world_commit(w);
    assert_int_equal(rsv_scene_set_volume(w->scene, &fog, &grid), RSV_OK);
}

static rsv_light *solve_by(const world *w, size_t elements, uint32_t rays, uint32_t seed)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_light *light;
    desc.element_target = elements;
    desc.rays_per_element = rays;
    desc.seed = seed;
    assert_int_equal(rsv_light_create(w->scene, &desc, &light), RSV_OK);
    return light;
}

static rsv_light *solve_with(const world *w, size_t elements, uint32_t rays)
{
    return solve_by(w, elements, rays, 1);
}

typedef struct sampling {
    uint32_t samples, seed;
} sampling;

/// @param light NULL = path traced
static void see(const world *w, const rsv_light *light, rsv_camera camera, rsv_render_mode mode,
    sampling s, estimate out[3])
{
    enum { SIDE = 16, PIXELS = SIDE * SIDE };
    rsv_render_desc desc = rsv_default_render_desc();
    rsv_image *image;
    desc.mode = mode;
    desc.width = desc.height = SIDE;
    desc.samples = s.samples;
    desc.seed = s.seed;
    desc.viewpoint = &camera;
    if (light)
        assert_int_equal(rsv_render(light, &desc, &image), RSV_OK);
    else
        assert_int_equal(rsv_render_reference(w->scene, &desc, &image, NULL), RSV_OK);
    const rsv_rgb *pixel = rsv_image_pixels(image, 0);
    for (int k = 0; k < 3; k++) {
        double sum = 0, squares = 0;
        for (int i = 0; i < PIXELS; i++) {
            double value = (double)channel(pixel[i], k);
            sum += value;
            squares += value * value;
        }
        double mean = sum / PIXELS, spread = fmax(squares / PIXELS - mean * mean, 0);
        out[k] = (estimate){ mean, sqrt(spread / (PIXELS - 1)) };
    }
    rsv_image_destroy(image);
}

// ---- columns ------------------------------------------------------------------------------------

/// Trilinear by its definition: a sum over all points of hat functions.
static double density_at(const rsv_volume_grid *g, rsv_vec3 p)
{
    double sum = 0;
    for (int k = 0; k < X * Y * Z; k++) {
        const int at[3] = { k % X, k / X % Y, k / X / Y };
        double weight = (double)g->density[k];
        for (int a = 0; a < 3; a++) {
            double place = ((double)(&p.x)[a] + 1) / 2 * (g->side[a] - 1);
            weight *= fmax(1 - fabs(place - at[a]), 0);
        }
        sum += weight;
    }
    return sum;
}

static void columns_are_integrals(void **state)
{
    (void)state;
    enum { STEPS = 4000 };
    float density[X * Y * Z];
    const rsv_volume_grid grid = rough_grid(density);
    world *w = world_begin(1);
    add_speck(w);
    fill_rough(w, medium(rgb_gray(1), rgb_gray(0)));
    const rsv_fog *fog = rsv_scene_get_view(w->scene)->fog;
    rsv_random random = rsv_random_from(1, 2, 3);
    for (int n = 0; n < 40; n++) {
        rsv_vec3 from = v3(4 * rsv_random_float(&random) - 2, 4 * rsv_random_float(&random) - 2, 3);
        rsv_vec3 to = v3(2 * rsv_random_float(&random) - 1, 2 * rsv_random_float(&random) - 1, 0);
        if (n % 4 == 0) from.x = to.x, from.y = to.y; // along an axis
        rsv_vec3 way = v3_normalize(v3_sub(to, from));
        rsv_fog_run run = rsv_fog_run_of(fog, from, way, n % 3 ? INFINITY : 3.1f);
        double sum = 0, step = (run.end - run.begin) / STEPS, middle = run.begin;
        for (int k = 0; k < STEPS; k++) {
            double s = run.begin + (k + 0.5) * step;
            if (k == STEPS / 3)
                middle = run.begin + k * step,
                assert_close(rsv_fog_column(&run, middle), sum, 2e-4);
            sum += density_at(&grid, v3_mad(from, (float)s, way)) * step;
        }
        assert_close(run.column, sum, 2e-4);
        for (int k = 1; k < 8 && run.column > 0; k++) {
            double column = run.column * k / 8;
            assert_close(rsv_fog_column(&run, rsv_fog_find(&run, column)), column, 1e-9);
        }
        assert_close(rsv_fog_density(&run, middle),
            density_at(&grid, v3_mad(from, (float)middle, way)), 1e-4);
    }
    world_end(w);
}

// ---- scenes -------------------------------------------------------------------------------------

static void assert_refused(world *w, rsv_fog fog, rsv_volume_grid grid, const char *part)
{
    assert_int_not_equal(rsv_scene_set_volume(w->scene, &fog, &grid), RSV_OK);
    if (!strstr(rsv_last_error(), part))
        fail_msg("'%s' does not mention '%s'", rsv_last_error(), part);
}

static void bad_grids_are_refused(void **state)
{
    (void)state;
    float density[X * Y * Z];
    const rsv_volume_grid good = rough_grid(density);
    static const float zeros[8], negative[8] = { [3] = -1 }, infinite[8] = { [7] = INFINITY };
    const rsv_fog fog = medium(rgb_gray(1), rgb_gray(1));
    world *w = world_begin(1);
    add_speck(w);
    world_commit(w);
    rsv_volume_grid grid = good;
    grid.side[1] = 1;
    assert_refused(w, fog, grid, "at least 2");
    grid = good;
    grid.side[0] = grid.side[1] = grid.side[2] = 1000;
    assert_refused(w, fog, grid, "1000 x 1000 x 1000");
    grid.side[0] = grid.side[1] = grid.side[2] = UINT32_MAX;
    assert_refused(w, fog, grid, "coarser");
    grid = good;
    grid.high.y = grid.low.y;
    assert_refused(w, fog, grid, "positive and finite");
    grid = (rsv_volume_grid){ { 2, 2, 2 }, good.low, good.high, zeros };
    assert_refused(w, fog, grid, "all densities are 0");
    grid.density = negative;
    assert_refused(w, fog, grid, "point 1, 1, 0");
    grid.density = infinite;
    assert_refused(w, fog, grid, "point 1, 1, 1");
    rsv_fog thinning = fog;
    thinning.scale_height = 1;
    assert_refused(w, thinning, good, "height");
    assert_refused(w, medium(rgb_gray(9e5f), rgb_gray(1)), good, "densest");
    assert_null(rsv_scene_get_view(w->scene)->fog);
    assert_int_equal(rsv_scene_set_volume(w->scene, &fog, &good), RSV_OK);
    assert_non_null(rsv_scene_get_view(w->scene)->fog->volume);
    assert_int_equal(rsv_scene_set_volume(w->scene, &fog, &good), RSV_OK); // in its place
    assert_int_equal(rsv_scene_set_fog(w->scene, &fog), RSV_OK);
    assert_null(rsv_scene_get_view(w->scene)->fog->volume);
    world_end(w);
}

static void exhaustion_leaves_the_air_clear(void **state)
{
    (void)state;
    float density[X * Y * Z];
    const rsv_volume_grid grid = rough_grid(density);
    const rsv_fog fog = medium(rgb_gray(1), rgb_gray(1));
    world *w = world_begin(1);
    add_speck(w);
    world_commit(w);
    rsv_status status = RSV_ERROR_MEMORY;
    for (long k = 0; status != RSV_OK; k++) {
        long alive = w->alive;
        w->until_failure = k;
        status = rsv_scene_set_volume(w->scene, &fog, &grid);
        w->until_failure = -1;
        if (status == RSV_OK) break;
        assert_int_equal(status, RSV_ERROR_MEMORY);
        assert_int_equal(w->alive, alive);
        assert_null(rsv_scene_get_view(w->scene)->fog);
    }
    world_end(w);
}

// ---- absorption -----------------------------------------------------------------------------------

/// Density rises linearly along the ray from 0 to 3 over 2 m: a column of 3 m.
static void a_ramp_follows_beer(void **state)
{
    (void)state;
    static const float ramp[8] = { 0, 0, 3, 3, 0, 0, 3, 3 };
    const rsv_volume_grid grid = { { 2, 2, 2 }, { -20, 0.5f, -20 }, { 20, 2.5f, 20 }, ramp };
    const rsv_fog fog = medium(rgb(0.1f, 0.3f, 0.6f), rgb_gray(0));
    world *w = world_begin(2);
    world_quad(
        w, world_lambert(w, 0, 1), v3(-99, 0, 99), v3(99, 0, 99), v3(99, 0, -99), v3(-99, 0, -99));
    world_commit(w);
    assert_int_equal(rsv_scene_set_volume(w->scene, &fog, &grid), RSV_OK);
    rsv_light *light = solve_with(w, 500, 64);
    for (int aslant = 0; aslant < 2; aslant++) {
        const rsv_camera eye = needle(v3(aslant ? 6 : 0, 6, 0.01f), v3(0, 0, 0));
        estimate traced[3], seen[3], stored[3];
        see(w, NULL, eye, RSV_RENDER_REFERENCE, (sampling){ 512, 1 }, traced);
        see(w, light, eye, RSV_RENDER_FINAL, (sampling){ 1, 1 }, seen);
        see(w, light, eye, RSV_RENDER_OPERATOR, (sampling){ 1, 1 }, stored);
        for (int k = 0; k < 3; k++) {
            double passed = exp(-(double)channel(fog.extinction, k) * 3 * (aslant ? sqrt(2) : 1));
            check("a ramp, path traced", traced[k], passed);
            assert_close(seen[k].mean, passed, 1e-4 * passed);
            assert_close(stored[k].mean, passed, 1e-3 * passed);
        }
    }
    rsv_light_destroy(light);
    world_end(w);
}

// ---- equilibrium and balance ----------------------------------------------------------------------

/// In a closed room whose walls all show radiance 1, fog changes nothing, whatever its density.
static void fog_is_invisible_in_a_furnace(void **state)
{
    (void)state;
    world *w = world_begin(2);
    world_room(w, world_lambert(w, 0.5f, 0.5f), v3(-1, -1, -1), v3(1, 1, 1));
    rsv_fog fog = medium(rgb(1, 2, 1), rgb(1, 0.7f, 0));
    fog.emission = rgb(0, 0.6f, 1);
    fill_rough(w, fog);
    rsv_light *light = solve_with(w, 1000, 256);
    assert_true(rsv_light_report(light)->norm_inf <= 1 + 1e-6);
    const rsv_camera eye = rsv_camera_look_at("eye", v3(0.3f, 0.2f, 0.9f), v3(0, 0, 0), 1, 1);
    estimate traced[3], seen[3], stored[3];
    see(w, NULL, eye, RSV_RENDER_REFERENCE, (sampling){ 256, 1 }, traced);
    see(w, light, eye, RSV_RENDER_FINAL, (sampling){ 4, 1 }, seen);
    see(w, light, eye, RSV_RENDER_OPERATOR, (sampling){ 4, 1 }, stored);
    for (int k = 0; k < 3; k++) {
        check("furnace, path traced", traced[k], 1);
        check("furnace, final", seen[k], 1);
        check("furnace, operator", stored[k], 1);
    }
    rsv_light_destroy(light);
    world_end(w);
}

/// Power at the walls per power of the lamp, in fog without absorption. A panel shines into voxels from afar, a point light
/// lies in one of them.
static double find_balance(bool panel, uint32_t seed)
{
    world *w = world_begin(2);
    world_room(w, world_lambert(w, 0.3f, 0), v3(-1, -1, -1), v3(1, 1, 1));
    if (panel)
        world_quad(w, world_lambert(w, 0, 1), v3(-0.2f, 0.6f, -0.2f), v3(0.2f, 0.6f, -0.2f),
            v3(0.2f, 0.6f, 0.2f), v3(-0.2f, 0.6f, 0.2f));
    else
        add_lamp(
            w, (rsv_punctual_light){ .position = v3(0.1f, 0.2f, -0.1f), .intensity = rgb_gray(1) });
    fill_rough(w, medium(rgb_gray(2), rgb_gray(1)));
    rsv_light *light = solve_by(w, 3000, 512, seed);
    double found = power_at_walls(light) / (panel ? M_PI * 0.16 : 4 * M_PI);
    rsv_light_destroy(light);
    world_end(w);
    return found;
}

/// Uses the mean of several solutions, because each has noise of a percent.
static void fog_loses_no_light(void **state)
{
    (void)state;
    enum { SEEDS = 8 };
    for (int panel = 0; panel < 2; panel++) {
        double sum = 0, squares = 0;
        for (uint32_t seed = 1; seed <= SEEDS; seed++) {
            double found = find_balance(panel, seed);
            sum += found / SEEDS;
            squares += found * found / SEEDS;
        }
        const estimate mean = { sum, sqrt(fmax(squares - sum * sum, 0) / (SEEDS - 1)) };
        check(panel ? "power of a panel" : "power of a point", mean, 1);
    }
}

/// Mean radiance of pictures by mode reference, and how far several of them lie apart.
static void trace(world *w, rsv_camera eye, uint32_t samples, estimate out[3])
{
    enum { RUNS = 8 };
    double sum[3] = { 0 }, squares[3] = { 0 };
    for (uint32_t seed = 1; seed <= RUNS; seed++) {
        estimate seen[3];
        see(w, NULL, eye, RSV_RENDER_REFERENCE, (sampling){ samples, seed }, seen);
        for (int k = 0; k < 3; k++) {
            sum[k] += seen[k].mean / RUNS;
            squares[k] += seen[k].mean * seen[k].mean / RUNS;
        }
    }
    for (int k = 0; k < 3; k++)
        out[k] = (estimate){ sum[k], sqrt(fmax(squares[k] - sum[k] * sum[k], 0) / (RUNS - 1)) };
}

/// Mean radiance of pictures from several solutions: rows have noise that all pixels of one share.
static void see_solved(world *w, rsv_camera eye, rsv_render_mode mode, estimate out[3])
{
    enum { SEEDS = 6 };
    double sum[3] = { 0 }, squares[3] = { 0 };
    for (uint32_t seed = 1; seed <= SEEDS; seed++) {
        estimate seen[3];
        rsv_light *light = solve_by(w, 4000, 512, seed);
        see(w, light, eye, mode, (sampling){ 32, seed }, seen);
        rsv_light_destroy(light);
        for (int k = 0; k < 3; k++) {
            sum[k] += seen[k].mean / SEEDS;
            squares[k] += seen[k].mean * seen[k].mean / SEEDS;
        }
    }
    for (int k = 0; k < 3; k++)
        out[k] = (estimate){ sum[k], sqrt(fmax(squares[k] - sum[k] * sum[k], 0) / (SEEDS - 1)) };
}

/// Means of pictures by mode reference and from solutions.
static void compare(world *w, rsv_camera eye, uint32_t samples)
{
    estimate traced[3], seen[3];
    bool even = rsv_scene_get_view(w->scene)->fog->anisotropy == 0;
    trace(w, eye, samples, traced);
    for (int mode = 0; mode < (even ? 2 : 1); mode++) {
        see_solved(w, eye, mode ? RSV_RENDER_OPERATOR : RSV_RENDER_FINAL, seen);
        for (int k = 0; k < 3; k++)
            check(mode ? "operator, by reference" : "final, by reference",
                (estimate){ seen[k].mean, hypot(seen[k].error, traced[k].error) }, traced[k].mean);
    }
}

static void solutions_agree_with_collisions(void **state)
{
    (void)state;
    for (int forward = 0; forward < 2; forward++) {
        world *w = world_begin(2);
        world_room(w, world_lambert(w, 0.5f, 0), v3(-1, -1, -1), v3(1, 1, 1));
        world_quad(w, world_lambert(w, 0, 3), v3(-0.5f, 0.9f, -0.5f), v3(0.5f, 0.9f, -0.5f),
            v3(0.5f, 0.9f, 0.5f), v3(-0.5f, 0.9f, 0.5f));
        rsv_fog fog = medium(rgb(1, 2, 3), rgb(0.9f, 0.8f, 0.95f));
        if (forward) fog.anisotropy = 0.5f;
        fill_rough(w, fog);
        compare(w, rsv_camera_look_at("eye", v3(0.8f, 0.1f, 0.9f), v3(0, 0, 0), 1.2f, 1), 1024);
        world_end(w);
    }
}

static void smoke_agrees_with_collisions(void **state)
{
    (void)state;
    world *w = world_builtin(2, "smoke");
    compare(w,
        rsv_camera_look_at("eye", v3(-0.278f, 0.273f, 0.2f), v3(-0.278f, 0.273f, -0.3f), 1, 1),
        512);
    world_end(w);
}

static void fog_does_not_depend_on_threads(void **state)
{
    (void)state;
    uint64_t hash[2][2];
    for (int many = 0; many < 2; many++) {
        world *w = world_builtin(many ? 3 : 1, "smoke");
        rsv_light *light = solve_with(w, 300, 64);
        rsv_render_desc desc = rsv_default_render_desc();
        desc.width = desc.height = 16;
        desc.samples = 2;
        for (int mode = 0; mode < 2; mode++) {
            rsv_image *image;
            desc.mode = mode ? RSV_RENDER_REFERENCE : RSV_RENDER_FINAL;
            if (mode)
                assert_int_equal(rsv_render_reference(w->scene, &desc, &image, NULL), RSV_OK);
            else
                assert_int_equal(rsv_render(light, &desc, &image), RSV_OK);
            hash[many][mode] =
                hash_bytes(HASH_START, rsv_image_pixels(image, 0), 256 * sizeof(rsv_rgb));
            rsv_image_destroy(image);
        }
        rsv_light_destroy(light);
        world_end(w);
    }
    assert_true(hash[0][0] == hash[1][0] && hash[0][1] == hash[1][1]);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest quick[] = {
        cmocka_unit_test(columns_are_integrals),
        cmocka_unit_test(bad_grids_are_refused),
        cmocka_unit_test(exhaustion_leaves_the_air_clear),
        cmocka_unit_test(a_ramp_follows_beer),
        cmocka_unit_test(fog_does_not_depend_on_threads),
    };
    const struct CMUnitTest slow[] = {
        cmocka_unit_test(fog_is_invisible_in_a_furnace),
    };
    const struct CMUnitTest longest[] = {
        cmocka_unit_test(fog_loses_no_light),
        cmocka_unit_test(solutions_agree_with_collisions),
        cmocka_unit_test(smoke_agrees_with_collisions),
    };
    return RUN_THIRD(argc, argv, quick, slow, longest);
}
