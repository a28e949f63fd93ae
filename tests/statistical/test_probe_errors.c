/// Standard errors of probes: the true value lies within two of them, with and without caustics, for any seed.
#include "resolvent/render.h"
#include "unit/light_fixture.h"
#include "unit/slow_tests.h"

#include "core/sampling.h"

enum { probe_count = 12, most_seeds = 40 };

// ---- scenes -------------------------------------------------------------------------------------

/// A closed room of two metres, with a box on its floor.
static world *begin_room(float albedo)
{
    world *w = world_begin(2);
    world_room(w, world_lambert(w, albedo, 0), v3(-1, -1, -1), v3(1, 1, 1));
    world_box(w, world_lambert(w, 0.5f, 0), v3(0.3f, -0.9999f, 0.2f), v3(0.7f, -0.4f, 0.6f));
    return w;
}

static void add_lamp(world *w, float half)
{
    world_quad(w, world_lambert(w, 0, 0.8f / (half * half)), v3(-half, 0.99f, -half),
        v3(half, 0.99f, -half), v3(half, 0.99f, half), v3(-half, 0.99f, half));
}

static void add_point(world *w, rsv_vec3 position)
{
    rsv_punctual_light light = {
        .kind = RSV_PUNCTUAL_POINT, .position = position, .intensity = rgb_gray(3)
    };
    assert_int_equal(rsv_scene_add_light(w->scene, &light), RSV_OK);
}

static void add_glass(world *w, rsv_vec3 centre, float radius, bool thin)
{
    rsv_material glass = glass_material();
    if (thin) glass.thickness = 0;
    world_sphere(w, world_material(w, glass), centre, radius, 3);
}

static world *create_bulb(void)
{
    world *w = begin_room(0.6f);
    add_glass(w, v3(0, 0.3f, 0), 0.2f, true);
    add_point(w, v3(0, 0.3f, 0));
    return w;
}

static world *create_spot_behind_glass(void)
{
    world *w = begin_room(0.6f);
    add_glass(w, v3(-0.2f, -0.4f, 0.1f), 0.3f, false);
    add_point(w, v3(-0.5f, 0.7f, -0.3f));
    return w;
}

static world *create_lamp_behind_glass(void)
{
    world *w = begin_room(0.6f);
    add_glass(w, v3(-0.2f, -0.4f, 0.1f), 0.3f, false);
    add_lamp(w, 0.2f);
    return w;
}

static world *create_mirror(void)
{
    world *w = begin_room(0.6f);
    world_box(w, world_material(w, mirror_material(0.9f)), v3(-0.9f, -0.9f, -1.5f),
        v3(0.9f, 0.9f, -0.98f));
    add_lamp(w, 0.2f);
    return w;
}

static world *create_plain(void)
{
    world *w = begin_room(0.6f);
    add_lamp(w, 0.3f);
    return w;
}

static world *create_bright(void)
{
    world *w = begin_room(0.9f);
    add_lamp(w, 0.1f);
    return w;
}

static world *create_sun(void)
{
    world *w = world_begin(2);
    world_quad(
        w, world_lambert(w, 0.5f, 0), v3(-2, 0, 2), v3(2, 0, 2), v3(2, 0, -2), v3(-2, 0, -2));
    world_box(w, world_lambert(w, 0.6f, 0), v3(-0.5f, 0.0001f, -0.5f), v3(0, 1, 0));
    assert_int_equal(rsv_scene_set_builtin_environment(w->scene, "sky", 1, 0), RSV_OK);
    return w;
}

static world *create_blocks(void) { return world_builtin(2, "cornell-blocks"); }
static world *create_spheres(void) { return world_builtin(2, "cornell-spheres"); }
static world *create_two_rooms(void) { return world_builtin(2, "two-rooms"); }

typedef struct trial {
    const char *name;
    world *(*create)(void);
    bool
        traced; ///< the path tracer finds all of its light; else a solution of many photons tells the truth
} trial;

static const trial trials[] = { { "bulb", create_bulb, false },
    { "spot behind glass", create_spot_behind_glass, false },
    { "lamp behind glass", create_lamp_behind_glass, true }, { "mirror", create_mirror, true },
    { "plain", create_plain, true }, { "bright", create_bright, true }, { "sun", create_sun, true },
    { "cornell-blocks", create_blocks, true }, { "cornell-spheres", create_spheres, true },
    { "two-rooms", create_two_rooms, true } };
enum { trial_count = sizeof trials / sizeof *trials };

// ---- readings -----------------------------------------------------------------------------------

/// Places on the diffuse surfaces that are seen from places in the air; every fourth place is in the air itself.
static void place_probes(const world *w, rsv_probe *probe)
{
    const rsv_scene_view *view = w->transport.view;
    rsv_random random = rsv_random_from(5, 1, 2);
    rsv_vec3 low = view->bounds_min, size = v3_sub(view->bounds_max, low);
    for (int k = 0; k < probe_count;) {
        float x = 0.15f + 0.7f * rsv_random_float(&random), y = rsv_random_float(&random);
        float z = 0.15f + 0.7f * rsv_random_float(&random), u = rsv_random_float(&random);
        rsv_vec3 place = v3_add(low, v3(x * size.x, (0.15f + 0.7f * y) * size.y, z * size.z));
        rsv_vec3 direction = rsv_square_to_sphere(u, rsv_random_float(&random));
        rsv_ray ray = { place, direction, INFINITY };
        rsv_hit hit;
        if (!rsv_tracer_closest(w->tracer, &ray, &hit)) continue;
        const rsv_material *m = &view->material[view->triangle_material[hit.triangle]];
        rsv_surface_point p = rsv_surface_point_at(view, hit.triangle, hit.u, hit.v, false);
        bool front = v3_dot(p.geometric, direction) < 0; // and not within a body
        if (!front || m->transmission > 0 || m->metallic > 0 || rgb_max(m->emission) > 0) continue;
        probe[k] =
            k % 4 == 3 ? (rsv_probe){ place, direction } : (rsv_probe){ p.position, p.geometric };
        k++;
    }
}

