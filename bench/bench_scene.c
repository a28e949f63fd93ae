#include "benchmarks.h"
#include "moving_scenes.h"

#include <string.h>

/// A closed box of albedo 0.95 with a lamp in it: hardly anything is absorbed, and the series takes its time.
static rsv_status create_bright_box(rsv_context *context, rsv_scene **scene)
{
    static const rsv_vec3 corner[8] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 1, 1, 0 },
        { 0, 0, 1.5f }, { 1, 0, 1.5f }, { 0, 1, 1.5f }, { 1, 1, 1.5f } };
    static const uint32_t inwards[36] = { 0, 1, 3, 0, 3, 2, 4, 7, 5, 4, 6, 7, 0, 2, 6, 0, 6, 4, 1,
        5, 7, 1, 7, 3, 0, 4, 5, 0, 5, 1, 2, 3, 7, 2, 7, 6 };
    rsv_material white = rsv_default_material();
    white.base_color = (rsv_rgb){ 0.95f, 0.95f, 0.95f };
    white.metallic = 0;
    white.specular = 0;
    rsv_punctual_light lamp = { .name = "lamp",
        .kind = RSV_PUNCTUAL_POINT,
        .position = { 0.3f, 0.8f, 1.1f },
        .intensity = { 1, 1, 1 } };
    rsv_mesh_desc box = { .name = "box",
        .positions = corner,
        .vertex_count = 8,
        .indices = inwards,
        .triangle_count = 12 };
    uint32_t mesh;
    rsv_status status = rsv_scene_create(context, scene);
    if (status == RSV_OK) status = rsv_scene_add_material(*scene, &white, &box.material);
    if (status == RSV_OK) status = rsv_scene_add_mesh(*scene, &box, &mesh);
    if (status == RSV_OK) status = rsv_scene_add_instance(*scene, mesh, NULL, NULL);
    if (status == RSV_OK) status = rsv_scene_add_light(*scene, &lamp);
    if (status == RSV_OK) status = rsv_scene_commit(*scene);
    return status;
}

rsv_scene *cli_open_bench_scene(const cli_bench_task *bench)
{
    rsv_context *context = bench->session->context;
    rsv_scene *scene = NULL;
    rsv_status status = strcmp(bench->scene, "bright-box") == 0
                            ? create_bright_box(context, &scene)
                            : cli_build_moving_scene(context, bench->scene, &scene);
    if (status == RSV_OK) return scene;
    if (!scene) return cli_open_scene(bench->session, bench->scene, NULL);
    cli_report_failure(bench->session, status);
    rsv_scene_destroy(scene);
    return NULL;
}

rsv_scene *cli_open_bench_body(const cli_bench_task *bench, size_t triangles)
{
    if (bench->session->mesh || !rsv_scene_is_builtin(bench->scene))
        return cli_open_scene(bench->session, bench->scene, NULL);
    rsv_scene *scene = NULL;
    rsv_builtin_desc desc = rsv_default_builtin_desc();
    desc.body_triangles = triangles;
    rsv_status status =
        rsv_scene_builtin_with(bench->session->context, bench->scene, &desc, &scene);
    if (status != RSV_OK) cli_report_failure(bench->session, status);
    return status == RSV_OK ? scene : NULL;
}
