/// From a glTF document to a scene.
#include "../core/core.h"
#include "../core/vec.h"
#include "../scene/document.h"
#include "gltf_accessor.h"
#include "gltf_archive.h"
#include "gltf_texture.h"
#include "matrix.h"
#include "scene_read.h"

#include <stdio.h>
#include <string.h>

#define LABEL_BYTES 256

typedef struct reader {
    rsv_context *context;
    const rsv_gltf_document *document;
    rsv_scene *scene;
    /// [mesh_count + 1] where the scene ids of a mesh's primitives begin in primitive_id
    size_t *first_primitive;
    uint32_t *primitive_id; ///< scene mesh of each primitive; RSV_NONE = nothing to show
    bool *mesh_read;        ///< [mesh_count]
    double (*world)[16];    ///< [node_count], column-major
    bool *visited;          ///< [node_count]
    uint32_t *pending;      ///< [node_count] nodes still to be walked, last first
    uint32_t material_count, default_material;
    size_t morphed_count, skinned_count; ///< primitives and nodes shown at rest
} reader;

static bool refers(int reference, size_t count)
{
    return reference >= 0 && (size_t)reference < count;
}

// ---- materials ------------------------------------------------------------------------------------

static rsv_status add_materials(reader *r)
{
    rsv_status status = rsv_gltf_add_materials(r->context, r->document, r->scene);
    r->material_count = (uint32_t)r->document->material_count;
    r->default_material = RSV_NONE;
    return status;
}