static void read_solution(const world *w, const rsv_solve_desc *desc, const rsv_probe *probe,
    uint32_t samples, rsv_probe_reading *reading)
{
    rsv_light *s;
    if (rsv_light_create(w->scene, desc, &s) != RSV_OK) fail_msg("%s", rsv_last_error());
    assert_int_equal(
        rsv_probe_irradiance(s,
            &(rsv_probe_desc){ sizeof(rsv_probe_desc), RSV_PROBE_OPERATOR, samples, desc->seed },
            probe, probe_count, reading),
        RSV_OK);
    rsv_light_destroy(s);
}

static void find_truth(const trial *t, const world *w, uint32_t paths, const rsv_probe *probe,
    rsv_probe_reading *truth)
{
    if (t->traced) {
        assert_int_equal(
            rsv_probe_reference(w->scene, probe, probe_count, paths, 77, truth), RSV_OK);
        return;
    }
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.photon_count = 200 * paths;
    desc.rays_per_element = 512;
    read_solution(w, &desc, probe, 8192, truth);
}

/// Compares readings with many seeds with the true value: how many lie within two standard errors, and the ratio of
/// these errors to the spread of the readings.
typedef struct tally {
    int covered, all;
    double stated, spread; ///< variances over squares of the means
} tally;

static void count(const rsv_probe_reading *truth, rsv_probe_reading (*reading)[probe_count],
    int seeds, int k, tally *sum)
{
    double mean = 0, spread = 0, t = (double)rgb_luminance(truth[k].irradiance);
    double doubt = (double)rgb_luminance(truth[k].standard_error);
    if (t == 0) return;
    for (int i = 0; i < seeds; i++)
        mean += (double)rgb_luminance(reading[i][k].irradiance) / seeds;
    for (int i = 0; i < seeds; i++) {
        double value = (double)rgb_luminance(reading[i][k].irradiance);
        double error = (double)rgb_luminance(reading[i][k].standard_error);
        sum->covered += fabs(value - t) <= 2 * sqrt(error * error + doubt * doubt);
        sum->stated += error * error / (mean * mean);
        spread += (value - mean) * (value - mean) / (mean * mean);
        sum->all++;
    }
    sum->spread += spread * seeds / (seeds - 1);
}

/// @param scale of the draft's elements and photons
static tally try_seeds(const trial *t, int seeds, uint32_t paths, double scale)
{
    static rsv_probe_reading reading[most_seeds][probe_count];
    rsv_probe_reading truth[probe_count];
    rsv_probe probe[probe_count];
    tally sum = { 0 };
    world *w = t->create();
    world_commit(w);
    place_probes(w, probe);
    find_truth(t, w, paths, probe, truth);
    for (int i = 0; i < seeds; i++) {
        rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
        desc.element_target = (uint32_t)(scale * desc.element_target);
        desc.photon_count = (uint32_t)(scale * desc.photon_count);
        desc.seed = (uint32_t)i;
        read_solution(w, &desc, probe, 1024, reading[i]);
    }
    for (int k = 0; k < probe_count; k++)
        count(truth, reading, seeds, k, &sum);
    print_message("%s: %.1f %% within two standard errors; these are %.2f times the spread\n",
        t->name, 100.0 * sum.covered / sum.all, sqrt(sum.stated / sum.spread));
    world_end(w);
    return sum;
}

/// Light that only photons find, so that the reading has exactly their noise.
static void noise_of_photons_is_stated(void **state)
{
    (void)state;
    tally sum = try_seeds(&trials[0], 4, 2048, 0.15);
    assert_true(
        sum.covered >= 0.8 * sum.all); // of 48: three of their own standard errors below 0.95
    assert_true(sum.stated < 9 * sum.spread);
}

/// Of one scene.
static void standard_errors_cover_the_truth(void **state)
{
    tally sum = try_seeds(*state, most_seeds, 65536, 1);
    assert_true(sum.covered >= 0.9 * sum.all);
    assert_true(sum.stated < 9 * sum.spread);
}

/// @param only the scene to look at; NULL = all of them
static int try_all(const char *only)
{
    struct CMUnitTest test[trial_count] = { 0 };
    for (int k = 0; k < trial_count; k++)
        if (!only || strcmp(only, trials[k].name) == 0)
            test[k] = (struct CMUnitTest){ .name = trials[k].name,
                .test_func = standard_errors_cover_the_truth,
                .initial_state = (void *)&trials[k] };
    return cmocka_run_group_tests(test, NULL, NULL);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest quick[] = { cmocka_unit_test(noise_of_photons_is_stated) };
    if (asks_for_more(argc, argv)) return try_all(argc > 2 ? argv[2] : NULL);
    return cmocka_run_group_tests(quick, NULL, NULL);
}
