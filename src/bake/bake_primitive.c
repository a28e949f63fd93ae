#include "bake_primitive.h"

#include "../core/vec.h"
#include "../io/gltf_accessor.h"

#include <stdio.h>
#include <string.h>

static cJSON *item(const cJSON *parent, const char *name)
{
    return cJSON_GetObjectItemCaseSensitive(parent, name);
}

static int reference(const cJSON *parent, const char *name)
{
    const cJSON *number = item(parent, name);
    return cJSON_IsNumber(number) ? number->valueint : -1;
}

// ---- meshes of their own --------------------------------------------------------------------------

static void count_uses(const cJSON *nodes, uint32_t *uses, size_t mesh_count)
{
    const cJSON *node;
    cJSON_ArrayForEach(node, nodes)
    {
        int mesh = reference(node, "mesh");
        if (mesh >= 0 && (size_t)mesh < mesh_count) uses[mesh]++;
    }
}

/// The mesh of a node alone: a copy, if other nodes share it.
static cJSON *own_mesh(rsv_bake_document *d, const rsv_bake_part *part, int node, bool shared)
{
    cJSON *meshes = item(d->root, "meshes");
    cJSON *mesh = cJSON_GetArrayItem(meshes, (int)part->mesh);
    if (!shared) return mesh;
    cJSON *copy = cJSON_Duplicate(mesh, true);
    int index = rsv_bake_append(d, meshes, copy);
    rsv_bake_number(d, cJSON_GetArrayItem(item(d->root, "nodes"), node), "mesh", index);
    return copy;
}

// ---- instances become nodes -----------------------------------------------------------------------

static const char instancing[] = "EXT_mesh_gpu_instancing";

/// A node below that of an instanced mesh, for one of the instances: each gets light of its own. @return its index
static int add_instance_node(
    rsv_bake_document *d, const rsv_bake_parts *parts, uint32_t of, size_t k)
{
    const rsv_bake_part *part = &parts->part[k];
    char name[160];
    cJSON *node = cJSON_CreateObject(), *matrix = cJSON_CreateArray(),
          *parent = cJSON_GetArrayItem(item(d->root, "nodes"), (int)part->node);
    snprintf(name, sizeof name, "%.100s, instance %u", d->gltf->node[part->node].name,
        part->copy - parts->shown.first_copy[part->node]);
    for (int i = 0; i < 16; i++)
        rsv_bake_append(d, matrix, cJSON_CreateNumber(parts->shown.copy[part->copy][i]));
    rsv_bake_string(d, node, "name", name);
    rsv_bake_number(d, node, "mesh", (double)of);
    if (!node || !cJSON_AddItemToObject(node, "matrix", matrix)) d->exhausted = true;
    int index = rsv_bake_append(d, rsv_bake_array(d, d->root, "nodes"), node);
    rsv_bake_append(d, rsv_bake_array(d, parent, "children"), cJSON_CreateNumber(index));
    return index;
}

/// Puts nodes in the place of EXT_mesh_gpu_instancing. @param node [parts->count] out: which shows each part
static void unfold_instances(rsv_bake_document *d, const rsv_bake_parts *parts, int *node)
{
    for (size_t k = 0; k < parts->count; k++) {
        const rsv_bake_part *part = &parts->part[k];
        bool same = k > 0 && part[-1].node == part->node && part[-1].copy == part->copy;
        node[k] = part->copy == RSV_NONE ? (int)part->node
                  : same                 ? node[k - 1]
                                         : add_instance_node(d, parts, part->mesh, k);
    }
    for (size_t k = 0; k < parts->count; k++) {
        if (parts->part[k].copy == RSV_NONE) continue;
        cJSON *json = cJSON_GetArrayItem(item(d->root, "nodes"), (int)parts->part[k].node);
        cJSON_DeleteItemFromObjectCaseSensitive(json, "mesh");
        rsv_bake_remove_extension(json, instancing);
    }
    const cJSON *json; // those that are hidden keep it
    cJSON_ArrayForEach(json, item(d->root, "nodes"))
    {
        if (item(item(json, "extensions"), instancing)) return;
    }
    rsv_bake_unlist_extension(d, instancing);
}

