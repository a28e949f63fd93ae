/// Relighting a relit light: factors are relative to the strengths in the scene, not to the previous ones.
#include "file_fixture.h"
#include "light_fixture.h"
#include "light_view.h"
#include "resolvent/opfile.h"
#include "resolvent/relight.h"
#include "scene/scene.h"
#include "slow_tests.h"

#define LIGHTS 3

/// A lamp, a bulb and a white sky over a yard with two walls.
static world *yard(void)
{
    world *w = world_begin(2);
    uint32_t gray = world_lambert(w, 0.6f, 0);
    rsv_material lamp = lambert_material(0, 9);
    lamp.name = "lamp";
    uint32_t light = world_material(w, lamp);
    world_quad(w, gray, v3(-2, 0, 2), v3(2, 0, 2), v3(2, 0, -2), v3(-2, 0, -2));
    world_quad(w, gray, v3(-2, 0, -2), v3(2, 0, -2), v3(2, 2, -2), v3(-2, 2, -2));
    world_quad(
        w, light, v3(-0.3f, 2, -0.3f), v3(0.3f, 2, -0.3f), v3(0.3f, 2, 0.3f), v3(-0.3f, 2, 0.3f));
    const rsv_punctual_light bulb = { .name = "bulb",
        .kind = RSV_PUNCTUAL_POINT,
        .position = { -1, 1.5f, 1 },
        .intensity = { 1, 2, 3 } };
    assert_int_equal(rsv_scene_add_light(w->scene, &bulb), RSV_OK);
    assert_int_equal(rsv_scene_set_builtin_environment(w->scene, "white", 0.3f, 0), RSV_OK);
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    return w;
}

static rsv_light *solve(const world *w)
{
    rsv_solve_desc desc = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    desc.element_target = 60;
    desc.direct_levels = 1;
    desc.photon_count = 0;
    desc.rays_per_element = 64;
    desc.refinements = 0;
    desc.tolerance = 1e-6f;
    rsv_light *light;
    if (rsv_light_create(w->scene, &desc, &light) != RSV_OK) fail_msg("%s", rsv_last_error());
    return light;
}

/// @param factor of lamp, bulb and surroundings
static void relight(rsv_light *light, const float factor[LIGHTS])
{
    static const char *const name[LIGHTS] = { "lamp", "bulb", "environment" };
    rsv_light_scale scale[LIGHTS];
    for (int k = 0; k < LIGHTS; k++)
        scale[k] = (rsv_light_scale){ name[k], { factor[k], factor[k], factor[k] } };
    const rsv_relight_desc desc = { .size = sizeof desc, .light = scale, .light_count = LIGHTS };
    if (rsv_light_relight(light, &desc) != RSV_OK) fail_msg("%s", rsv_last_error());
}

static const float on[LIGHTS] = { 1, 1, 1 }, off[LIGHTS] = { 0, 0, 0 };

static void check_same(const rsv_light *light, const rsv_light *wanted)
{
    const rsv_light_view *a = inside(light), *b = inside(wanted);
    size_t bytes = a->elements->node_count * sizeof(rsv_rgb);
    assert_memory_equal(a->source, b->source, bytes);
    assert_memory_equal(a->irradiance, b->irradiance, bytes);
    assert_memory_equal(a->indirect, b->indirect, bytes);
    const rsv_scene_view *p = rsv_scene_get_view(rsv_light_scene(light)),
                         *q = rsv_scene_get_view(rsv_light_scene(wanted));
    const rsv_environment *sky = p->environment;
    for (size_t m = 0; m < p->material_count; m++)
        assert_memory_equal(&p->material[m].emission, &q->material[m].emission, sizeof(rsv_rgb));
    assert_memory_equal(&p->light[0].intensity, &q->light[0].intensity, sizeof(rsv_rgb));
    assert_memory_equal(
        sky->pixels, q->environment->pixels, (size_t)sky->width * sky->height * sizeof(rsv_rgb));
}

static void check_near(const rsv_light *light, const rsv_light *wanted, float share)
{
    const rsv_light_view *a = inside(light), *b = inside(wanted);
    for (size_t n = 0; n < a->elements->node_count; n++) {
        float size = 1e-6f + share * rgb_max(b->irradiance[n]);
        assert_true(fabsf(a->irradiance[n].r - b->irradiance[n].r) <= size);
        assert_true(fabsf(a->irradiance[n].b - b->irradiance[n].b) <= size);
    }
}

