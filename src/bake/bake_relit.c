#include "bake_relit.h"

#include "../core/vec.h"
#include "../io/gltf_luminaire.h"
#include "../scene/punctual.h"
#include "../scene/scene.h"
#include "bake_constants.h"

#include <string.h>

static const char punctual[] = "KHR_lights_punctual", measured[] = "EXT_lights_ies";

typedef struct follower {
    const rsv_scene *scene; ///< of the light
    const rsv_bake_parts *parts;
    cJSON **primitive;
    rsv_bake_document *d;
    int *profile; ///< [luminaire_count] of the file that is written; -1 = not there yet
} follower;

static cJSON *item(const cJSON *parent, const char *name)
{
    return cJSON_GetObjectItemCaseSensitive(parent, name);
}

static bool differs(rsv_rgb a, rsv_rgb b)
{
    float most = f_max(rgb_max(a), rgb_max(b));
    return f_max(fabsf(a.r - b.r), f_max(fabsf(a.g - b.g), fabsf(a.b - b.b))) > ROUNDING * most;
}

static void put_rgb(follower *f, cJSON *parent, const char *name, rsv_rgb c)
{
    cJSON_DeleteItemFromObjectCaseSensitive(parent, name);
    cJSON *array = rsv_bake_array(f->d, parent, name);
    for (int k = 0; k < 3; k++)
        rsv_bake_append(f->d, array, cJSON_CreateNumber((double)(&c.r)[k]));
}

// ---- materials ------------------------------------------------------------------------------------

/// The opacity stays.
static void write_color(follower *f, cJSON *material, rsv_rgb color)
{
    cJSON *pbr = rsv_bake_object(f->d, material, "pbrMetallicRoughness");
    const cJSON *alpha = cJSON_GetArrayItem(item(pbr, "baseColorFactor"), 3);
    double opacity = cJSON_IsNumber(alpha) ? alpha->valuedouble : 1;
    put_rgb(f, pbr, "baseColorFactor", color);
    rsv_bake_append(f->d, item(pbr, "baseColorFactor"), cJSON_CreateNumber(opacity));
}

static void write_emission(follower *f, cJSON *material, rsv_rgb emission)
{
    float strength = f_max(rgb_max(emission), 1); // the factor itself may not exceed 1
    put_rgb(f, material, "emissiveFactor", rgb_scale(emission, 1 / strength));
    rsv_bake_number(f->d, rsv_bake_extension(f->d, material, "KHR_materials_emissive_strength"),
        "emissiveStrength", (double)strength);
}

/// Colours that can be relit. The rest differs from the document only where loading has changed it.
static bool is_plain(const follower *f, size_t m)
{
    const rsv_material *material = &f->scene->material[m];
    return material->metallic == 0 && material->transmission == 0 && !f->scene->material_varies[m];
}

static void follow_materials(follower *f)
{
    const cJSON *materials = item(f->d->root, "materials");
    for (size_t m = 0; m < f->d->gltf->material_count; m++) {
        const rsv_material *was = &f->d->gltf->material[m].value, *is = &f->scene->material[m];
        cJSON *json = cJSON_GetArrayItem(materials, (int)m);
        bool in_range = rgb_max(was->base_color) <= 1 && isfinite(rgb_max(was->emission));
        if (!json || !in_range) continue;
        if (is_plain(f, m) && differs(was->base_color, is->base_color))
            write_color(f, json, is->base_color);
        if (differs(was->emission, is->emission)) write_emission(f, json, is->emission);
    }
}

// ---- nodes ----------------------------------------------------------------------------------------

/// The list of top-level nodes; NULL if the file has no scenes: then they are all nodes without a parent.
static cJSON *find_roots(follower *f)
{
    cJSON *scenes = item(f->d->root, "scenes");
    const cJSON *shown = item(f->d->root, "scene");
    cJSON *scene = cJSON_GetArrayItem(scenes, cJSON_IsNumber(shown) ? shown->valueint : 0);
    return scene ? rsv_bake_array(f->d, scene, "nodes") : NULL;
}

