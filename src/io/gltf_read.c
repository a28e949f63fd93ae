/// From a glTF document to a scene.
#include "../core/core.h"
#include "../core/vec.h"
#include "../scene/placed_luminaire.h"
#include "../scene/punctual.h"
#include "../scene/scene.h"
#include "gltf_archive.h"
#include "gltf_geometry.h"
#include "gltf_luminaire.h"
#include "gltf_part.h"
#include "gltf_skin.h"
#include "gltf_texture.h"
#include "light_units.h"
#include "matrix.h"
#include "scene_read.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define LABEL_BYTES 256

typedef struct reader {
    rsv_context *context;
    const rsv_gltf_document *document;
    rsv_scene *scene;
    bool is_moment; ///< of a file that was read before, and told of
    rsv_gltf_parts parts;
    rsv_gltf_joints *joints; ///< [skin_count]; those without matrices have not been needed yet
    /// [mesh_count + 1] where the scene ids of a mesh's primitives begin in primitive_id
    size_t *first_primitive;
    uint32_t
        *primitive_id; ///< scene mesh of each primitive as its mesh has it; RSV_NONE = not read
    bool *mesh_named;  ///< [mesh_count] whether its skipped primitives were reported
    uint32_t material_count, default_material;
    rsv_light_scale scale;
    int variant; ///< that is shown; -1 = the default
} reader;

static bool refers(int reference, size_t count)
{
    return reference >= 0 && (size_t)reference < count;
}

// ---- materials ------------------------------------------------------------------------------------

static rsv_status add_materials(reader *r)
{
    rsv_status status =
        r->is_moment ? RSV_OK : rsv_gltf_add_materials(r->context, r->document, r->scene);
    r->material_count = (uint32_t)r->document->material_count;
    bool has_default = r->scene->material_count > r->material_count; // from the scene at rest
    r->default_material = has_default ? r->material_count : RSV_NONE;
    for (size_t k = 0; k < r->scene->material_count && !r->is_moment; k++)
        r->scene->material[k].emission =
            rgb_scale(r->scene->material[k].emission, (float)r->scale.emission);
    return status;
}

/// The scene's id of a primitive's material; the specification's default where it names none.
static rsv_status find_material(reader *r, int reference, const char *owner, uint32_t *id)
{
    rsv_status status = RSV_OK;
    if (reference != -1) {
        if (!refers(reference, r->material_count))
            return rsv_fail(
                RSV_ERROR_FORMAT, "mesh '%s': material %d does not exist", owner, reference);
        *id = (uint32_t)reference;
        return RSV_OK;
    }
    if (r->default_material == RSV_NONE) {
        rsv_material material = rsv_default_material();
        material.name = "default";
        material.metallic = 1;
        RSV_TRY(rsv_scene_add_material(r->scene, &material, &r->default_material));
    }
    *id = r->default_material;
cleanup:
    return status;
}

// ---- meshes ---------------------------------------------------------------------------------------

static void name_primitive(const rsv_gltf_mesh *mesh, size_t primitive, char label[LABEL_BYTES])
{
    snprintf(label, LABEL_BYTES, mesh->primitive_count > 1 ? "%.200s, primitive %zu" : "%.200s",
        mesh->name, primitive);
}

static rsv_status add_geometry(reader *r, const rsv_gltf_geometry *g, const char *owner,
    uint32_t material, bool deforms, uint32_t *id)
{
    if (g->index_count % 3 && !r->is_moment)
        rsv_log(r->context, RSV_LOG_WARNING,
            "mesh '%s': the last %zu indices do not form a whole triangle and are ignored", owner,
            g->index_count % 3);
    const rsv_mesh_desc mesh = { .size = sizeof mesh,
        .name = owner,
        .positions = g->position,
        .normals = g->normal,
        .uvs = { (const float(*)[2])g->uv[0], (const float(*)[2])g->uv[1] },
        .tangents = (const float(*)[4])g->tangent,
        .colors = (const float(*)[4])g->color,
        .vertex_count = g->vertex_count,
        .indices = g->index,
        .triangle_count = g->index_count / 3,
        .material = material,
        .deforms = deforms };
    return rsv_scene_add_mesh(r->scene, &mesh, id);
}