rsv_status rsv_bake_separate(rsv_bake_document *d, const rsv_bake_parts *parts, cJSON ***primitive)
{
    rsv_status status;
    size_t meshes = d->gltf->mesh_count;
    uint32_t *uses = rsv_alloc(d->context, meshes, sizeof *uses);
    int *node = rsv_alloc(d->context, parts->count, sizeof *node);
    cJSON **json = rsv_alloc(d->context, parts->count, sizeof *json), *mesh = NULL;
    RSV_TRY(uses && json && node ? RSV_OK : RSV_ERROR_MEMORY);
    unfold_instances(d, parts, node);
    count_uses(item(d->root, "nodes"), uses, meshes);
    for (size_t k = 0; k < parts->count; k++) {
        const rsv_bake_part *part = &parts->part[k];
        if (k == 0 || node[k - 1] != node[k])
            mesh = own_mesh(d, part, node[k], uses[part->mesh] > 1);
        json[k] = cJSON_GetArrayItem(item(mesh, "primitives"), (int)part->primitive);
        RSV_TRY(json[k] ? RSV_OK : rsv_fail(RSV_ERROR_MEMORY, "%s: out of memory", d->name));
    }
    *primitive = json;
    json = NULL;
cleanup:
    rsv_free(d->context, uses);
    rsv_free(d->context, node);
    rsv_free(d->context, json);
    return status;
}

cJSON *rsv_bake_material(const rsv_bake_document *d, const cJSON *primitive)
{
    int material = reference(primitive, "material");
    return material < 0 ? NULL : cJSON_GetArrayItem(item(d->root, "materials"), material);
}

// ---- vertices -------------------------------------------------------------------------------------

/// Attributes that can be interpolated.
static bool is_blendable(const char *name)
{
    return !strcmp(name, "POSITION") || !strcmp(name, "NORMAL") || !strcmp(name, "TANGENT") ||
           !strncmp(name, "TEXCOORD_", 9) || !strncmp(name, "COLOR_", 6) ||
           !strcmp(name, "_COLOR"); // of an earlier bake
}

bool rsv_bake_may_divide(const cJSON *primitive)
{
    const cJSON *attribute;
    if (item(primitive, "targets")) return false;
    cJSON_ArrayForEach(attribute, item(primitive, "attributes"))
    {
        if (!is_blendable(attribute->string)) return false;
    }
    return true;
}

/// Values of all attributes of a mesh: those of the file, then interpolated ones.
static void blend(const rsv_bake_mesh *mesh, size_t width, const float *from, float *to)
{
    for (size_t n = 0; n < mesh->attribute_count; n++) {
        uint32_t a = mesh->parent[n][0], b = mesh->parent[n][1];
        float share = mesh->share ? mesh->share[n] : 0;
        for (size_t c = 0; c < width; c++)
            to[n * width + c] = a == b
                                    ? from[a * width + c]
                                    : (1 - share) * to[a * width + c] + share * to[b * width + c];
    }
}

/// Directions stay unit; the fourth number of a tangent, its side, stays a sign.
static void normalize(float *value, size_t count, size_t width)
{
    for (size_t n = 0; n < count; n++) {
        float *v = value + n * width;
        rsv_vec3 unit = v3(v[0], v[1], v[2]);
        float length = v3_length(unit);
        unit = length > 0 ? v3_scale(unit, 1 / length) : v3(0, 1, 0);
        v[0] = unit.x, v[1] = unit.y, v[2] = unit.z;
        if (width == 4) v[3] = v[3] < 0 ? -1 : 1;
    }
}

/// Attributes of a mesh have as many values as there are vertices. Those that loading does not read were not looked at.
static rsv_status check_count(const rsv_bake_part *part, int accessor, size_t count)
{
    if (count >= part->vertex_count) return RSV_OK;
    return rsv_fail(RSV_ERROR_FORMAT, "mesh '%s': accessor %d holds %zu values for %zu positions",
        part->label, accessor, count, part->vertex_count);
}

