/// Which way metal is brushed: by texture coordinates, a rotation and a texture of directions.
#include "core/vec.h"
#include "resolvent/scene.h"
#include "surface/surface.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

static int set_up(void **state) { return rsv_context_create(NULL, (rsv_context **)state); }

static int tear_down(void **state)
{
    rsv_context_destroy(*state);
    return 0;
}

static rsv_material brushed(float rotation)
{
    rsv_material m = rsv_default_material();
    m.metallic = 1;
    m.roughness = 0.5f;
    m.anisotropy = 0.8f;
    m.anisotropy_rotation = rotation;
    return m;
}

/// A floor whose texture coordinates are x and z, v running down towards +z: up in the texture is -z.
static rsv_scene *floor_of(
    rsv_context *context, rsv_material material, const uint8_t *texel, bool uvs)
{
    const rsv_vec3 corner[] = { { 0, 0, 1 }, { 1, 0, 1 }, { 1, 0, 0 }, { 0, 0, 0 } };
    const float uv[][2] = { { 0, 1 }, { 1, 1 }, { 1, 0 }, { 0, 0 } };
    const uint32_t index[] = { 0, 1, 2, 0, 2, 3 };
    rsv_scene *scene;
    rsv_texture_ref ref;
    uint32_t id, mesh;
    assert_int_equal(rsv_scene_create(context, &scene), RSV_OK);
    if (texel) {
        const rsv_texture_desc desc = {
            .size = sizeof desc, .width = 1, .height = 1, .channel_count = 3, .codes = texel
        };
        assert_int_equal(rsv_scene_add_texture(scene, &desc, &id), RSV_OK);
        ref = rsv_default_texture_ref(RSV_TEXTURE_ANISOTROPY, id);
        material.textures = &ref;
        material.texture_count = 1;
    }
    assert_int_equal(rsv_scene_add_material(scene, &material, &id), RSV_OK);
    const rsv_mesh_desc desc = { .size = sizeof desc,
        .positions = corner,
        .vertex_count = 4,
        .indices = index,
        .triangle_count = 2,
        .material = id,
        .uvs = { uvs ? uv : NULL } };
    assert_int_equal(rsv_scene_add_mesh(scene, &desc, &mesh), RSV_OK);
    assert_int_equal(rsv_scene_add_instance(scene, mesh, NULL, NULL), RSV_OK);
    assert_int_equal(rsv_scene_commit(scene), RSV_OK);
    return scene;
}

static rsv_bsdf bsdf_on(const rsv_scene *scene)
{
    rsv_bsdf storage, common = rsv_surface_common_bsdf(rsv_scene_get_view(scene), 0);
    rsv_footprint at = { 0, 0.3f, 0.3f, 0, RSV_CHANNEL_ALL };
    return *rsv_surface_bsdf(rsv_scene_get_view(scene), &common, at, &storage);
}

static void assert_direction(rsv_vec3 found, float x, float z)
{
    assert_float_equal(found.x, x, 5e-3);
    assert_float_equal(found.y, 0, 1e-6);
    assert_float_equal(found.z, z, 5e-3);
}

static void brush_follows_texture_coordinates_and_rotation(void **state)
{
    for (int k = 0; k < 8; k++) {
        float turn = 0.7f * (float)k;
        rsv_scene *scene = floor_of(*state, brushed(turn), NULL, true);
        rsv_bsdf bsdf = bsdf_on(scene);
        assert_true(bsdf.brushed);
        assert_direction(bsdf.brush, cosf(turn), -sinf(turn));
        assert_float_equal(bsdf.brush_across, 0.25f, 1e-6);
        assert_float_equal(bsdf.brush_along, 0.25f + 0.75f * 0.64f, 1e-6);
        rsv_scene_destroy(scene);
    }
}

static void texture_turns_and_weakens(void **state)
{
    const uint8_t up_half[3] = { 128, 255, 128 };
    rsv_scene *scene = floor_of(*state, brushed(0.5f), up_half, true);
    rsv_bsdf bsdf = bsdf_on(scene);
    assert_direction(bsdf.brush, -sinf(0.5f), -cosf(0.5f));
    assert_float_equal(bsdf.brush_along, 0.25f + 0.75f * 0.16f, 2e-3);
    rsv_scene_destroy(scene);
}

/// Any direction will do, and nothing is undefined.
static void surfaces_without_coordinates_are_brushed_somehow(void **state)
{
    rsv_scene *scene = floor_of(*state, brushed(0), NULL, false);
    rsv_bsdf bsdf = bsdf_on(scene);
    rsv_vec3 up = v3(0, 1, 0), wo = v3_normalize(v3(0.3f, 1, 0.2f));
    rsv_rgb value = rsv_bsdf_eval(&bsdf, v3_normalize(v3(-0.3f, 1, -0.2f)), wo, up, true);
    assert_true(bsdf.brushed && isfinite(value.r) && value.r > 0);
    rsv_scene_destroy(scene);
}

static void dielectrics_are_only_wider(void **state)
{
    rsv_material m = brushed(0);
    m.metallic = 0;
    rsv_scene *scene = floor_of(*state, m, NULL, true);
    assert_int_equal(rsv_scene_get_view(scene)->material_varies[0], 0);
    rsv_bsdf bsdf = bsdf_on(scene);
    assert_false(bsdf.brushed);
    assert_float_equal(bsdf.alpha, sqrtf(0.25f * (0.25f + 0.75f * 0.64f)), 1e-6);
    rsv_scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(brush_follows_texture_coordinates_and_rotation),
        cmocka_unit_test(texture_turns_and_weakens),
        cmocka_unit_test(surfaces_without_coordinates_are_brushed_somehow),
        cmocka_unit_test(dielectrics_are_only_wider),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
