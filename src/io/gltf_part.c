#include "gltf_part.h"

#include "../core/core.h"
#include "gltf_accessor.h"
#include "gltf_skin.h"
#include "matrix.h"

#include <string.h>

/// Bytes that a triangle takes at the least, once it is in the scene.
#define TRIANGLE_BYTES 48.0
/// Bytes per vertex of a mesh that is deformed for one node only.
#define VERTEX_BYTES 24.0

static const double identity[16] = { [0] = 1, [5] = 1, [10] = 1, [15] = 1 };

static bool refers(int reference, size_t count)
{
    return reference >= 0 && (size_t)reference < count;
}

// ---- nodes ----------------------------------------------------------------------------------------

/// Stack of nodes to be visited.
typedef struct walk {
    rsv_gltf_parts *parts;
    uint32_t *pending; ///< [node_count], last first
    size_t count;
    bool of_scene; ///< else of nodes outside all scenes
} walk;

/// Puts nodes on the stack, last first. Fails if a node of the scene is reached a second time: only a forest can be
/// walked to the end.
static rsv_status push_nodes(walk *w, const int *node, size_t count, const uint32_t *parent)
{
    rsv_gltf_parts *parts = w->parts;
    const rsv_gltf_document *document = parts->document;
    for (size_t i = count; i-- > 0;) {
        if (!refers(node[i], document->node_count))
            return rsv_fail(RSV_ERROR_FORMAT, "node %d does not exist", node[i]);
        if (parts->placed[node[i]] && !w->of_scene) continue;
        if (parts->placed[node[i]])
            return rsv_fail(RSV_ERROR_FORMAT,
                "node '%s' is reached twice: nodes must form a tree without cycles",
                document->node[node[i]].name);
        const rsv_gltf_node *n = &document->node[node[i]];
        parts->placed[node[i]] = true;
        parts->hidden[node[i]] = n->hidden || (parent && parts->hidden[*parent]);
        rsv_matrix_multiply(
            parent ? parts->world[*parent] : identity, n->local, parts->world[node[i]]);
        w->pending[w->count++] = (uint32_t)node[i];
    }
    return RSV_OK;
}

static rsv_status walk_nodes(walk *w, const int *root, size_t root_count)
{
    rsv_gltf_parts *parts = w->parts;
    rsv_status status = push_nodes(w, root, root_count, NULL);
    while (status == RSV_OK && w->count) {
        uint32_t index = w->pending[--w->count];
        const rsv_gltf_node *node = &parts->document->node[index];
        if (w->of_scene) parts->order[parts->order_count++] = index;
        status = push_nodes(w, node->child, node->child_count, &index);
    }
    return status;
}

/// Joints may belong to no scene, though the format wants them to.
static rsv_status walk_others(walk *w)
{
    rsv_status status = RSV_OK;
    const rsv_gltf_document *document = w->parts->document;
    bool *is_child = rsv_alloc(w->parts->context, document->node_count, sizeof *is_child);
    if (!is_child) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < document->node_count; k++)
        for (size_t c = 0; c < document->node[k].child_count; c++)
            if (refers(document->node[k].child[c], document->node_count))
                is_child[document->node[k].child[c]] = true;
    w->of_scene = false;
    for (size_t k = 0; k < document->node_count && status == RSV_OK; k++)
        if (!is_child[k] && !w->parts->placed[k]) status = walk_nodes(w, &(int){ (int)k }, 1);
    rsv_free(w->parts->context, is_child);
    return status;
}

