/// The contents of a committed scene, array by array.
#include "../media/volume.h"
#include "../scene/material_fields.h"
#include "../scene/punctual.h"
#include "../scene/restore.h"
#include "../scene/texture.h"
#include "exchange.h"
#include "luminaire_tensors.h"
#include "table.h"

#include <stdio.h>
#include <string.h>

_Static_assert(sizeof(rsv_punctual_light_kind) == 4 && sizeof(rsv_texture_role) == 4 &&
                   sizeof(rsv_wrap) == 4 && sizeof(bool) == 1,
    "tables hold enumerations as U32 and flags as U8");

#define COUNT_OF(array) (sizeof(array) / sizeof(array)[0])

static const rsv_column material_columns[] = {
#define NUMBER(field, channels, usual, low, high, extension, key)                                  \
    RSV_FLOATS(rsv_material, field, channels),
#define FLAG(field) RSV_FLAG(rsv_material, field),
    RSV_MATERIAL_FIELDS(NUMBER, FLAG)
#undef NUMBER
#undef FLAG
};

static const rsv_column light_columns[] = {
    RSV_CHOICE(rsv_punctual_light, kind, RSV_PUNCTUAL_KINDS),
    RSV_FLOATS(rsv_punctual_light, position, 3),
    RSV_FLOATS(rsv_punctual_light, direction, 3),
    RSV_FLOATS(rsv_punctual_light, intensity, 3),
    RSV_FLOATS(rsv_punctual_light, inner_cone_angle, 1),
    RSV_FLOATS(rsv_punctual_light, outer_cone_angle, 1),
    RSV_FLOATS(rsv_punctual_light, exponent, 1),
    RSV_FLAG(rsv_punctual_light, smooth_cone),
};

static const rsv_column camera_columns[] = {
    RSV_FLOATS(rsv_camera, position, 3),
    RSV_FLOATS(rsv_camera, right, 3),
    RSV_FLOATS(rsv_camera, up, 3),
    RSV_FLOATS(rsv_camera, forward, 3),
    RSV_FLOATS(rsv_camera, vertical_fov, 1),
    RSV_FLOATS(rsv_camera, vertical_extent, 1),
    RSV_FLOATS(rsv_camera, aspect, 1),
};

/// A texture of a material, and whose it is.
typedef struct texture_use {
    uint32_t material;
    rsv_texture_ref ref;
} texture_use;

static const rsv_column use_columns[] = {
    RSV_CHOICE(texture_use, material, UINT32_MAX),
    { "role", RSV_TENSOR_U32, 1, offsetof(texture_use, ref.role), RSV_TEXTURE_ROLE_COUNT },
    { "texture", RSV_TENSOR_U32, 1, offsetof(texture_use, ref.texture), UINT32_MAX },
    { "uv_set", RSV_TENSOR_U32, 1, offsetof(texture_use, ref.uv_set), 2 },
    { "transform", RSV_TENSOR_F32, 6, offsetof(texture_use, ref.transform), 0 },
    { "scale", RSV_TENSOR_F32, 1, offsetof(texture_use, ref.scale), 0 },
};

static const rsv_column texture_columns[] = {
    RSV_CHOICE(rsv_texture_desc, wrap_u, RSV_WRAP_CLAMP + 1),
    RSV_CHOICE(rsv_texture_desc, wrap_v, RSV_WRAP_CLAMP + 1),
    RSV_FLAG(rsv_texture_desc, nearest),
};

static const rsv_column fog_columns[] = {
    RSV_FLOATS(rsv_fog, extinction, 3),
    RSV_FLOATS(rsv_fog, albedo, 3),
    RSV_FLOATS(rsv_fog, emission, 3),
    RSV_FLOATS(rsv_fog, anisotropy, 1),
    RSV_FLOATS(rsv_fog, scale_height, 1),
    RSV_FLOATS(rsv_fog, base_height, 1),
    RSV_FLOATS(rsv_fog, bounds_min, 3),
    RSV_FLOATS(rsv_fog, bounds_max, 3),
};

static const rsv_column environment_columns[] = {
    RSV_FLOATS(rsv_environment, rotation, 1),
};

#define WRITE_TABLE(file, columns, rows, count)                                                    \
    rsv_write_table(file, columns, COUNT_OF(columns), rows, count, sizeof *(rows))
#define READ_TABLE(file, columns, rows, count)                                                     \
    rsv_read_table(file, columns, COUNT_OF(columns), &(rows), count, sizeof *(rows))

