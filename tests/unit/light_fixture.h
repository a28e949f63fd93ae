/// A scene under construction and everything that transport needs of it, for the tests of operator, solve, render
/// and trace. Counts allocations and can make them fail.
#ifndef RSV_TEST_LIGHT_FIXTURE_H
#define RSV_TEST_LIGHT_FIXTURE_H

#include "builtin/builtin.h"
#include "sources/lights.h"
#include "specular/specular_path.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

typedef struct world {
    rsv_context *context;
    rsv_scene *scene;
    rsv_transport_scene transport; ///< filled by world_commit
    rsv_tracer *tracer;
    rsv_bsdf *bsdf;
    rsv_lights *lights;
    atomic_long alive;         ///< allocations not released yet
    atomic_long until_failure; ///< allocations that still succeed; negative = all do
    bool fail_once;            ///< only one allocation fails, not all that follow
} world;

static inline void *world_allocate(void *user, size_t bytes)
{
    world *w = user;
    if (w->until_failure >= 0) {
        long left = w->until_failure--;
        if (left == 0) {
            if (!w->fail_once) w->until_failure = 0;
            return NULL;
        }
    }
    w->alive++;
    return aligned_alloc(64, bytes);
}

static inline void world_release(void *user, void *memory)
{
    ((world *)user)->alive--;
    free(memory);
}

/// @param device NULL = none
static inline world *world_begin_on(int threads, struct rsv_device *device)
{
    world *w = calloc(1, sizeof *w);
    assert_non_null(w);
    w->until_failure = -1;
    rsv_context_desc desc = rsv_default_context_desc();
    desc.thread_count = threads;
    desc.allocate = world_allocate;
    desc.release = world_release;
    desc.user = w;
    desc.device = device;
    assert_int_equal(rsv_context_create(&desc, &w->context), RSV_OK);
    assert_int_equal(rsv_scene_create(w->context, &w->scene), RSV_OK);
    return w;
}

static inline world *world_begin(int threads) { return world_begin_on(threads, NULL); }

static inline world *world_builtin_on(int threads, struct rsv_device *device, const char *name)
{
    world *w = world_begin_on(threads, device);
    rsv_scene_destroy(w->scene);
    assert_int_equal(rsv_scene_builtin(w->context, name, &w->scene), RSV_OK);
    return w;
}

static inline world *world_builtin(int threads, const char *name)
{
    return world_builtin_on(threads, NULL, name);
}

/// Releases everything and checks that nothing leaked through the context.
static inline void world_end(world *w)
{
    rsv_lights_destroy(w->lights);
    rsv_tracer_destroy(w->tracer);
    free(w->bsdf);
    rsv_scene_destroy(w->scene);
    rsv_context_destroy(w->context);
    assert_int_equal(w->alive, 0);
    free(w);
}

static inline uint32_t world_material(world *w, rsv_material material)
{
    uint32_t id;
    assert_int_equal(rsv_scene_add_material(w->scene, &material, &id), RSV_OK);
    return id;
}

static inline uint32_t world_lambert(world *w, float albedo, float radiance)
{
    uint32_t id;
    assert_int_equal(
        rsv_add_lambert(w->scene, "lambert", rgb_gray(albedo), rgb_gray(radiance), &id), RSV_OK);
    return id;
}

static inline rsv_material lambert_material(float albedo, float radiance)
{
    rsv_material material = rsv_default_material();
    material.base_color = rgb_gray(albedo);
    material.emission = rgb_gray(radiance);
    material.specular = 0;
    material.metallic = 0;
    return material;
}

static inline rsv_material mirror_material(float reflectance)
{
    rsv_material material = rsv_default_material();
    material.base_color = rgb_gray(reflectance);
    material.metallic = 1;
    material.roughness = 0;
    return material;
}

static inline rsv_material glass_material(void)
{
    rsv_material material = rsv_default_material();
    material.base_color = rgb_gray(1);
    material.metallic = 0;
    material.roughness = 0;
    material.transmission = 1;
    material.thickness = 1;
    return material;
}

static inline rsv_shape shape_of(world *w, uint32_t material)
{
    return (rsv_shape){ w->scene, "shape", material, NULL };
}

static inline void world_quad(
    world *w, uint32_t material, rsv_vec3 a, rsv_vec3 b, rsv_vec3 c, rsv_vec3 d)
{
    const rsv_vec3 corner[4] = { a, b, c, d };
    assert_int_equal(rsv_add_quad(shape_of(w, material), corner), RSV_OK);
}

static inline void world_room(world *w, uint32_t material, rsv_vec3 low, rsv_vec3 high)
{
    assert_int_equal(rsv_add_room(shape_of(w, material), low, high), RSV_OK);
}

static inline void world_box(world *w, uint32_t material, rsv_vec3 low, rsv_vec3 high)
{
    assert_int_equal(rsv_add_box(shape_of(w, material), low, high), RSV_OK);
}

static inline void world_sphere(
    world *w, uint32_t material, rsv_vec3 centre, float radius, int level)
{
    assert_int_equal(rsv_add_sphere(shape_of(w, material), centre, radius, level), RSV_OK);
}

