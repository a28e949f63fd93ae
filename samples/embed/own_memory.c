/// A room built in code, solved with the program's own allocator and messages. C17 and C++17, as all samples here.
#include <resolvent/resolvent.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static void *take(void *user, size_t bytes)
{
    void *memory = aligned_alloc(64, (bytes + 63) / 64 * 64);
    if (memory)
        __atomic_add_fetch((long *)user, 1, __ATOMIC_RELAXED); // worker threads call it, too
    return memory;
}

static void give(void *user, void *memory)
{
    if (memory) __atomic_sub_fetch((long *)user, 1, __ATOMIC_RELAXED);
    free(memory);
}

static void say(void *user, rsv_log_level level, const char *message)
{
    (void)user;
    printf("%s: %s\n", level == RSV_LOG_WARNING ? "warning" : "note", message);
}

/// A square of `size` metres whose normal is +y, turned about x by `angle` and moved to (0, y, z).
static rsv_status add_square(
    rsv_scene *scene, uint32_t material, float size, float angle, float y, float z)
{
    const float h = size / 2, c = cosf(angle), s = sinf(angle);
    const rsv_vec3 corner[4] = { { -h, 0, -h }, { -h, 0, h }, { h, 0, h }, { h, 0, -h } };
    const uint32_t triangles[6] = { 0, 1, 2, 0, 2, 3 };
    const float place[16] = { 1, 0, 0, 0, 0, c, s, 0, 0, -s, c, 0, 0, y, z, 1 };
    uint32_t mesh;
    rsv_mesh_desc desc = rsv_default_mesh_desc();
    desc.positions = corner;
    desc.vertex_count = 4;
    desc.indices = triangles;
    desc.triangle_count = 2;
    desc.material = material;
    rsv_status status = rsv_scene_add_mesh(scene, &desc, &mesh);
    return status == RSV_OK ? rsv_scene_add_instance(scene, mesh, place, "square") : status;
}

/// A floor, a wall behind it, and a lamp of 0.5 m above.
static rsv_status build(rsv_scene *scene)
{
    uint32_t plaster, lamp;
    rsv_material material = rsv_default_material();
    material.base_color.r = material.base_color.g = material.base_color.b = 0.7f;
    rsv_status status = rsv_scene_add_material(scene, &material, &plaster);
    material.emission.r = material.emission.g = material.emission.b = 20;
    if (status == RSV_OK) status = rsv_scene_add_material(scene, &material, &lamp);
    if (status == RSV_OK) status = add_square(scene, plaster, 4, 0, 0, 0);
    if (status == RSV_OK) status = add_square(scene, plaster, 4, 1.5708f, 2, -2);
    if (status == RSV_OK) status = add_square(scene, lamp, 0.5f, 3.1416f, 2.5f, 0);
    return status == RSV_OK ? rsv_scene_commit(scene) : status;
}

int main(void)
{
    long blocks = 0;
    rsv_context *context = NULL;
    rsv_scene *scene = NULL;
    rsv_light *light = NULL;
    rsv_context_desc own = rsv_default_context_desc();
    own.allocate = take;
    own.release = give;
    own.log = say;
    own.user = &blocks;
    rsv_solve_desc solve = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_status status = rsv_context_create(&own, &context);
    if (status == RSV_OK) status = rsv_scene_create(context, &scene);
    if (status == RSV_OK) status = build(scene);
    if (status == RSV_OK) status = rsv_light_create(scene, &solve, &light);
    if (status == RSV_OK)
        printf("%.3f W/m2 in the mean, %ld blocks of memory\n",
            rsv_light_report(light)->mean_irradiance, blocks);
    else
        fprintf(stderr, "error: %s\n", rsv_last_error());
    rsv_light_destroy(light);
    rsv_scene_destroy(scene);
    rsv_context_destroy(context);
    return status != RSV_OK || blocks != 0; // all of it came back
}