static void lights_that_were_switched_off_are_switched_on_again(void **state)
{
    (void)state;
    world *w = yard();
    rsv_light *first = solve(w), *once, *again;
    assert_int_equal(rsv_light_copy(first, &once), RSV_OK);
    assert_int_equal(rsv_light_copy(first, &again), RSV_OK);
    relight(once, on);
    check_near(once, first, 1e-5f);
    for (int k = 0; k < LIGHTS; k++) {
        float others[LIGHTS] = { 1, 1, 1 };
        others[k] = 0;
        relight(again, others);
        relight(again, on);
        check_same(again, once);
    }
    relight(again, off);
    for (size_t n = 0; n < inside(again)->elements->node_count; n++)
        assert_true(rgb_is_black(inside(again)->irradiance[n]));
    relight(again, on);
    check_same(again, once);
    rsv_light_destroy(first);
    rsv_light_destroy(once);
    rsv_light_destroy(again);
    world_end(w);
}

static int times = 4; ///< that lights are relit in between; 20 of the long ones

static void factors_do_not_compound(void **state)
{
    (void)state;
    const float half[LIGHTS] = { 0.5f, 0.25f, 0.125f };
    world *w = yard();
    rsv_light *once = solve(w), *often = solve(w);
    relight(once, half);
    for (int k = 0; k < times; k++) {
        const float some[LIGHTS] = { 0.37f * (float)k, 1 / (1 + (float)k), 0.1f * (float)(k % 3) };
        relight(often, some);
    }
    relight(often, half);
    check_same(often, once);
    relight(often, half);
    check_same(often, once);
    rsv_light_destroy(once);
    rsv_light_destroy(often);
    world_end(w);
}

static void what_is_not_named_stays_as_it_was(void **state)
{
    (void)state;
    const rsv_light_scale dim = { "bulb", { 0.5f, 0.5f, 0.5f } };
    const float both[LIGHTS] = { 0, 0.5f, 1 }, dark[LIGHTS] = { 0, 1, 1 };
    world *w = yard();
    rsv_light *together = solve(w), *light = solve(w);
    relight(together, both);
    relight(light, dark);
    assert_int_equal(rsv_light_relight(light,
                         &(rsv_relight_desc){
                             .size = sizeof(rsv_relight_desc), .light = &dim, .light_count = 1 }),
        RSV_OK);
    check_same(light, together);
    rsv_light_destroy(together);
    rsv_light_destroy(light);
    world_end(w);
}

/// A relit light, from its file, which is written again.
static rsv_light *reload(world *w, const rsv_light *light, rsv_scene **scene)
{
    folder f = new_folder();
    char path[256];
    rsv_light *loaded;
    snprintf(path, sizeof path, "%s", path_in(&f, "relit.safetensors"));
    assert_int_equal(rsv_light_save(light, "relit", path), RSV_OK);
    if (rsv_light_load(w->context, path, scene, &loaded) != RSV_OK)
        fail_msg("%s", rsv_last_error());
    check_same(loaded, light);
    remove_folder(f.path);
    return loaded;
}

static void files_and_copies_know_how_lights_stand(void **state)
{
    (void)state;
    const float some[LIGHTS] = { 0, 0.5f, 0 };
    world *w = yard();
    rsv_scene *scene, *scene_again;
    rsv_light *once = solve(w), *relit = solve(w), *copy;
    relight(once, on);
    relight(relit, some);
    rsv_light *loaded = reload(w, relit, &scene), *twice = reload(w, loaded, &scene_again);
    assert_int_equal(rsv_light_copy(loaded, &copy), RSV_OK);
    relight(copy, on);
    check_same(copy, once);
    relight(twice, on);
    check_same(twice, once);
    rsv_light_destroy(copy);
    rsv_light_destroy(loaded);
    rsv_light_destroy(twice);
    rsv_scene_destroy(scene);
    rsv_scene_destroy(scene_again);
    rsv_light_destroy(once);
    rsv_light_destroy(relit);
    world_end(w);
}

/// @return whether the node is one of these elements' own
static uint8_t *own_nodes(const rsv_elements *e)
{
    uint8_t *own = malloc(e->node_count);
    assert_non_null(own);
    memset(own, 1, e->node_count);
    for (size_t h = 0; h < e->hanging_count; h++)
        own[e->hanging[h].node] = 0;
    return own;
}

