#include "scene.h"
#include "../core/descriptor.h"
#include "../core/vec.h"
#include "coat_normal.h"
#include "placed_luminaire.h"
#include "punctual.h"
#include "volume.h"

#include <string.h>

rsv_status rsv_scene_create(rsv_context *context, rsv_scene **scene)
{
    if (!context || !scene)
        return rsv_fail(RSV_ERROR_ARGUMENT, "scene: context and result must not be NULL");
    rsv_scene *created = rsv_alloc(context, 1, sizeof *created);
    if (!created) return RSV_ERROR_MEMORY;
    created->context = context;
    *scene = created;
    return RSV_OK;
}

static void release_mesh(rsv_context *context, rsv_mesh *mesh)
{
    rsv_free(context, mesh->name);
    rsv_free(context, mesh->position);
    rsv_free(context, mesh->normal);
    rsv_free(context, mesh->uv[0]);
    rsv_free(context, mesh->uv[1]);
    rsv_free(context, mesh->tangent);
    rsv_free(context, mesh->color);
    rsv_free(context, mesh->index);
}

void rsv_scene_release_sources(rsv_scene *scene)
{
    for (size_t i = 0; i < scene->mesh_count; i++)
        release_mesh(scene->context, &scene->mesh[i]);
    for (size_t i = 0; i < scene->instance_count; i++)
        rsv_free(scene->context, scene->instance[i].name);
    rsv_free(scene->context, scene->mesh);
    rsv_free(scene->context, scene->instance);
    scene->mesh = NULL;
    scene->instance = NULL;
    scene->mesh_count = scene->mesh_capacity = 0;
    scene->instance_count = scene->instance_capacity = 0;
}

/// Frees the data that a variant does not share.
static void release_lights_and_colors(rsv_scene *scene)
{
    for (size_t i = 0; i < scene->light_count; i++) {
        rsv_free(scene->context, (void *)scene->light[i].name);
        rsv_free(scene->context, scene->light_fixture[i].node);
    }
    rsv_free(scene->context, scene->light);
    rsv_free(scene->context, scene->light_fixture);
    rsv_free(scene->context, (void *)scene->light_node);
    rsv_free(scene->context, scene->material);
}

static void release_names(rsv_scene *scene)
{
    rsv_context *context = scene->context;
    for (size_t i = 0; i < scene->material_count; i++) {
        rsv_free(context, (void *)scene->material[i].name);
        rsv_free(context, (void *)scene->material[i].textures);
    }
    for (size_t i = 0; i < scene->camera_count; i++) {
        rsv_free(context, (void *)scene->camera[i].name);
        rsv_free(context, scene->camera_fixture[i].node);
    }
    for (size_t i = 0; i < scene->object_count; i++)
        rsv_free(context, scene->object_name[i]);
}

static void release_variant(rsv_scene *scene)
{
    release_lights_and_colors(scene);
    if (scene->owns_positions) {
        rsv_free(scene->context, scene->position);
        rsv_scene_release_twins(scene);
    }
    if (scene->owns_normals) {
        rsv_free(scene->context, scene->normal);
        rsv_free(scene->context, scene->tangent);
    }
    if (scene->owns_environment) rsv_free(scene->context, (void *)scene->environment.pixels);
    rsv_volumes_destroy(scene->context, scene->volume);
    rsv_free(scene->context, scene);
}