/// The joints of a skin, found when they are first needed.
static rsv_status find_joints(reader *r, int skin, const rsv_gltf_joints **joints)
{
    rsv_gltf_joints *found = &r->joints[skin];
    *joints = found;
    return found->matrix ? RSV_OK : rsv_gltf_joints_create(&r->parts, (size_t)skin, found);
}

/// Textures that a mesh has no coordinates for show one texel everywhere.
static void check_coordinates(
    const reader *r, const rsv_gltf_geometry *g, int reference, const char *owner)
{
    if (reference < 0 || r->is_moment) return;
    const rsv_gltf_material *material = &r->document->material[reference];
    for (size_t k = 0; k < material->texture_count; k++) {
        uint32_t set = material->texture[k].ref.uv_set;
        if (g->uv[set]) continue;
        rsv_log(r->context, RSV_LOG_WARNING,
            "mesh '%s': material '%s' has textures that use TEXCOORD_%u, which the mesh lacks: they show a "
            "single colour",
            owner, material->value.name, set);
        return;
    }
}

/// The material of a primitive in the variant that is shown.
static int material_of(const reader *r, const rsv_gltf_primitive *primitive)
{
    for (size_t k = 0; k < primitive->variant_count && r->variant >= 0; k++)
        if (primitive->variant[k].variant == r->variant) return primitive->variant[k].material;
    return primitive->material;
}

/// Whether animations may change the shape of a part, by its joints or by weights of morph targets.
static bool is_bent(const reader *r, const rsv_gltf_part *part)
{
    const rsv_gltf_mesh *mesh = &r->document->mesh[part->mesh];
    return r->document->animation_count &&
           (part->skinned || mesh->primitive[part->primitive].target_count);
}

/// Adds a primitive to the scene, bent and morphed as one part shows it.
static rsv_status add_primitive(reader *r, const rsv_gltf_part *part, uint32_t *id)
{
    rsv_status status;
    uint32_t material;
    rsv_gltf_geometry g = { 0 };
    const rsv_gltf_node *node = &r->document->node[part->node];
    const rsv_gltf_mesh *mesh = &r->document->mesh[part->mesh];
    const rsv_gltf_primitive *primitive = &mesh->primitive[part->primitive];
    char label[LABEL_BYTES];
    name_primitive(mesh, part->primitive, label);
    RSV_TRY(find_material(r, material_of(r, primitive), label, &material));
    RSV_TRY(rsv_gltf_read_geometry(
        r->context, r->document, primitive, rsv_gltf_weights_of(r->document, node), label, &g));
    if (part->skinned) {
        const rsv_gltf_joints *joints;
        RSV_TRY(find_joints(r, node->skin, &joints));
        RSV_TRY(rsv_gltf_bend(joints, r->document, primitive, label, part->mirrored, &g));
    }
    check_coordinates(r, &g, material_of(r, primitive), label);
    RSV_TRY(add_geometry(r, &g, label, material, is_bent(r, part), id));
cleanup:
    rsv_gltf_release_geometry(r->context, &g);
    return status;
}

/// The scene's mesh for a part. All parts that show a primitive undeformed share it.
static rsv_status find_mesh(reader *r, const rsv_gltf_part *part, uint32_t *id)
{
    const rsv_gltf_node *node = &r->document->node[part->node];
    uint32_t *shared = &r->primitive_id[r->first_primitive[part->mesh] + part->primitive];
    bool own = part->skinned || node->weight;
    rsv_status status = RSV_OK;
    if (own) return add_primitive(r, part, id);
    if (*shared == RSV_NONE) status = add_primitive(r, part, shared);
    *id = *shared;
    return status;
}

