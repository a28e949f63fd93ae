/// Two lightings of one room, alive side by side: the operator is built once and shared.
#include <resolvent/resolvent.h>

#include <stdio.h>

/// Scales the lamp of `light`; the other lighting stays as it is.
static rsv_status dim(rsv_light *light, const char *lamp, float factor)
{
    rsv_light_scale scale = { lamp, { factor, factor, factor } };
    rsv_relight_desc relight = rsv_default_relight_desc();
    relight.light = &scale;
    relight.light_count = 1;
    return rsv_light_relight(light, &relight);
}

/// Irradiance in the middle of the first two triangles of the ceiling, in one call.
static rsv_status read_ceiling(const rsv_light *light, rsv_rgb irradiance[2])
{
    const rsv_scene *scene = rsv_light_scene(light);
    uint32_t first, ceiling = rsv_scene_find_object(scene, "ceiling");
    if (rsv_scene_object_triangles(scene, ceiling, &first) < 2) return RSV_ERROR_SCENE;
    const rsv_triangle_point points[2] = { { first, 0.3f, 0.3f, false },
        { first + 1, 0.3f, 0.3f, false } };
    return rsv_light_irradiance_points(light, points, 2, RSV_NONE, irradiance);
}

int main(void)
{
    rsv_context *context = NULL;
    rsv_scene *scene = NULL;
    rsv_light *day = NULL, *evening = NULL;
    rsv_rgb bright[2], dim_light[2];
    rsv_solve_desc solve = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_status status = rsv_context_create(NULL, &context);
    if (status == RSV_OK) status = rsv_scene_builtin(context, "cornell-blocks", &scene);
    if (status == RSV_OK) status = rsv_light_create(scene, &solve, &day);
    if (status == RSV_OK) status = rsv_light_copy(day, &evening);
    if (status == RSV_OK) status = dim(evening, "light", 0.1f);
    if (status == RSV_OK) status = read_ceiling(day, bright);
    if (status == RSV_OK) status = read_ceiling(evening, dim_light);
    if (status == RSV_OK)
        for (int k = 0; k < 2; k++)
            printf("triangle %d: %.4f W/m2 by day, %.4f in the evening\n", k, (double)bright[k].r,
                (double)dim_light[k].r);
    else
        fprintf(stderr, "error: %s\n", rsv_last_error());
    bool shared = status == RSV_OK && rsv_light_operator(day) == rsv_light_operator(evening);
    bool dimmed = shared && dim_light[0].r > 0 && dim_light[0].r < 0.2f * bright[0].r;
    rsv_light_destroy(day); // in any order
    rsv_light_destroy(evening);
    rsv_scene_destroy(scene);
    rsv_context_destroy(context);
    return !dimmed;
}