/// An attribute of the file at the vertices of a mesh.
static rsv_status read_blended(const rsv_bake_document *d, int accessor, const rsv_bake_part *part,
    const rsv_bake_mesh *mesh, float **value, size_t *width)
{
    rsv_status status;
    rsv_gltf_attribute from = { 0 };
    float *all = NULL, *to = NULL;
    RSV_TRY(rsv_gltf_read_attribute(d->context, d->gltf, accessor, part->label, &from));
    RSV_TRY(check_count(part, accessor, from.count));
    *width = from.width;
    all = rsv_alloc(d->context, mesh->attribute_count, *width * sizeof *all);
    to = rsv_alloc(d->context, mesh->vertex_count, *width * sizeof *to);
    RSV_TRY(all && to ? RSV_OK : RSV_ERROR_MEMORY);
    blend(mesh, *width, from.values, all);
    for (size_t n = 0; n < mesh->vertex_count; n++)
        memcpy(to + n * *width, all + mesh->attribute[n] * *width, *width * sizeof *to);
    *value = to;
    to = NULL;
cleanup:
    rsv_free(d->context, from.values);
    rsv_free(d->context, all);
    rsv_free(d->context, to);
    return status;
}

static int component_bytes(int type)
{
    return type == RSV_GLTF_BYTE || type == RSV_GLTF_UNSIGNED_BYTE     ? 1
           : type == RSV_GLTF_SHORT || type == RSV_GLTF_UNSIGNED_SHORT ? 2
                                                                       : 4;
}

/// Whether `count` elements of an accessor are within its buffer; the document is not trusted.
/// @param stride between elements @param bytes of each
static bool holds(const rsv_gltf_document *gltf, const rsv_gltf_accessor *a,
    const rsv_gltf_buffer_view *view, size_t count, size_t stride, size_t bytes)
{
    if ((size_t)view->buffer >= gltf->buffer_count || a->count < count) return false;
    size_t size = gltf->buffer[view->buffer].size;
    if (view->offset > size || a->span.offset > size - view->offset) return false;
    size_t left = size - view->offset - a->span.offset;
    return count == 0 || (left >= bytes && count - 1 <= (left - bytes) / stride);
}

/// Integers are copied unchanged: joints, weights, and unknown attributes.
static rsv_status copy_attribute(
    rsv_bake_document *d, cJSON *attribute, const rsv_bake_part *part, const rsv_bake_mesh *mesh)
{
    const rsv_gltf_accessor *a = &d->gltf->accessor[attribute->valueint];
    const rsv_gltf_buffer_view *view =
        a->span.buffer_view >= 0 && (size_t)a->span.buffer_view < d->gltf->buffer_view_count
            ? &d->gltf->buffer_view[a->span.buffer_view]
            : NULL;
    size_t bytes = (size_t)a->component_count * (size_t)component_bytes(a->span.component_type);
    size_t stride = view && view->stride ? view->stride : bytes, padded = (bytes + 3) & ~(size_t)3;
    if (!view || a->sparse_count || a->component_count < 1 ||
        !holds(d->gltf, a, view, part->vertex_count, stride, bytes))
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "mesh '%s': accessor %d ('%s') is sparse or out of range and cannot be copied",
            part->label, attribute->valueint, attribute->string);
    uint8_t *copy = rsv_alloc(d->context, mesh->vertex_count, padded);
    if (!copy) return RSV_ERROR_MEMORY;
    const uint8_t *data = d->gltf->buffer[view->buffer].data + view->offset + a->span.offset;
    for (size_t n = 0; n < mesh->vertex_count; n++)
        memcpy(copy + n * padded, data + mesh->attribute[n] * stride, bytes);
    cJSON *json =
        cJSON_Duplicate(cJSON_GetArrayItem(item(d->root, "accessors"), attribute->valueint), true);
    int place = rsv_bake_add_view(d, copy, mesh->vertex_count * padded, RSV_BAKE_VERTICES);
    rsv_bake_number(
        d, cJSON_GetArrayItem(item(d->root, "bufferViews"), place), "byteStride", (double)padded);
    rsv_bake_number(d, json, "bufferView", place);
    rsv_bake_number(d, json, "count", (double)mesh->vertex_count);
    cJSON_DeleteItemFromObjectCaseSensitive(json, "byteOffset");
    cJSON_DeleteItemFromObjectCaseSensitive(json, "min");
    cJSON_DeleteItemFromObjectCaseSensitive(json, "max");
    cJSON_SetNumberValue(attribute, rsv_bake_append(d, item(d->root, "accessors"), json));
    rsv_free(d->context, copy);
    return RSV_OK;
}