/// Reports, once per mesh, the primitives that cannot be shown.
static void name_skipped(reader *r, int index)
{
    const rsv_gltf_mesh *mesh = &r->document->mesh[index];
    if (r->mesh_named[index] || r->is_moment) return;
    r->mesh_named[index] = true;
    for (size_t k = 0; k < mesh->primitive_count; k++) {
        const rsv_gltf_primitive *primitive = &mesh->primitive[k];
        char label[LABEL_BYTES];
        name_primitive(mesh, k, label);
        if (primitive->position < 0)
            rsv_log(r->context, RSV_LOG_WARNING, "mesh '%s': it has no positions and is skipped",
                label);
        else if (primitive->mode < 0 || primitive->mode > RSV_GLTF_TRIANGLE_FAN)
            rsv_log(r->context, RSV_LOG_WARNING,
                "mesh '%s': its mode %d is not in the format; it is skipped", label,
                primitive->mode);
        else if (primitive->mode < RSV_GLTF_TRIANGLES)
            rsv_log(r->context, RSV_LOG_INFO, "mesh '%s': points and lines are skipped", label);
    }
}

// ---- parts ----------------------------------------------------------------------------------------

/// Names a part; instances of one node are numbered.
static void name_part(const reader *r, const rsv_gltf_part *part, char name[LABEL_BYTES])
{
    const char *node = r->document->node[part->node].name;
    if (part->copy == RSV_NONE)
        snprintf(name, LABEL_BYTES, "%s", node);
    else
        snprintf(name, LABEL_BYTES, "%.200s, instance %u", node,
            part->copy - r->parts.first_copy[part->node]);
}

static rsv_status add_part(reader *r, const rsv_gltf_part *part)
{
    rsv_status status;
    uint32_t mesh;
    double world[16] = { [0] = 1, [5] = 1, [10] = 1, [15] = 1 };
    char name[LABEL_BYTES];
    RSV_TRY(find_mesh(r, part, &mesh));
    if (part->skinned)
        memcpy(world + 12, r->joints[r->document->node[part->node].skin].origin, sizeof(double[3]));
    else
        rsv_gltf_part_world(&r->parts, part, world);
    name_part(r, part, name);
    RSV_TRY(rsv_scene_place_instance(
        r->scene, mesh, world, part->copy == RSV_NONE ? r->document->node[part->node].name : name));
cleanup:
    return status;
}

static rsv_status add_parts(reader *r)
{
    rsv_status status = RSV_OK;
    for (size_t k = 0; k < r->parts.order_count; k++) {
        uint32_t node = r->parts.order[k];
        int mesh = r->document->node[node].mesh;
        if (mesh >= 0 && !r->parts.hidden[node]) name_skipped(r, mesh);
    }
    for (size_t k = 0; k < r->parts.count; k++)
        RSV_TRY(add_part(r, &r->parts.part[k]));
cleanup:
    return status;
}

// ---- cameras and lights ---------------------------------------------------------------------------

static rsv_vec3 column_of(const double m[16], int column)
{
    const double *c = &m[4 * column];
    return v3((float)c[0], (float)c[1], (float)c[2]);
}

/// Leaves out a part that cannot be shown, with a warning, and goes on.
static rsv_status leave_out(
    const reader *r, const rsv_gltf_node *node, const char *what, const char *why)
{
    rsv_log(
        r->context, RSV_LOG_WARNING, "node '%s': its %s is left out: %s", node->name, what, why);
    return RSV_OK;
}

static rsv_status add_camera(reader *r, const rsv_gltf_node *node, const double world[16])
{
    if (!refers(node->camera, r->document->camera_count))
        return rsv_fail(
            RSV_ERROR_FORMAT, "node '%s': camera %d does not exist", node->name, node->camera);
    rsv_camera camera = r->document->camera[node->camera];
    bool perspective = camera.vertical_fov > 0 && camera.vertical_fov < RSV_PI;
    bool orthographic = camera.vertical_fov == 0 && camera.vertical_extent > 0;
    if (!*camera.name) camera.name = node->name;
    if ((!perspective && !orthographic) || !(camera.aspect >= 0 && isfinite(camera.aspect)))
        return leave_out(r, node, "camera", "its lens is not valid (yfov, ymag or aspect)");
    camera.forward = v3_neg(v3_normalize(column_of(world, 2)));
    camera.right = v3_normalize(v3_cross(camera.forward, column_of(world, 1)));
    camera.up = v3_cross(camera.right, camera.forward);
    if (v3_length(camera.right) == 0)
        return leave_out(r, node, "camera", "its transform makes its direction zero");
    return rsv_scene_place_camera(r->scene, &camera, world + 12, node->name);
}

