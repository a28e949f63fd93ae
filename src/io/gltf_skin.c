#include "gltf_skin.h"

#include "../core/core.h"
#include "../core/vec.h"
#include "gltf_accessor.h"
#include "matrix.h"

#include <math.h>
#include <string.h>

static const double identity[16] = { [0] = 1, [5] = 1, [10] = 1, [15] = 1 };

// ---- joints ---------------------------------------------------------------------------------------

/// Where a joint is in the world.
static rsv_status find_joint(
    const rsv_gltf_parts *parts, const rsv_gltf_skin *skin, size_t k, const double **world)
{
    int node = skin->joint[k];
    if (node < 0 || (size_t)node >= parts->document->node_count || !parts->placed[node])
        return rsv_fail(RSV_ERROR_FORMAT,
            "skin '%s': its joint %zu is node %d, which does not exist or has no root", skin->name,
            k, node);
    *world = parts->world[node];
    return RSV_OK;
}

/// The inverse bind matrices; NULL = all identity.
static rsv_status read_binding(
    const rsv_gltf_parts *parts, const rsv_gltf_skin *skin, float (**matrices)[16])
{
    size_t count;
    *matrices = NULL;
    if (skin->inverse_bind_matrices < 0) return RSV_OK;
    rsv_status status = rsv_gltf_read_matrices(
        parts->context, parts->document, skin->inverse_bind_matrices, skin->name, matrices, &count);
    if (status == RSV_OK && count < skin->joint_count)
        status =
            rsv_fail(RSV_ERROR_FORMAT, "skin '%s': accessor %d holds %zu matrices for %zu joints",
                skin->name, skin->inverse_bind_matrices, count, skin->joint_count);
    for (size_t k = 0; status == RSV_OK && k < 16 * skin->joint_count; k++)
        if (!isfinite((*matrices)[k / 16][k % 16]))
            status = rsv_fail(RSV_ERROR_FORMAT,
                "skin '%s': accessor %d: the matrix of joint %zu is not finite; export it again",
                skin->name, skin->inverse_bind_matrices, k / 16);
    if (status == RSV_OK) return RSV_OK;
    rsv_free(parts->context, *matrices);
    *matrices = NULL;
    return status;
}

/// Joint matrix `k`: bound vertex to world.
static void joint_matrix(
    const double world[16], const float (*binding)[16], size_t k, double matrix[16])
{
    double inverse[16];
    for (int i = 0; i < 16; i++)
        inverse[i] = binding ? (double)binding[k][i] : identity[i];
    rsv_matrix_multiply(world, inverse, matrix);
}

static rsv_status check_joints(const rsv_gltf_skin *skin)
{
    if (skin->joint_count) return RSV_OK;
    return rsv_fail(RSV_ERROR_FORMAT, "skin '%s': it has no joints", skin->name);
}

rsv_status rsv_gltf_joints_create(
    const rsv_gltf_parts *parts, size_t index, rsv_gltf_joints *joints)
{
    rsv_status status;
    const rsv_gltf_skin *skin = &parts->document->skin[index];
    float(*binding)[16] = NULL;
    *joints = (rsv_gltf_joints){ .context = parts->context, .name = skin->name };
    RSV_TRY(check_joints(skin));
    RSV_TRY(read_binding(parts, skin, &binding));
    joints->matrix = rsv_alloc(parts->context, skin->joint_count, sizeof *joints->matrix);
    RSV_TRY(joints->matrix ? RSV_OK : RSV_ERROR_MEMORY);
    joints->count = skin->joint_count;
    for (size_t k = 0; k < skin->joint_count; k++) {
        const double *world;
        RSV_TRY(find_joint(parts, skin, k, &world));
        if (k == 0) memcpy(joints->origin, world + 12, sizeof joints->origin);
        joint_matrix(world, (const float(*)[16])binding, k, joints->matrix[k]);
        for (int i = 0; i < 3; i++)
            joints->matrix[k][12 + i] -= joints->origin[i];
    }
cleanup:
    rsv_free(parts->context, binding);
    if (status != RSV_OK) rsv_gltf_joints_destroy(joints);
    return status;
}

void rsv_gltf_joints_destroy(rsv_gltf_joints *joints)
{
    rsv_free(joints->context, joints->matrix);
    joints->matrix = NULL;
}