/// A node at the top. @param world column-major
static cJSON *add_node(follower *f, const char *name, const double world[16])
{
    cJSON *node = cJSON_CreateObject(), *roots = find_roots(f);
    int index = rsv_bake_append(f->d, rsv_bake_array(f->d, f->d->root, "nodes"), node);
    if (roots) rsv_bake_append(f->d, roots, cJSON_CreateNumber(index));
    rsv_bake_string(f->d, node, "name", name);
    cJSON *matrix = rsv_bake_array(f->d, node, "matrix");
    for (int k = 0; k < 16; k++)
        rsv_bake_append(f->d, matrix, cJSON_CreateNumber(world[k]));
    return node;
}

/// A position of the file in the scene's coordinates, from which an origin may have been subtracted.
static rsv_vec3 in_scene(const follower *f, const double place[3])
{
    const double *origin = f->scene->view.origin;
    return v3((float)(place[0] - origin[0]), (float)(place[1] - origin[1]),
        (float)(place[2] - origin[2]));
}

static cJSON *node_at(const follower *f, uint32_t node)
{
    return cJSON_GetArrayItem(item(f->d->root, "nodes"), (int)node);
}

static bool is_elsewhere(const follower *f, rsv_vec3 was, rsv_vec3 is)
{
    const rsv_scene_view *view = &f->scene->view;
    float size = v3_length(v3_sub(view->bounds_max, view->bounds_min));
    return v3_max_abs(v3_sub(is, was)) > ROUNDING * (size + v3_max_abs(is));
}

// ---- luminaires -----------------------------------------------------------------------------------

/// The profile of a scene's luminaire among the file's, appended when it is first needed; its highest intensity is that
/// of 1 W/sr.
static int profile_of(follower *f, uint32_t luminaire)
{
    if (f->profile[luminaire] >= 0) return f->profile[luminaire];
    const rsv_luminaire *is = &f->scene->view.luminaire[luminaire];
    cJSON *light = cJSON_CreateObject(),
          *lights = rsv_bake_array(f->d, rsv_bake_extension(f->d, f->d->root, measured), "lights");
    char *text = NULL;
    if (rsv_luminaire_print(f->d->context, is, &text) != RSV_OK) f->d->exhausted = true;
    if (text)
        rsv_bake_number(f->d, light, "bufferView", rsv_bake_add_view(f->d, text, strlen(text), 0));
    rsv_bake_string(f->d, light, "mimeType", "application/x-ies-lm-63");
    rsv_bake_string(f->d, light, "name", is->name);
    rsv_free(f->d->context, text);
    return f->profile[luminaire] = rsv_bake_append(f->d, lights, light);
}

/// A node of its own for a luminaire that the file does not have, or has otherwise.
static void add_luminaire(follower *f, const rsv_punctual_light *is)
{
    const double *origin = f->scene->view.origin;
    rsv_vec3 x = is->side, z = v3_neg(is->direction), y = v3_cross(z, x), p = is->position;
    const double world[16] = { (double)x.x, (double)x.y, (double)x.z, 0, (double)y.x, (double)y.y,
        (double)y.z, 0, (double)z.x, (double)z.y, (double)z.z, 0, (double)p.x + origin[0],
        (double)p.y + origin[1], (double)p.z + origin[2], 1 };
    float strength = rgb_max(is->intensity);
    cJSON *json = rsv_bake_extension(f->d, add_node(f, is->name, world), measured);
    rsv_bake_number(f->d, json, "light", profile_of(f, is->luminaire));
    rsv_bake_number(f->d, json, "multiplier", RSV_LUMEN_PER_WATT * (double)strength);
    put_rgb(f, json, "color", strength > 0 ? rgb_scale(is->intensity, 1 / strength) : rgb_gray(1));
    if (!rsv_punctual_is_extended(is)) return;
    put_rgb(f, rsv_bake_object(f->d, json, "extras"), "opening",
        rgb(is->opening.x, is->opening.y, is->opening.z));
}

