/// What the rays of a packet see where faces lie in the same place (twins.h): lanes that met one triangle are settled
/// together, as most packets meet few.
#ifndef RSV_PACKET_SETTLE_H
#define RSV_PACKET_SETTLE_H

#include "../scene/twins.h"
#include "packet.h"

RSV_INLINE rsv_vec3 rsv_packet_direction(const rsv_ray_packet *p, uint32_t lane)
{
    return v3(p->direction_x[lane], p->direction_y[lane], p->direction_z[lane]);
}

/// Has a lane meet another triangle at the same distance. @param normal of its plane
RSV_INLINE void rsv_packet_turn_to(
    rsv_ray_packet *p, uint32_t lane, uint32_t triangle, rsv_vec3 normal, float u, float v)
{
    p->normal_x[lane] = normal.x;
    p->normal_y[lane] = normal.y;
    p->normal_z[lane] = normal.z;
    p->triangle[lane] = triangle;
    p->u[lane] = u;
    p->v[lane] = v;
}

/// Lanes one by one, a bit each.
RSV_INLINE void rsv_packet_search(const rsv_scene_view *scene, rsv_ray_packet *p, uint32_t lanes)
{
    for (uint32_t k = 0; k < RSV_PACKET_WIDTH; k++) {
        rsv_hit hit = { p->triangle[k], p->t_max[k], p->u[k], p->v[k] };
        if (!(lanes >> k & 1)) continue;
        rsv_twins_search(scene, rsv_packet_direction(p, k), &hit);
        if (hit.triangle == p->triangle[k]) continue;
        rsv_vec3 normal = rsv_twin_plane_of(scene, hit.triangle).normal;
        rsv_packet_turn_to(p, k, hit.triangle, normal, hit.u, hit.v);
    }
}

/// Lanes that look along a normal, a bit each: those that meet the back of its face.
RSV_INLINE uint32_t rsv_lanes_along(const rsv_ray_packet *p, rsv_vec3 normal)
{
    uint32_t lanes = 0;
    for (uint32_t k = 0; k < RSV_PACKET_WIDTH; k++)
        lanes |= (v3_dot(normal, rsv_packet_direction(p, k)) > 0 ? 1u : 0u) << k;
    return lanes;
}

/// Lanes that rsv_twin_sole holds for.
RSV_INLINE uint32_t rsv_lanes_inside(const rsv_ray_packet *p)
{
    uint32_t lanes = 0;
    for (uint32_t k = 0; k < RSV_PACKET_WIDTH; k++) {
        float least = f_min(f_min(p->u[k], p->v[k]), 1 - p->u[k] - p->v[k]);
        lanes |= (least > RSV_TWIN_INSET ? 1u : 0u) << k;
    }
    return lanes;
}

/// A triangle that was met, and the one face that may be seen in its place.
typedef struct rsv_twin_pair {
    uint32_t met, sole;
    rsv_twin_plane plane, sole_plane; ///< theirs
} rsv_twin_pair;

/// Turns lanes that the sole face covers to it.
RSV_INLINE void rsv_packet_cover(
    const rsv_scene_view *scene, const rsv_twin_pair *pair, rsv_ray_packet *p, uint32_t lanes)
{
    const rsv_twins *twins = scene->twins;
    const rsv_twin_plane *a = &pair->plane, *b = &pair->sole_plane;
    float own_a = rsv_twin_rounding(a, twins->rounding);
    float own_b = rsv_twin_rounding(b, twins->rounding), rounding = f_max(own_a, own_b);
    float reach =
        f_max(f_min(rsv_twin_reach(b, own_b, twins->reach), rsv_twin_reach(a, own_a, twins->reach)),
            rounding);
    bool opposite = v3_dot(b->normal, a->normal) < 0;
    rsv_twin_limits limits = rsv_twin_limits_of(b, opposite ? reach : rounding, rounding);
    for (uint32_t k = 0; k < RSV_PACKET_WIDTH; k++) {
        float u, v;
        rsv_vec3 point = rsv_twin_point(a, p->u[k], p->v[k]);
        if ((lanes >> k & 1) && rsv_twin_covers(b, &limits, point, &u, &v))
            rsv_packet_turn_to(p, k, pair->sole, b->normal, u, v);
    }
}

/// Lanes that met one side of one triangle.
RSV_INLINE void rsv_packet_settle_alike(
    const rsv_scene_view *scene, rsv_twin_pair *pair, bool back, rsv_ray_packet *p, uint32_t lanes)
{
    const rsv_twins *twins = scene->twins;
    uint32_t met = pair->met, sole = twins->sole ? twins->sole[met] : RSV_NONE;
    uint32_t inside = sole == RSV_NONE ? 0 : lanes & rsv_lanes_inside(p), sole_backs;
    rsv_packet_search(scene, p, lanes & ~inside);
    if (!inside || sole == met) return;
    pair->sole = sole;
    pair->sole_plane = rsv_twin_plane_of(scene, sole);
    sole_backs = rsv_lanes_along(p, pair->sole_plane.normal) & inside;
    bool sole_back = sole_backs == inside;
    uint32_t material = scene->triangle_material[sole];
    if (scene->material[material].alpha_cutoff > 0 || (sole_backs && !sole_back)) {
        rsv_packet_search(scene, p, inside);
        return;
    }
    uint32_t own = rsv_twin_rank(scene, met, back);
    uint32_t other = rsv_twin_rank(scene, sole, sole_back);
    if (other > own || (other == own && sole > met)) rsv_packet_cover(scene, pair, p, inside);
}

/// Lanes that met faces with copies, a bit each.
RSV_INLINE uint32_t rsv_lanes_with_twins(const rsv_scene_view *scene, const rsv_ray_packet *p)
{
    uint32_t lanes = 0, over = RSV_TWIN_OVER_FRONT | RSV_TWIN_OVER_BACK;
    for (uint32_t k = 0; k < RSV_PACKET_WIDTH; k++) {
        uint32_t met = p->triangle[k];
        if (met != RSV_NONE && (scene->twins->flags[met] & over)) lanes |= 1u << k;
    }
    return lanes;
}

/// See rsv_twins_settle. @param scene with twins
RSV_INLINE void rsv_packet_settle(const rsv_scene_view *scene, rsv_ray_packet *p)
{
    for (uint32_t left = rsv_lanes_with_twins(scene, p); left;) {
        uint32_t lanes = 0;
        rsv_twin_pair pair;
        pair.met = p->triangle[__builtin_ctz(left)];
        pair.plane = rsv_twin_plane_of(scene, pair.met);
        for (uint32_t k = 0; k < RSV_PACKET_WIDTH; k++)
            lanes |= (p->triangle[k] == pair.met ? 1u : 0u) << k;
        lanes &= left;
        left &= ~lanes;
        uint8_t over = scene->twins->flags[pair.met];
        uint32_t backs = rsv_lanes_along(p, pair.plane.normal) & lanes, fronts = lanes & ~backs;
        if (fronts && (over & RSV_TWIN_OVER_FRONT))
            rsv_packet_settle_alike(scene, &pair, false, p, fronts);
        if (backs && (over & RSV_TWIN_OVER_BACK))
            rsv_packet_settle_alike(scene, &pair, true, p, backs);
    }
}

#endif