void rsv_scene_destroy(rsv_scene *scene)
{
    if (!scene) return;
    if (scene->base) {
        release_variant(scene);
        return;
    }
    rsv_context *context = scene->context;
    rsv_scene_release_sources(scene);
    release_names(scene);
    rsv_scene_release_environment(scene);
    rsv_scene_release_twins(scene);
    rsv_scene_drop_document(scene);
    rsv_volumes_destroy(context, scene->volume);
    release_lights_and_colors(scene);
    for (size_t i = 0; !scene->rest && i < scene->texture_count; i++)
        rsv_texture_release(context, &scene->texture[i]);
    for (size_t i = 0; i < scene->luminaire_count; i++)
        rsv_luminaire_free(context, &scene->luminaire[i]);
    rsv_free(context, scene->luminaire);
    rsv_free(context, scene->camera);
    rsv_free(context, scene->camera_fixture);
    rsv_free(context, (void *)scene->camera_node);
    rsv_free(context, scene->position);
    rsv_free(context, scene->normal);
    rsv_free(context, scene->texture);
    rsv_free(context, scene->material_varies);
    rsv_free(context, scene->uv[0]);
    rsv_free(context, scene->uv[1]);
    rsv_free(context, scene->tangent);
    rsv_free(context, scene->color);
    rsv_free(context, scene->triangle);
    rsv_free(context, scene->triangle_material);
    rsv_free(context, scene->triangle_object);
    rsv_free(context, scene->triangle_source);
    rsv_free(context, scene->object_instance);
    rsv_free(context, scene->object_name);
    rsv_free(context, scene);
}

/// Room for one more element, refused after commit and beyond 32-bit ids.
static rsv_status reserve_one(
    rsv_scene *scene, const char *what, void **array, size_t *capacity, size_t count, size_t size)
{
    if (scene->committed)
        return rsv_fail(RSV_ERROR_ARGUMENT, "scene: cannot add a %s after commit", what);
    if (count >= RSV_NONE - 1) return rsv_fail(RSV_ERROR_ARGUMENT, "scene: too many %ss", what);
    return rsv_grow(scene->context, array, capacity, count + 1, size);
}

static rsv_status copy_name(rsv_scene *scene, const char *name, const char *fallback, char **copy)
{
    *copy = rsv_copy_string(scene->context, name && *name ? name : fallback);
    return *copy ? RSV_OK : RSV_ERROR_MEMORY;
}

static bool finite3(rsv_vec3 v) { return isfinite(v.x) && isfinite(v.y) && isfinite(v.z); }

rsv_texture_ref rsv_default_texture_ref(rsv_texture_role role, uint32_t texture)
{
    return (rsv_texture_ref){
        .role = role, .texture = texture, .transform = { { 1, 0, 0 }, { 0, 1, 0 } }, .scale = 1
    };
}

void rsv_texture_desc_init(rsv_texture_desc *desc, size_t size)
{
    const rsv_texture_desc defaults = { .size = sizeof defaults };
    rsv_desc_fill(desc, size, &defaults);
}

rsv_status rsv_scene_add_texture(
    rsv_scene *scene, const rsv_texture_desc *desc, uint32_t *texture_id)
{
    rsv_status status;
    rsv_texture texture;
    rsv_texture_desc settings = rsv_default_texture_desc();
    RSV_TRY(RSV_READ_DESC(rsv_texture_desc, &settings, desc));
    RSV_TRY(reserve_one(scene, "texture", (void **)&scene->texture, &scene->texture_capacity,
        scene->texture_count, sizeof texture));
    RSV_TRY(rsv_texture_create(scene->context, &settings, &texture));
    if (texture_id) *texture_id = (uint32_t)scene->texture_count;
    scene->texture[scene->texture_count++] = texture;
cleanup:
    return status;
}

static rsv_status check_texture_ref(
    const rsv_scene *scene, const rsv_texture_ref *ref, const char *material)
{
    if (ref->texture >= scene->texture_count)
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "material '%s': texture %u does not exist", material, ref->texture);
    if ((uint32_t)ref->role >= RSV_TEXTURE_ROLE_COUNT || ref->uv_set > 1)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "material '%s': texture %u has an unknown role or uv set %u (there are 0 and 1)",
            material, ref->texture, ref->uv_set);
    float sum = ref->scale;
    for (int k = 0; k < 6; k++)
        sum += ref->transform[k / 3][k % 3];
    if (!isfinite(sum))
        return rsv_fail(RSV_ERROR_FORMAT,
            "material '%s': the transform or scale of texture '%s' is not finite", material,
            scene->texture[ref->texture].name);
    return RSV_OK;
}