static rsv_status place_nodes(rsv_gltf_parts *parts)
{
    rsv_status status;
    const rsv_gltf_document *document = parts->document;
    rsv_context *context = parts->context;
    size_t nodes = document->node_count;
    parts->world = rsv_alloc(context, nodes, sizeof *parts->world);
    parts->placed = rsv_alloc(context, nodes, sizeof *parts->placed);
    parts->hidden = rsv_alloc(context, nodes, sizeof *parts->hidden);
    parts->order = rsv_alloc(context, nodes, sizeof *parts->order);
    walk w = {
        .parts = parts, .pending = rsv_alloc(context, nodes, sizeof *w.pending), .of_scene = true
    };
    RSV_TRY(parts->world && parts->placed && parts->hidden && parts->order && w.pending
                ? RSV_OK
                : RSV_ERROR_MEMORY);
    RSV_TRY(walk_nodes(&w, document->root, document->root_count));
    if (document->skin_count) RSV_TRY(walk_others(&w));
cleanup:
    rsv_free(context, w.pending);
    return status;
}

// ---- instances ------------------------------------------------------------------------------------

/// As many elements as an accessor can have: one that promises more is refused when it is read.
static double elements_of(const rsv_gltf_document *document, int accessor)
{
    if (!refers(accessor, document->accessor_count)) return 0;
    const rsv_gltf_accessor *a = &document->accessor[accessor];
    if (!refers(a->span.buffer_view, document->buffer_view_count))
        return fmin((double)a->count, RSV_GLTF_MAX_ZERO_FILLED);
    int buffer = document->buffer_view[a->span.buffer_view].buffer;
    size_t bytes = refers(buffer, document->buffer_count) ? document->buffer[buffer].size : 0;
    return fmin((double)a->count, (double)bytes);
}

/// Bytes that a primitive takes in a scene, as its accessors promise, each time that it is shown.
static double bytes_of(const rsv_gltf_document *document, const rsv_gltf_primitive *p, bool own)
{
    double corners = elements_of(document, p->indices >= 0 ? p->indices : p->position);
    double triangles = p->mode == RSV_GLTF_TRIANGLES ? corners / 3 : corners;
    return (double)(sizeof(rsv_gltf_part) + sizeof(double[16])) + TRIANGLE_BYTES * triangles +
           (own ? VERTEX_BYTES * elements_of(document, p->position) : 0);
}

/// Number of instances of a node. Fails before an allocation that memory cannot hold.
static rsv_status count_instances(
    const rsv_gltf_document *document, const rsv_gltf_node *node, double memory, size_t *count)
{
    const int accessor[3] = { node->instancing.translation, node->instancing.rotation,
        node->instancing.scale };
    static const char *const name[3] = { "TRANSLATION", "ROTATION", "SCALE" };
    const rsv_gltf_mesh *mesh = &document->mesh[node->mesh];
    int first = -1;
    for (int k = 0; k < 3; k++) {
        if (accessor[k] < 0) continue;
        if ((size_t)accessor[k] >= document->accessor_count)
            return rsv_fail(
                RSV_ERROR_FORMAT, "node '%s': accessor %d does not exist", node->name, accessor[k]);
        size_t found = document->accessor[accessor[k]].count;
        if (first >= 0 && found != *count)
            return rsv_fail(RSV_ERROR_FORMAT,
                "node '%s': its instances have %zu elements as %s, but %zu as %s", node->name,
                *count, name[first], found, name[k]);
        if (first < 0) first = k;
        *count = found;
    }
    double each = sizeof(double[16]);
    for (size_t k = 0; k < mesh->primitive_count; k++)
        each += bytes_of(document, &mesh->primitive[k], false);
    double bytes = first < 0 ? 0 : elements_of(document, accessor[first]) * each;
    if (bytes > memory)
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "node '%s': %zu instances of mesh '%s' need at least %.3g GB of memory, more than is "
            "available; leave most of them out",
            node->name, *count, mesh->name, bytes / 1e9);
    return RSV_OK;
}

