/// Duplicate faces (twins.h) for the rays of a packet. Lanes that hit the same triangle are processed together, because
/// most packets hit few triangles.
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

/// Looks through all faces at the place of a lane's hit.
RSV_INLINE void rsv_packet_search(const rsv_scene_view *scene, rsv_ray_packet *p, uint32_t lane)
{
    rsv_hit hit = rsv_packet_hit(p, lane);
    rsv_twins_search(scene, rsv_packet_direction(p, lane), &hit);
    if (hit.triangle == p->triangle[lane]) return;
    rsv_vec3 normal = rsv_twin_plane_of(scene, hit.triangle).normal;
    rsv_packet_turn_to(p, lane, hit.triangle, normal, hit.u, hit.v);
}

/// A face that may be seen in place of another one.
typedef struct rsv_twin_rival {
    uint32_t triangle, rank[2]; ///< by whether rays meet its back
    rsv_twin_plane plane;
    rsv_twin_limits limits;
} rsv_twin_rival;

/// A triangle that lanes hit, and the face seen well inside it.
typedef struct rsv_twin_group {
    uint32_t met, rank[2];
    rsv_twin_plane plane;
    uint32_t count; ///< of rivals; RSV_NONE = hits must look all around
    rsv_twin_rival rival[RSV_TWIN_RIVALS];
} rsv_twin_group;

RSV_INLINE void rsv_twin_rival_of(
    const rsv_scene_view *scene, const rsv_twin_plane *a, uint32_t triangle, rsv_twin_rival *to)
{
    const rsv_twins *twins = scene->twins;
    rsv_twin_plane b = rsv_twin_plane_of(scene, triangle);
    rsv_twin_margin margin =
        rsv_twin_margin_between(rsv_twin_margin_of(a, twins->rounding, twins->reach),
            rsv_twin_margin_of(&b, twins->rounding, twins->reach));
    bool opposite = v3_dot(b.normal, a->normal) < 0;
    to->triangle = triangle;
    to->rank[0] = rsv_twin_rank(scene, triangle, false);
    to->rank[1] = rsv_twin_rank(scene, triangle, true);
    to->plane = b;
    to->limits = rsv_twin_limits_of(&b, opposite ? margin.reach : margin.rounding, margin.rounding);
}

RSV_INLINE void rsv_twin_group_of(const rsv_scene_view *scene, uint32_t met, rsv_twin_group *g)
{
    const rsv_hit inside = { met, 0, 1 / 3.0f, 1 / 3.0f };
    const uint32_t *rival = NULL;
    g->met = met;
    g->rank[0] = rsv_twin_rank(scene, met, false);
    g->rank[1] = rsv_twin_rank(scene, met, true);
    g->plane = rsv_twin_plane_of(scene, met);
    g->count = rsv_twin_rivals(scene->twins, &inside, &rival);
    for (uint32_t k = 0; g->count != RSV_NONE && k < g->count; k++) {
        uint32_t material = scene->triangle_material[rival[k]];
        if (scene->material[material].alpha_cutoff > 0)
            g->count = RSV_NONE; // it may be cut out where it is met
        else
            rsv_twin_rival_of(scene, &g->plane, rival[k], &g->rival[k]);
    }
}

/// rsv_twins_search for a lane that is well inside the triangle.
RSV_INLINE void rsv_packet_compare(
    const rsv_twin_group *g, bool back, rsv_ray_packet *p, uint32_t lane)
{
    rsv_vec3 direction = rsv_packet_direction(p, lane);
    rsv_vec3 point = rsv_twin_point(&g->plane, p->u[lane], p->v[lane]);
    uint32_t seen = g->met, most = g->rank[back];
    for (uint32_t k = 0; k < g->count; k++) {
        float u, v;
        const rsv_twin_rival *r = &g->rival[k];
        uint32_t rank = r->rank[v3_dot(r->plane.normal, direction) > 0];
        if (rank < most || (rank == most && r->triangle < seen)) continue;
        if (!rsv_twin_covers(&r->plane, &r->limits, point, &u, &v)) continue;
        seen = r->triangle, most = rank;
        rsv_packet_turn_to(p, lane, seen, r->plane.normal, u, v);
    }
}

/// rsv_twins_settle for a lane that met the triangle.
RSV_INLINE void rsv_packet_settle_lane(
    const rsv_scene_view *scene, const rsv_twin_group *g, rsv_ray_packet *p, uint32_t lane)
{
    bool back = v3_dot(g->plane.normal, rsv_packet_direction(p, lane)) > 0;
    float least = f_min(f_min(p->u[lane], p->v[lane]), 1 - p->u[lane] - p->v[lane]);
    uint8_t over = scene->twins->flags[g->met];
    if (!(over & (back ? RSV_TWIN_OVER_BACK : RSV_TWIN_OVER_FRONT))) return;
    if (g->count == RSV_NONE || !(least > RSV_TWIN_INSET))
        rsv_packet_search(scene, p, lane);
    else
        rsv_packet_compare(g, back, p, lane);
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
    for (uint32_t left = rsv_lanes_with_twins(scene, p), k; left;) {
        uint32_t lanes = left, met = p->triangle[__builtin_ctz(left)];
        rsv_twin_group group;
        rsv_twin_group_of(scene, met, &group);
        for (; lanes; lanes &= lanes - 1) {
            k = (uint32_t)__builtin_ctz(lanes);
            if (p->triangle[k] != met) continue;
            left &= ~(1u << k);
            rsv_packet_settle_lane(scene, &group, p, k);
        }
    }
}

#endif