static rsv_status copy_texture_refs(
    rsv_scene *scene, const rsv_material *from, const char *name, rsv_material *to)
{
    rsv_status status = RSV_OK;
    rsv_texture_ref *copy = NULL;
    to->textures = NULL;
    if (!from->texture_count) return RSV_OK;
    for (size_t i = 0; i < from->texture_count; i++)
        RSV_TRY(check_texture_ref(scene, &from->textures[i], name));
    copy = rsv_alloc(scene->context, from->texture_count, sizeof *copy);
    if (!copy) return RSV_ERROR_MEMORY;
    memcpy(copy, from->textures, from->texture_count * sizeof *copy);
    to->textures = copy;
cleanup:
    return status;
}

rsv_texture_info rsv_scene_texture_info(const rsv_scene *scene, uint32_t texture)
{
    if (texture >= scene->texture_count) return (rsv_texture_info){ 0 };
    const rsv_texture *t = &scene->texture[texture];
    return (rsv_texture_info){ t->name, t->level[0].width, t->level[0].height, t->channel_count };
}

/// Colours of invisible texels must not mix with those of visible ones.
static void use_colours(rsv_scene *scene, const rsv_material *material)
{
    const rsv_texture_ref *color = rsv_find_texture(material, RSV_TEXTURE_BASE_COLOR);
    const rsv_texture_ref *opacity = rsv_find_texture(material, RSV_TEXTURE_OPACITY);
    if (color)
        rsv_texture_add_use(scene->context, &scene->texture[color->texture],
            opacity && opacity->texture == color->texture);
}

rsv_status rsv_scene_add_material(
    rsv_scene *scene, const rsv_material *material, uint32_t *material_id)
{
    rsv_status status;
    char *name = NULL;
    rsv_material stored = *material;
    RSV_TRY(reserve_one(scene, "material", (void **)&scene->material, &scene->material_capacity,
        scene->material_count, sizeof stored));
    RSV_TRY(copy_name(scene, material->name, "unnamed", &name));
    RSV_TRY(copy_texture_refs(scene, material, name, &stored));
    stored.name = name;
    use_colours(scene, &stored);
    rsv_material_clamp(scene->context, &stored);
    if (material_id) *material_id = (uint32_t)scene->material_count;
    scene->material[scene->material_count++] = stored;
    return RSV_OK;
cleanup:
    rsv_free(scene->context, name);
    return status;
}

static rsv_status check_mesh(const rsv_scene *scene, const rsv_mesh_desc *mesh, const char *name)
{
    if (mesh->vertex_count >= RSV_NONE || mesh->triangle_count >= RSV_NONE / 3)
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "mesh '%s': %zu vertices and %zu triangles exceed 32-bit indices; split the mesh", name,
            mesh->vertex_count, mesh->triangle_count);
    if (mesh->material >= scene->material_count)
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "mesh '%s': material %u does not exist", name, mesh->material);
    if (!mesh->positions && mesh->vertex_count)
        return rsv_fail(RSV_ERROR_ARGUMENT, "mesh '%s': positions are NULL", name);
    for (size_t i = 0; i < mesh->vertex_count; i++)
        if (!finite3(mesh->positions[i]))
            return rsv_fail(
                RSV_ERROR_FORMAT, "mesh '%s': position of vertex %zu is not finite", name, i);
    if (!mesh->indices && 3 * mesh->triangle_count > mesh->vertex_count)
        return rsv_fail(RSV_ERROR_FORMAT, "mesh '%s': %zu triangles need %zu vertices, not %zu",
            name, mesh->triangle_count, 3 * mesh->triangle_count, mesh->vertex_count);
    for (size_t i = 0; mesh->indices && i < 3 * mesh->triangle_count; i++)
        if (mesh->indices[i] >= mesh->vertex_count)
            return rsv_fail(RSV_ERROR_FORMAT,
                "mesh '%s': triangle %zu refers to vertex %u, but there are only %zu", name, i / 3,
                mesh->indices[i], mesh->vertex_count);
    return RSV_OK;
}

