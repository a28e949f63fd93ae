/// From what Assimp read to parts of a scene.
#include "../core/vec.h"
#include "../scene/smooth_normals.h"
#include "assimp_file.h"
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
    double world[16]; ///< of its parent
} pending_node;

typedef struct reader {
    rsv_context *context;
    rsv_file_kind kind;
    const rsv_load_desc *desc;
    const struct aiScene *file;
    FILE *to;
    uint32_t mesh_count;      ///< sent
    uint32_t *mesh_id;        ///< [file->mNumMeshes]; RSV_NONE = nothing to show
    const void **light_node;  ///< [file->mNumLights] names, sorted
    const void **camera_node; ///< [file->mNumCameras] names, sorted
    pending_node *pending;
    size_t pending_count, pending_capacity;
} reader;

_Static_assert(sizeof(struct aiVector3D) == sizeof(rsv_vec3), "both are three floats");

// ---- meshes ---------------------------------------------------------------------------------------

static rsv_status copy_triangles(const struct aiMesh *mesh, const char *name, uint32_t *index)
{
    for (size_t t = 0; t < mesh->mNumFaces; t++) {
        const struct aiFace *face = &mesh->mFaces[t];
        if (face->mNumIndices != 3 || !face->mIndices)
            return rsv_fail(RSV_ERROR_FORMAT, "mesh '%s': face %zu is not a triangle", name, t);
        memcpy(&index[3 * t], face->mIndices, 3 * sizeof *index);
        for (int k = 0; k < 3; k++)
            if (index[3 * t + k] >= mesh->mNumVertices)
                return rsv_fail(RSV_ERROR_FORMAT,
                    "mesh '%s': face %zu refers to vertex %u, but there are only %u", name, t,
                    index[3 * t + k], mesh->mNumVertices);
    }
    return RSV_OK;
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
    RSV_TRY(rsv_smooth_normals(r->context, position, vertex_count, mesh.indices,
        mesh.triangle_count, r->desc->crease_angle, &smooth));
    split = rsv_alloc(r->context, smooth.vertex_count, sizeof *split);
    if (!split) RSV_TRY(RSV_ERROR_MEMORY);
    for (size_t i = 0; i < smooth.vertex_count; i++)
        split[i] = position[smooth.source[i]];
    mesh.positions = split;
    mesh.normals = smooth.normal;
    mesh.vertex_count = smooth.vertex_count;
    mesh.indices = smooth.index;
    rsv_send_mesh(r->to, &mesh);
cleanup:
    rsv_free(r->context, split);
    rsv_smooth_mesh_release(r->context, &smooth);
    return status;
}

/// @param id out: its number among those sent
static rsv_status add_mesh(reader *r, const struct aiMesh *source, uint32_t *id)
{
    rsv_status status;
    char name[RSV_NAME_BYTES];
    rsv_assimp_name(&source->mName, "unnamed", name);
    rsv_vec3 *position = rsv_alloc(r->context, source->mNumVertices, sizeof *position);
    uint32_t *index = rsv_alloc(r->context, source->mNumFaces, 3 * sizeof *index);
    if (!position || !index) RSV_TRY(RSV_ERROR_MEMORY);
    if (source->mMaterialIndex >= r->file->mNumMaterials)
        RSV_TRY(rsv_fail(RSV_ERROR_FORMAT, "mesh '%s': material %u does not exist", name,
            source->mMaterialIndex));
    RSV_TRY(copy_positions(source, name, position));
    RSV_TRY(copy_triangles(source, name, index));
    rsv_mesh_desc mesh = { .name = name,
        .positions = position,
        .normals = (const rsv_vec3 *)source->mNormals,
        .vertex_count = source->mNumVertices,
        .indices = index,
        .triangle_count = source->mNumFaces,
        .material = source->mMaterialIndex };
    if (source->mNormals)
        rsv_send_mesh(r->to, &mesh);
    else
        RSV_TRY(add_smoothed(r, mesh, position, source->mNumVertices));
    *id = r->mesh_count++;
cleanup:
    rsv_free(r->context, position);
    rsv_free(r->context, index);
    return status;
}

static rsv_status add_meshes(reader *r)
{
    rsv_status status = RSV_OK;
    for (unsigned i = 0; i < r->file->mNumMeshes; i++) {
        const struct aiMesh *mesh = r->file->mMeshes[i];
        r->mesh_id[i] = RSV_NONE;
        if (mesh->mPrimitiveTypes & aiPrimitiveType_TRIANGLE && mesh->mVertices && mesh->mFaces)
            RSV_TRY(add_mesh(r, mesh, &r->mesh_id[i]));
    }
cleanup:
    return status;
}