/// Whether a node's luminaire is unchanged since loading. Also false if it is left out.
static bool is_as_filed(const follower *f, uint32_t index, const rsv_punctual_light *is)
{
    rsv_luminaire luminaire;
    rsv_punctual_light was;
    const rsv_gltf_node *node = &f->d->gltf->node[index];
    const double *world = f->parts->shown.world[index];
    rsv_status status =
        rsv_gltf_read_luminaire(f->d->context, f->d->gltf, node->luminaire, &luminaire);
    bool same = status == RSV_OK && rsv_gltf_luminaire_light(node, world, &luminaire, &was) &&
                is->kind == RSV_PUNCTUAL_LUMINAIRE && !differs(was.intensity, is->intensity) &&
                !is_elsewhere(f, in_scene(f, world + 12), is->position) &&
                v3_max_abs(v3_sub(was.direction, is->direction)) < 1e-4f &&
                v3_max_abs(v3_sub(was.side, is->side)) < 1e-4f;
    rsv_luminaire_free(f->d->context, &luminaire);
    return same;
}

/// Whether loading makes a light of a node's luminaire.
static bool has_luminaire(const follower *f, uint32_t index)
{
    rsv_luminaire luminaire;
    rsv_punctual_light was;
    const rsv_gltf_node *node = &f->d->gltf->node[index];
    rsv_rgb scale = node->luminaire_scale;
    if (node->luminaire == -1 || f->parts->shown.hidden[index]) return false;
    if (f_min(scale.r, f_min(scale.g, scale.b)) < 0) return false;
    bool has =
        rsv_gltf_read_luminaire(f->d->context, f->d->gltf, node->luminaire, &luminaire) == RSV_OK &&
        rsv_gltf_luminaire_light(node, f->parts->shown.world[index], &luminaire, &was);
    rsv_luminaire_free(f->d->context, &luminaire);
    return has;
}

// ---- punctual lights ------------------------------------------------------------------------------

static void write_intensity(follower *f, cJSON *light, rsv_rgb intensity)
{
    float strength = rgb_max(intensity), scale = strength > 0 ? 1 / strength : 0;
    put_rgb(f, light, "color", strength > 0 ? rgb_scale(intensity, scale) : rgb_gray(1));
    rsv_bake_number(f->d, light, "intensity", (double)strength);
}

static cJSON *light_list(follower *f)
{
    return rsv_bake_array(f->d, rsv_bake_extension(f->d, f->d->root, punctual), "lights");
}

/// Names a light of its own for a node: others may show the one that it has.
static void own_light(follower *f, cJSON *node, int index, const rsv_punctual_light *is)
{
    cJSON *light = cJSON_Duplicate(cJSON_GetArrayItem(light_list(f), index), true);
    if (!light) return;
    write_intensity(f, light, is->intensity);
    rsv_bake_number(f->d, rsv_bake_extension(f->d, node, punctual), "light",
        rsv_bake_append(f->d, light_list(f), light));
}

static void move_light(follower *f, uint32_t index, rsv_vec3 position)
{
    double world[16];
    rsv_vec3 was = in_scene(f, f->parts->shown.world[index] + 12);
    cJSON *extensions = item(node_at(f, index), "extensions");
    cJSON *shown = cJSON_DetachItemFromObjectCaseSensitive(extensions, punctual);
    memcpy(world, f->parts->shown.world[index], sizeof world);
    for (int axis = 0; axis < 3; axis++)
        world[12 + axis] += (double)(&position.x)[axis] - (double)(&was.x)[axis];
    if (extensions && !extensions->child)
        cJSON_DeleteItemFromObjectCaseSensitive(node_at(f, index), "extensions");
    cJSON *node = add_node(f, f->d->gltf->node[index].name, world);
    if (shown && !cJSON_AddItemToObject(rsv_bake_object(f->d, node, "extensions"), punctual, shown))
        f->d->exhausted = true;
}

static void follow_light(follower *f, uint32_t index, const rsv_punctual_light *is)
{
    int light = f->d->gltf->node[index].light;
    if (is->kind == RSV_PUNCTUAL_LUMINAIRE) { // in its place
        rsv_bake_remove_extension(node_at(f, index), punctual);
        add_luminaire(f, is);
        return;
    }
    if (differs(f->d->gltf->light[light].value.intensity, is->intensity))
        own_light(f, node_at(f, index), light, is);
    if (!rsv_punctual_is_distant(is) &&
        is_elsewhere(f, in_scene(f, f->parts->shown.world[index] + 12), is->position))
        move_light(f, index, is->position);
}