/// Unit normals; unusable ones become zero. Returns how many were unusable.
static size_t normalize_normals(rsv_vec3 *normal, size_t count)
{
    size_t unusable = 0;
    for (size_t i = 0; i < count; i++) {
        float scale = v3_max_abs(normal[i]);
        bool usable = finite3(normal[i]) && scale > 0;
        // scaling first keeps very long and very short normals from over- and underflowing
        normal[i] =
            usable ? v3_normalize(v3(normal[i].x / scale, normal[i].y / scale, normal[i].z / scale))
                   : v3(0, 0, 0);
        unusable += !usable;
    }
    return unusable;
}

/// Whether a triangle with an area lacks a normal. Other triangles are skipped, so their normals do not matter.
static bool lacks_normals(const rsv_mesh *mesh)
{
    rsv_vec3 normal;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *corner = &mesh->index[3 * t];
        bool lacks = false;
        for (int k = 0; k < 3; k++)
            lacks = lacks || v3_max_abs(mesh->normal[corner[k]]) == 0;
        const rsv_vec3 *p = mesh->position;
        if (lacks && rsv_triangle_normal(p[corner[0]], p[corner[1]], p[corner[2]], &normal))
            return true;
    }
    return false;
}

/// A copy of `count` groups of `width` floats. Non-finite values become 0. NULL stays NULL.
static rsv_status copy_attribute(
    rsv_context *context, const void *source, size_t count, size_t width, void *copy)
{
    if (!source) return RSV_OK;
    float *value = rsv_alloc(context, count, width * sizeof *value);
    if (!value) return RSV_ERROR_MEMORY;
    memcpy(value, source, count * width * sizeof *value);
    for (size_t i = 0; i < count * width; i++)
        if (!isfinite(value[i])) value[i] = 0;
    *(float **)copy = value;
    return RSV_OK;
}

/// Copies attributes that vary over the surface, except its shape.
static rsv_status copy_attributes(rsv_scene *scene, const rsv_mesh_desc *source, rsv_mesh *mesh)
{
    rsv_status status;
    size_t count = source->vertex_count;
    for (int set = 0; set < 2; set++)
        RSV_TRY(copy_attribute(scene->context, source->uvs[set], count, 2, &mesh->uv[set]));
    RSV_TRY(copy_attribute(scene->context, source->tangents, count, 4, &mesh->tangent));
    RSV_TRY(copy_attribute(scene->context, source->colors, count, 4, &mesh->color));
    for (size_t i = 0; mesh->color && i < 4 * count; i++)
        mesh->color[i / 4][i % 4] = f_min(f_max(mesh->color[i / 4][i % 4], 0), 1);
cleanup:
    return status;
}

/// Copies the arrays of a checked description. On failure, the caller frees the copies.
static rsv_status copy_mesh(rsv_scene *scene, const rsv_mesh_desc *source, rsv_mesh *mesh)
{
    rsv_context *context = scene->context;
    size_t index_count = 3 * source->triangle_count;
    mesh->position = rsv_alloc(context, source->vertex_count, sizeof *mesh->position);
    mesh->index = rsv_alloc(context, index_count, sizeof *mesh->index);
    if (!mesh->position || !mesh->index) return RSV_ERROR_MEMORY;
    if (source->vertex_count)
        memcpy(mesh->position, source->positions, source->vertex_count * sizeof *mesh->position);
    for (size_t i = 0; i < index_count; i++)
        mesh->index[i] = source->indices ? source->indices[i] : (uint32_t)i;
    if (source->normals) {
        mesh->normal = rsv_alloc(context, source->vertex_count, sizeof *mesh->normal);
        if (!mesh->normal) return RSV_ERROR_MEMORY;
        memcpy(mesh->normal, source->normals, source->vertex_count * sizeof *mesh->normal);
    }
    mesh->vertex_count = source->vertex_count;
    mesh->triangle_count = source->triangle_count;
    mesh->material = source->material;
    return RSV_OK;
}

void rsv_mesh_desc_init(rsv_mesh_desc *desc, size_t size)
{
    const rsv_mesh_desc defaults = { .size = sizeof defaults };
    rsv_desc_fill(desc, size, &defaults);
}