// ---- names ----------------------------------------------------------------------------------------

/// Names that are fields of structs. @param first of [count], `stride` bytes apart
static rsv_status write_struct_names(
    rsv_tensor_file *file, const char *note, const void *first, size_t stride, size_t count)
{
    const char **name = rsv_alloc(file->context, count, sizeof *name);
    if (!name) return RSV_ERROR_MEMORY;
    RSV_ASSERT(first || count == 0);
    for (size_t k = 0; k < count; k++)
        name[k] = *(const char *const *)((const char *)first + k * stride);
    rsv_status status = rsv_write_names(file, note, name, count);
    rsv_free(file->context, name);
    return status;
}

static rsv_status read_struct_names(
    rsv_tensor_file *file, const char *note, void *first, size_t stride, size_t count, cJSON **list)
{
    const char **name = rsv_alloc(file->context, count, sizeof *name);
    if (!name) return RSV_ERROR_MEMORY;
    rsv_status status = rsv_read_names(file, note, count, name, list);
    RSV_ASSERT(first || count == 0);
    for (size_t k = 0; status == RSV_OK && k < count; k++)
        *(const char **)((char *)first + k * stride) = name[k];
    rsv_free(file->context, name);
    return status;
}

#define WRITE_NAMES(file, note, rows, count)                                                       \
    write_struct_names(file, note, (rows) ? &(rows)->name : NULL, sizeof *(rows), count)
#define READ_NAMES(file, note, rows, count, list)                                                  \
    read_struct_names(file, note, (rows) ? &(rows)->name : NULL, sizeof *(rows), count, list)

// ---- where it is, and by which nodes --------------------------------------------------------------

static const rsv_field origin_fields[] = {
    { "x", RSV_FIELD_DOUBLE, offsetof(rsv_scene_view, origin[0]), sizeof(double) },
    { "y", RSV_FIELD_DOUBLE, offsetof(rsv_scene_view, origin[1]), sizeof(double) },
    { "z", RSV_FIELD_DOUBLE, offsetof(rsv_scene_view, origin[2]), sizeof(double) },
};

rsv_status rsv_write_origin(rsv_tensor_file *file, const rsv_scene_view *view)
{
    if (view->origin[0] == 0 && view->origin[1] == 0 && view->origin[2] == 0) return RSV_OK;
    return rsv_write_fields(file, "scene.origin", origin_fields, COUNT_OF(origin_fields), view);
}

/// Names of nodes; omitted if all are equal to the names of what the nodes placed. @param own [count], `stride` bytes
/// apart
static rsv_status write_nodes(rsv_tensor_file *file, const char *note, const char *const *node,
    const void *own, size_t stride, size_t count)
{
    bool any = false;
    const char **name = rsv_alloc(file->context, count, sizeof *name);
    if (!name) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < count; k++) {
        const char *of_itself = *(const char *const *)((const char *)own + k * stride);
        name[k] = node[k] ? node[k] : "";
        any = any || (node[k] && strcmp(node[k], of_itself) != 0);
    }
    rsv_status status = any ? rsv_write_names(file, note, name, count) : RSV_OK;
    rsv_free(file->context, name);
    return status;
}

#define WRITE_NODES(file, note, nodes, rows, count)                                                \
    write_nodes(file, note, nodes, (rows) ? &(rows)->name : NULL, sizeof *(rows), count)

/// @param node out: [count], freed by the caller; "" = none
static rsv_status read_nodes(
    rsv_tensor_file *file, const char *note, size_t count, const char ***node, cJSON **list)
{
    if (!rsv_note_get(file, note)) return RSV_OK;
    *node = rsv_alloc(file->context, count, sizeof **node);
    if (!*node) return RSV_ERROR_MEMORY;
    rsv_status status = rsv_read_names(file, note, count, *node, list);
    for (size_t k = 0; status == RSV_OK && k < count; k++)
        if (!*(*node)[k]) (*node)[k] = NULL;
    return status;
}

// ---- writing --------------------------------------------------------------------------------------

