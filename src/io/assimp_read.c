/// Turns the scene that Assimp read into parts (scene_parts.h).
#include "../core/vec.h"
#include "../scene/smooth_normals.h"
#include "assimp_light.h"
#include "assimp_texture.h"
#include "light_units.h"
#include "matrix.h"
#include "scene_parts.h"

#include <assimp/cimport.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/// A node still to be walked.
typedef struct pending_node {
    const struct aiNode *node;
    double world[16]; ///< its place
    bool visible;     ///< as far as it inherits that, or says so itself
} pending_node;

/// A light or camera, and the nodes of its name.
typedef struct named {
    const struct aiString *name;
    const void *object;
    uint32_t number; ///< among those of its kind
    uint32_t nodes,
        visited; ///< of the first of namesakes: nodes of that name, and those seen so far
} named;

typedef struct named_list {
    named *item; ///< [count] sorted by name, then number
    size_t count;
} named_list;

typedef struct reader {
    rsv_context *context;
    rsv_file_kind kind;
    const rsv_load_desc *desc;
    const struct aiScene *file;
    FILE *to;
    uint32_t mesh_count; ///< sent
    uint32_t *mesh_id;   ///< [file->mNumMeshes]; RSV_NONE = nothing to show
    rsv_assimp_facts facts;
    named_list lights, cameras;
    pending_node *pending;
    size_t pending_count, pending_capacity;
    const struct aiNode *hidden; ///< the first of
    size_t hidden_count;
} reader;

_Static_assert(sizeof(struct aiVector3D) == sizeof(rsv_vec3), "both are three floats");

// ---- meshes ---------------------------------------------------------------------------------------

/// Lines and points are left out. @return how many triangles
static size_t copy_triangles(const struct aiMesh *mesh, uint32_t *index)
{
    size_t count = 0;
    for (size_t t = 0; t < mesh->mNumFaces; t++)
        if (mesh->mFaces[t].mNumIndices == 3)
            memcpy(&index[3 * count++], mesh->mFaces[t].mIndices, 3 * sizeof *index);
    return count;
}

static rsv_status copy_positions(const struct aiMesh *mesh, const char *name, rsv_vec3 *position)
{
    for (size_t i = 0; i < mesh->mNumVertices; i++) {
        const struct aiVector3D *p = &mesh->mVertices[i];
        if (!isfinite(p->x) || !isfinite(p->y) || !isfinite(p->z))
            return rsv_fail(
                RSV_ERROR_FORMAT, "mesh '%s': position of vertex %zu is not finite", name, i);
        position[i] = v3(p->x, p->y, p->z);
    }
    return RSV_OK;
}

/// Adds a mesh without normals, split at its creases.
static rsv_status add_smoothed(
    reader *r, rsv_mesh_desc mesh, const rsv_vec3 *position, size_t vertex_count)
{
    rsv_status status;
    rsv_smooth_mesh smooth = { 0 };
    rsv_vec3 *split = NULL;
    float(*uv[2])[2] = { NULL, NULL };
    mesh.positions = position;
    mesh.vertex_count = vertex_count;
    RSV_TRY(rsv_smooth_normals(r->context, &mesh, r->desc->crease_angle, &smooth));
    split = rsv_alloc(r->context, smooth.vertex_count, sizeof *split);
    if (!split) RSV_TRY(RSV_ERROR_MEMORY);
    for (size_t i = 0; i < smooth.vertex_count; i++)
        split[i] = position[smooth.source[i]];
    for (int k = 0; k < 2; k++) {
        if (!mesh.uvs[k]) continue;
        if (!(uv[k] = rsv_alloc(r->context, smooth.vertex_count, sizeof *uv[k])))
            RSV_TRY(RSV_ERROR_MEMORY);
        for (size_t i = 0; i < smooth.vertex_count; i++)
            memcpy(uv[k][i], mesh.uvs[k][smooth.source[i]], sizeof uv[k][i]);
        mesh.uvs[k] = (const float(*)[2])uv[k];
    }
    mesh.positions = split;
    mesh.normals = smooth.normal;
    mesh.vertex_count = smooth.vertex_count;
    mesh.indices = smooth.index;
    rsv_send_mesh(r->to, &mesh);
cleanup:
    rsv_free(r->context, split);
    rsv_free(r->context, uv[0]);
    rsv_free(r->context, uv[1]);
    rsv_smooth_mesh_release(r->context, &smooth);
    return status;
}