rsv_status rsv_scene_add_mesh(rsv_scene *scene, const rsv_mesh_desc *desc, uint32_t *mesh_id)
{
    rsv_status status;
    rsv_mesh stored = { 0 };
    rsv_mesh_desc settings = rsv_default_mesh_desc();
    const rsv_mesh_desc *mesh = &settings;
    RSV_TRY(RSV_READ_DESC(rsv_mesh_desc, &settings, desc));
    RSV_TRY(reserve_one(scene, "mesh", (void **)&scene->mesh, &scene->mesh_capacity,
        scene->mesh_count, sizeof stored));
    RSV_TRY(copy_name(scene, mesh->name, "unnamed", &stored.name));
    RSV_TRY(check_mesh(scene, mesh, stored.name));
    RSV_TRY(copy_mesh(scene, mesh, &stored));
    RSV_TRY(copy_attributes(scene, mesh, &stored));
    stored.deforms = mesh->deforms;
    if (stored.normal) {
        size_t unusable = normalize_normals(stored.normal, stored.vertex_count);
        if (unusable && lacks_normals(&stored))
            rsv_log(scene->context, RSV_LOG_WARNING,
                "mesh '%s': %zu of %zu normals are zero or not finite; geometric ones are used "
                "there",
                stored.name, unusable, stored.vertex_count);
    }
    if (mesh_id) *mesh_id = (uint32_t)scene->mesh_count;
    scene->mesh[scene->mesh_count++] = stored;
    return RSV_OK;
cleanup:
    release_mesh(scene->context, &stored);
    return status;
}

static rsv_status add_instance(
    rsv_scene *scene, uint32_t mesh_id, const double transform[16], const char *name)
{
    rsv_status status;
    rsv_instance stored = { .mesh = mesh_id };
    RSV_TRY(reserve_one(scene, "instance", (void **)&scene->instance, &scene->instance_capacity,
        scene->instance_count, sizeof stored));
    if (mesh_id >= scene->mesh_count)
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "instance '%s': mesh %u does not exist", name ? name : "", mesh_id);
    memcpy(stored.transform, transform, sizeof stored.transform);
    RSV_TRY(copy_name(scene, name, scene->mesh[mesh_id].name, &stored.name));
    scene->instance[scene->instance_count++] = stored;
cleanup:
    return status;
}

rsv_status rsv_scene_add_instance(
    rsv_scene *scene, uint32_t mesh_id, const float transform[16], const char *name)
{
    double wide[16] = { [0] = 1, [5] = 1, [10] = 1, [15] = 1 };
    for (int i = 0; transform && i < 16; i++)
        wide[i] = (double)transform[i];
    return add_instance(scene, mesh_id, wide, name);
}

rsv_status rsv_scene_place_instance(
    rsv_scene *scene, uint32_t mesh_id, const double transform[16], const char *name)
{
    scene->in_double = true;
    return add_instance(scene, mesh_id, transform, name);
}

rsv_punctual_facts rsv_punctual_facts_of(rsv_punctual_light_kind kind)
{
    return rsv_punctual_kind(kind);
}

