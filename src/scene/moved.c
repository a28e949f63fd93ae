#include "moved.h"

#include "../core/vec.h"
#include "../subsurface/scatter_profile.h"
#include "material_fields.h"
#include "variant.h"

#include <string.h>

/// Rounding that distances within a body are allowed, as a part of its size.
#define SHAPE_TOLERANCE 1e-4f

// ---- moving objects -------------------------------------------------------------------------------

static rsv_vec3 column_of(const float m[16], int k)
{
    return v3(m[4 * k], m[4 * k + 1], m[4 * k + 2]);
}

static rsv_vec3 combine(const rsv_vec3 axis[3], rsv_vec3 v)
{
    return v3_mad(v3_mad(v3_scale(axis[0], v.x), v.y, axis[1]), v.z, axis[2]);
}

/// A motion, and how normals take part in it.
typedef struct placement {
    rsv_vec3 axis[3], offset, cofactor[3];
} placement;

static const char *object_name(const rsv_scene *scene, const rsv_motion *motion)
{
    return scene->object_name[motion->object];
}

static rsv_status check_matrix(const rsv_scene *scene, const rsv_motion *motion)
{
    for (int k = 0; k < 16; k++)
        if (!isfinite(motion->matrix[k]))
            return rsv_fail(RSV_ERROR_ARGUMENT,
                "scene: the matrix that moves object '%s' has a number that is not finite",
                object_name(scene, motion));
    return RSV_OK;
}

static rsv_status place(const rsv_scene *scene, const rsv_motion *motion, placement *p)
{
    const float *m = motion->matrix;
    if (motion->object >= scene->object_count)
        return rsv_fail(RSV_ERROR_ARGUMENT, "scene: object %u does not exist; there are %zu",
            motion->object, scene->object_count);
    rsv_status status = check_matrix(scene, motion);
    if (status != RSV_OK) return status;
    for (int k = 0; k < 3; k++)
        p->axis[k] = column_of(m, k);
    p->offset = column_of(m, 3);
    for (int k = 0; k < 3; k++)
        p->cofactor[k] = v3_cross(p->axis[(k + 1) % 3], p->axis[(k + 2) % 3]);
    float volume = v3_dot(p->axis[0], p->cofactor[0]);
    float extent = v3_length(p->axis[0]) * v3_length(p->axis[1]) * v3_length(p->axis[2]);
    if (!(fabsf(volume) > 1e-6f * extent) || !(fabsf(volume) > 1e-18f))
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "scene: object '%s' is scaled to zero; leave it out of the scene instead",
            object_name(scene, motion));
    if (volume < 0)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "scene: object '%s' is mirrored, which turns its triangles over; build a scene with "
            "the "
            "mirrored mesh instead",
            object_name(scene, motion));
    return RSV_OK;
}

static void move_vertex(rsv_scene *scene, uint32_t vertex, const placement *p)
{
    scene->position[vertex] = v3_add(combine(p->axis, scene->position[vertex]), p->offset);
    scene->normal[vertex] = v3_normalize(combine(p->cofactor, scene->normal[vertex]));
    if (!scene->tangent) return;
    float *t = scene->tangent[vertex];
    rsv_vec3 tangent = combine(p->axis, v3(t[0], t[1], t[2]));
    if (v3_dot(tangent, tangent) > 0) tangent = v3_normalize(tangent);
    t[0] = tangent.x, t[1] = tangent.y, t[2] = tangent.z;
}

/// @param moved [vertex_count] 1 = has been moved already
static rsv_status move_object(rsv_scene *scene, const rsv_motion *motion, uint8_t *moved)
{
    placement p = { .offset = { 0, 0, 0 } };
    rsv_status status = place(scene, motion, &p);
    for (size_t t = 0; t < scene->triangle_count && status == RSV_OK; t++) {
        if (scene->triangle_object[t] != motion->object) continue;
        for (int k = 0; k < 3; k++) {
            uint32_t vertex = scene->triangle[t][k];
            if (moved[vertex]) continue;
            moved[vertex] = 1;
            move_vertex(scene, vertex, &p);
            if (!rsv_within_reach(scene->position[vertex]))
                return rsv_fail(RSV_ERROR_ARGUMENT,
                    "scene: object '%s' is moved farther than %g m from the origin",
                    object_name(scene, motion), (double)RSV_FARTHEST);
        }
    }
    return status;
}