/// A quad under texture coordinates.
static inline void world_textured_quad(
    world *w, const char *name, rsv_material m, const rsv_vec3 corner[4], const float uv[4][2])
{
    static const uint32_t index[6] = { 0, 1, 2, 0, 2, 3 };
    const rsv_mesh_desc quad = { .size = sizeof quad,
        .name = name,
        .positions = corner,
        .vertex_count = 4,
        .indices = index,
        .triangle_count = 2,
        .material = world_material(w, m),
        .uvs = { uv, NULL } };
    uint32_t mesh;
    assert_int_equal(rsv_scene_add_mesh(w->scene, &quad, &mesh), RSV_OK);
    assert_int_equal(rsv_scene_add_instance(w->scene, mesh, NULL, NULL), RSV_OK);
}

/// A quad with a texture of 4x4 texels, uneven in all channels, in each of these roles (4 at most).
static inline void world_pattern(world *w, rsv_material m, const rsv_vec3 corner[4],
    const rsv_texture_role *role, size_t role_count)
{
    enum { side = 4 };
    float texel[side * side][4];
    rsv_texture_ref ref[4];
    for (size_t k = 0; k < side * side; k++) {
        float x = (float)(k * 7 % 16) / 16;
        texel[k][0] = 0.4f + 0.2f * x;
        texel[k][1] = 0.9f - 0.5f * x;
        texel[k][2] = 0.8f + 0.2f * x;
        texel[k][3] = x;
    }
    rsv_texture_desc texture = { .size = sizeof texture,
        .name = "pattern",
        .width = side,
        .height = side,
        .channel_count = 4,
        .values = texel[0] };
    for (size_t k = 0; k < role_count; k++) {
        uint32_t id;
        texture.nearest = k == 0;
        assert_int_equal(rsv_scene_add_texture(w->scene, &texture, &id), RSV_OK);
        ref[k] = rsv_default_texture_ref(role[k], id);
        ref[k].transform[0][0] = 1.0f + 0.5f * (float)k;
    }
    m.textures = ref;
    m.texture_count = role_count;
    static const float uv[4][2] = { { 0, 0 }, { 0, 1 }, { 1, 1 }, { 1, 0 } };
    world_textured_quad(w, "pattern", m, corner, uv);
}

/// Grey on both sides, with holes of about half its area.
static inline void world_lattice(world *w, rsv_vec3 a, rsv_vec3 b, rsv_vec3 c, rsv_vec3 d)
{
    static const rsv_texture_role role[] = { RSV_TEXTURE_OPACITY, RSV_TEXTURE_BASE_COLOR };
    const rsv_vec3 corner[4] = { a, b, c, d };
    rsv_material lattice = lambert_material(0.7f, 0);
    lattice.double_sided = true;
    lattice.alpha_cutoff = 0.5f;
    world_pattern(w, lattice, corner, role, 2);
}

/// A quad that shines unevenly.
static inline void world_screen(
    world *w, float radiance, rsv_vec3 a, rsv_vec3 b, rsv_vec3 c, rsv_vec3 d)
{
    static const rsv_texture_role role[] = { RSV_TEXTURE_EMISSION };
    const rsv_vec3 corner[4] = { a, b, c, d };
    world_pattern(w, lambert_material(0, radiance), corner, role, 1);
}

/// Flat triangles of one mesh.
static inline void world_triangles(world *w, uint32_t material, const rsv_vec3 *position,
    size_t vertex_count, const uint32_t *index, size_t triangle_count)
{
    rsv_mesh_desc mesh = { .size = sizeof mesh,
        .name = "triangles",
        .positions = position,
        .vertex_count = vertex_count,
        .indices = index,
        .triangle_count = triangle_count,
        .material = material };
    uint32_t id;
    assert_int_equal(rsv_scene_add_mesh(w->scene, &mesh, &id), RSV_OK);
    assert_int_equal(rsv_scene_add_instance(w->scene, id, NULL, NULL), RSV_OK);
}

/// Commits the scene, if that is not done yet, and prepares transport.
static inline void world_commit(world *w)
{
    if (!rsv_scene_get_view(w->scene)->triangle_count)
        assert_int_equal(rsv_scene_commit(w->scene), RSV_OK);
    const rsv_scene_view *view = rsv_scene_get_view(w->scene);
    w->bsdf = calloc(view->material_count, sizeof *w->bsdf);
    assert_non_null(w->bsdf);
    for (size_t m = 0; m < view->material_count; m++) {
        w->bsdf[m] = rsv_bsdf_from_material(&view->material[m]);
    }
    assert_int_equal(rsv_tracer_create(w->scene, &w->tracer), RSV_OK);
    assert_int_equal(rsv_lights_create(w->scene, w->bsdf, &w->lights), RSV_OK);
    w->transport = (rsv_transport_scene){ .scene = w->scene,
        .view = view,
        .tracer = w->tracer,
        .bsdf = w->bsdf,
        .media = rsv_media_of(view, w->tracer, w->bsdf) };
}

static inline void assert_close(double value, double expected, double tolerance)
{
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%.9g differs from %.9g by more than %.3g", value, expected, tolerance);
}

/// FNV-1a, to compare arrays between runs.
static inline uint64_t hash_bytes(uint64_t hash, const void *data, size_t bytes)
{
    const uint8_t *byte = data;
    for (size_t k = 0; k < bytes; k++)
        hash = (hash ^ byte[k]) * 0x100000001b3ull;
    return hash;
}

#define HASH_START 0xcbf29ce484222325ull

#endif