/// Numbers that are right already stay bit for bit.
static rsv_rgb scaled(rsv_rgb value, double factor)
{
    return rgb((float)((double)value.r * factor), (float)((double)value.g * factor),
        (float)((double)value.b * factor));
}

static rsv_status add_light(reader *r, const rsv_gltf_node *node, const double world[16])
{
    if (!refers(node->light, r->document->light_count))
        return rsv_fail(
            RSV_ERROR_FORMAT, "node '%s': light %d does not exist", node->name, node->light);
    rsv_punctual_light light = r->document->light[node->light].value;
    if (!r->document->light[node->light].known) return RSV_OK;
    if (!*light.name) light.name = node->name;
    light.direction = v3_neg(v3_normalize(column_of(world, 2)));
    light.side = column_of(world, 0);
    light.intensity = scaled(
        light.intensity, rsv_punctual_is_distant(&light) ? r->scale.distant : r->scale.local);
    if (rsv_punctual_has_direction(&light) && v3_length(light.direction) == 0)
        return leave_out(r, node, "light", "its transform makes its direction zero");
    return rsv_scene_place_light(r->scene, &light, world + 12, node->name);
}

static rsv_status add_luminaire(reader *r, const rsv_gltf_node *node, const double world[16])
{
    rsv_status status;
    rsv_luminaire luminaire;
    rsv_punctual_light light;
    rsv_rgb scale = node->luminaire_scale;
    if (f_min(scale.r, f_min(scale.g, scale.b)) < 0)
        return leave_out(r, node, "luminaire", "its intensity is negative");
    status = rsv_gltf_read_luminaire(r->context, r->document, node->luminaire, &luminaire);
    if (status == RSV_ERROR_FORMAT) {
        char problem[512];
        snprintf(problem, sizeof problem, "%s", rsv_last_error());
        rsv_luminaire_free(r->context, &luminaire);
        return leave_out(r, node, "luminaire", problem);
    }
    RSV_TRY(status);
    if (!rsv_gltf_luminaire_light(node, world, &luminaire, &light)) {
        status = leave_out(r, node, "luminaire", "its transform makes its direction zero");
    } else {
        RSV_TRY(rsv_scene_add_luminaire(r->scene, &luminaire, &light.luminaire));
        status = rsv_scene_place_light(r->scene, &light, world + 12, node->name);
    }
cleanup:
    rsv_luminaire_free(r->context, &luminaire);
    return status;
}

/// Where a luminaire is to hang from a node that has neither a mesh nor a light (rsv_load_desc.luminaire): a dark light
/// that points along its -y, which the luminaire will replace.
static rsv_status mark_node(
    reader *r, const rsv_load_desc *desc, const rsv_gltf_node *node, const double world[16])
{
    bool meant = false;
    if (node->mesh != -1 || node->light != -1 || node->luminaire != -1) return RSV_OK;
    for (size_t k = 0; k < desc->luminaire_count; k++)
        meant = meant || rsv_name_is_meant(desc->luminaire[k].name, node->name);
    rsv_punctual_light light = { .name = node->name,
        .kind = RSV_PUNCTUAL_SPOT,
        .direction = v3_neg(v3_normalize(column_of(world, 1))),
        .side = column_of(world, 0) };
    if (!meant || !(v3_length(light.direction) > 0)) return RSV_OK;
    return rsv_scene_place_light(r->scene, &light, world + 12, node->name);
}