static void write_shape(follower *f, cJSON *json, const rsv_punctual_light *is)
{
    rsv_bake_string(f->d, json, "type", rsv_punctual_kind(is->kind).name);
    if (!rsv_punctual_has_cone(is)) return;
    cJSON *spot = rsv_bake_object(f->d, json, "spot");
    rsv_bake_number(f->d, spot, "innerConeAngle", (double)is->inner_cone_angle);
    rsv_bake_number(f->d, spot, "outerConeAngle", (double)is->outer_cone_angle);
}

/// One that relighting added.
static void add_light(follower *f, const rsv_punctual_light *is)
{
    rsv_vec3 x = v3(1, 0, 0), y = v3(0, 1, 0), z = v3(0, 0, 1), p = is->position;
    const double *origin = f->scene->view.origin;
    if (rsv_punctual_has_direction(is)) {
        z = v3_neg(is->direction);
        v3_frame(z, &x, &y);
    }
    const double world[16] = { (double)x.x, (double)x.y, (double)x.z, 0, (double)y.x, (double)y.y,
        (double)y.z, 0, (double)z.x, (double)z.y, (double)z.z, 0, (double)p.x + origin[0],
        (double)p.y + origin[1], (double)p.z + origin[2], 1 };
    cJSON *light = cJSON_CreateObject();
    rsv_bake_string(f->d, light, "name", is->name);
    write_shape(f, light, is);
    write_intensity(f, light, is->intensity);
    rsv_bake_number(f->d, rsv_bake_extension(f->d, add_node(f, is->name, world), punctual), "light",
        rsv_bake_append(f->d, light_list(f), light));
}

/// Whether loading creates a light for a node.
static bool shines(const follower *f, uint32_t node)
{
    const rsv_gltf_document *gltf = f->d->gltf;
    int light = gltf->node[node].light;
    bool exists = light >= 0 && (size_t)light < gltf->light_count;
    if (f->parts->shown.hidden[node] || (exists && !gltf->light[light].known)) return false;
    const double *back = &f->parts->shown.world[node][8];
    bool flat = back[0] == 0 && back[1] == 0 && back[2] == 0; // no direction: it is left out
    return !exists || !rsv_punctual_has_direction(&gltf->light[light].value) || !flat;
}

/// Lights of the scene are those of the file's nodes, one after the other, and then those that were added.
static rsv_status follow_lights(follower *f)
{
    size_t count = 0;
    for (size_t k = 0; k < f->parts->shown.order_count; k++) {
        uint32_t index = f->parts->shown.order[k];
        int light = f->d->gltf->node[index].light;
        bool shown = light != -1 && shines(f, index), hangs = has_luminaire(f, index);
        if ((shown && (light < 0 || (size_t)light >= f->d->gltf->light_count)) ||
            count + shown + hangs > f->scene->light_count)
            return rsv_fail(RSV_ERROR_ARGUMENT,
                "%s: bake: the glTF document in it has other lights than its scene; solve the scene again",
                f->d->name);
        if (shown) follow_light(f, index, &f->scene->light[count++]);
        if (!hangs) continue;
        const rsv_punctual_light *is = &f->scene->light[count++];
        if (is_as_filed(f, index, is)) continue;
        rsv_bake_remove_extension(node_at(f, index), measured);
        add_luminaire(f, is);
    }
    for (; count < f->scene->light_count; count++)
        (f->scene->light[count].kind == RSV_PUNCTUAL_LUMINAIRE ? add_luminaire : add_light)(
            f, &f->scene->light[count]);
    return RSV_OK;
}

// ---- lamps ----------------------------------------------------------------------------------------

static void transform(const double m[16], rsv_vec3 v, double result[3])
{
    for (int r = 0; r < 3; r++)
        result[r] =
            m[r] * (double)v.x + m[4 + r] * (double)v.y + m[8 + r] * (double)v.z + m[12 + r];
}