static rsv_status check_light(
    const rsv_scene *scene, const rsv_punctual_light *light, const char *name)
{
    if (!rsv_punctual_kind(light->kind).name)
        return rsv_fail(RSV_ERROR_ARGUMENT, "light '%s': %d is not an rsv_punctual_light_kind",
            name, (int)light->kind);
    if (!finite3(light->position) || !finite3(light->direction) || !isfinite(light->exponent) ||
        light->exponent < 0)
        return rsv_fail(
            RSV_ERROR_FORMAT, "light '%s': position, direction or exponent is not usable", name);
    if (!rsv_punctual_is_distant(light) && !rsv_within_reach(light->position))
        return rsv_fail(RSV_ERROR_FORMAT,
            "light '%s': it is farther than %g m from the origin; make it directional", name,
            (double)RSV_FARTHEST);
    float sum = light->intensity.r + light->intensity.g + light->intensity.b;
    if (!isfinite(sum) ||
        f_min(light->intensity.r, f_min(light->intensity.g, light->intensity.b)) < 0)
        return rsv_fail(
            RSV_ERROR_FORMAT, "light '%s': intensity must be finite and not negative", name);
    if (rsv_punctual_has_direction(light) && v3_length(light->direction) == 0)
        return rsv_fail(RSV_ERROR_FORMAT, "light '%s': it has no direction", name);
    float widest = light->kind == RSV_PUNCTUAL_LUMINAIRE ? RSV_PI : RSV_PI / 2;
    bool cone_ok = light->inner_cone_angle >= 0 &&
                   light->inner_cone_angle <= light->outer_cone_angle &&
                   light->outer_cone_angle <= widest * 1.000001f;
    if (rsv_punctual_has_cone(light) && !cone_ok)
        return rsv_fail(RSV_ERROR_FORMAT,
            "light '%s': cone angles must be 0 <= inner <= outer <= pi/2, not %g and %g", name,
            light->inner_cone_angle, light->outer_cone_angle);
    return light->kind == RSV_PUNCTUAL_LUMINAIRE ? rsv_check_placed_luminaire(scene, light, name)
                                                 : RSV_OK;
}

/// Where a light or camera stands, and by which node.
static rsv_status make_fixture(
    rsv_scene *scene, const double position[3], const char *node, rsv_fixture *fixture)
{
    *fixture = (rsv_fixture){ .position = { position[0], position[1], position[2] } };
    if (!node) return RSV_OK;
    fixture->node = rsv_copy_string(scene->context, node);
    return fixture->node ? RSV_OK : RSV_ERROR_MEMORY;
}

static rsv_vec3 rounded(const double v[3]) { return v3((float)v[0], (float)v[1], (float)v[2]); }

rsv_status rsv_scene_place_light(
    rsv_scene *scene, const rsv_punctual_light *light, const double position[3], const char *node)
{
    rsv_status status;
    char *name = NULL;
    rsv_punctual_light stored = *light;
    RSV_TRY(reserve_one(scene, "light", (void **)&scene->light, &scene->light_capacity,
        scene->light_count, sizeof stored));
    RSV_TRY(reserve_one(scene, "light", (void **)&scene->light_fixture,
        &scene->light_fixture_capacity, scene->light_count, sizeof *scene->light_fixture));
    RSV_TRY(copy_name(scene, light->name, "unnamed", &name));
    stored.name = name;
    stored.position = rounded(position);
    RSV_TRY(check_light(scene, &stored, name));
    stored.direction = v3_normalize(light->direction);
    stored.side = v3_length(light->side) > 0 ? v3_normalize(light->side) : v3(0, 0, 0);
    RSV_TRY(make_fixture(scene, position, node, &scene->light_fixture[scene->light_count]));
    scene->light[scene->light_count++] = stored;
    return RSV_OK;
cleanup:
    rsv_free(scene->context, name);
    return status;
}

rsv_status rsv_scene_add_light(rsv_scene *scene, const rsv_punctual_light *light)
{
    rsv_vec3 p = light->position;
    return rsv_scene_place_light(
        scene, light, (const double[3]){ (double)p.x, (double)p.y, (double)p.z }, NULL);
}

rsv_status rsv_scene_append_light(rsv_scene *scene, const rsv_punctual_light *light)
{
    bool committed = scene->committed;
    scene->committed = false;
    rsv_status status = rsv_scene_add_light(scene, light);
    scene->committed = committed;
    scene->view.light = scene->light;
    scene->view.light_count = scene->light_count;
    return status == RSV_OK ? rsv_scene_list_nodes(scene) : status;
}

