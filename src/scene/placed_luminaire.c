#include "placed_luminaire.h"

#include "punctual.h"
#include "resolvent/luminaire.h"
#include "scene.h"

#include <fnmatch.h>
#include <string.h>

bool rsv_name_is_meant(const char *pattern, const char *name)
{
    return name && fnmatch(pattern, name, 0) == 0;
}

// ---- luminaires -----------------------------------------------------------------------------------

static void normalize(rsv_luminaire *l)
{
    double peak = rsv_luminaire_peak(l);
    size_t count = (size_t)l->vertical_count * l->horizontal_count;
    for (size_t k = 0; k < count && peak > 0; k++)
        l->intensity[k] = (float)((double)l->intensity[k] / peak);
}

rsv_status rsv_scene_add_luminaire(rsv_scene *scene, const rsv_luminaire *luminaire, uint32_t *id)
{
    rsv_status status;
    rsv_luminaire copy = { 0 };
    if (scene->base)
        return rsv_fail(RSV_ERROR_ARGUMENT, "scene: luminaires are added to the scene itself");
    RSV_TRY(rsv_luminaire_check(luminaire));
    RSV_TRY(rsv_grow(scene->context, (void **)&scene->luminaire, &scene->luminaire_capacity,
        scene->luminaire_count + 1, sizeof copy));
    RSV_TRY(rsv_luminaire_copy(scene->context, luminaire, &copy));
    normalize(&copy);
    if (id) *id = (uint32_t)scene->luminaire_count;
    scene->luminaire[scene->luminaire_count++] = copy;
    scene->view.luminaire = scene->luminaire;
    scene->view.luminaire_count = scene->luminaire_count;
    return RSV_OK;
cleanup:
    rsv_luminaire_free(scene->context, &copy);
    return status;
}

rsv_punctual_light rsv_luminaire_light(const rsv_luminaire *luminaire, uint32_t id)
{
    float peak = (float)(rsv_luminaire_peak(luminaire) / RSV_LUMEN_PER_WATT);
    return (rsv_punctual_light){ .name = luminaire->name,
        .kind = RSV_PUNCTUAL_LUMINAIRE,
        .direction = { 0, -1, 0 },
        .side = { 1, 0, 0 },
        .intensity = rgb_gray(peak),
        .outer_cone_angle = (float)(rsv_luminaire_cutoff(luminaire) * M_PI / 180),
        .luminaire = id,
        .opening = rsv_luminaire_opening(luminaire) };
}

rsv_status rsv_check_placed_luminaire(
    const rsv_scene *scene, const rsv_punctual_light *light, const char *name)
{
    float opening = v3_length(light->opening), side = v3_length(light->side);
    if (light->luminaire >= scene->luminaire_count)
        return rsv_fail(
            RSV_ERROR_FORMAT, "light '%s': luminaire %u does not exist", name, light->luminaire);
    bool upright = side > 0 && fabsf(v3_dot(light->side, light->direction)) <=
                                   1e-3f * side * v3_length(light->direction);
    if (!isfinite(side) || !upright)
        return rsv_fail(
            RSV_ERROR_FORMAT, "light '%s': its side is not at right angles to its direction", name);
    if (!isfinite(opening) || opening > RSV_FARTHEST)
        return rsv_fail(RSV_ERROR_FORMAT, "light '%s': its opening is not usable", name);
    return RSV_OK;
}

// ---- where they hang ------------------------------------------------------------------------------

/// A direction perpendicular to another, as close to `wanted` as possible.
static rsv_vec3 side_of(rsv_vec3 direction, rsv_vec3 wanted)
{
    rsv_vec3 side = v3_mad(wanted, -v3_dot(wanted, direction), direction), other;
    if (v3_length(side) > 1e-3f) return v3_normalize(side);
    v3_frame(direction, &side, &other);
    return side;
}

/// In place of a light, whose name and place stay.
static void replace_light(rsv_punctual_light *light, const rsv_punctual_light *shape)
{
    bool aimed = rsv_punctual_has_direction(light);
    rsv_punctual_light placed = *shape;
    placed.name = light->name;
    placed.position = light->position;
    if (aimed) placed.direction = v3_normalize(light->direction);
    placed.side = side_of(placed.direction, v3_length(light->side) > 0 ? light->side : shape->side);
    *light = placed;
}

static size_t replace_lights(
    rsv_scene *scene, const char *name, bool by_node, const rsv_punctual_light *shape)
{
    size_t count = 0;
    for (size_t k = 0; k < scene->light_count; k++) {
        const char *called = by_node ? scene->light_fixture[k].node : scene->light[k].name;
        if (!rsv_name_is_meant(name, called)) continue;
        count++;
        if (rsv_punctual_is_distant(&scene->light[k]))
            rsv_log(scene->context, RSV_LOG_WARNING,
                "light '%s' is infinitely far away, so no luminaire can replace it",
                scene->light[k].name);
        else
            replace_light(&scene->light[k], shape);
    }
    return count;
}

/// Primitives of one mesh are objects of one name in one place.
static bool is_same_object(const rsv_instance *a, const rsv_instance *b)
{
    bool same = strcmp(a->name, b->name) == 0;
    for (int k = 0; same && k < 16; k++)
        same = a->transform[k] == b->transform[k];
    return same;
}

/// At the origins of objects.
static rsv_status add_at_objects(
    rsv_scene *scene, const char *name, const rsv_punctual_light *shape, size_t *count)
{
    rsv_status status = RSV_OK;
    for (size_t k = 0; k < scene->instance_count && status == RSV_OK; k++) {
        const rsv_instance *object = &scene->instance[k];
        if (!rsv_name_is_meant(name, object->name)) continue;
        if (k > 0 && is_same_object(object - 1, object)) continue;
        const double *m = object->transform;
        rsv_punctual_light light = *shape;
        rsv_vec3 down = v3((float)-m[4], (float)-m[5], (float)-m[6]);
        light.name = object->name;
        if (v3_length(down) > 0) light.direction = v3_normalize(down);
        light.side = side_of(light.direction, v3((float)m[0], (float)m[1], (float)m[2]));
        status = rsv_scene_place_light(scene, &light, m + 12, object->name);
        ++*count;
    }
    return status;
}

rsv_status rsv_scene_place_luminaire(
    rsv_scene *scene, const char *name, const rsv_luminaire *luminaire)
{
    uint32_t id;
    rsv_status status = rsv_scene_add_luminaire(scene, luminaire, &id);
    if (status != RSV_OK) return status;
    rsv_punctual_light shape = rsv_luminaire_light(luminaire, id);
    size_t count = replace_lights(scene, name, false, &shape);
    if (!count) count = replace_lights(scene, name, true, &shape);
    if (!count) status = add_at_objects(scene, name, &shape, &count);
    if (status == RSV_OK && !count)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "luminaire: there is no light or object named '%.200s'; `resolvent info` lists them",
            name);
    return status;
}