/// Motion of a part as a whole, from its first corner. False if it has not moved.
static bool find_offset(const follower *f, size_t k, double offset[3])
{
    const rsv_scene *scene = f->scene;
    const rsv_bake_part *part = &f->parts->part[k];
    double world[16];
    rsv_gltf_part_world(&f->parts->shown, &f->parts->shown.part[k], world);
    for (size_t t = 0; t < part->triangle_count; t++) {
        double was[3];
        if (part->triangle[t] == RSV_NONE) continue;
        rsv_vec3 is = scene->position[scene->triangle[part->triangle[t]][0]];
        transform(world, part->position[part->corner[t][0]], was);
        rsv_vec3 from = in_scene(f, was);
        for (int axis = 0; axis < 3; axis++)
            offset[axis] = (double)(&is.x)[axis] - (double)(&from.x)[axis];
        return is_elsewhere(f, from, is);
    }
    return false;
}

/// The node that shows a primitive: that of the file, or one of its instances.
static cJSON *find_shower(const follower *f, const cJSON *primitive)
{
    cJSON *node;
    const cJSON *meshes = item(f->d->root, "meshes"), *own;
    cJSON_ArrayForEach(node, item(f->d->root, "nodes"))
    {
        const cJSON *mesh = item(node, "mesh");
        const cJSON *shown = mesh ? cJSON_GetArrayItem(meshes, mesh->valueint) : NULL;
        cJSON_ArrayForEach(own, item(shown, "primitives")) if (own == primitive) return node;
    }
    return NULL;
}

/// Takes a primitive out of its mesh into a mesh that a node of its own shows.
static void move_part(follower *f, size_t k, const double offset[3])
{
    double world[16];
    const rsv_bake_part *part = &f->parts->part[k];
    cJSON *node = find_shower(f, f->primitive[k]), *meshes = item(f->d->root, "meshes");
    cJSON *mesh =
        cJSON_GetArrayItem(meshes, item(node, "mesh") ? item(node, "mesh")->valueint : -1);
    cJSON *primitives = item(mesh, "primitives");
    rsv_gltf_part_world(&f->parts->shown, &f->parts->shown.part[k], world);
    for (int axis = 0; axis < 3; axis++)
        world[12 + axis] += offset[axis];
    cJSON *own = add_node(f, f->d->gltf->node[part->node].name, world);
    if (cJSON_GetArraySize(primitives) == 1) {
        rsv_bake_number(f->d, own, "mesh", item(node, "mesh")->valueint);
        cJSON_DeleteItemFromObjectCaseSensitive(node, "mesh");
        return;
    }
    cJSON *fresh = cJSON_CreateObject();
    rsv_bake_string(f->d, fresh, "name", f->d->gltf->mesh[part->mesh].name);
    rsv_bake_append(f->d, rsv_bake_array(f->d, fresh, "primitives"),
        cJSON_DetachItemViaPointer(primitives, f->primitive[k]));
    rsv_bake_number(f->d, own, "mesh", rsv_bake_append(f->d, meshes, fresh));
}

static void follow_lamps(follower *f)
{
    const rsv_gltf_document *gltf = f->d->gltf;
    for (size_t k = 0; k < f->parts->count; k++) {
        const rsv_bake_part *part = &f->parts->part[k];
        const rsv_gltf_primitive *primitive = &gltf->mesh[part->mesh].primitive[part->primitive];
        int m = primitive->material;
        double offset[3];
        bool emits = m >= 0 && (size_t)m < gltf->material_count &&
                     rgb_max(gltf->material[m].value.emission) > 0;
        bool bends = f->parts->shown.part[k].skinned || primitive->target_count; // stays
        if (!emits || bends || !find_offset(f, k, offset)) continue;
        move_part(f, k, offset);
    }
}

rsv_status rsv_bake_follow_relight(const rsv_light_view *solution, const rsv_bake_parts *parts,
    cJSON **primitive, rsv_bake_document *document)
{
    follower f = {
        .scene = solution->scene.scene, .parts = parts, .primitive = primitive, .d = document
    };
    if (document->is_made) return RSV_OK;
    size_t profiles = f.scene->luminaire_count;
    f.profile = rsv_alloc(document->context, profiles, sizeof *f.profile);
    if (!f.profile) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < profiles; k++)
        f.profile[k] = -1;
    follow_materials(&f);
    follow_lamps(&f);
    rsv_status status = follow_lights(&f);
    rsv_free(document->context, f.profile);
    return status;
}
