/// The light tree: which lights it samples, with what probability and noise; ten thousand lights of each kind.
#include "light_fixture.h"
#include "slow_tests.h"

#include "resolvent/render.h"
#include "resolvent/solve.h"
#include "sources/light_tree.h"
#include "sources/punctual_light.h"

enum { MANY = 10000 };

static rsv_vec3 random_place(rsv_random *random, float size)
{
    float x = rsv_random_float(random), y = rsv_random_float(random);
    return v3(size * (2 * x - 1), size * (2 * y - 1), size * (2 * rsv_random_float(random) - 1));
}

static rsv_vec3 random_direction(rsv_random *random)
{
    float x = rsv_random_float(random);
    return rsv_square_to_sphere(x, rsv_random_float(random));
}

/// Points and small patches, dim and bright, with all kinds of cones.
static void fill_bounds(rsv_light_bounds *bounds, size_t count, rsv_random *random)
{
    for (size_t i = 0; i < count; i++) {
        rsv_vec3 place = random_place(random, 10);
        float size = i % 3 ? 0 : 0.2f;
        bounds[i] = (rsv_light_bounds){ .low = place,
            .high = v3_add(place, v3(size, size, size)),
            .axis = random_direction(random),
            .cos_spread = i % 4 == 0 ? -1 : 1 - 1.5f * rsv_random_float(random),
            .cos_emission = i % 2 ? 0 : 0.9f,
            .strength = expf(4 * rsv_random_float(random)) };
    }
}

static rsv_light_tree *random_tree(world *w, size_t count, uint32_t seed)
{
    rsv_light_bounds *bounds = malloc(count * sizeof *bounds);
    rsv_random random = rsv_random_from(seed, 1, 2);
    rsv_light_tree *tree;
    fill_bounds(bounds, count, &random);
    assert_int_equal(rsv_light_tree_create(w->context, bounds, count, &tree), RSV_OK);
    free(bounds);
    return tree;
}

static void probabilities_sum_to_one_and_are_those_drawn(void **state)
{
    (void)state;
    world *w = world_begin(1);
    enum { COUNT = 200, SAMPLES = 100000 };
    rsv_light_tree *tree = random_tree(w, COUNT, 3);
    rsv_random random = rsv_random_from(4, 5, 6);
    for (int receiver = 0; receiver < 6; receiver++) {
        rsv_vec3 point = random_place(&random, receiver < 3 ? 8 : 30);
        rsv_vec3 normal = receiver % 2 ? random_direction(&random) : v3(0, 0, 0);
        double drawn[COUNT] = { 0 }, sum = 0, lost = 0;
        for (uint32_t k = 0; k < SAMPLES; k++) {
            uint32_t light;
            float p = rsv_light_tree_sample(tree, point, normal, (k + 0.5f) / SAMPLES, &light);
            if (p == 0) {
                lost++;
                continue;
            }
            drawn[light]++;
            assert_float_equal(p, rsv_light_tree_probability(tree, point, normal, light), 1e-4 * p);
        }
        for (uint32_t i = 0; i < COUNT; i++) {
            float p = rsv_light_tree_probability(tree, point, normal, i);
            sum += p;
            assert_float_equal(drawn[i] / SAMPLES, p, 4.0 / SAMPLES + 1e-4 * p);
        }
        assert_float_equal(sum + lost / SAMPLES, 1, 1e-3);
    }
    rsv_light_tree_destroy(tree);
    world_end(w);
}

static int depth_of(const rsv_light_tree *tree, uint32_t light)
{
    int depth = 0;
    for (uint32_t k = tree->leaf[light]; tree->node[k].parent != RSV_NONE; k = tree->node[k].parent)
        depth++;
    return depth;
}

