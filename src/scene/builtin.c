#include "builtin.h"

#include <string.h>

static const char *const builtin_names[] = { "cornell-blocks", "cornell-spheres", "cornell-glass",
    "cornell-marble", "character", "furnace", "two-rooms", NULL };

/// In the order of their names; one of the two.
static const struct {
    rsv_status (*build)(rsv_scene *);
    rsv_status (*build_around)(rsv_scene *, const rsv_builtin_desc *);
} generators[] = { { rsv_build_cornell_blocks, NULL }, { rsv_build_cornell_spheres, NULL },
    { NULL, rsv_build_cornell_glass }, { NULL, rsv_build_cornell_marble },
    { NULL, rsv_build_character }, { rsv_build_furnace, NULL }, { rsv_build_two_rooms, NULL } };

const char *const *rsv_scene_builtin_names(void) { return builtin_names; }

rsv_builtin_desc rsv_default_builtin_desc(void)
{
    return (rsv_builtin_desc){ .body_triangles = 60000 };
}

static rsv_status generate(size_t i, const rsv_builtin_desc *desc, rsv_scene *scene)
{
    if (generators[i].build_around) return generators[i].build_around(scene, desc);
    if (desc->body)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "scene '%s' takes no mesh; cornell-glass, cornell-marble and character do",
            builtin_names[i]);
    return generators[i].build(scene);
}

rsv_status rsv_scene_builtin_with(
    rsv_context *context, const char *name, const rsv_builtin_desc *desc, rsv_scene **scene)
{
    rsv_status status;
    rsv_scene *built = NULL;
    const rsv_builtin_desc defaults = rsv_default_builtin_desc();
    size_t i = 0;
    if (!desc) desc = &defaults;
    while (builtin_names[i] && strcmp(builtin_names[i], name) != 0)
        i++;
    if (!builtin_names[i])
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "there is no built-in scene '%s'; use cornell-blocks, cornell-spheres, cornell-glass, "
            "cornell-marble, character, furnace or two-rooms",
            name);
    if (desc->body_triangles < 100 || desc->body_triangles > 20000000)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "a body of %zu triangles is not possible; ask for 100 to 20,000,000",
            desc->body_triangles);
    RSV_TRY(rsv_scene_create(context, &built));
    RSV_TRY(generate(i, desc, built));
    RSV_TRY(rsv_scene_commit(built));
    *scene = built;
    return RSV_OK;
cleanup:
    rsv_scene_destroy(built);
    return status;
}

rsv_status rsv_scene_builtin(rsv_context *context, const char *name, rsv_scene **scene)
{
    return rsv_scene_builtin_with(context, name, NULL, scene);
}

rsv_status rsv_add_lambert(
    rsv_scene *scene, const char *name, rsv_rgb albedo, rsv_rgb radiance, uint32_t *material_id)
{
    rsv_material material = rsv_default_material();
    material.name = name;
    material.base_color = albedo;
    material.specular = 0;
    material.emission = radiance;
    return rsv_scene_add_material(scene, &material, material_id);
}

rsv_status rsv_build_furnace(rsv_scene *scene)
{
    rsv_status status;
    uint32_t walls;
    // exitance 1 W/m2; with albedo 1/2 the radiosity is 2 W/m2 everywhere
    RSV_TRY(rsv_add_lambert(scene, "walls", rgb_gray(0.5f), rgb_gray(1 / RSV_PI), &walls));
    RSV_TRY(rsv_add_room((rsv_shape){ scene, "furnace", walls, NULL }, v3(0, 0, 0), v3(1, 1, 1)));
    rsv_camera camera =
        rsv_camera_look_at("inside", v3(0.3f, 0.4f, 0.9f), v3(0.6f, 0.5f, 0), 60 * RSV_PI / 180, 1);
    RSV_TRY(rsv_scene_add_camera(scene, &camera));
cleanup:
    return status;
}