/// The scene's id of a primitive's material; the specification's default where it names none.
static rsv_status find_material(reader *r, int reference, const char *owner, uint32_t *id)
{
    rsv_status status = RSV_OK;
    if (reference >= 0) {
        if ((size_t)reference >= r->material_count)
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

/// Geometry of one primitive while it is read.
typedef struct geometry {
    rsv_vec3 *position, *normal;
    float *uv[2], *tangent, *color;
    uint32_t *index;
    size_t vertex_count, index_count;
} geometry;

static void release_geometry(rsv_context *context, geometry *g)
{
    rsv_free(context, g->position);
    rsv_free(context, g->normal);
    rsv_free(context, g->uv[0]);
    rsv_free(context, g->uv[1]);
    rsv_free(context, g->tangent);
    rsv_free(context, g->color);
    rsv_free(context, g->index);
}

static rsv_status check_count(
    const geometry *g, const char *owner, int accessor, const char *what, size_t count)
{
    if (count == g->vertex_count) return RSV_OK;
    return rsv_fail(RSV_ERROR_FORMAT, "mesh '%s': accessor %d holds %zu %s for %zu positions",
        owner, accessor, count, what, g->vertex_count);
}

/// An attribute of `width` floats per vertex; absent ones stay NULL.
static rsv_status read_attribute(reader *r, int accessor, const char *owner, const char *what,
    size_t width, const geometry *g, float **values)
{
    rsv_status status;
    size_t count, found;
    if (accessor < 0) return RSV_OK;
    RSV_TRY(
        rsv_gltf_read_attribute(r->context, r->document, accessor, owner, values, &count, &found));
    if (found != width)
        return rsv_fail(RSV_ERROR_FORMAT, "mesh '%s': accessor %d must hold VEC%zu as %s", owner,
            accessor, width, what);
    status = check_count(g, owner, accessor, what, count);
cleanup:
    return status;
}

/// Colours of vertices have three components or four.
static rsv_status read_colors(reader *r, int accessor, const char *owner, bool opaque, geometry *g)
{
    rsv_status status;
    size_t count, width;
    float *values = NULL;
    if (accessor < 0) return RSV_OK;
    RSV_TRY(
        rsv_gltf_read_attribute(r->context, r->document, accessor, owner, &values, &count, &width));
    if (width < 3) {
        status = rsv_fail(RSV_ERROR_FORMAT, "mesh '%s': accessor %d must hold VEC3 or VEC4 colours",
            owner, accessor);
        goto cleanup;
    }
    RSV_TRY(check_count(g, owner, accessor, "colours", count));
    g->color = rsv_alloc(r->context, count, 4 * sizeof *g->color);
    if (!g->color) status = RSV_ERROR_MEMORY;
    for (size_t i = 0; g->color && i < 4 * count; i++) {
        size_t k = i % 4;
        g->color[i] = k < 3 || (width == 4 && !opaque) ? values[i / 4 * width + k] : 1;
    }
cleanup:
    rsv_free(r->context, values);
    return status;
}

static rsv_status read_geometry(
    reader *r, const rsv_gltf_primitive *primitive, const char *owner, geometry *g)
{
    rsv_status status;
    bool opaque = primitive->material < 0 || r->document->material[primitive->material].opaque;
    RSV_TRY(rsv_gltf_read_vectors(
        r->context, r->document, primitive->position, owner, &g->position, &g->vertex_count));
    RSV_TRY(read_attribute(r, primitive->normal, owner, "normals", 3, g, (float **)&g->normal));
    for (int set = 0; set < 2; set++)
        RSV_TRY(
            read_attribute(r, primitive->uv[set], owner, "texture coordinates", 2, g, &g->uv[set]));
    RSV_TRY(read_attribute(r, primitive->tangent, owner, "tangents", 4, g, &g->tangent));
    RSV_TRY(read_colors(r, primitive->color, owner, opaque, g));
    g->index_count = g->vertex_count;
    if (primitive->indices >= 0)
        RSV_TRY(rsv_gltf_read_indices(r->context, r->document, primitive->indices, owner,
            g->vertex_count, &g->index, &g->index_count));
cleanup:
    return status;
}

/// Turns a strip or fan into separate triangles; both keep the winding of the specification.
static rsv_status unroll(reader *r, int mode, geometry *g, size_t triangle_count)
{
    uint32_t *list = rsv_alloc(r->context, triangle_count, 3 * sizeof *list);
    if (!list) return RSV_ERROR_MEMORY;
    for (size_t t = 0; t < triangle_count; t++) {
        size_t strip[3] = { t, t + 1 + t % 2, t + 2 - t % 2 }, fan[3] = { t + 1, t + 2, 0 };
        const size_t *corner = mode == RSV_GLTF_TRIANGLE_STRIP ? strip : fan;
        for (int k = 0; k < 3; k++)
            list[3 * t + k] = g->index ? g->index[corner[k]] : (uint32_t)corner[k];
    }
    rsv_free(r->context, g->index);
    g->index = list;
    return RSV_OK;
}

static rsv_status add_primitive(
    reader *r, const rsv_gltf_primitive *primitive, const char *owner, uint32_t *id)
{
    rsv_status status;
    geometry g = { 0 };
    rsv_mesh_desc mesh = { .name = owner };
    RSV_TRY(find_material(r, primitive->material, owner, &mesh.material));
    RSV_TRY(read_geometry(r, primitive, owner, &g));
    if (g.vertex_count >= RSV_NONE) {
        status = rsv_fail(RSV_ERROR_UNSUPPORTED, "mesh '%s': too many vertices", owner);
        goto cleanup;
    }
    if (primitive->mode == RSV_GLTF_TRIANGLES) {
        mesh.triangle_count = g.index_count / 3;
        if (g.index_count % 3)
            rsv_log(r->context, RSV_LOG_WARNING,
                "mesh '%s': the last %zu indices make no whole triangle and are ignored", owner,
                g.index_count % 3);
    } else {
        mesh.triangle_count = g.index_count < 3 ? 0 : g.index_count - 2;
        RSV_TRY(unroll(r, primitive->mode, &g, mesh.triangle_count));
    }
    mesh.positions = g.position;
    mesh.normals = g.normal;
    mesh.uvs[0] = (const float(*)[2])g.uv[0];
    mesh.uvs[1] = (const float(*)[2])g.uv[1];
    mesh.tangents = (const float(*)[4])g.tangent;
    mesh.colors = (const float(*)[4])g.color;
    mesh.vertex_count = g.vertex_count;
    mesh.indices = g.index;
    RSV_TRY(rsv_scene_add_mesh(r->scene, &mesh, id));
cleanup:
    release_geometry(r->context, &g);
    return status;
}

/// Reads a mesh when a node first uses it.
static rsv_status read_mesh(reader *r, size_t index)
{
    rsv_status status = RSV_OK;
    const rsv_gltf_mesh *mesh = &r->document->mesh[index];
    if (r->mesh_read[index]) return RSV_OK;
    r->mesh_read[index] = true;
    for (size_t i = 0; i < mesh->primitive_count; i++) {
        const rsv_gltf_primitive *primitive = &mesh->primitive[i];
        uint32_t *id = &r->primitive_id[r->first_primitive[index] + i];
        char label[LABEL_BYTES];
        snprintf(label, sizeof label,
            mesh->primitive_count > 1 ? "%.200s, primitive %zu" : "%.200s", mesh->name, i);
        *id = RSV_NONE;
        r->morphed_count += primitive->has_morph_targets;
        if (primitive->position < 0)
            rsv_log(r->context, RSV_LOG_WARNING, "mesh '%s': it has no positions and is skipped",
                label);
        else if (primitive->mode < RSV_GLTF_TRIANGLES || primitive->mode > RSV_GLTF_TRIANGLE_FAN)
            rsv_log(r->context, RSV_LOG_INFO, "mesh '%s': points and lines are skipped", label);
        else
            RSV_TRY(add_primitive(r, primitive, label, id));
    }
cleanup:
    return status;
}

// ---- nodes ----------------------------------------------------------------------------------------

static rsv_vec3 column_of(const double m[16], int column)
{
    const double *c = &m[4 * column];
    return v3((float)c[0], (float)c[1], (float)c[2]);
}

static rsv_status add_node_mesh(reader *r, const rsv_gltf_node *node, const double world[16])
{
    rsv_status status;
    float transform[16];
    if (!refers(node->mesh, r->document->mesh_count))
        return rsv_fail(
            RSV_ERROR_FORMAT, "node '%s': mesh %d does not exist", node->name, node->mesh);
    r->skinned_count += node->skin >= 0;
    RSV_TRY(read_mesh(r, (size_t)node->mesh));
    for (int i = 0; i < 16; i++)
        transform[i] = (float)world[i];
    for (size_t i = r->first_primitive[node->mesh]; i < r->first_primitive[node->mesh + 1]; i++)
        if (r->primitive_id[i] != RSV_NONE)
            RSV_TRY(rsv_scene_add_instance(r->scene, r->primitive_id[i], transform, node->name));
cleanup:
    return status;
}

static rsv_status add_node_camera(reader *r, const rsv_gltf_node *node, const double world[16])
{
    if (!refers(node->camera, r->document->camera_count))
        return rsv_fail(
            RSV_ERROR_FORMAT, "node '%s': camera %d does not exist", node->name, node->camera);
    rsv_camera camera = r->document->camera[node->camera];
    if (!*camera.name) camera.name = node->name;
    camera.position = column_of(world, 3);
    camera.forward = v3_neg(v3_normalize(column_of(world, 2)));
    camera.right = v3_normalize(v3_cross(camera.forward, column_of(world, 1)));
    camera.up = v3_cross(camera.right, camera.forward);
    if (v3_length(camera.right) == 0)
        return rsv_fail(RSV_ERROR_FORMAT, "node '%s': its transform leaves the camera no direction",
            node->name);
    return rsv_scene_add_camera(r->scene, &camera);
}

static rsv_status add_node_light(reader *r, const rsv_gltf_node *node, const double world[16])
{
    if (!refers(node->light, r->document->light_count))
        return rsv_fail(
            RSV_ERROR_FORMAT, "node '%s': light %d does not exist", node->name, node->light);
    rsv_light light = r->document->light[node->light];
    if (!*light.name) light.name = node->name;
    light.position = column_of(world, 3);
    light.direction = v3_neg(v3_normalize(column_of(world, 2)));
    return rsv_scene_add_light(r->scene, &light);
}

static rsv_status add_node(reader *r, const rsv_gltf_node *node, const double world[16])
{
    rsv_status status = RSV_OK;
    if (node->mesh != -1) RSV_TRY(add_node_mesh(r, node, world));
    if (node->camera != -1) RSV_TRY(add_node_camera(r, node, world));
    if (node->light != -1) RSV_TRY(add_node_light(r, node, world));
cleanup:
    return status;
}

/// Puts nodes on the stack, last first. Each node may be reached once only: that is what makes the
/// hierarchy a forest, and the walk end.
static rsv_status push_nodes(
    reader *r, const int *node, size_t count, const double *parent, size_t *pending_count)
{
    static const double identity[16] = { [0] = 1, [5] = 1, [10] = 1, [15] = 1 };
    for (size_t i = count; i-- > 0;) {
        if (!refers(node[i], r->document->node_count))
            return rsv_fail(RSV_ERROR_FORMAT, "node %d does not exist", node[i]);
        if (r->visited[node[i]])
            return rsv_fail(RSV_ERROR_FORMAT,
                "node '%s' is reached twice: nodes must form a tree without cycles",
                r->document->node[node[i]].name);
        r->visited[node[i]] = true;
        rsv_matrix_multiply(
            parent ? parent : identity, r->document->node[node[i]].local, r->world[node[i]]);
        r->pending[(*pending_count)++] = (uint32_t)node[i];
    }
    return RSV_OK;
}

static rsv_status walk_nodes(reader *r)
{
    rsv_status status;
    size_t pending_count = 0;
    RSV_TRY(push_nodes(r, r->document->root, r->document->root_count, NULL, &pending_count));
    while (pending_count) {
        uint32_t index = r->pending[--pending_count];
        const rsv_gltf_node *node = &r->document->node[index];
        RSV_TRY(add_node(r, node, r->world[index]));
        RSV_TRY(push_nodes(r, node->child, node->child_count, r->world[index], &pending_count));
    }
    if (r->morphed_count || r->skinned_count)
        rsv_log(r->context, RSV_LOG_INFO,
            "%zu primitives with morph targets and %zu nodes with skins are shown at rest",
            r->morphed_count, r->skinned_count);
cleanup:
    return status;
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
    r->primitive_id =
        rsv_alloc(context, r->first_primitive[document->mesh_count], sizeof *r->primitive_id);
    r->mesh_read = rsv_alloc(context, document->mesh_count, sizeof *r->mesh_read);
    r->world = rsv_alloc(context, document->node_count, sizeof *r->world);
    r->visited = rsv_alloc(context, document->node_count, sizeof *r->visited);
    r->pending = rsv_alloc(context, document->node_count, sizeof *r->pending);
    bool complete = r->primitive_id && r->mesh_read && r->world && r->visited && r->pending;
    return complete ? RSV_OK : RSV_ERROR_MEMORY;
}

/// Gives the scene the file, where it is not too large.
static rsv_status keep(const reader *r, const char *path)
{
    uint8_t *bytes;
    size_t count;
    rsv_status status = rsv_gltf_archive_pack(r->context, r->document, &bytes, &count);
    if (status != RSV_ERROR_UNSUPPORTED)
        return status == RSV_OK ? rsv_scene_set_document(r->scene, path, bytes, count) : status;
    rsv_log(r->context, RSV_LOG_WARNING,
        "with what lies beside it, it exceeds 4 GiB and is not kept: bakes will write a file of "
        "their own");
    return RSV_OK;
}

rsv_status rsv_gltf_read(const char *path, bool keep_document, rsv_scene *scene)
{
    rsv_status status;
    rsv_context *context = rsv_scene_get_context(scene);
    reader r = { .context = context, .scene = scene };
    RSV_TRY(rsv_gltf_open(path, &r.document));
    if (*r.document->warning)
        rsv_log(context, RSV_LOG_WARNING, "%s: %s", path, r.document->warning);
    RSV_TRY(allocate(&r));
    RSV_TRY(add_materials(&r));
    RSV_TRY(walk_nodes(&r));
    if (keep_document) RSV_TRY(keep(&r, path));
cleanup:
    rsv_free(context, r.first_primitive);
    rsv_free(context, r.primitive_id);
    rsv_free(context, r.mesh_read);
    rsv_free(context, r.world);
    rsv_free(context, r.visited);
    rsv_free(context, r.pending);
    rsv_gltf_close(r.document);
    return status;
}