rsv_status rsv_gltf_skin_mirrors(const rsv_gltf_parts *parts, size_t index, bool *mirrored)
{
    rsv_status status;
    const rsv_gltf_skin *skin = &parts->document->skin[index];
    float(*binding)[16] = NULL;
    const double *world;
    double matrix[16];
    RSV_TRY(check_joints(skin));
    RSV_TRY(find_joint(parts, skin, 0, &world));
    RSV_TRY(read_binding(parts, skin, &binding));
    joint_matrix(world, (const float(*)[16])binding, 0, matrix);
    *mirrored = rsv_matrix_handedness(matrix) < 0;
cleanup:
    rsv_free(parts->context, binding);
    return status;
}

// ---- vertices -------------------------------------------------------------------------------------

/// Joints and weights of all vertices.
typedef struct influences {
    float **joint, **weight; ///< [count] of [4 * vertex_count] each
    size_t count;
} influences;

static void release_influences(rsv_context *context, influences *all)
{
    for (size_t k = 0; all->joint && all->weight && k < all->count; k++) {
        rsv_free(context, all->joint[k]);
        rsv_free(context, all->weight[k]);
    }
    rsv_free(context, all->joint);
    rsv_free(context, all->weight);
}

/// @param what name of the attribute in messages
static rsv_status read_four(rsv_context *context, const rsv_gltf_document *document, int accessor,
    const char *owner, size_t vertex_count, float **values)
{
    rsv_gltf_attribute read;
    rsv_status status = rsv_gltf_read_attribute(context, document, accessor, owner, &read);
    if (status != RSV_OK) return status;
    *values = read.values;
    if (read.width != 4 || read.count != vertex_count)
        return rsv_fail(RSV_ERROR_FORMAT,
            "mesh '%s': accessor %d must hold VEC4 joints or weights for %zu positions", owner,
            accessor, vertex_count);
    return RSV_OK;
}

static rsv_status read_influences(rsv_context *context, const rsv_gltf_document *document,
    const rsv_gltf_primitive *primitive, const char *owner, size_t vertex_count, influences *all)
{
    rsv_status status = RSV_OK;
    size_t count = primitive->influence_count;
    *all = (influences){ .joint = rsv_alloc(context, count, sizeof *all->joint),
        .weight = rsv_alloc(context, count, sizeof *all->weight),
        .count = count };
    if (!all->joint || !all->weight) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < count; k++) {
        RSV_TRY(read_four(context, document, primitive->influence[k].joints, owner, vertex_count,
            &all->joint[k]));
        RSV_TRY(read_four(context, document, primitive->influence[k].weights, owner, vertex_count,
            &all->weight[k]));
    }
cleanup:
    return status;
}

/// A weight that can be used: neither negative nor without a value.
static double usable(float weight) { return weight > 0 && isfinite(weight) ? (double)weight : 0; }

static rsv_status add_joint(
    const rsv_gltf_joints *joints, float joint, double share, const char *owner, double matrix[16])
{
    if (!(joint >= 0 && joint < (float)joints->count))
        return rsv_fail(RSV_ERROR_FORMAT,
            "mesh '%s': a vertex follows joint %g of skin '%s', which has %zu", owner,
            (double)joint, joints->name, joints->count);
    const double *from = joints->matrix[(size_t)joint];
    for (int i = 0; i < 16; i++)
        matrix[i] += share * from[i];
    return RSV_OK;
}

/// Sum of the weights of vertex `n`.
static double total_weight(const influences *all, size_t n)
{
    double sum = 0;
    for (size_t k = 0; k < all->count; k++)
        for (size_t i = 4 * n; i < 4 * n + 4; i++)
            sum += usable(all->weight[k][i]);
    return sum;
}

/// Reports invalid weights and what they are replaced by.
static void tell_weights(
    rsv_context *context, const influences *all, size_t vertex_count, const char *owner)
{
    size_t faulty = 0, loose = 0;
    for (size_t n = 0; n < vertex_count; n++) {
        bool good = true;
        for (size_t k = 0; k < all->count; k++)
            for (size_t i = 4 * n; i < 4 * n + 4; i++)
                good = good && all->weight[k][i] >= 0 && isfinite(all->weight[k][i]);
        faulty += !good;
        loose += !(total_weight(all, n) > 0);
    }
    if (faulty)
        rsv_log(context, RSV_LOG_WARNING,
            "mesh '%s': %zu of %zu vertices have weights that are negative or not finite; these "
            "count as 0",
            owner, faulty, vertex_count);
    if (loose)
        rsv_log(context, RSV_LOG_WARNING,
            "mesh '%s': %zu of %zu vertices have no weight above 0; they follow their first joint",
            owner, loose, vertex_count);
}

