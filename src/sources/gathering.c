/// Selects emitters that gather rays find best: those that fill much of the view of the scene's surfaces.
#include "lights_internal.h"

#define VIEW_POINTS 64
/// With more emitters than this, every second (third, ...) one stands for its neighbours.
#define VIEW_EMITTERS 4096

static double triangle_area(const rsv_scene_view *scene, size_t triangle)
{
    const uint32_t *index = scene->triangle[triangle];
    rsv_vec3 a = scene->position[index[0]];
    rsv_vec3 edge1 = v3_sub(scene->position[index[1]], a);
    return 0.5 * v3_length(v3_cross(edge1, v3_sub(scene->position[index[2]], a)));
}

/// Adds to each group the part of the hemisphere at a surface point that it fills, cosine-weighted
/// and without occlusion.
static void add_view(const rsv_lights *lights, rsv_vec3 point, rsv_vec3 normal)
{
    size_t stride = lights->emitter_count / VIEW_EMITTERS + 1;
    double scale = (double)stride / ((double)RSV_PI * VIEW_POINTS);
    for (size_t i = 0; i < lights->emitter_count; i += stride) {
        const rsv_emitter *emitter = &lights->emitter[i];
        if (rsv_emitter_faces(emitter, point))
            lights->group[emitter->group].share +=
                scale * rsv_polygon_irradiance(emitter->corner, 3, point, normal);
    }
}

static void add_view_from_triangle(const rsv_lights *lights, size_t triangle, uint32_t index)
{
    const rsv_scene_view *scene = lights->scene;
    const uint32_t *corner = scene->triangle[triangle];
    rsv_vec3 a = scene->position[corner[0]], b = scene->position[corner[1]],
             c = scene->position[corner[2]];
    float x, y, u, v;
    rsv_sobol_2d(index, 0, &x, &y);
    rsv_square_to_triangle(x, y, &u, &v);
    rsv_vec3 normal = v3_normalize(v3_cross(v3_sub(b, a), v3_sub(c, a)));
    add_view(lights, v3_barycentric(a, b, c, u, v), normal);
}

/// Looks from points spread evenly over the area of all surfaces.
static void measure_shares(const rsv_lights *lights)
{
    const rsv_scene_view *scene = lights->scene;
    double total = 0, passed = 0;
    for (size_t i = 0; i < scene->triangle_count; i++)
        total += triangle_area(scene, i);
    uint32_t index = 0;
    for (size_t i = 0; i < scene->triangle_count; i++) {
        passed += triangle_area(scene, i);
        for (; index < VIEW_POINTS && (index + 0.5) * total < passed * VIEW_POINTS; index++)
            add_view_from_triangle(lights, i, index);
    }
}

void rsv_lights_choose_gathered(rsv_lights *lights)
{
    measure_shares(lights);
    double total = 0, mean_radiance = 0;
    for (size_t i = 0; i < lights->group_count; i++) {
        const rsv_emitter_group *group = &lights->group[i];
        total += group->share;
        mean_radiance += group->share * rgb_luminance(lights->emitter[group->first].radiance);
    }
    for (size_t i = 0; i < lights->group_count; i++) {
        rsv_emitter_group *group = &lights->group[i];
        double radiance = rgb_luminance(lights->emitter[group->first].radiance);
        bool stands_out = radiance > RSV_GATHERED_CONTRAST * mean_radiance;
        group->gathered =
            group->share > RSV_GATHERED_SHARE || (total > RSV_GATHERED_TOTAL_SHARE && !stands_out);
    }
}