static rsv_status write_texture_uses(rsv_tensor_file *file, const rsv_scene_view *view)
{
    size_t count = 0;
    for (size_t m = 0; m < view->material_count; m++)
        count += view->material[m].texture_count;
    texture_use *use = rsv_alloc(file->context, count, sizeof *use);
    if (!use) return RSV_ERROR_MEMORY;
    count = 0;
    for (size_t m = 0; m < view->material_count; m++)
        for (size_t k = 0; k < view->material[m].texture_count; k++)
            use[count++] = (texture_use){ (uint32_t)m, view->material[m].textures[k] };
    rsv_tensor_prefix(file, "scene.texture_use.");
    rsv_status status = WRITE_TABLE(file, use_columns, use, count);
    rsv_free(file->context, use);
    return status;
}

static rsv_status write_texels(rsv_tensor_file *file, const rsv_texture *texture, size_t index)
{
    char name[32];
    const size_t shape[3] = { texture->level[0].height, texture->level[0].width,
        texture->channel_count };
    snprintf(name, sizeof name, "%zu", index);
    return rsv_tensor_add(file, name, texture->unorm ? RSV_TENSOR_U16 : RSV_TENSOR_F32, 3, shape,
        texture->unorm ? (const void *)texture->unorm : texture->value);
}

static rsv_status write_textures(rsv_tensor_file *file, const rsv_scene_view *view)
{
    rsv_status status;
    rsv_texture_desc *desc = rsv_alloc(file->context, view->texture_count, sizeof *desc);
    if (!desc) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < view->texture_count; k++)
        desc[k] = (rsv_texture_desc){ .size = sizeof(rsv_texture_desc),
            .name = view->texture[k].name,
            .wrap_u = view->texture[k].wrap_u,
            .wrap_v = view->texture[k].wrap_v,
            .nearest = view->texture[k].nearest };
    rsv_tensor_prefix(file, "scene.texture.");
    RSV_TRY(WRITE_TABLE(file, texture_columns, desc, view->texture_count));
    RSV_TRY(WRITE_NAMES(file, "scene.texture.name", desc, view->texture_count));
    for (size_t k = 0; k < view->texture_count; k++)
        RSV_TRY(write_texels(file, &view->texture[k], k));
cleanup:
    rsv_free(file->context, desc);
    return status;
}

static rsv_status write_environment(rsv_tensor_file *file, const rsv_environment *environment)
{
    if (!environment) return RSV_OK;
    const size_t shape[3] = { environment->height, environment->width, 3 };
    rsv_status status;
    rsv_tensor_prefix(file, "scene.environment.");
    RSV_TRY(WRITE_TABLE(file, environment_columns, environment, 1));
    RSV_TRY(WRITE_NAMES(file, "scene.environment.name", environment, 1));
    status = rsv_tensor_add(file, "radiance", RSV_TENSOR_F32, 3, shape, environment->pixels);
cleanup:
    return status;
}

/// Densities of fog; its box is among its columns.
static rsv_status write_volume(rsv_tensor_file *file, const rsv_volume *volume)
{
    const size_t shape[3] = { volume->side[2], volume->side[1], volume->side[0] };
    return rsv_tensor_add(file, "density", RSV_TENSOR_F32, 3, shape, volume->density);
}

/// The arrays of the geometry, in both directions.
static rsv_status exchange_geometry(rsv_tensor_file *file, rsv_scene_view *view)
{
    rsv_status status;
    rsv_tensor_type f32 = RSV_TENSOR_F32, u32 = RSV_TENSOR_U32;
    size_t *vertices = &view->vertex_count, *triangles = &view->triangle_count;
    rsv_tensor_prefix(file, "scene.");
    RSV_TRY(rsv_tensor_exchange(file, "vertex.position", f32, 3, &view->position, vertices));
    RSV_TRY(rsv_tensor_exchange(file, "vertex.normal", f32, 3, &view->normal, vertices));
    RSV_TRY(rsv_tensor_exchange_optional(file, "vertex.uv0", f32, 2, &view->uv[0], vertices));
    RSV_TRY(rsv_tensor_exchange_optional(file, "vertex.uv1", f32, 2, &view->uv[1], vertices));
    RSV_TRY(rsv_tensor_exchange_optional(file, "vertex.tangent", f32, 4, &view->tangent, vertices));
    RSV_TRY(rsv_tensor_exchange_optional(file, "vertex.color", f32, 4, &view->color, vertices));
    RSV_TRY(rsv_tensor_exchange(file, "triangle.vertex", u32, 3, &view->triangle, triangles));
    RSV_TRY(rsv_tensor_exchange(
        file, "triangle.material", u32, 1, &view->triangle_material, triangles));
    RSV_TRY(
        rsv_tensor_exchange(file, "triangle.object", u32, 1, &view->triangle_object, triangles));
cleanup:
    return status;
}