/// The stored light of a source is unchanged at all earlier nodes, even if nodes were added since.
static void check_part_kept(const rsv_light *light, const rsv_light *before, size_t source)
{
    const rsv_light_view *now = inside(light), *then = inside(before);
    const rsv_light_part *a = &now->basis->part[source], *b = &then->basis->part[source];
    const rsv_elements *finer = now->fine.elements, *fine = then->fine.elements;
    assert_int_equal(now->elements->node_count, then->elements->node_count);
    assert_memory_equal(a->direct, b->direct, now->elements->node_count * sizeof *a->direct);
    uint8_t *own = own_nodes(fine);
    for (uint32_t n = 0; n < fine->node_count; n++) {
        uint32_t face;
        float u, v, weight[3];
        if (!own[n]) continue;
        rsv_elements_place_node(fine, n, &face, &u, &v);
        uint32_t cell = rsv_elements_locate(finer, face, u, v, weight);
        int k = weight[1] > weight[0] ? 1 : 0;
        if (weight[2] > weight[k]) k = 2;
        assert_memory_equal(&a->fine[finer->cell_node[cell][k]], &b->fine[n], sizeof *b->fine);
    }
    free(own);
}

static void chains_through_files_keep_what_does_not_move(void **state)
{
    (void)state;
    world *w = yard();
    rsv_light *light = solve(w);
    rsv_scene *scene = NULL, *first_scene;
    relight(light, on);
    rsv_light *first = reload(w, light, &first_scene);
    for (int k = 0; k < 4; k++) {
        const rsv_light_move move = { "bulb", { k % 2 ? -0.5f : 0.5f, 0, 0 } };
        const rsv_relight_desc moved = { .size = sizeof moved, .move = &move, .move_count = 1 };
        rsv_scene *next;
        if (rsv_light_relight(light, &moved) != RSV_OK) fail_msg("%s", rsv_last_error());
        rsv_light *loaded = reload(w, light, &next);
        rsv_light_destroy(light);
        rsv_scene_destroy(scene);
        light = loaded;
        scene = next;
        check_part_kept(light, first, 0);
        check_part_kept(light, first, 2);
    }
    check_near(light, first, 1e-4f);
    rsv_light_destroy(light);
    rsv_scene_destroy(scene);
    rsv_light_destroy(first);
    rsv_scene_destroy(first_scene);
    world_end(w);
}

static void roughly_sampled_parts_are_sampled_in_full_later(void **state)
{
    (void)state;
    const rsv_light_move move = { "bulb", { 0.5f, 0, 0 } };
    const rsv_light_scale off_now = { "lamp", { 0, 0, 0 } }, on_again = { "lamp", { 1, 1, 1 } };
    const rsv_relight_desc moved = { .size = sizeof moved, .move = &move, .move_count = 1 };
    const rsv_relight_desc both = {
        .size = sizeof both, .light = &off_now, .light_count = 1, .move = &move, .move_count = 1
    };
    world *w = yard();
    rsv_light *once = solve(w), *light = solve(w);
    rsv_relighter *relighter;
    assert_int_equal(rsv_light_relight(once, &moved), RSV_OK);
    assert_int_equal(rsv_relighter_create(light, &relighter), RSV_OK);
    assert_int_equal(rsv_relighter_change(relighter, &both), RSV_OK);
    rsv_relighter_destroy(relighter); // before it settles
    assert_int_equal(rsv_light_relight(light, &(rsv_relight_desc){ .size = sizeof(rsv_relight_desc),
                                                  .light = &on_again,
                                                  .light_count = 1 }),
        RSV_OK);
    check_near(light, once, 1e-3f);
    rsv_light_destroy(once);
    rsv_light_destroy(light);
    world_end(w);
}

// ---- lights of one name -----------------------------------------------------------------------------

/// Two bulbs and two lamps that are all called alike.
static world *twins(void)
{
    world *w = world_begin(2);
    rsv_material lamp = lambert_material(0, 5);
    lamp.name = "twin";
    uint32_t gray = world_lambert(w, 0.5f, 0), one = world_material(w, lamp),
             two = world_material(w, lamp);
    world_quad(w, gray, v3(-2, 0, 2), v3(2, 0, 2), v3(2, 0, -2), v3(-2, 0, -2));
    world_quad(
        w, one, v3(-1.3f, 2, -0.3f), v3(-0.9f, 2, -0.3f), v3(-0.9f, 2, 0.1f), v3(-1.3f, 2, 0.1f));
    world_quad(
        w, two, v3(0.9f, 2, -0.3f), v3(1.3f, 2, -0.3f), v3(1.3f, 2, 0.1f), v3(0.9f, 2, 0.1f));
    for (int k = 0; k < 2; k++) {
        const rsv_punctual_light bulb = { .name = "twin",
            .kind = RSV_PUNCTUAL_POINT,
            .position = { k ? 1.0f : -1.0f, 1.5f, 1 },
            .intensity = { 1, 1, 1 } };
        assert_int_equal(rsv_scene_add_light(w->scene, &bulb), RSV_OK);
    }
    assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    return w;
}