rsv_status rsv_scene_move(
    const rsv_scene *scene, const rsv_motion *motion, size_t count, rsv_scene **result)
{
    rsv_status status;
    rsv_scene *moved = NULL;
    uint8_t *vertex = NULL;
    RSV_TRY(rsv_scene_require_committed(scene));
    vertex = rsv_alloc(scene->context, scene->vertex_count, 1);
    RSV_TRY(vertex ? RSV_OK : RSV_ERROR_MEMORY);
    RSV_TRY(rsv_scene_vary(scene, &moved));
    RSV_TRY(rsv_scene_vary_positions(moved));
    RSV_TRY(rsv_scene_vary_normals(moved));
    for (size_t k = 0; k < count; k++)
        RSV_TRY(move_object(moved, &motion[k], vertex));
    RSV_TRY(rsv_scene_update_bounds(moved));
    *result = moved;
    moved = NULL;
cleanup:
    rsv_free(scene->context, vertex);
    rsv_scene_destroy(moved);
    return status;
}

// ---- comparing versions ---------------------------------------------------------------------------

static bool is_same_number(const void *a, const void *b, int channels)
{
    return memcmp(a, b, (size_t)channels * sizeof(float)) == 0;
}

static bool is_same_material(const rsv_material *a, const rsv_material *b)
{
    bool same = a->texture_count == b->texture_count;
#define SAME_NUMBER(field, channels, usual, low, high, extension, key)                             \
    same = same && is_same_number(&a->field, &b->field, channels);
#define SAME_FLAG(field) same = same && a->field == b->field;
    RSV_MATERIAL_FIELDS(SAME_NUMBER, SAME_FLAG)
#undef SAME_NUMBER
#undef SAME_FLAG
    for (size_t k = 0; k < a->texture_count && same; k++)
        same = a->textures[k].role == b->textures[k].role &&
               a->textures[k].texture == b->textures[k].texture;
    return same;
}

static rsv_status refuse(const char *what)
{
    return rsv_fail(RSV_ERROR_UNSUPPORTED,
        "scene: this version has different %s; a light can only follow surfaces that move: solve "
        "the scene again",
        what);
}

static bool has_same_triangles(const rsv_scene *a, const rsv_scene *b)
{
    size_t count = a->triangle_count;
    return count == b->triangle_count && a->vertex_count == b->vertex_count &&
           a->object_count == b->object_count && !a->tangent == !b->tangent &&
           memcmp(a->triangle, b->triangle, count * sizeof *a->triangle) == 0 &&
           memcmp(a->triangle_object, b->triangle_object, count * sizeof(uint32_t)) == 0 &&
           memcmp(a->triangle_material, b->triangle_material, count * sizeof(uint32_t)) == 0;
}

static rsv_status check_alike(const rsv_scene *a, const rsv_scene *b)
{
    if (!has_same_triangles(a, b)) return refuse("triangles");
    if (a->material_count != b->material_count) return refuse("materials");
    for (size_t m = 0; m < a->material_count; m++)
        if (!is_same_material(&a->material[m], &b->material[m])) return refuse("materials");
    if (a->light_count != b->light_count) return refuse("lights");
    for (size_t k = 0; k < a->light_count; k++)
        if (a->light[k].kind != b->light[k].kind) return refuse("lights");
    for (int k = 0; k < 3; k++)
        if (a->origin[k] != b->origin[k]) return refuse("coordinates");
    return RSV_OK;
}

static bool is_light_moved(const rsv_punctual_light *a, const rsv_punctual_light *b)
{
    return !is_same_number(&a->position, &b->position, 3) ||
           !is_same_number(&a->direction, &b->direction, 3) ||
           !is_same_number(&a->intensity, &b->intensity, 3) ||
           a->inner_cone_angle != b->inner_cone_angle ||
           a->outer_cone_angle != b->outer_cone_angle || a->exponent != b->exponent;
}

static bool is_vertex_moved(const rsv_scene *a, const rsv_scene *b, uint32_t vertex)
{
    return !is_same_number(&a->position[vertex], &b->position[vertex], 3) ||
           !is_same_number(&a->normal[vertex], &b->normal[vertex], 3) ||
           (a->tangent && !is_same_number(a->tangent[vertex], b->tangent[vertex], 4));
}

/// Corners that determine the pose of an object: two that are far apart, and one that is far from both.
typedef struct pose_corners {
    uint32_t vertex[3];
} pose_corners;