rsv_status rsv_write_scene(rsv_tensor_file *file, const rsv_scene *scene)
{
    rsv_status status;
    rsv_scene_view view = *rsv_scene_get_view(scene);
    RSV_TRY(exchange_geometry(file, &view));
    RSV_TRY(rsv_write_names(file, "scene.object.name", view.object_name, view.object_count));
    rsv_tensor_prefix(file, "scene.material.");
    RSV_TRY(WRITE_TABLE(file, material_columns, view.material, view.material_count));
    RSV_TRY(WRITE_NAMES(file, "scene.material.name", view.material, view.material_count));
    rsv_tensor_prefix(file, "scene.light.");
    RSV_TRY(WRITE_TABLE(file, light_columns, view.light, view.light_count));
    RSV_TRY(WRITE_NAMES(file, "scene.light.name", view.light, view.light_count));
    RSV_TRY(WRITE_NODES(file, "scene.light.node", view.light_node, view.light, view.light_count));
    RSV_TRY(rsv_write_luminaires(file, &view));
    rsv_tensor_prefix(file, "scene.camera.");
    RSV_TRY(WRITE_TABLE(file, camera_columns, view.camera, view.camera_count));
    RSV_TRY(WRITE_NAMES(file, "scene.camera.name", view.camera, view.camera_count));
    RSV_TRY(
        WRITE_NODES(file, "scene.camera.node", view.camera_node, view.camera, view.camera_count));
    RSV_TRY(rsv_write_origin(file, &view));
    RSV_TRY(write_texture_uses(file, &view));
    RSV_TRY(write_textures(file, &view));
    RSV_TRY(write_environment(file, view.environment));
    rsv_tensor_prefix(file, "scene.fog.");
    if (view.fog) RSV_TRY(WRITE_TABLE(file, fog_columns, view.fog, 1));
    if (view.fog && view.fog->volume) RSV_TRY(write_volume(file, view.fog->volume));
cleanup:
    return status;
}

// ---- reading --------------------------------------------------------------------------------------

enum {
    OBJECT_NAMES,
    MATERIAL_NAMES,
    LIGHT_NAMES,
    LIGHT_NODES,
    CAMERA_NAMES,
    CAMERA_NODES,
    TEXTURE_NAMES,
    SKY_NAME,
    LISTS
};

/// The parts read so far; the scene copies them.
typedef struct scene_reader {
    rsv_tensor_file *file;
    rsv_scene_parts parts;
    rsv_material *material;
    rsv_punctual_light *light;
    rsv_camera *camera;
    const char **object_name, **light_node, **camera_node;
    rsv_texture_parts *texture;
    rsv_texture_desc *desc;   ///< [texture_count]
    texture_use *use;         ///< by material
    rsv_texture_ref *ref;     ///< [use_count] of those
    rsv_luminaire *luminaire; ///< [luminaire_count]
    size_t luminaire_count;
    rsv_environment *environment;
    cJSON *list[LISTS]; ///< names
} scene_reader;

static rsv_status read_objects(scene_reader *r)
{
    rsv_scene_view *view = &r->parts.view;
    size_t objects = 0; // as many as there are triangles, at most
    for (size_t t = 0; t < view->triangle_count; t++)
        if (view->triangle_object[t] >= objects) objects = (size_t)view->triangle_object[t] + 1;
    if (objects > view->triangle_count)
        return rsv_tensor_fail(r->file, "triangle.object", "names more objects than triangles");
    r->object_name = rsv_alloc(r->file->context, objects, sizeof *r->object_name);
    if (!r->object_name) return RSV_ERROR_MEMORY;
    view->object_count = objects;
    view->object_name = r->object_name;
    return rsv_read_names(
        r->file, "scene.object.name", objects, r->object_name, &r->list[OBJECT_NAMES]);
}

/// Hands materials their textures, which are listed by material.
static rsv_status read_texture_uses(scene_reader *r)
{
    rsv_status status;
    size_t count = RSV_ANY_COUNT;
    rsv_tensor_prefix(r->file, "scene.texture_use.");
    RSV_TRY(READ_TABLE(r->file, use_columns, r->use, &count));
    r->ref = rsv_alloc(r->file->context, count, sizeof *r->ref);
    if (!r->ref) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < count; k++) {
        uint32_t m = r->use[k].material;
        if (m >= r->parts.view.material_count || (k && m < r->use[k - 1].material))
            return rsv_tensor_fail(r->file, "material", "is out of order");
        r->ref[k] = r->use[k].ref;
        if (!r->material[m].texture_count) r->material[m].textures = &r->ref[k];
        r->material[m].texture_count++;
    }