/// @param id out: its number among those sent; as it was where there is nothing to show
static rsv_status add_mesh(reader *r, const struct aiMesh *source, uint32_t *id)
{
    rsv_status status;
    char name[RSV_NAME_BYTES];
    rsv_assimp_name(&source->mName, "unnamed", name);
    rsv_vec3 *position = rsv_alloc(r->context, source->mNumVertices, sizeof *position);
    uint32_t *index = rsv_alloc(r->context, source->mNumFaces, 3 * sizeof *index);
    float(*uv[2])[2] = { rsv_assimp_coordinates(r->context, source, 0),
        rsv_assimp_coordinates(r->context, source, 1) };
    if (!position || !index) RSV_TRY(RSV_ERROR_MEMORY);
    if (source->mMaterialIndex >= r->file->mNumMaterials)
        RSV_TRY(rsv_fail(RSV_ERROR_FORMAT, "mesh '%s': material %u does not exist", name,
            source->mMaterialIndex));
    RSV_TRY(copy_positions(source, name, position));
    size_t triangles = copy_triangles(source, index);
    if (triangles == 0) goto cleanup;
    rsv_mesh_desc mesh = { .size = sizeof mesh,
        .name = name,
        .positions = position,
        .normals = (const rsv_vec3 *)source->mNormals,
        .uvs = { (const float(*)[2])uv[0], (const float(*)[2])uv[1] },
        .vertex_count = source->mNumVertices,
        .indices = index,
        .triangle_count = triangles,
        .material = source->mMaterialIndex };
    if (source->mNormals)
        rsv_send_mesh(r->to, &mesh);
    else
        RSV_TRY(add_smoothed(r, mesh, position, source->mNumVertices));
    *id = r->mesh_count++;
cleanup:
    rsv_free(r->context, uv[0]);
    rsv_free(r->context, uv[1]);
    rsv_free(r->context, position);
    rsv_free(r->context, index);
    return status;
}

static rsv_status add_meshes(reader *r)
{
    rsv_status status = RSV_OK;
    for (unsigned i = 0; i < r->file->mNumMeshes; i++) {
        r->mesh_id[i] = RSV_NONE;
        RSV_TRY(add_mesh(r, r->file->mMeshes[i], &r->mesh_id[i]));
    }
cleanup:
    return status;
}

/// These formats show both sides of a polygon; a lamp shines from its front, as everywhere here, and the surface of a
/// body separates inside from outside.
static bool shows_both_sides(const rsv_material *material)
{
    return rgb_is_black(material->emission) && material->thickness == 0;
}

static rsv_status add_materials(const reader *r, const char *path)
{
    rsv_status status = RSV_OK;
    const rsv_assimp_maker maker = rsv_assimp_maker_of(r->desc->files, path, r->kind, r->file);
    rsv_assimp_textures textures = {
        .context = r->context, .file = r->file, .maker = maker, .to = r->to
    };
    for (unsigned i = 0; i < r->file->mNumMaterials; i++) {
        char name[RSV_NAME_BYTES];
        rsv_material material;
        rsv_texture_ref ref[RSV_ASSIMP_MOST_TEXTURES];
        rsv_assimp_material(r->context, &maker, r->file->mMaterials[i], name, &material);
        RSV_TRY(rsv_assimp_take_textures(&textures, r->file->mMaterials[i], ref, &material));
        material.double_sided = shows_both_sides(&material);
        // Blender's exporters leave emission unscaled, as for glTF
        if (r->facts.photometric && !r->facts.watts)
            material.emission = rgb_scale(material.emission, (float)(1 / RSV_LUMENS_PER_WATT));
        rsv_send_material(r->to, &material);
    }
cleanup:
    rsv_assimp_textures_release(&textures);
    return status;
}

// ---- lights and cameras ---------------------------------------------------------------------------

/// Lights, cameras and nodes refer to each other by name.
static int compare_named(const void *a, const void *b)
{
    const named *p = a, *q = b;
    size_t shorter = p->name->length < q->name->length ? p->name->length : q->name->length;
    int order = memcmp(p->name->data, q->name->data, shorter);
    if (!order) order = (p->name->length > q->name->length) - (p->name->length < q->name->length);
    return order ? order : (p->number > q->number) - (p->number < q->number);
}