/// The vertex of an object for which a sum of distances to others is largest.
static uint32_t farthest_vertex(
    const rsv_scene *s, uint32_t object, const uint32_t *from, int from_count)
{
    uint32_t best = from[0];
    float most = -1;
    for (size_t t = 0; t < s->triangle_count; t++)
        for (int k = 0; k < 3 && s->triangle_object[t] == object; k++) {
            uint32_t v = s->triangle[t][k];
            float nearest = INFINITY;
            for (int f = 0; f < from_count; f++)
                nearest = f_min(nearest, v3_length(v3_sub(s->position[v], s->position[from[f]])));
            if (nearest > most) most = nearest, best = v;
        }
    return best;
}

/// Whether an object has the same shape in both versions: all its corners are as far from three of them.
static bool keeps_shape(const rsv_scene *a, const rsv_scene *b, uint32_t object, uint32_t vertex)
{
    pose_corners p = { { vertex, vertex, vertex } };
    for (int k = 1; k < 3; k++)
        p.vertex[k] = farthest_vertex(a, object, p.vertex, k);
    float size = v3_length(v3_sub(a->position[p.vertex[1]], a->position[vertex]));
    for (size_t t = 0; t < a->triangle_count; t++)
        for (int k = 0; k < 9 && a->triangle_object[t] == object; k++) {
            uint32_t v = a->triangle[t][k / 3], from = p.vertex[k % 3];
            float then = v3_length(v3_sub(a->position[v], a->position[from]));
            float now = v3_length(v3_sub(b->position[v], b->position[from]));
            if (fabsf(then - now) > SHAPE_TOLERANCE * size) return false;
        }
    return true;
}

/// Light diffuses below the surface of a body from everywhere to everywhere: another shape is another body.
static rsv_status check_translucent(const rsv_scene *a, const rsv_scene *b, const uint8_t *moved)
{
    rsv_status status = RSV_OK;
    uint8_t *done = rsv_alloc(a->context, a->object_count, 1);
    if (!done) return RSV_ERROR_MEMORY;
    for (size_t t = 0; t < a->triangle_count && status == RSV_OK; t++) {
        uint32_t object = a->triangle_object[t];
        const rsv_material *m = &a->material[a->triangle_material[t]];
        if (!moved[t] || done[object] || !rsv_material_scatters_below(m)) continue;
        done[object] = 1;
        if (!keeps_shape(a, b, object, a->triangle[t][0]))
            status = rsv_fail(RSV_ERROR_UNSUPPORTED,
                "scene: the translucent object '%s' changes its shape, which a light does not "
                "follow; solve the scene again",
                a->object_name[object]);
    }
    rsv_free(a->context, done);
    return status;
}

rsv_status rsv_scene_find_moved(
    const rsv_scene *scene, const rsv_scene *version, rsv_scene_difference *d)
{
    *d = (rsv_scene_difference){ .moved = NULL };
    rsv_status status = check_alike(scene, version);
    if (status != RSV_OK) return status;
    d->moved = rsv_alloc(scene->context, scene->triangle_count, 1);
    if (!d->moved) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < scene->light_count; k++)
        d->lights_moved = d->lights_moved || is_light_moved(&scene->light[k], &version->light[k]);
    for (size_t t = 0; t < scene->triangle_count; t++) {
        const uint32_t *corner = scene->triangle[t];
        d->moved[t] = is_vertex_moved(scene, version, corner[0]) ||
                      is_vertex_moved(scene, version, corner[1]) ||
                      is_vertex_moved(scene, version, corner[2]);
        d->moved_count += d->moved[t];
    }
    return d->moved_count ? check_translucent(scene, version, d->moved) : RSV_OK;
}

static void take_light(rsv_punctual_light *to, const rsv_punctual_light *from)
{
    const char *name = to->name;
    *to = *from;
    to->name = name;
}

void rsv_scene_take_places(rsv_scene *variant, const rsv_scene *version)
{
    size_t count = variant->vertex_count;
    memcpy(variant->position, version->position, count * sizeof *variant->position);
    memcpy(variant->normal, version->normal, count * sizeof *variant->normal);
    if (variant->tangent)
        memcpy(variant->tangent, version->tangent, count * sizeof *variant->tangent);
    for (size_t k = 0; k < variant->light_count; k++)
        take_light(&variant->light[k], &version->light[k]);
}
