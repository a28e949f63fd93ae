/// Random materials and rooms: what every mode of rendering shows of them.
#include "resolvent/render.h"
#include "resolvent/solve.h"
#include "unit/random_scene.h"
#include "unit/scene_fixture.h"
#include "unit/slow_tests.h"

static rsv_scene *begin_scene(fixture *f)
{
    rsv_scene *scene;
    assert_int_equal(rsv_scene_create(f->context, &scene), RSV_OK);
    return scene;
}

// ---- the scenes themselves ----------------------------------------------------------------------

static uint64_t hash_of(const void *data, size_t bytes, uint64_t hash)
{
    const uint8_t *byte = data;
    for (size_t k = 0; k < bytes; k++)
        hash = (hash ^ byte[k]) * 0x100000001b3ull;
    return hash;
}

static uint64_t hash_of_scene(const rsv_scene *scene)
{
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    uint64_t hash = 0xcbf29ce484222325ull;
    hash = hash_of(view->position, view->vertex_count * sizeof *view->position, hash);
    for (size_t k = 0; k < view->material_count; k++)
        hash = hash_of(view->material[k].name, strlen(view->material[k].name), hash);
    return hash;
}

/// Another seed is another scene, the same seed the same; and no part of them is warned of.
static void a_seed_names_a_scene(void **state)
{
    fixture *f = *state;
    uint64_t hash[2][8];
    for (int again = 0; again < 2; again++)
        for (uint32_t seed = 0; seed < 8; seed++) {
            rsv_scene *scene = begin_scene(f);
            assert_int_equal(random_room(scene, seed), RSV_OK);
            hash[again][seed] = hash_of_scene(scene);
            rsv_scene_destroy(scene);
        }
    assert_memory_equal(hash[0], hash[1], sizeof hash[0]);
    for (int k = 1; k < 8; k++)
        assert_true(hash[0][k] != hash[0][k - 1]);
    rsv_scene *scene = begin_scene(f);
    assert_int_equal(random_furnace(scene, 0, 20), RSV_OK);
    assert_int_equal(rsv_scene_get_view(scene)->camera_count, 20);
    rsv_scene_destroy(scene);
    assert_string_equal(f->log, "");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_seed_names_a_scene, fixture_setup, fixture_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