/// A hidden node shows no mesh and gives no light, but its camera works.
static rsv_status add_cameras_and_lights(reader *r, const rsv_load_desc *desc)
{
    rsv_status status = RSV_OK;
    for (size_t k = 0; k < r->parts.order_count; k++) {
        uint32_t index = r->parts.order[k];
        const rsv_gltf_node *node = &r->document->node[index];
        if (node->camera != -1) RSV_TRY(add_camera(r, node, r->parts.world[index]));
        if (node->light != -1 && !r->parts.hidden[index])
            RSV_TRY(add_light(r, node, r->parts.world[index]));
        if (node->luminaire != -1 && !r->parts.hidden[index])
            RSV_TRY(add_luminaire(r, node, r->parts.world[index]));
    }
    for (size_t k = 0; k < r->parts.order_count; k++) {
        uint32_t index = r->parts.order[k];
        RSV_TRY(mark_node(r, desc, &r->document->node[index], r->parts.world[index]));
    }
cleanup:
    return status;
}

// ---- what is left out -----------------------------------------------------------------------------

/// A group of nodes of which something is not done, named once.
typedef struct group {
    size_t count;
    const char *first;
} group;

static void count_in(group *g, bool is_in, const char *name)
{
    if (is_in && !g->count++) g->first = name;
}

/// Whether a node has a skin for a mesh that is bound to no joints.
static bool is_stiff(const rsv_gltf_document *document, const rsv_gltf_node *node)
{
    if (node->skin < 0 || node->mesh < 0) return false;
    const rsv_gltf_mesh *mesh = &document->mesh[node->mesh];
    for (size_t k = 0; k < mesh->primitive_count; k++)
        if (mesh->primitive[k].influence_count) return false;
    return true;
}

static void name_groups(const reader *r)
{
    group hidden = { 0 }, bent = { 0 }, loose = { 0 }, stiff = { 0 };
    for (size_t k = 0; k < r->parts.order_count; k++) {
        const rsv_gltf_node *node = &r->document->node[r->parts.order[k]];
        count_in(&hidden, node->hidden, node->name);
        count_in(&bent, node->instanced && node->skin >= 0, node->name);
        count_in(&loose, node->instanced && node->mesh < 0, node->name);
        count_in(&stiff, is_stiff(r->document, node), node->name);
    }
    if (hidden.count)
        rsv_log(r->context, RSV_LOG_INFO,
            "%zu nodes (first: '%s') are hidden by KHR_node_visibility, with all below them",
            hidden.count, hidden.first);
    if (bent.count)
        rsv_log(r->context, RSV_LOG_WARNING,
            "%zu nodes (first: '%s') have instances and a skin: they are shown once, by the skin",
            bent.count, bent.first);
    if (stiff.count)
        rsv_log(r->context, RSV_LOG_WARNING,
            "%zu nodes (first: '%s') have a skin, but their mesh has no joints and weights: they "
            "are shown where they are",
            stiff.count, stiff.first);
    if (loose.count)
        rsv_log(r->context, RSV_LOG_WARNING, "%zu nodes (first: '%s') have instances but no mesh",
            loose.count, loose.first);
}

static void tell_notes(const reader *r)
{
    if (r->is_moment) return;
    for (size_t k = 0; k < r->document->note_count; k++)
        rsv_log(r->context, r->document->note[k].level, "%s", r->document->note[k].text);
    if (r->scale.said) rsv_log(r->context, RSV_LOG_INFO, "%s", r->scale.said);
    name_groups(r);
}

// ---- the whole file -------------------------------------------------------------------------------

static rsv_status allocate(reader *r)
{
    const rsv_gltf_document *document = r->document;
    rsv_context *context = r->context;
    r->first_primitive = rsv_alloc(context, document->mesh_count + 1, sizeof *r->first_primitive);
    if (!r->first_primitive) return RSV_ERROR_MEMORY;
    for (size_t i = 0; i < document->mesh_count; i++)
        r->first_primitive[i + 1] = r->first_primitive[i] + document->mesh[i].primitive_count;
    size_t primitives = r->first_primitive[document->mesh_count];
    r->primitive_id = rsv_alloc(context, primitives, sizeof *r->primitive_id);
    r->mesh_named = rsv_alloc(context, document->mesh_count, sizeof *r->mesh_named);
    r->joints = rsv_alloc(context, document->skin_count, sizeof *r->joints);
    for (size_t i = 0; r->primitive_id && i < primitives; i++)
        r->primitive_id[i] = RSV_NONE;
    return r->primitive_id && r->mesh_named && r->joints ? RSV_OK : RSV_ERROR_MEMORY;
}