static rsv_status place_instance(const rsv_gltf_node *node, size_t index, const float *translation,
    const float *rotation, const float *scale, double m[16])
{
    double t[3] = { 0, 0, 0 }, q[4] = { 0, 0, 0, 1 }, s[3] = { 1, 1, 1 };
    for (int k = 0; k < 3; k++) {
        if (translation) t[k] = (double)translation[3 * index + k];
        if (scale) s[k] = (double)scale[3 * index + k];
    }
    for (int k = 0; k < 4 && rotation; k++)
        q[k] = (double)rotation[4 * index + k];
    if (rsv_matrix_place(t, q, s, m)) return RSV_OK;
    return rsv_fail(
        RSV_ERROR_FORMAT, "node '%s': the rotation of its instance %zu is zero", node->name, index);
}

/// EXT_mesh_gpu_instancing: appends a node's transforms. @param count out
static rsv_status read_copies(rsv_gltf_parts *parts, const rsv_gltf_node *node, size_t *count)
{
    rsv_status status;
    rsv_context *context = parts->context;
    const rsv_gltf_document *document = parts->document;
    const rsv_gltf_instancing *from = &node->instancing;
    float *translation = NULL, *rotation = NULL, *scale = NULL;
    RSV_TRY(count_instances(document, node, parts->memory, count));
    if (from->translation >= 0)
        RSV_TRY(rsv_gltf_read_instances(
            context, document, from->translation, node->name, 3, &translation));
    if (from->rotation >= 0)
        RSV_TRY(
            rsv_gltf_read_instances(context, document, from->rotation, node->name, 4, &rotation));
    if (from->scale >= 0)
        RSV_TRY(rsv_gltf_read_instances(context, document, from->scale, node->name, 3, &scale));
    RSV_TRY(rsv_grow(context, (void **)&parts->copy, &parts->copy_capacity,
        parts->copy_count + *count, sizeof *parts->copy));
    for (size_t k = 0; k < *count; k++)
        RSV_TRY(place_instance(
            node, k, translation, rotation, scale, parts->copy[parts->copy_count + k]));
    parts->copy_count += *count;
cleanup:
    rsv_free(context, translation);
    rsv_free(context, rotation);
    rsv_free(context, scale);
    return status;
}

// ---- parts ----------------------------------------------------------------------------------------

static bool is_shown(const rsv_gltf_primitive *primitive)
{
    return primitive->position >= 0 && primitive->mode >= RSV_GLTF_TRIANGLES &&
           primitive->mode <= RSV_GLTF_TRIANGLE_FAN;
}

/// Whether a skin reverses the winding; determined once for all meshes that it deforms.
static rsv_status find_mirroring(rsv_gltf_parts *parts, int skin, bool *mirrored)
{
    signed char *known = &parts->skin_mirrors[skin];
    if (!*known) {
        rsv_status status = rsv_gltf_skin_mirrors(parts, (size_t)skin, mirrored);
        if (status != RSV_OK) return status;
        *known = *mirrored ? -1 : 1;
    }
    *mirrored = *known < 0;
    return RSV_OK;
}

/// Refuses a scene that memory cannot hold, before it is tried.
static rsv_status account(rsv_gltf_parts *parts, const rsv_gltf_part *part)
{
    const rsv_gltf_node *node = &parts->document->node[part->node];
    parts->bytes +=
        bytes_of(parts->document, &parts->document->mesh[part->mesh].primitive[part->primitive],
            part->skinned || node->weight);
    if (!(parts->bytes > parts->memory)) return RSV_OK;
    return rsv_fail(RSV_ERROR_UNSUPPORTED,
        "with node '%s' %zu meshes are shown, which need at least %.3g GB of memory, more than is "
        "available; leave most of them out",
        node->name, parts->count + 1, parts->bytes / 1e9);
}

