#include "receiver_points.h"

#define LANES RSV_SUPPORT_POINTS

/// Leaves the places of points that do not count to those that do, in turn from a random one on.
static void replace_buried(uint16_t valid, uint32_t random, rsv_support_point *sample)
{
    uint32_t count = 0, sound[LANES];
    for (uint32_t k = 0; k < LANES; k++)
        if (valid >> k & 1) sound[count++] = k;
    for (uint32_t k = 0, next = random; count && k < LANES; k++)
        if (!(valid >> k & 1)) sample[k] = sample[sound[next++ % count]];
}

void rsv_receiver_points_choose(
    const rsv_elements *e, rsv_receiver_draw draw, rsv_support_point sample[LANES])
{
    rsv_elements_sample_support_as(e, draw.node, draw.index, LANES, draw.seed, sample);
    replace_buried(draw.valid, rsv_hash3(draw.seed, draw.index, 0x3f1du) % LANES, sample);
}

static void set_origin(rsv_receiver_points *r, uint32_t k, const rsv_surface_point *point)
{
    rsv_vec3 origin = rsv_offset_origin(point->position, point->geometric, point->extent);
    r->origin_x[k] = origin.x, r->origin_y[k] = origin.y, r->origin_z[k] = origin.z;
    r->geometric_x[k] = point->geometric.x, r->geometric_y[k] = point->geometric.y;
    r->geometric_z[k] = point->geometric.z;
    r->horizon_x[k] = point->horizon.x, r->horizon_y[k] = point->horizon.y;
    r->horizon_z[k] = point->horizon.z;
    r->lift_x[k] = point->lift.x, r->lift_y[k] = point->lift.y, r->lift_z[k] = point->lift.z;
    if (v3_dot(point->lift, point->lift) > 0) r->lifted |= 1u << k;
}

/// Tangent of the first frame: turned by a random angle.
static rsv_vec3 turned_tangent(rsv_receiver_draw draw, rsv_vec3 normal)
{
    float turn = 2 * RSV_PI * rsv_unit_float(rsv_hash3(draw.seed, draw.index, 0x7a3du));
    rsv_vec3 t, b;
    v3_frame(normal, &t, &b);
    return v3_mad(v3_scale(t, cosf(turn)), sinf(turn), b);
}

/// The tangent of a frame about another normal: as close to the first one's as it can be, so that a direction of the
/// rows means the same at all points of a node.
static rsv_vec3 carried_tangent(rsv_vec3 first, rsv_vec3 normal)
{
    rsv_vec3 tangent = v3_mad(first, -v3_dot(first, normal), normal), other;
    if (v3_dot(tangent, tangent) < 1e-4f) v3_frame(normal, &tangent, &other);
    return v3_normalize(tangent);
}

static void set_frame(rsv_receiver_points *r, uint32_t k, rsv_vec3 normal, rsv_vec3 tangent)
{
    rsv_vec3 bitangent = v3_cross(normal, tangent);
    r->tangent_x[k] = tangent.x, r->tangent_y[k] = tangent.y, r->tangent_z[k] = tangent.z;
    r->bitangent_x[k] = bitangent.x, r->bitangent_y[k] = bitangent.y;
    r->bitangent_z[k] = bitangent.z;
    r->normal_x[k] = normal.x, r->normal_y[k] = normal.y, r->normal_z[k] = normal.z;
}

void rsv_receiver_points_set_up(const rsv_elements *e, const rsv_tracer *tracer,
    rsv_receiver_draw draw, const rsv_support_point sample[LANES], rsv_receiver_points *r)
{
    rsv_vec3 first = v3(0, 0, 0);
    r->lifted = 0;
    for (uint32_t k = 0; k < LANES; k++) {
        uint32_t face = e->cell[sample[k].support / 4].face, triangle = e->face_triangle[face];
        float u = sample[k].u, v = sample[k].v;
        bool back = e->face_back[face];
        rsv_surface_point point = rsv_surface_point_seen(e->scene, triangle, u, v, back, 0);
        rsv_surface_lift(e->scene, tracer, triangle, u, v, &point);
        set_origin(r, k, &point);
        if (k == 0) first = turned_tangent(draw, point.normal);
        set_frame(r, k, point.normal, k == 0 ? first : carried_tangent(first, point.normal));
    }
}

/// Rays that graze curved surfaces leave these instead of their triangles.
static void lift_lanes(const rsv_receiver_points *r, rsv_ray_packet *packet)
{
    for (uint32_t left = r->lifted; left; left &= left - 1) {
        rsv_ray ray;
        uint32_t k = (uint32_t)__builtin_ctz(left);
        packet->t_max[k] =
            rsv_receiver_points_lift(r, k,
                v3(packet->direction_x[k], packet->direction_y[k], packet->direction_z[k]), &ray)
                ? INFINITY
                : -1;
        packet->origin_x[k] = ray.origin.x, packet->origin_y[k] = ray.origin.y;
        packet->origin_z[k] = ray.origin.z;
    }
}

void rsv_receiver_points_aim(const rsv_receiver_points *r, const float *x, const float *y,
    const float *z, rsv_ray_packet *packet)
{
    for (int k = 0; k < LANES; k++) {
        float dx = x[k] * r->tangent_x[k] + y[k] * r->bitangent_x[k] + z[k] * r->normal_x[k];
        float dy = x[k] * r->tangent_y[k] + y[k] * r->bitangent_y[k] + z[k] * r->normal_y[k];
        float dz = x[k] * r->tangent_z[k] + y[k] * r->bitangent_z[k] + z[k] * r->normal_z[k];
        float above = dx * r->geometric_x[k] + dy * r->geometric_y[k] + dz * r->geometric_z[k];
        packet->origin_x[k] = r->origin_x[k];
        packet->origin_y[k] = r->origin_y[k];
        packet->origin_z[k] = r->origin_z[k];
        packet->direction_x[k] = dx;
        packet->direction_y[k] = dy;
        packet->direction_z[k] = dz;
        packet->t_max[k] = above > 0 ? INFINITY : -1;
    }
    if (r->lifted) lift_lanes(r, packet);
}