static void add_materials(const reader *r)
{
    for (unsigned i = 0; i < r->file->mNumMaterials; i++) {
        char name[RSV_NAME_BYTES];
        rsv_material material;
        rsv_assimp_material(r->context, r->kind, r->file->mMaterials[i], name, &material);
        rsv_send_material(r->to, &material);
    }
}

// ---- lights and cameras ---------------------------------------------------------------------------

static rsv_vec3 transform(const double m[16], struct aiVector3D v, double w)
{
    double r[3];
    for (int i = 0; i < 3; i++)
        r[i] = m[i] * v.x + m[4 + i] * v.y + m[8 + i] * v.z + m[12 + i] * w;
    return v3((float)r[0], (float)r[1], (float)r[2]);
}

static void add_light(reader *r, const struct aiLight *source, const double world[16])
{
    char name[RSV_NAME_BYTES];
    rsv_assimp_name(&source->mName, "unnamed", name);
    float falloff = source->mAttenuationQuadratic;
    rsv_light light = { .name = name,
        .position = transform(world, source->mPosition, 1),
        .direction = transform(world, source->mDirection, 0),
        .intensity = {
            source->mColorDiffuse.r, source->mColorDiffuse.g, source->mColorDiffuse.b } };
    switch (source->mType) {
    case aiLightSource_DIRECTIONAL:
        light.kind = RSV_LIGHT_DIRECTIONAL;
        rsv_send_light(r->to, &light);
        return;
    case aiLightSource_POINT:
        light.kind = RSV_LIGHT_POINT;
        break;
    case aiLightSource_SPOT:
        light.kind = RSV_LIGHT_SPOT;
        light.outer_cone_angle = f_min(f_max(source->mAngleOuterCone / 2, 0), RSV_PI / 2);
        light.inner_cone_angle =
            f_min(f_max(source->mAngleInnerCone / 2, 0), light.outer_cone_angle);
        break;
    default:
        rsv_log(r->context, RSV_LOG_WARNING,
            "light '%s': ambient and area lights are left out; use an emissive material", name);
        return;
    }
    if (falloff > 0 && isfinite(falloff)) light.intensity = rgb_scale(light.intensity, 1 / falloff);
    if (source->mAttenuationLinear > 0 || !(falloff > 0))
        rsv_log(r->context, RSV_LOG_WARNING,
            "light '%s': falls off with the square of the distance here, whatever the file says",
            name);
    rsv_send_light(r->to, &light);
}

static rsv_status add_camera(reader *r, const struct aiCamera *source, const double world[16])
{
    char name[RSV_NAME_BYTES];
    rsv_assimp_name(&source->mName, "unnamed", name);
    float aspect = source->mAspect > 0 && isfinite(source->mAspect) ? source->mAspect : 1;
    rsv_camera camera = { .name = name,
        .position = transform(world, source->mPosition, 1),
        .forward = v3_normalize(transform(world, source->mLookAt, 0)),
        .aspect = aspect };
    rsv_vec3 up = transform(world, source->mUp, 0);
    camera.right = v3_normalize(v3_cross(camera.forward, up));
    camera.up = v3_cross(camera.right, camera.forward);
    if (!(v3_length(camera.right) > 0))
        return rsv_fail(RSV_ERROR_FORMAT, "camera '%s': it has no direction", name);
    // the header calls it half an angle, every importer stores the whole
    camera.vertical_fov = 2 * atanf(tanf(source->mHorizontalFOV / 2) / aspect);
    if (!(source->mHorizontalFOV > 0)) {
        camera.vertical_fov = 0;
        camera.vertical_extent = source->mOrthographicWidth / aspect;
    }
    rsv_send_camera(r->to, &camera);
    return RSV_OK;
}

/// Lights, cameras and nodes refer to each other by name.
static int compare_names(const void *a, const void *b)
{
    const struct aiString *p = *(const struct aiString *const *)a;
    const struct aiString *q = *(const struct aiString *const *)b;
    size_t shorter = p->length < q->length ? p->length : q->length;
    int order = memcmp(p->data, q->data, shorter);
    return order ? order : (p->length > q->length) - (p->length < q->length);
}