static void trees_are_shallow_whatever_the_lights(void **state)
{
    (void)state;
    world *w = world_begin(1);
    rsv_light_bounds *bounds = calloc(MANY, sizeof *bounds);
    for (int i = 0; i < MANY;
         i++) { // each ten times as far as the one before, then all in one place
        float x = i < 38 ? powf(10, (float)i - 10) : 0;
        bounds[i] = (rsv_light_bounds){ .low = v3(x, 0, 0),
            .high = v3(x, 0, 0),
            .axis = v3(0, 0, 1),
            .cos_spread = -1,
            .strength = 1 };
    }
    rsv_light_tree *tree;
    assert_int_equal(rsv_light_tree_create(w->context, bounds, MANY, &tree), RSV_OK);
    for (uint32_t i = 0; i < MANY; i++)
        assert_true(depth_of(tree, i) < 48);
    uint32_t light;
    assert_true(rsv_light_tree_sample(tree, v3(0, 0, 0), v3(0, 0, 1), 0.5f, &light) >= 0);
    rsv_light_tree_destroy(tree);
    free(bounds);
    world_end(w);
}

/// A lamp: `size` 0 = punctual, half of them spots; else a small triangle that shines downwards.
static void add_lamp(world *w, rsv_vec3 place, float size, int index, uint32_t *mesh_id)
{
    if (size == 0) {
        rsv_punctual_light light = { .name = "lamp",
            .kind = index % 2 ? RSV_PUNCTUAL_SPOT : RSV_PUNCTUAL_POINT,
            .position = place,
            .direction = v3(0, -1, 0),
            .intensity = rgb_gray(0.01f * (float)(1 + index % 7)),
            .outer_cone_angle = 0.8f,
            .inner_cone_angle = 0.4f };
        assert_int_equal(rsv_scene_add_light(w->scene, &light), RSV_OK);
        return;
    }
    float transform[16] = { [0] = size,
        [5] = size,
        [10] = size,
        [12] = place.x,
        [13] = place.y,
        [14] = place.z,
        [15] = 1 };
    assert_int_equal(rsv_scene_add_instance(w->scene, *mesh_id, transform, "lamp"), RSV_OK);
}

/// A long floor, with ten thousand lamps above it.
static world *long_hall(float lamp_size)
{
    world *w = world_begin(2);
    rsv_material floor = rsv_default_material(), glow = floor;
    floor.base_color = rgb_gray(0.5f);
    floor.specular = glow.specular = 0;
    floor.roughness = 1;
    glow.base_color = rgb_gray(0);
    glow.emission = rgb_gray(50);
    uint32_t floor_id, glow_id, floor_mesh, lamp_mesh;
    assert_int_equal(rsv_scene_add_material(w->scene, &floor, &floor_id), RSV_OK);
    assert_int_equal(rsv_scene_add_material(w->scene, &glow, &glow_id), RSV_OK);
    const rsv_vec3 plane[6] = { { -4, 0, -50 }, { -4, 0, 50 }, { 4, 0, 50 }, { -4, 0, -50 },
        { 4, 0, 50 }, { 4, 0, -50 } };
    const rsv_vec3 lamp[3] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 0, 1 } };
    rsv_mesh_desc mesh = { .size = sizeof mesh,
        .name = "floor",
        .positions = plane,
        .vertex_count = 6,
        .triangle_count = 2,
        .material = floor_id };
    assert_int_equal(rsv_scene_add_mesh(w->scene, &mesh, &floor_mesh), RSV_OK);
    assert_int_equal(rsv_scene_add_instance(w->scene, floor_mesh, NULL, NULL), RSV_OK);
    mesh = (rsv_mesh_desc){ .size = sizeof(rsv_mesh_desc),
        .name = "lamp",
        .positions = lamp,
        .vertex_count = 3,
        .triangle_count = 1,
        .material = glow_id };
    assert_int_equal(rsv_scene_add_mesh(w->scene, &mesh, &lamp_mesh), RSV_OK);
    rsv_random random = rsv_random_from(7, 7, 7);
    for (int i = 0; i < MANY; i++) {
        float x = rsv_random_float(&random), z = rsv_random_float(&random);
        rsv_vec3 place = v3(8 * x - 4, 1 + 2 * rsv_random_float(&random), 100 * z - 50);
        add_lamp(w, place, lamp_size, i, &lamp_mesh);
    }
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    return w;
}