static rsv_status check_camera(const rsv_camera *camera, const char *name)
{
    bool finite = rsv_within_reach(camera->position) && finite3(camera->right) &&
                  finite3(camera->up) && finite3(camera->forward) && isfinite(camera->aspect) &&
                  camera->aspect >= 0;
    if (!finite)
        return rsv_fail(
            RSV_ERROR_FORMAT, "camera '%s': position, axes or aspect are not usable", name);
    bool perspective = camera->vertical_fov > 0 && camera->vertical_fov < RSV_PI;
    bool orthographic = camera->vertical_fov == 0 && camera->vertical_extent > 0 &&
                        isfinite(camera->vertical_extent);
    if (!perspective && !orthographic)
        return rsv_fail(RSV_ERROR_FORMAT,
            "camera '%s': needs a vertical field of view in (0, pi) or a vertical extent above 0",
            name);
    return RSV_OK;
}

rsv_status rsv_scene_add_camera(rsv_scene *scene, const rsv_camera *camera)
{
    rsv_vec3 p = camera->position;
    return rsv_scene_place_camera(
        scene, camera, (const double[3]){ (double)p.x, (double)p.y, (double)p.z }, NULL);
}

rsv_status rsv_scene_place_camera(
    rsv_scene *scene, const rsv_camera *camera, const double position[3], const char *node)
{
    rsv_status status;
    char *name = NULL;
    rsv_camera stored = *camera;
    RSV_TRY(reserve_one(scene, "camera", (void **)&scene->camera, &scene->camera_capacity,
        scene->camera_count, sizeof stored));
    RSV_TRY(reserve_one(scene, "camera", (void **)&scene->camera_fixture,
        &scene->camera_fixture_capacity, scene->camera_count, sizeof *scene->camera_fixture));
    RSV_TRY(copy_name(scene, camera->name, "unnamed", &name));
    stored.name = name;
    stored.position = rounded(position);
    RSV_TRY(check_camera(&stored, name));
    RSV_TRY(make_fixture(scene, position, node, &scene->camera_fixture[scene->camera_count]));
    scene->camera[scene->camera_count++] = stored;
    return RSV_OK;
cleanup:
    rsv_free(scene->context, name);
    return status;
}

static rsv_status list_nodes(
    rsv_context *context, const rsv_fixture *fixture, size_t count, const char ***list)
{
    const char **node = rsv_alloc(context, count, sizeof *node);
    if (!node) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < count; k++)
        node[k] = fixture[k].node;
    rsv_free(context, (void *)*list);
    *list = node;
    return RSV_OK;
}

rsv_status rsv_scene_list_nodes(rsv_scene *scene)
{
    rsv_status status;
    RSV_TRY(
        list_nodes(scene->context, scene->light_fixture, scene->light_count, &scene->light_node));
    if (!scene->base) // whose cameras a variant has
        RSV_TRY(list_nodes(
            scene->context, scene->camera_fixture, scene->camera_count, &scene->camera_node));
    scene->view.light_node = (const char *const *)scene->light_node;
    scene->view.camera_node = (const char *const *)scene->camera_node;
cleanup:
    return status;
}

const rsv_scene_view *rsv_scene_get_view(const rsv_scene *scene) { return &scene->view; }

rsv_context *rsv_scene_get_context(const rsv_scene *scene) { return scene->context; }

uint32_t rsv_scene_find_object(const rsv_scene *scene, const char *name)
{
    for (size_t i = 0; i < scene->view.object_count; i++)
        if (strcmp(scene->view.object_name[i], name) == 0) return (uint32_t)i;
    return RSV_NONE;
}

size_t rsv_scene_object_triangles(const rsv_scene *scene, uint32_t object, uint32_t *first)
{
    const rsv_scene_view *view = &scene->view;
    size_t begin = 0, end;
    while (begin < view->triangle_count && view->triangle_object[begin] != object)
        begin++;
    for (end = begin; end < view->triangle_count && view->triangle_object[end] == object;)
        end++;
    *first = (uint32_t)begin;
    return end - begin;
}

bool rsv_scene_shines(const rsv_scene_view *view)
{
    for (size_t t = 0; t < view->triangle_count; t++)
        if (!rgb_is_black(view->material[view->triangle_material[t]].emission)) return true;
    for (size_t k = 0; k < view->light_count; k++)
        if (!rgb_is_black(view->light[k].intensity)) return true;
    return view->environment != NULL || (view->fog && !rgb_is_black(view->fog->emission));
}