/// What a light or camera starts with is its name: a pointer to one is a pointer to the other.
_Static_assert(offsetof(struct aiLight, mName) == 0, "a light begins with its name");
_Static_assert(offsetof(struct aiCamera, mName) == 0, "a camera begins with its name");

static const void *find_named(const void **sorted, size_t count, const struct aiString *name)
{
    const void **found = bsearch(&name, sorted, count, sizeof *sorted, compare_names);
    return found ? *found : NULL;
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

static rsv_status add_node(reader *r, const struct aiNode *node, const double world[16])
{
    rsv_status status = RSV_OK;
    char name[RSV_NAME_BYTES];
    float placed[16];
    rsv_assimp_name(&node->mName, "", name);
    for (int i = 0; i < 16; i++)
        placed[i] = (float)world[i];
    for (unsigned i = 0; i < node->mNumMeshes; i++) {
        if (node->mMeshes[i] >= r->file->mNumMeshes)
            return rsv_fail(
                RSV_ERROR_FORMAT, "node '%s': mesh %u does not exist", name, node->mMeshes[i]);
        uint32_t id = r->mesh_id[node->mMeshes[i]];
        if (id != RSV_NONE) rsv_send_instance(r->to, id, placed, *name ? name : NULL);
    }
    const struct aiLight *light = find_named(r->light_node, r->file->mNumLights, &node->mName);
    if (light) add_light(r, light, world);
    const struct aiCamera *camera = find_named(r->camera_node, r->file->mNumCameras, &node->mName);
    if (camera) RSV_TRY(add_camera(r, camera, world));
cleanup:
    return status;
}

static rsv_status push_node(reader *r, const struct aiNode *node, const double parent[16])
{
    rsv_status status;
    RSV_TRY(rsv_grow(r->context, (void **)&r->pending, &r->pending_capacity, r->pending_count + 1,
        sizeof *r->pending));
    pending_node *pushed = &r->pending[r->pending_count++];
    pushed->node = node;
    memcpy(pushed->world, parent, sizeof pushed->world);
cleanup:
    return status;
}

static rsv_status walk_nodes(reader *r, const double file_to_scene[16])
{
    rsv_status status;
    RSV_TRY(push_node(r, r->file->mRootNode, file_to_scene));
    while (r->pending_count) {
        pending_node parent = r->pending[--r->pending_count];
        double local[16], world[16];
        matrix_of(&parent.node->mTransformation, local);
        if (parent.node == r->file->mRootNode && r->kind == RSV_FILE_FBX)
            memcpy(world, parent.world, sizeof world);
        else
            rsv_matrix_multiply(parent.world, local, world);
        RSV_TRY(add_node(r, parent.node, world));
        for (unsigned i = parent.node->mNumChildren; i-- > 0;)
            RSV_TRY(push_node(r, parent.node->mChildren[i], world));
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
    r->light_node = rsv_alloc(r->context, file->mNumLights, sizeof *r->light_node);
    r->camera_node = rsv_alloc(r->context, file->mNumCameras, sizeof *r->camera_node);
    if (!r->mesh_id || !r->light_node || !r->camera_node) return RSV_ERROR_MEMORY;
    for (unsigned i = 0; i < file->mNumLights; i++)
        r->light_node[i] = file->mLights[i];
    for (unsigned i = 0; i < file->mNumCameras; i++)
        r->camera_node[i] = file->mCameras[i];
    qsort(r->light_node, file->mNumLights, sizeof *r->light_node, compare_names);
    qsort(r->camera_node, file->mNumCameras, sizeof *r->camera_node, compare_names);
    return RSV_OK;
}

rsv_status rsv_assimp_convert(
    rsv_context *context, const char *path, rsv_file_kind kind, const rsv_load_desc *desc, FILE *to)
{
    rsv_status status;
    double frame[16];
    reader r = { .context = context, .kind = kind, .desc = desc, .to = to };
    RSV_TRY(rsv_assimp_import(context, path, &r.file));
    if (!r.file->mRootNode) RSV_TRY(rsv_fail(RSV_ERROR_FORMAT, "it holds no scene"));
    RSV_TRY(find_frame(&r, frame));
    RSV_TRY(allocate(&r));
    add_materials(&r);
    RSV_TRY(add_meshes(&r));
    RSV_TRY(walk_nodes(&r, frame));
cleanup:
    rsv_free(context, r.mesh_id);
    rsv_free(context, r.light_node);
    rsv_free(context, r.camera_node);
    rsv_free(context, r.pending);
    if (r.file) aiReleaseImport(r.file);
    return status;
}
