/// Tangents for normal maps and brushed metal, after MikkTSpace's definition (Mikkelsen 2008): at each vertex the mean,
/// weighted by angle, of the directions in which u increases on the triangles around it.
#include "../core/vec.h"
#include "material_at.h"
#include "scene.h"

/// Hand of a vertex whose triangles disagree: the texture is mirrored there.
#define MIXED 2.0f

static void texture_coordinates(
    const rsv_mesh *mesh, const rsv_texture_ref *ref, uint32_t vertex, float coordinate[2])
{
    const float *uv = mesh->uv[ref->uv_set][vertex];
    for (int k = 0; k < 2; k++)
        coordinate[k] =
            ref->transform[k][0] * uv[0] + ref->transform[k][1] * uv[1] + ref->transform[k][2];
}

/// Direction of increasing u on a triangle, and its hand: +1 where the texture is not mirrored, v running down.
static bool triangle_tangent(const rsv_mesh *mesh, const rsv_texture_ref *ref,
    const uint32_t *corner, rsv_vec3 *tangent, float *hand)
{
    float a[2], b[2], c[2];
    texture_coordinates(mesh, ref, corner[0], a);
    texture_coordinates(mesh, ref, corner[1], b);
    texture_coordinates(mesh, ref, corner[2], c);
    rsv_vec3 edge1 = v3_sub(mesh->position[corner[1]], mesh->position[corner[0]]);
    rsv_vec3 edge2 = v3_sub(mesh->position[corner[2]], mesh->position[corner[0]]);
    float area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
    rsv_vec3 along = v3_sub(v3_scale(edge1, c[1] - a[1]), v3_scale(edge2, b[1] - a[1]));
    float size = v3_max_abs(along);
    if (!(size > 0) || !isfinite(size) || area == 0) return false;
    *tangent = v3_scale(along, (area < 0 ? -1 : 1) / size);
    *hand = area < 0 ? 1.0f : -1.0f;
    return true;
}

static float angle_at(const rsv_mesh *mesh, const uint32_t *corner, int k)
{
    rsv_vec3 at = mesh->position[corner[k]];
    rsv_vec3 e1 = v3_normalize(v3_sub(mesh->position[corner[(k + 1) % 3]], at));
    rsv_vec3 e2 = v3_normalize(v3_sub(mesh->position[corner[(k + 2) % 3]], at));
    return acosf(f_min(f_max(v3_dot(e1, e2), -1), 1));
}

static void add_tangent(rsv_mesh *mesh, uint32_t vertex, rsv_vec3 tangent, float hand, float angle)
{
    rsv_vec3 normal = mesh->normal[vertex];
    tangent = v3_normalize(v3_mad(tangent, -v3_dot(tangent, normal), normal));
    float *sum = mesh->tangent[vertex];
    sum[0] += angle * tangent.x;
    sum[1] += angle * tangent.y;
    sum[2] += angle * tangent.z;
    sum[3] = sum[3] == 0 || sum[3] == hand ? hand : MIXED;
}

/// Unit tangents; where the hand is mixed, none, so that each triangle uses its own.
static void finish_tangent(float tangent[4])
{
    rsv_vec3 t = v3_normalize(v3(tangent[0], tangent[1], tangent[2]));
    if (tangent[3] == MIXED) t = v3(0, 0, 0);
    tangent[0] = t.x, tangent[1] = t.y, tangent[2] = t.z;
}

static bool asks_for_tangents(const rsv_material *material)
{
    return material->anisotropy > 0 || rsv_find_texture(material, RSV_TEXTURE_NORMAL) ||
           rsv_find_texture(material, RSV_TEXTURE_CLEARCOAT_NORMAL);
}

rsv_status rsv_mesh_create_tangents(
    rsv_context *context, const rsv_material *material, rsv_mesh *mesh)
{
    const rsv_texture_ref ref = rsv_tangent_ref(material);
    if (!asks_for_tangents(material) || mesh->tangent || !mesh->normal || !mesh->uv[ref.uv_set])
        return RSV_OK;
    mesh->tangent = rsv_alloc(context, mesh->vertex_count, sizeof *mesh->tangent);
    if (!mesh->tangent) return RSV_ERROR_MEMORY;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *corner = &mesh->index[3 * t];
        rsv_vec3 tangent;
        float hand;
        if (!triangle_tangent(mesh, &ref, corner, &tangent, &hand)) continue;
        for (int k = 0; k < 3; k++)
            add_tangent(mesh, corner[k], tangent, hand, angle_at(mesh, corner, k));
    }
    for (size_t i = 0; i < mesh->vertex_count; i++)
        finish_tangent(mesh->tangent[i]);
    return RSV_OK;
}