static double exact_irradiance(const world *w, const rsv_probe *probe)
{
    double sum = 0;
    for (size_t i = 0; i < w->lights->emitter_count; i++) {
        const rsv_emitter *e = &w->lights->emitter[i];
        if (v3_dot(e->normal, v3_sub(probe->position, e->corner[0])) > 0)
            sum += e->radiance.g *
                   rsv_polygon_irradiance(e->corner, 3, probe->position, probe->normal);
    }
    const rsv_scene_view *view = rsv_scene_get_view(w->scene);
    for (size_t i = 0; i < view->light_count; i++) {
        rsv_punctual_sample s;
        if (rsv_punctual_arriving(
                view, &view->light[i], view->light[i].position, probe->position, &s))
            sum += s.irradiance.g * f_max(v3_dot(s.direction, probe->normal), 0);
    }
    return sum;
}

/// Probes just above the floor see all lamps and nothing else; few samples are enough.
static void check_hall(float lamp_size)
{
    world *w = long_hall(lamp_size);
    world_commit(w);
    const rsv_probe probes[3] = { { { 0, 0.01f, 0 }, { 0, 1, 0 } },
        { { 3, 0.5f, 20 }, { 0, 1, 0 } }, { { -2, 0.2f, -45 }, { 0.6f, 0.8f, 0 } } };
    rsv_probe_reading reading[3];
    assert_int_equal(rsv_probe_reference(w->scene, probes, 3, 16384, 1, reading), RSV_OK);
    for (int i = 0; i < 3; i++) {
        double expected = exact_irradiance(w, &probes[i]), error = reading[i].standard_error.g;
        // the floor lights a tilted probe a little, and lamps shade one another
        double other = i == 2 ? 0.1 : 0.02;
        assert_float_equal(reading[i].irradiance.g, expected, 4 * error + other * expected);
        assert_true(error < 0.01 * expected);
    }
    world_end(w);
}

static void ten_thousand_emitters_take_few_samples(void **state)
{
    (void)state;
    check_hall(0.02f);
}

static void ten_thousand_punctual_lights_take_few_samples(void **state)
{
    (void)state;
    check_hall(0);
}

/// Operator and reference read the same light, by different ways of sampling it.
static void the_operator_agrees_with_the_reference(void **state)
{
    (void)state;
    world *w = long_hall(0);
    const rsv_probe probes[2] = { { { 0, 0, 0 }, { 0, 1, 0 } }, { { 1, 0.4f, 30 }, { 0, -1, 0 } } };
    rsv_probe_reading a[2], b[2];
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_light *solution;
    assert_int_equal(rsv_light_create(w->scene, &desc, &solution), RSV_OK);
    assert_int_equal(
        rsv_probe_irradiance(solution,
            &(rsv_probe_desc){ sizeof(rsv_probe_desc), RSV_PROBE_OPERATOR, 8192, 1 }, probes, 2, a),
        RSV_OK);
    assert_int_equal(rsv_probe_reference(w->scene, probes, 2, 16384, 1, b), RSV_OK);
    for (int i = 0; i < 2; i++) {
        double error = sqrt((double)a[i].standard_error.g * a[i].standard_error.g +
                            (double)b[i].standard_error.g * b[i].standard_error.g);
        assert_float_equal(
            a[i].irradiance.g, b[i].irradiance.g, 4 * error + 0.005 * b[i].irradiance.g);
        assert_true(error < 0.02 * b[i].irradiance.g);
    }
    rsv_light_destroy(solution);
    world_end(w);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest quick[] = {
        cmocka_unit_test(probabilities_sum_to_one_and_are_those_drawn),
        cmocka_unit_test(trees_are_shallow_whatever_the_lights),
        cmocka_unit_test(ten_thousand_emitters_take_few_samples),
        cmocka_unit_test(ten_thousand_punctual_lights_take_few_samples),
    };
    const struct CMUnitTest slow[] = {
        cmocka_unit_test(the_operator_agrees_with_the_reference),
    };
    return RUN_HALF(argc, argv, quick, slow);
}
