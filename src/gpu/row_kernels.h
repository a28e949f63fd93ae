/// Rays of rows of G, from receiver points to the nodes where they end: the GPU version of src/operator/row_tracer.c.
#ifndef RSV_ROW_KERNELS_H
#define RSV_ROW_KERNELS_H

#include "../bvh/bvh_trace.h"
#include "../operator/device_rows.h"
#include "launch.h"

/// Rays are numbered row by row.
typedef struct rsv_row_args {
    rsv_bvh_view bvh;
    const rsv_scene_view *scene;  ///< that of rsv_gpu_scene
    const rsv_elements *elements; ///< only face_level, face_slot, slot and cell_node
    const rsv_ray_target *target;
    const float *x, *y, *z; ///< [RSV_DIRECTION_SETS * rays] directions
    uint32_t rays, seed;
    bool sky, varied;
    const rsv_row_receiver *receiver;
    uint32_t *column;
    uint8_t *is_left; ///< rays that are left to the processor
    rsv_hit *hit;     ///< of these
    const uint32_t *left;
    rsv_hit *left_hit; ///< of these, one after the other
} rsv_row_args;

/// The arithmetic of rsv_receiver_points_aim. @return false = the ray carries nothing
RSV_INLINE bool rsv_row_aim(
    const rsv_row_args *a, const rsv_row_receiver *r, uint32_t ray_index, rsv_ray *ray)
{
    const rsv_receiver_points *p = &r->points;
    size_t at = (size_t)(rsv_hash2(a->seed, r->index) % RSV_DIRECTION_SETS) * a->rays + ray_index;
    uint32_t k = ray_index % RSV_SUPPORT_POINTS;
    float x = a->x[at], y = a->y[at], z = a->z[at];
    ray->origin = v3(p->origin_x[k], p->origin_y[k], p->origin_z[k]);
    ray->direction = v3(x * p->tangent_x[k] + y * p->bitangent_x[k] + z * p->normal_x[k],
        x * p->tangent_y[k] + y * p->bitangent_y[k] + z * p->normal_y[k],
        x * p->tangent_z[k] + y * p->bitangent_z[k] + z * p->normal_z[k]);
    ray->t_max = INFINITY;
    if (p->lifted >> k & 1) return rsv_receiver_points_lift(p, k, ray->direction, ray);
    rsv_vec3 geometric = v3(p->geometric_x[k], p->geometric_y[k], p->geometric_z[k]);
    return v3_dot(ray->direction, geometric) > 0;
}

RSV_INLINE rsv_ray_target rsv_row_target(
    const rsv_row_args *a, const rsv_hit *hit, rsv_vec3 direction)
{
    const uint32_t *corner = a->scene->triangle[hit->triangle];
    const rsv_vec3 *position = a->scene->position;
    rsv_vec3 p = position[corner[0]];
    rsv_vec3 normal = v3_cross(v3_sub(position[corner[1]], p), v3_sub(position[corner[2]], p));
    return a->target[2 * (size_t)hit->triangle + (v3_dot(normal, direction) > 0)];
}

RSV_INLINE void rsv_row_leave(const rsv_row_args *a, uint32_t item, const rsv_hit *hit)
{
    a->is_left[item] = 1;
    a->hit[item] = *hit;
}

RSV_INLINE void rsv_row_ray_item(const rsv_row_args *a, uint32_t item, bool varied)
{
    rsv_bvh_view bvh = rsv_bvh_with_holes(a->bvh, varied);
    const rsv_row_receiver *r = &a->receiver[item / a->rays];
    uint32_t ray_index = item % a->rays;
    rsv_ray ray;
    rsv_hit hit;
    a->column[item] = RSV_NONE;
    a->is_left[item] = 0;
    if (!rsv_row_aim(a, r, ray_index, &ray)) return;
    if (!rsv_bvh_closest(&bvh, &ray, &hit)) {
        if (a->sky) rsv_row_leave(a, item, &hit);
        return;
    }
    rsv_ray_target target = rsv_row_target(a, &hit, ray.direction);
    if (target.kind == RSV_TARGET_BLACK) return;
    if (target.kind == RSV_TARGET_SPECULAR || r->tints) {
        rsv_row_leave(a, item, &hit);
        return;
    }
    float weight[3], random = rsv_unit_float(rsv_hash(rsv_hash2(a->seed, r->index) + ray_index));
    uint32_t cell = rsv_elements_locate(a->elements, target.face, hit.u, hit.v, weight);
    a->column[item] = rsv_elements_pick_node(a->elements, cell, weight, random);
}

RSV_KERNEL_VARIED(row_ray, rsv_row_args, rsv_row_ray_item)

RSV_INLINE void rsv_row_left_item(const rsv_row_args *a, uint32_t item)
{
    a->left_hit[item] = a->hit[a->left[item]];
}

RSV_KERNEL(row_left, rsv_row_args, rsv_row_left_item)

#endif