static bool is_accessor(const rsv_bake_document *d, const cJSON *attribute)
{
    return cJSON_IsNumber(attribute) && attribute->valueint >= 0 &&
           (size_t)attribute->valueint < d->gltf->accessor_count;
}

static rsv_status replace_attribute(
    rsv_bake_document *d, cJSON *attribute, const rsv_bake_part *part, const rsv_bake_mesh *mesh)
{
    float *value;
    size_t width;
    const char *name = attribute->string;
    bool divided = mesh->attribute_count > part->vertex_count;
    if (!is_accessor(d, attribute)) return RSV_OK;
    const rsv_gltf_accessor *a = &d->gltf->accessor[attribute->valueint];
    if (!is_blendable(name) && (a->span.component_type != RSV_GLTF_FLOAT || a->component_count < 2))
        return copy_attribute(d, attribute, part, mesh);
    rsv_status status = read_blended(d, attribute->valueint, part, mesh, &value, &width);
    if (status != RSV_OK) return status;
    if (divided && (!strcmp(name, "NORMAL") || !strcmp(name, "TANGENT")))
        normalize(value, mesh->vertex_count, width);
    cJSON_SetNumberValue(attribute,
        rsv_bake_add_floats(d, value, mesh->vertex_count, (int)width, !strcmp(name, "POSITION")));
    rsv_free(d->context, value);
    return RSV_OK;
}

rsv_status rsv_bake_read_colors(const rsv_bake_document *d, const cJSON *primitive,
    const rsv_bake_part *part, const rsv_bake_mesh *mesh, float **color, size_t *width)
{
    int accessor = reference(item(primitive, "attributes"), "COLOR_0");
    rsv_gltf_attribute read;
    *color = NULL;
    *width = 3;
    if (accessor < 0) return RSV_OK;
    if (mesh->changed) return read_blended(d, accessor, part, mesh, color, width);
    rsv_status status = rsv_gltf_read_attribute(d->context, d->gltf, accessor, part->label, &read);
    if (status != RSV_OK) return status;
    *color = read.values;
    *width = read.width;
    return check_count(part, accessor, read.count);
}

static rsv_status replace_attributes(
    rsv_bake_document *d, cJSON *attributes, const rsv_bake_part *part, const rsv_bake_mesh *mesh)
{
    cJSON *attribute;
    cJSON_ArrayForEach(attribute, attributes)
    {
        rsv_status status = replace_attribute(d, attribute, part, mesh);
        if (status != RSV_OK) return status;
    }
    return RSV_OK;
}

rsv_status rsv_bake_replace_vertices(
    rsv_bake_document *d, cJSON *primitive, const rsv_bake_part *part, const rsv_bake_mesh *mesh)
{
    rsv_status status = replace_attributes(d, item(primitive, "attributes"), part, mesh);
    cJSON *target;
    cJSON_ArrayForEach(target, item(primitive, "targets")) if (status == RSV_OK) status =
        replace_attributes(d, target, part, mesh);
    if (status != RSV_OK) return status;
    cJSON_DeleteItemFromObjectCaseSensitive(primitive, "mode");
    rsv_bake_number(d, primitive, "indices",
        rsv_bake_add_indices(d, mesh->corner[0], 3 * mesh->triangle_count));
    return RSV_OK;
}
