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

void rsv_receiver_points_choose(const rsv_elements *e, uint32_t node, uint32_t index, uint32_t seed,
    uint16_t valid, rsv_support_point sample[LANES])
{
    rsv_elements_sample_support_as(e, node, index, LANES, seed, sample);
    replace_buried(valid, rsv_hash3(seed, index, 0x3f1du) % LANES, sample);
}

void rsv_receiver_points_set_up(const rsv_elements *e, const rsv_support_point sample[LANES],
    uint32_t index, uint32_t seed, rsv_receiver_points *r)
{
    float turn = 2 * RSV_PI * rsv_unit_float(rsv_hash3(seed, index, 0x7a3du));
    float cos_turn = cosf(turn), sin_turn = sinf(turn);
    for (uint32_t k = 0; k < LANES; k++) {
        uint32_t face = e->cell[sample[k].support / 4].face;
        rsv_surface_point point = rsv_surface_point_at(
            e->scene, e->face_triangle[face], sample[k].u, sample[k].v, e->face_back[face]);
        rsv_vec3 origin = rsv_offset_origin(point.position, point.geometric, point.extent);
        rsv_vec3 t, b;
        v3_frame(point.normal, &t, &b);
        rsv_vec3 tangent = v3_mad(v3_scale(t, cos_turn), sin_turn, b);
        rsv_vec3 bitangent = v3_mad(v3_scale(b, cos_turn), -sin_turn, t);
        r->origin_x[k] = origin.x, r->origin_y[k] = origin.y, r->origin_z[k] = origin.z;
        r->tangent_x[k] = tangent.x, r->tangent_y[k] = tangent.y, r->tangent_z[k] = tangent.z;
        r->bitangent_x[k] = bitangent.x, r->bitangent_y[k] = bitangent.y;
        r->bitangent_z[k] = bitangent.z;
        r->normal_x[k] = point.normal.x, r->normal_y[k] = point.normal.y;
        r->normal_z[k] = point.normal.z;
        r->geometric_x[k] = point.geometric.x, r->geometric_y[k] = point.geometric.y;
        r->geometric_z[k] = point.geometric.z;
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
}