cleanup:
    return status;
}

static rsv_status read_texels(scene_reader *r, size_t index)
{
    char name[32];
    snprintf(name, sizeof name, "%zu", index);
    const rsv_tensor *tensor = rsv_tensor_find(r->file, name);
    bool is_linear = tensor && tensor->type == RSV_TENSOR_U16;
    bool sound = tensor && tensor->rank == 3 && (is_linear || tensor->type == RSV_TENSOR_F32);
    for (int k = 0; sound && k < 3; k++)
        sound = tensor->shape[k] >= 1 && tensor->shape[k] <= RSV_TEXTURE_MAX_SIDE;
    if (!sound) return rsv_tensor_fail(r->file, name, "is not a valid texture");
    rsv_texture_parts *parts = &r->texture[index];
    parts->desc = r->desc[index];
    parts->desc.size = sizeof parts->desc;
    parts->desc.height = (uint32_t)tensor->shape[0];
    parts->desc.width = (uint32_t)tensor->shape[1];
    parts->desc.channel_count = (uint32_t)tensor->shape[2];
    parts->linear = is_linear ? tensor->data : NULL;
    parts->value = is_linear ? NULL : tensor->data;
    return RSV_OK;
}

static rsv_status read_textures(scene_reader *r)
{
    rsv_status status;
    size_t count = RSV_ANY_COUNT;
    rsv_tensor_prefix(r->file, "scene.texture.");
    RSV_TRY(READ_TABLE(r->file, texture_columns, r->desc, &count));
    RSV_TRY(READ_NAMES(r->file, "scene.texture.name", r->desc, count, &r->list[TEXTURE_NAMES]));
    r->texture = rsv_alloc(r->file->context, count, sizeof *r->texture);
    if (!r->texture) return RSV_ERROR_MEMORY;
    r->parts.texture = r->texture;
    r->parts.view.texture_count = count;
    for (size_t k = 0; k < count; k++)
        RSV_TRY(read_texels(r, k));
cleanup:
    return status;
}

static rsv_status read_environment(scene_reader *r)
{
    rsv_status status;
    size_t one = 1;
    rsv_tensor_prefix(r->file, "scene.environment.");
    const rsv_tensor *radiance = rsv_tensor_find(r->file, "radiance");
    if (!radiance) return RSV_OK;
    if (radiance->type != RSV_TENSOR_F32 || radiance->rank != 3 || radiance->shape[2] != 3 ||
        radiance->shape[0] > RSV_ENVIRONMENT_MAX_PIXELS ||
        radiance->shape[1] > RSV_ENVIRONMENT_MAX_PIXELS)
        return rsv_tensor_fail(r->file, "radiance", "is not a valid picture");
    RSV_TRY(READ_TABLE(r->file, environment_columns, r->environment, &one));
    RSV_TRY(READ_NAMES(r->file, "scene.environment.name", r->environment, 1, &r->list[SKY_NAME]));
    r->environment->pixels = radiance->data;
    r->environment->height = (uint32_t)radiance->shape[0];
    r->environment->width = (uint32_t)radiance->shape[1];
    r->environment->intensity = 1;
    r->parts.view.environment = r->environment;
cleanup:
    return status;
}

static rsv_status read_volume(rsv_tensor_file *file, rsv_scene *scene)
{
    uint32_t side[3];
    const rsv_tensor *density = rsv_tensor_find(file, "density");
    if (!density) return RSV_OK;
    if (density->type != RSV_TENSOR_F32 || density->rank != 3)
        return rsv_tensor_fail(file, "density", "is no grid");
    for (int k = 0; k < 3; k++) {
        if (density->shape[2 - k] > RSV_VOLUME_MAX_POINTS)
            return rsv_tensor_fail(file, "density", "is too large");
        side[k] = (uint32_t)density->shape[2 - k];
    }
    rsv_status status = rsv_scene_restore_volume(scene, side, density->data);
    if (status == RSV_OK || status == RSV_ERROR_MEMORY) return status;
    return rsv_tensor_fail(file, "density", "holds no densities of fog");
}

