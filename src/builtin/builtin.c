#include "builtin.h"
#include "../core/descriptor.h"

#include "../core/number_text.h"

#include <string.h>

static const char *const builtin_names[] = { "cornell-blocks", "cornell-spheres", "cornell-glass",
    "cornell-marble", "cornell-plaster", "cornell-showcase", "character", "furnace", "two-rooms",
    "gallery", "terraces", "fog-rooms", "milk", "smoke", NULL };

/// Unit and range of a scene's size, if it can be chosen.
typedef struct size_range {
    const char *unit;
    double standard, least, most;
} size_range;

/// In the order of their names; one of the first three.
static const struct {
    rsv_status (*build)(rsv_scene *);
    rsv_status (*build_around)(rsv_scene *, const rsv_builtin_desc *);
    rsv_status (*build_sized)(rsv_scene *, double size);
    rsv_status (*fill)(rsv_scene *); ///< the air of the committed scene; NULL = it is clear
    size_range size;
} generators[] = {
    { .build = rsv_build_cornell_blocks },
    { .build = rsv_build_cornell_spheres },
    { .build_around = rsv_build_cornell_glass },
    { .build_around = rsv_build_cornell_marble },
    { .build_around = rsv_build_cornell_plaster },
    { .build_around = rsv_build_cornell_showcase },
    { .build_around = rsv_build_character },
    { .build = rsv_build_furnace },
    { .build = rsv_build_two_rooms },
    { .build_sized = rsv_build_gallery, .size = { "rooms", 6, 1, 10000 } },
    { .build_sized = rsv_build_terraces, .size = { "triangles", 1e5, 5000, 1e8 } },
    { .build = rsv_build_fog_rooms, .fill = rsv_fill_fog_rooms },
    { .build = rsv_build_milk },
    { .build = rsv_build_smoke, .fill = rsv_fill_smoke },
};

const char *const *rsv_scene_builtin_names(void) { return builtin_names; }

void rsv_builtin_desc_init(rsv_builtin_desc *desc, size_t size)
{
    const rsv_builtin_desc defaults = { .size = sizeof defaults, .body_triangles = 60000 };
    rsv_desc_fill(desc, size, &defaults);
}

/// Index of the scene that `name`, up to its size, names; of the NULL at the end if there is none.
static size_t find_builtin(const char *name)
{
    size_t length = strcspn(name, ":"), i = 0;
    while (builtin_names[i] &&
           (strlen(builtin_names[i]) != length || strncmp(builtin_names[i], name, length) != 0))
        i++;
    return i;
}

bool rsv_scene_is_builtin(const char *name) { return builtin_names[find_builtin(name)] != NULL; }

/// Reads the size behind the colon in a scene's name.
static rsv_status read_size(size_t i, const char *name, double *size)
{
    const size_range *range = &generators[i].size;
    const char *text = strchr(name, ':');
    char *end;
    *size = range->standard;
    if (!text) return RSV_OK;
    if (!generators[i].build_sized)
        return rsv_fail(RSV_ERROR_ARGUMENT, "scene '%s': %s has no size to choose; leave out '%s'",
            name, builtin_names[i], text);
    *size = rsv_number_value(text + 1, &end);
    if (end == text + 1 || *end || !(*size >= range->least && *size <= range->most) ||
        *size != floor(*size))
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "scene '%s': a whole number of %s from %.0f to %.0f must follow the colon", name,
            range->unit, range->least, range->most);
    return RSV_OK;
}

static rsv_status generate(
    size_t i, const char *name, const rsv_builtin_desc *desc, rsv_scene *scene)
{
    double size;
    rsv_status status = read_size(i, name, &size);
    if (status != RSV_OK) return status;
    if (generators[i].build_around) return generators[i].build_around(scene, desc);
    if (desc->body)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "scene '%s' takes no mesh; cornell-glass, -marble, -plaster, -showcase and character "
            "do",
            builtin_names[i]);
    return generators[i].build_sized ? generators[i].build_sized(scene, size)
                                     : generators[i].build(scene);
}

rsv_status rsv_scene_builtin_with(
    rsv_context *context, const char *name, const rsv_builtin_desc *desc, rsv_scene **scene)
{
    rsv_status status;
    rsv_scene *built = NULL;
    rsv_builtin_desc settings = rsv_default_builtin_desc();
    size_t i = find_builtin(name);
    RSV_TRY(RSV_READ_DESC(rsv_builtin_desc, &settings, desc));
    if (!builtin_names[i])
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "there is no built-in scene '%s'; use cornell-blocks, cornell-spheres, cornell-glass, "
            "cornell-marble, cornell-plaster, cornell-showcase, character, furnace, two-rooms, "
            "gallery, terraces, fog-rooms, milk or smoke",
            name);
    if (settings.body_triangles < 100 || settings.body_triangles > 20000000)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "a body of %zu triangles is not possible; ask for 100 to 20,000,000",
            settings.body_triangles);
    RSV_TRY(rsv_scene_create(context, &built));
    RSV_TRY(generate(i, name, &settings, built));
    RSV_TRY(rsv_scene_commit(built));
    if (generators[i].fill) RSV_TRY(generators[i].fill(built));
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