static void lights_of_one_name_are_told_apart_by_number(void **state)
{
    (void)state;
    world *w = twins();
    rsv_light *light = solve(w);
    uint32_t number = rsv_light_find_source(light, RSV_LIGHT_PUNCTUAL, 1);
    assert_int_equal(number, 3); // two materials and a light come first
    assert_int_equal(rsv_light_find_source(light, RSV_LIGHT_MATERIAL, 0), RSV_NONE);
    assert_int_equal(rsv_light_find_source(light, RSV_LIGHT_SURROUNDINGS, 0), RSV_NONE);
    rsv_light_scale scale = { "#3", { 0, 0, 0 } };
    rsv_light_move move = { "#1", { 0, 0.5f, 0 } };
    const rsv_relight_desc desc = {
        .size = sizeof desc, .light = &scale, .light_count = 1, .move = &move, .move_count = 1
    };
    assert_int_equal(rsv_light_relight(light, &desc), RSV_OK);
    const rsv_scene_view *lit = rsv_scene_get_view(rsv_light_scene(light));
    assert_true(lit->light[0].intensity.r == 1 && lit->light[1].intensity.r == 0);
    rsv_relighter *relighter;
    assert_int_equal(rsv_relighter_create(light, &relighter), RSV_OK);
    rsv_relight_source lamp = rsv_relighter_source(relighter, 1);
    assert_int_equal(lamp.kind, RSV_LIGHT_MATERIAL);
    assert_int_equal(lamp.index, 2);
    assert_float_equal(lamp.position.y, 2.5f, 1e-5f);
    assert_float_equal(rsv_relighter_source(relighter, 0).position.y, 2, 1e-5f);
    rsv_relighter_destroy(relighter);
    scale.name = "#4";
    assert_int_equal(rsv_light_relight(light, &desc), RSV_ERROR_ARGUMENT);
    assert_non_null(strstr(rsv_last_error(), "'#4'"));
    rsv_light_destroy(light);
    world_end(w);
}

static void a_star_in_a_name_matches_any_text(void **state)
{
    (void)state;
    world *w = twins();
    rsv_light *light = solve(w);
    rsv_light_scale scale = { "tw*", { 0.5f, 0.5f, 0.5f } };
    const rsv_relight_desc desc = { .size = sizeof desc, .light = &scale, .light_count = 1 };
    assert_int_equal(rsv_light_relight(light, &desc), RSV_OK);
    const rsv_scene_view *lit = rsv_scene_get_view(rsv_light_scene(light));
    assert_true(lit->light[0].intensity.r == 0.5f && lit->light[1].intensity.r == 0.5f);
    assert_float_equal(lit->material[1].emission.r, 2.5f, 1e-6f);
    scale.name = "w*";
    assert_int_equal(rsv_light_relight(light, &desc), RSV_ERROR_ARGUMENT);
    rsv_light_destroy(light);
    world_end(w);
}

int main(int argc, char **argv)
{
    if (asks_for_more(argc, argv)) times = 20;
    const struct CMUnitTest quick[] = {
        cmocka_unit_test(lights_that_were_switched_off_are_switched_on_again),
        cmocka_unit_test(factors_do_not_compound),
        cmocka_unit_test(what_is_not_named_stays_as_it_was),
        cmocka_unit_test(files_and_copies_know_how_lights_stand),
        cmocka_unit_test(roughly_sampled_parts_are_sampled_in_full_later),
        cmocka_unit_test(lights_of_one_name_are_told_apart_by_number),
        cmocka_unit_test(a_star_in_a_name_matches_any_text),
    };
    const struct CMUnitTest longest[] = {
        cmocka_unit_test(factors_do_not_compound),
        cmocka_unit_test(chains_through_files_keep_what_does_not_move),
    };
    return RUN_HALF(argc, argv, quick, longest);
}