static void release(reader *r)
{
    for (size_t k = 0; r->joints && k < r->document->skin_count; k++)
        if (r->joints[k].matrix) rsv_gltf_joints_destroy(&r->joints[k]);
    rsv_free(r->context, r->joints);
    rsv_free(r->context, r->first_primitive);
    rsv_free(r->context, r->primitive_id);
    rsv_free(r->context, r->mesh_named);
    rsv_gltf_parts_destroy(&r->parts);
}

/// Gives the scene the file, where it is not too large.
static rsv_status keep(const rsv_gltf_document *document, const char *path, rsv_scene *scene)
{
    uint8_t *bytes;
    size_t count;
    rsv_context *context = rsv_scene_get_context(scene);
    rsv_status status = rsv_gltf_archive_pack(context, document, &bytes, &count);
    if (status != RSV_ERROR_UNSUPPORTED)
        return status == RSV_OK ? rsv_scene_set_document(scene, path, bytes, count) : status;
    rsv_log(context, RSV_LOG_WARNING,
        "with its buffers and images, it exceeds 4 GiB and is not kept: bakes will write a new file");
    return RSV_OK;
}

/// Names of variants for a message, as many as it holds.
static void list_variants(const rsv_gltf_document *document, char text[512])
{
    *text = '\0';
    for (size_t k = 0; k < document->variant_count; k++) {
        size_t used = strlen(text);
        snprintf(text + used, 512 - used, "%s'%s'", k ? ", " : "", document->variant[k]);
    }
}

static rsv_status choose_variant(reader *r, const char *wanted)
{
    char names[512];
    size_t count = r->document->variant_count;
    list_variants(r->document, names);
    r->variant = -1;
    if (!wanted && count && !r->is_moment)
        rsv_log(r->context, RSV_LOG_INFO,
            "its materials have variants: %s; --variant NAME shows one of them", names);
    if (!wanted) return RSV_OK;
    for (size_t k = 0; k < count && r->variant < 0; k++)
        if (strcmp(r->document->variant[k], wanted) == 0) r->variant = (int)k;
    if (r->variant >= 0) return RSV_OK;
    return rsv_fail(RSV_ERROR_ARGUMENT, "it has no variant '%.200s'%s%s", wanted,
        count ? "; there are " : ", nor any other", names);
}

rsv_status rsv_gltf_fill(
    const rsv_gltf_document *document, const rsv_load_desc *desc, bool is_moment, rsv_scene *scene)
{
    rsv_status status;
    rsv_context *context = rsv_scene_get_context(scene);
    reader r = { .context = context,
        .document = document,
        .scene = scene,
        .is_moment = is_moment,
        .parts = { .context = context } };
    RSV_TRY(choose_variant(&r, desc->variant));
    r.scale = rsv_gltf_light_scale(document, desc->light_units);
    RSV_TRY(rsv_gltf_parts_create(context, document, &r.parts));
    RSV_TRY(allocate(&r));
    tell_notes(&r);
    RSV_TRY(add_materials(&r));
    RSV_TRY(add_parts(&r));
    RSV_TRY(add_cameras_and_lights(&r, desc));
cleanup:
    release(&r);
    return status;
}

static void note_animations(rsv_context *context, size_t count)
{
    if (count)
        rsv_log(context, RSV_LOG_INFO,
            "%zu animation%s not played: the scene is shown in its rest pose", count,
            count > 1 ? "s are" : " is");
}

rsv_status rsv_gltf_read(const char *path, const rsv_load_desc *desc, rsv_scene *scene)
{
    rsv_status status;
    const rsv_gltf_document *document = NULL;
    RSV_TRY(rsv_gltf_open(desc->files, path, &document));
    note_animations(rsv_scene_get_context(scene), document->animation_count);
    RSV_TRY(rsv_gltf_fill(document, desc, false, scene));
    if (desc->keep_document && !desc->variant) RSV_TRY(keep(document, path, scene));
cleanup:
    rsv_gltf_close(document);
    return status;
}