static rsv_status read_fog(rsv_tensor_file *file, rsv_scene *scene)
{
    rsv_status status;
    rsv_fog *fog = NULL;
    size_t one = 1;
    rsv_tensor_prefix(file, "scene.fog.");
    if (!rsv_tensor_find(file, "extinction")) return RSV_OK;
    RSV_TRY(READ_TABLE(file, fog_columns, fog, &one));
    RSV_TRY(rsv_scene_restore_fog(scene, fog));
    RSV_TRY(read_volume(file, scene));
cleanup:
    rsv_free(file->context, fog);
    return status;
}

static rsv_status read_tables(scene_reader *r)
{
    rsv_status status;
    rsv_scene_view *view = &r->parts.view;
    size_t materials = RSV_ANY_COUNT, lights = RSV_ANY_COUNT, cameras = RSV_ANY_COUNT;
    rsv_tensor_prefix(r->file, "scene.material.");
    RSV_TRY(READ_TABLE(r->file, material_columns, r->material, &materials));
    RSV_TRY(READ_NAMES(
        r->file, "scene.material.name", r->material, materials, &r->list[MATERIAL_NAMES]));
    rsv_tensor_prefix(r->file, "scene.light.");
    RSV_TRY(READ_TABLE(r->file, light_columns, r->light, &lights));
    RSV_TRY(READ_NAMES(r->file, "scene.light.name", r->light, lights, &r->list[LIGHT_NAMES]));
    rsv_tensor_prefix(r->file, "scene.camera.");
    RSV_TRY(READ_TABLE(r->file, camera_columns, r->camera, &cameras));
    RSV_TRY(READ_NAMES(r->file, "scene.camera.name", r->camera, cameras, &r->list[CAMERA_NAMES]));
    RSV_TRY(read_nodes(r->file, "scene.light.node", lights, &r->light_node, &r->list[LIGHT_NODES]));
    RSV_TRY(
        read_nodes(r->file, "scene.camera.node", cameras, &r->camera_node, &r->list[CAMERA_NODES]));
    RSV_TRY(rsv_read_luminaires(r->file, r->light, lights, &r->luminaire, &r->luminaire_count));
    if (rsv_note_get(r->file, "scene.origin"))
        RSV_TRY(
            rsv_read_fields(r->file, "scene.origin", origin_fields, COUNT_OF(origin_fields), view));
    if (cameras == 0) RSV_TRY(rsv_tensor_fail(r->file, "position", "lists no camera"));
    view->material = r->material, view->material_count = materials;
    view->light = r->light, view->light_count = lights;
    view->luminaire = r->luminaire, view->luminaire_count = r->luminaire_count;
    view->camera = r->camera, view->camera_count = cameras;
    view->light_node = r->light_node, view->camera_node = r->camera_node;
cleanup:
    return status;
}

static void free_reader(scene_reader *r)
{
    const rsv_scene_view *view = &r->parts.view;
    const void *arrays[] = { view->position, view->normal, view->uv[0], view->uv[1], view->tangent,
        view->color, view->triangle, view->triangle_material, view->triangle_object, r->material,
        r->light, r->camera, r->object_name, r->light_node, r->camera_node, r->texture, r->desc,
        r->use, r->ref, r->environment, r->luminaire };
    for (size_t k = 0; k < r->luminaire_count; k++)
        rsv_luminaire_free(r->file->context, &r->luminaire[k]);
    for (size_t k = 0; k < COUNT_OF(arrays); k++)
        rsv_free(r->file->context, (void *)arrays[k]);
    for (int k = 0; k < LISTS; k++)
        cJSON_Delete(r->list[k]);
}

rsv_status rsv_read_scene(rsv_tensor_file *file, rsv_scene **scene)
{
    rsv_status status;
    scene_reader r = { .file = file };
    r.parts.view.vertex_count = r.parts.view.triangle_count = RSV_ANY_COUNT;
    RSV_TRY(exchange_geometry(file, &r.parts.view));
    RSV_TRY(read_objects(&r));
    RSV_TRY(read_tables(&r));
    RSV_TRY(read_texture_uses(&r));
    RSV_TRY(read_textures(&r));
    RSV_TRY(read_environment(&r));
    RSV_TRY(rsv_scene_restore(file->context, &r.parts, scene));
    RSV_TRY(read_fog(file, *scene));
cleanup:
    free_reader(&r);
    return status;
}