/// The primitives of a node's mesh, once. @param copy RSV_NONE = at the node itself
static rsv_status add_mesh(rsv_gltf_parts *parts, uint32_t index, uint32_t copy)
{
    rsv_status status = RSV_OK;
    const rsv_gltf_node *node = &parts->document->node[index];
    const rsv_gltf_mesh *mesh = &parts->document->mesh[node->mesh];
    for (size_t k = 0; k < mesh->primitive_count; k++) {
        rsv_gltf_part part = { .node = index,
            .mesh = (uint32_t)node->mesh,
            .primitive = (uint32_t)k,
            .copy = copy,
            .skinned = node->skin >= 0 && mesh->primitive[k].influence_count > 0 };
        double world[16];
        if (!is_shown(&mesh->primitive[k])) continue;
        rsv_gltf_part_world(parts, &part, world);
        part.mirrored = rsv_matrix_handedness(world) < 0;
        if (part.skinned) RSV_TRY(find_mirroring(parts, node->skin, &part.mirrored));
        RSV_TRY(account(parts, &part));
        RSV_TRY(rsv_grow(parts->context, (void **)&parts->part, &parts->capacity, parts->count + 1,
            sizeof part));
        parts->part[parts->count++] = part;
    }
cleanup:
    return status;
}

static rsv_status add_node(rsv_gltf_parts *parts, uint32_t index)
{
    rsv_status status;
    const rsv_gltf_document *document = parts->document;
    const rsv_gltf_node *node = &document->node[index];
    if (node->mesh == -1) return RSV_OK;
    if (!refers(node->mesh, document->mesh_count))
        return rsv_fail(
            RSV_ERROR_FORMAT, "node '%s': mesh %d does not exist", node->name, node->mesh);
    if (node->skin != -1 && !refers(node->skin, document->skin_count))
        return rsv_fail(
            RSV_ERROR_FORMAT, "node '%s': skin %d does not exist", node->name, node->skin);
    if (parts->hidden[index]) return RSV_OK;
    if (!node->instanced || node->skin >= 0) return add_mesh(parts, index, RSV_NONE);
    size_t count = 0;
    parts->first_copy[index] = (uint32_t)parts->copy_count;
    RSV_TRY(read_copies(parts, node, &count));
    for (size_t k = 0; k < count; k++)
        RSV_TRY(add_mesh(parts, index, parts->first_copy[index] + (uint32_t)k));
cleanup:
    return status;
}

rsv_status rsv_gltf_parts_create(
    rsv_context *context, const rsv_gltf_document *document, rsv_gltf_parts *parts)
{
    rsv_status status;
    *parts = (rsv_gltf_parts){
        .context = context, .document = document, .memory = rsv_machine_memory()
    };
    RSV_TRY(place_nodes(parts));
    parts->first_copy = rsv_alloc(context, document->node_count, sizeof *parts->first_copy);
    parts->skin_mirrors = rsv_alloc(context, document->skin_count, sizeof *parts->skin_mirrors);
    RSV_TRY(parts->first_copy && parts->skin_mirrors ? RSV_OK : RSV_ERROR_MEMORY);
    for (size_t k = 0; k < parts->order_count; k++)
        RSV_TRY(add_node(parts, parts->order[k]));
cleanup:
    if (status != RSV_OK) rsv_gltf_parts_destroy(parts);
    return status;
}

void rsv_gltf_parts_destroy(rsv_gltf_parts *parts)
{
    rsv_free(parts->context, parts->world);
    rsv_free(parts->context, parts->placed);
    rsv_free(parts->context, parts->hidden);
    rsv_free(parts->context, parts->order);
    rsv_free(parts->context, parts->copy);
    rsv_free(parts->context, parts->first_copy);
    rsv_free(parts->context, parts->skin_mirrors);
    rsv_free(parts->context, parts->part);
    *parts = (rsv_gltf_parts){ .context = parts->context };
}

void rsv_gltf_part_world(const rsv_gltf_parts *parts, const rsv_gltf_part *part, double world[16])
{
    if (part->copy == RSV_NONE)
        memcpy(world, parts->world[part->node], sizeof parts->world[0]);
    else
        rsv_matrix_multiply(parts->world[part->node], parts->copy[part->copy], world);
}