/// The transform of vertex `n`.
static rsv_status blend(const rsv_gltf_joints *joints, const influences *all, size_t n,
    const char *owner, double matrix[16])
{
    rsv_status status = RSV_OK;
    double sum = total_weight(all, n);
    memset(matrix, 0, sizeof(double[16]));
    if (!(sum > 0)) return add_joint(joints, all->joint[0][4 * n], 1, owner, matrix);
    for (size_t k = 0; k < all->count; k++)
        for (size_t i = 4 * n; i < 4 * n + 4; i++) {
            double weight = usable(all->weight[k][i]);
            if (weight > 0)
                RSV_TRY(add_joint(joints, all->joint[k][i], weight / sum, owner, matrix));
        }
cleanup:
    return status;
}

static rsv_vec3 turn(const double m[16], const double offset[3], rsv_vec3 v)
{
    double r[3] = { 0 };
    for (int i = 0; i < 3; i++)
        r[i] = m[i] * (double)v.x + m[4 + i] * (double)v.y + m[8 + i] * (double)v.z + offset[i];
    return v3((float)r[0], (float)r[1], (float)r[2]);
}

/// Unit image of a normal: by the cofactors, which are the inverse transpose up to a factor.
static rsv_vec3 turn_normal(const double m[16], rsv_vec3 n)
{
    double cofactor[16] = { 0 };
    static const double nowhere[3] = { 0, 0, 0 };
    for (int column = 0; column < 3; column++)
        for (int row = 0; row < 3; row++) {
            int c1 = 4 * ((column + 1) % 3), c2 = 4 * ((column + 2) % 3);
            int r1 = (row + 1) % 3, r2 = (row + 2) % 3;
            cofactor[4 * column + row] = m[c1 + r1] * m[c2 + r2] - m[c1 + r2] * m[c2 + r1];
        }
    double sign = rsv_matrix_handedness(m) < 0 ? -1 : 1, longest = 0;
    for (int i = 0; i < 16; i++)
        longest = fmax(longest, fabs(cofactor[i]));
    for (int i = 0; i < 16 && longest > 0; i++)
        cofactor[i] *= sign / longest;
    rsv_vec3 turned = turn(cofactor, nowhere, n);
    return v3_length(turned) > 0 ? v3_normalize(turned) : v3(0, 0, 0);
}

static void move_vertex(const double m[16], size_t n, rsv_gltf_geometry *g)
{
    static const double nowhere[3] = { 0, 0, 0 };
    g->position[n] = turn(m, m + 12, g->position[n]);
    if (g->normal) g->normal[n] = turn_normal(m, g->normal[n]);
    if (!g->tangent) return;
    float *t = g->tangent + 4 * n;
    rsv_vec3 turned = v3_normalize(turn(m, nowhere, v3(t[0], t[1], t[2])));
    t[0] = turned.x, t[1] = turned.y, t[2] = turned.z;
    if (rsv_matrix_handedness(m) < 0) t[3] = -t[3];
}

/// Swaps two corners of each triangle, so that the front side stays the front; commit does the same for mirroring
/// nodes.
static rsv_status turn_triangles(rsv_context *context, rsv_gltf_geometry *g)
{
    if (!g->index) {
        g->index = rsv_alloc(context, g->index_count, sizeof *g->index);
        if (!g->index) return RSV_ERROR_MEMORY;
        for (size_t k = 0; k < g->index_count; k++)
            g->index[k] = (uint32_t)k;
    }
    for (size_t k = 0; k + 2 < g->index_count; k += 3) {
        uint32_t second = g->index[k + 1];
        g->index[k + 1] = g->index[k + 2];
        g->index[k + 2] = second;
    }
    return RSV_OK;
}

rsv_status rsv_gltf_bend(const rsv_gltf_joints *joints, const rsv_gltf_document *document,
    const rsv_gltf_primitive *primitive, const char *owner, bool mirrored, rsv_gltf_geometry *g)
{
    rsv_status status;
    influences all = { 0 };
    RSV_TRY(read_influences(joints->context, document, primitive, owner, g->vertex_count, &all));
    tell_weights(joints->context, &all, g->vertex_count, owner);
    for (size_t n = 0; n < g->vertex_count; n++) {
        double matrix[16];
        RSV_TRY(blend(joints, &all, n, owner, matrix));
        move_vertex(matrix, n, g);
    }
    if (mirrored) RSV_TRY(turn_triangles(joints->context, g));
cleanup:
    release_influences(joints->context, &all);
    return status;
}
