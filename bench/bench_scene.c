#include "benchmarks.h"
#include "box_mesh.h"
#include "moving_scenes.h"

#include <string.h>

/// A closed box of albedo 0.95 with a lamp in it: hardly anything is absorbed, and the series takes its time.
static rsv_status create_bright_box(rsv_context *context, rsv_scene **scene)
{
    rsv_material white = rsv_default_material();
    white.base_color = (rsv_rgb){ 0.95f, 0.95f, 0.95f };
    white.metallic = 0;
    white.specular = 0;
    rsv_punctual_light lamp = { .name = "lamp",
        .kind = RSV_PUNCTUAL_POINT,
        .position = { 0.3f, 0.8f, 1.1f },
        .intensity = { 1, 1, 1 } };
    uint32_t material;
    rsv_status status = rsv_scene_create(context, scene);
    if (status == RSV_OK) status = rsv_scene_add_material(*scene, &white, &material);
    if (status == RSV_OK)
        status = cli_add_box(*scene, "box", (rsv_vec3){ 0, 0, 0 }, (rsv_vec3){ 1, 1, 1.5f },
            CLI_FACES_INWARDS, material);
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