static bool are_namesakes(const struct aiString *a, const struct aiString *b)
{
    return a->length == b->length && memcmp(a->data, b->data, a->length) == 0;
}

static void sort_named(named_list *list)
{
    qsort(list->item, list->count, sizeof *list->item, compare_named);
}

/// The first of those that bear a name, and their number; NULL = there is none.
static named *find_named(const named_list *list, const struct aiString *name, size_t *count)
{
    size_t low = 0, high = list->count;
    named wanted = { .name = name };
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (compare_named(&list->item[middle], &wanted) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    for (*count = 0; low + *count < list->count; ++*count)
        if (!are_namesakes(list->item[low + *count].name, name)) break;
    return *count ? &list->item[low] : NULL;
}

/// Takes the lights or cameras of a node. If several nodes share a name, the entries of that name are dealt out in file
/// order.
/// @param first out: index in `list` @return how many
static size_t take_own(const named_list *list, const struct aiString *name, size_t *first)
{
    size_t count;
    named *found = find_named(list, name, &count);
    if (!found || !found->nodes) return 0;
    size_t begin = count * found->visited / found->nodes;
    size_t end = count * ++found->visited / found->nodes;
    *first = (size_t)(found - list->item) + begin;
    return end - begin;
}

static void add_lights(reader *r, const struct aiString *node, const double world[16])
{
    size_t first = 0, count = take_own(&r->lights, node, &first);
    for (size_t k = 0; k < count; k++) {
        char name[RSV_NAME_BYTES];
        rsv_punctual_light light = { .name = name };
        const named *own = &r->lights.item[first + k];
        rsv_assimp_name(own->name, "unnamed", name);
        if (rsv_assimp_light(r->context, &r->facts, own->object, k, world, &light))
            rsv_send_light(r->to, &light);
    }
}

static rsv_status add_cameras(reader *r, const struct aiString *node, const double world[16])
{
    rsv_status status = RSV_OK;
    size_t first = 0, count = take_own(&r->cameras, node, &first);
    for (size_t k = 0; k < count; k++) {
        char name[RSV_NAME_BYTES];
        rsv_camera camera = { .name = name };
        const named *own = &r->cameras.item[first + k];
        rsv_assimp_name(own->name, "unnamed", name);
        RSV_TRY(rsv_assimp_camera(r->context, &r->facts, own->object, k, world, &camera));
        rsv_send_camera(r->to, &camera);
    }
cleanup:
    return status;
}

// ---- nodes ----------------------------------------------------------------------------------------

/// Assimp's matrices are rows.
static void matrix_of(const struct aiMatrix4x4 *m, double result[16])
{
    const float row[4][4] = { { m->a1, m->a2, m->a3, m->a4 }, { m->b1, m->b2, m->b3, m->b4 },
        { m->c1, m->c2, m->c3, m->c4 }, { m->d1, m->d2, m->d3, m->d4 } };
    for (int i = 0; i < 16; i++)
        result[i] = (double)row[i % 4][i / 4];
}

/// FBX's `Show` of a node. It affects neither its children nor its cameras.
static bool is_shown(const struct aiNode *node)
{
    const struct aiMetadata *metadata = node->mMetaData;
    for (unsigned i = 0; metadata && i < metadata->mNumProperties; i++)
        if (strcmp(metadata->mKeys[i].data, "Show") == 0 && metadata->mValues[i].mData &&
            metadata->mValues[i].mType == AI_BOOL)
            return *(const bool *)metadata->mValues[i].mData;
    return true;
}

/// `Visibility`, which children inherit unless they say that they do not.
static bool is_visible(const struct aiNode *node, bool parent)
{
    bool inherits = rsv_assimp_number(node->mMetaData, "Visibility Inheritance", 1) != 0;
    return (parent || !inherits) && rsv_assimp_number(node->mMetaData, "Visibility", 1) != 0;
}

static rsv_status add_node(reader *r, const pending_node *of)
{
    rsv_status status = RSV_OK;
    char name[RSV_NAME_BYTES];
    const struct aiNode *node = of->node;
    const double *world = of->world;
    rsv_assimp_name(&node->mName, "", name);
    bool hidden = !of->visible || !is_shown(node);
    if (hidden && r->hidden_count++ == 0) r->hidden = node;
    for (unsigned i = 0; i < node->mNumMeshes && !hidden; i++) {
        if (node->mMeshes[i] >= r->file->mNumMeshes)
            return rsv_fail(
                RSV_ERROR_FORMAT, "node '%s': mesh %u does not exist", name, node->mMeshes[i]);
        uint32_t id = r->mesh_id[node->mMeshes[i]];
        if (id != RSV_NONE) rsv_send_instance(r->to, id, world, *name ? name : NULL);
    }
    if (!hidden) add_lights(r, &node->mName, world);
    RSV_TRY(add_cameras(r, &node->mName, world));
cleanup:
    return status;
}

/// @param visible whether the parent is
static rsv_status push_node(
    reader *r, const struct aiNode *node, const double world[16], bool visible)
{
    rsv_status status;
    RSV_TRY(rsv_grow(r->context, (void **)&r->pending, &r->pending_capacity, r->pending_count + 1,
        sizeof *r->pending));
    pending_node *pushed = &r->pending[r->pending_count++];
    pushed->node = node;
    pushed->visible = is_visible(node, visible);
    memcpy(pushed->world, world, sizeof pushed->world);
cleanup:
    return status;
}

/// The transform of the root node.
/// @param origin what was subtracted from the file's coordinates
static void place_root(
    const reader *r, const double file_to_scene[16], const double origin[3], double world[16])
{
    double local[16];
    matrix_of(&r->file->mRootNode->mTransformation, local);
    if (r->kind == RSV_FILE_FBX)
        memcpy(world, file_to_scene, 16 * sizeof *world);
    else
        rsv_matrix_multiply(file_to_scene, local, world);
    for (int row = 0; row < 3; row++)
        for (int axis = 0; axis < 3; axis++)
            world[12 + row] += world[4 * axis + row] * origin[axis];
}

static void count_node(reader *r, const struct aiString *name)
{
    named_list *const lists[] = { &r->lights, &r->cameras };
    for (int k = 0; k < 2; k++) {
        size_t count;
        named *found = find_named(lists[k], name, &count);
        if (found) found->nodes++;
    }
}

/// Visits every node after its parent. @param root its place @param counting nodes of lights and cameras, nothing else
static rsv_status walk_nodes(reader *r, const double root[16], bool counting)
{
    rsv_status status;
    RSV_TRY(push_node(r, r->file->mRootNode, root, true));
    while (r->pending_count) {
        pending_node next = r->pending[--r->pending_count];
        if (counting)
            count_node(r, &next.node->mName);
        else
            RSV_TRY(add_node(r, &next));
        for (unsigned i = next.node->mNumChildren; i-- > 0;) {
            double local[16], world[16];
            matrix_of(&next.node->mChildren[i]->mTransformation, local);
            rsv_matrix_multiply(next.world, local, world);
            RSV_TRY(push_node(r, next.node->mChildren[i], world, next.visible));
        }
    }
cleanup:
    return status;
}

// ---- units and axes -------------------------------------------------------------------------------

/// FBX names the axes that point right, up and forward, and its unit in centimetres. Versions of the
/// importer differ in whether they put these into the root node, which has no transform otherwise.
static rsv_status fbx_frame(const reader *r, double matrix[16])
{
    static const char *const key[3][2] = { { "CoordAxis", "CoordAxisSign" },
        { "UpAxis", "UpAxisSign" }, { "FrontAxis", "FrontAxisSign" } };
    const struct aiMetadata *settings = r->file->mMetaData;
    double scale = 0.01 * rsv_assimp_number(settings, "UnitScaleFactor", 1);
    unsigned used = 0;
    memset(matrix, 0, 16 * sizeof *matrix);
    for (int i = 0; i < 3; i++) {
        int axis = (int)rsv_assimp_number(settings, key[i][0], i);
        double sign = rsv_assimp_number(settings, key[i][1], 1) < 0 ? -1 : 1;
        if (axis < 0 || axis > 2)
            return rsv_fail(RSV_ERROR_FORMAT, "%s %d is not an axis", key[i][0], axis);
        matrix[4 * axis + i] = sign * scale;
        used |= 1u << axis;
    }
    matrix[15] = 1;
    if (used != 7 || !(scale > 0) || !isfinite(scale))
        return rsv_fail(RSV_ERROR_FORMAT, "its axes or its unit of %g m are not usable", scale);
    return RSV_OK;
}

static rsv_status find_frame(const reader *r, double matrix[16])
{
    if (r->kind == RSV_FILE_FBX) return fbx_frame(r, matrix);
    bool says_its_own = r->kind == RSV_FILE_COLLADA;
    rsv_matrix_upright(says_its_own ? RSV_AXIS_Y : r->desc->up,
        says_its_own ? 1 : (double)r->desc->metres_per_unit, matrix);
    return RSV_OK;
}

// ---- the whole file -------------------------------------------------------------------------------

static rsv_status allocate(reader *r)
{
    const struct aiScene *file = r->file;
    r->mesh_id = rsv_alloc(r->context, file->mNumMeshes, sizeof *r->mesh_id);
    r->lights.item = rsv_alloc(r->context, file->mNumLights, sizeof *r->lights.item);
    r->cameras.item = rsv_alloc(r->context, file->mNumCameras, sizeof *r->cameras.item);
    if (!r->mesh_id || !r->lights.item || !r->cameras.item) return RSV_ERROR_MEMORY;
    for (; r->lights.count < file->mNumLights; r->lights.count++) {
        const struct aiLight *light = file->mLights[r->lights.count];
        r->lights.item[r->lights.count] =
            (named){ .name = &light->mName, .object = light, .number = (uint32_t)r->lights.count };
    }
    for (; r->cameras.count < file->mNumCameras; r->cameras.count++) {
        const struct aiCamera *camera = file->mCameras[r->cameras.count];
        r->cameras.item[r->cameras.count] = (named){
            .name = &camera->mName, .object = camera, .number = (uint32_t)r->cameras.count
        };
    }
    sort_named(&r->lights);
    sort_named(&r->cameras);
    return RSV_OK;
}

/// Metres per unit at the root: the cube root of the determinant, so negative for a transform that mirrors.
static double metres_per_unit(const double m[16])
{
    double volume = m[0] * (m[5] * m[10] - m[6] * m[9]) - m[4] * (m[1] * m[10] - m[2] * m[9]) +
                    m[8] * (m[1] * m[6] - m[2] * m[5]);
    return cbrt(volume);
}

rsv_status rsv_assimp_convert(
    rsv_context *context, const char *path, rsv_file_kind kind, const rsv_load_desc *desc, FILE *to)
{
    rsv_status status;
    double frame[16], root[16], origin[3];
    reader r = { .context = context, .kind = kind, .desc = desc, .to = to };
    RSV_TRY(rsv_assimp_import(context, desc->files, path, kind, &r.file, origin));
    RSV_TRY(find_frame(&r, frame));
    place_root(&r, frame, origin, root);
    double unit = metres_per_unit(root);
    if (kind == RSV_FILE_COLLADA && !(unit > 0 && unit < INFINITY))
        RSV_TRY(rsv_fail(RSV_ERROR_FORMAT, "its <unit> of %g m is not usable", unit));
    const rsv_assimp_reading reading = { desc->files, path, kind, desc->light_units, fabs(unit) };
    RSV_TRY(rsv_assimp_learn(context, &reading, r.file, &r.facts));
    RSV_TRY(allocate(&r));
    RSV_TRY(add_materials(&r, path));
    RSV_TRY(add_meshes(&r));
    if (r.lights.count + r.cameras.count) RSV_TRY(walk_nodes(&r, root, true));
    RSV_TRY(walk_nodes(&r, root, false));
    if (r.hidden_count)
        rsv_log(context, RSV_LOG_INFO, "%zu node%s (first: '%s') hidden by Show or Visibility",
            r.hidden_count, r.hidden_count > 1 ? "s are" : " is", r.hidden->mName.data);
cleanup:
    rsv_free(context, r.mesh_id);
    rsv_free(context, r.lights.item);
    rsv_free(context, r.cameras.item);
    rsv_free(context, r.pending);
    rsv_assimp_forget(context, &r.facts);
    if (r.file) aiReleaseImport(r.file);
    return status;
}
