/// Movers as frames see them.
#ifndef RSV_MOVER_H
#define RSV_MOVER_H

#include "../receiver/next_event.h"
#include "../render/probe_grid.h"
#include "resolvent/mover.h"
#include "resolvent/trace.h"

/// A sphere.
typedef struct rsv_ball {
    rsv_vec3 centre;
    float radius;
} rsv_ball;

struct rsv_mover {
    rsv_context *context;
    const rsv_light_view *solution;
    const rsv_scene_view *body;
    rsv_tracer *tracer; ///< of the body, at its position in its scene
    rsv_mover_desc desc;
    rsv_probe_grid grid; ///< without light straight from sources
    rsv_rgb *irradiance; ///< [vertex_count]
    rsv_rgb *albedo;     ///< [material_count]
    rsv_vec3 middle;     ///< that it turns about
    rsv_vec3 offset;     ///< from its position in its scene, in the coordinates of the solution's scene
    rsv_vec3 base;       ///< part of it due to the two scenes' origins
    float sine, cosine;  ///< of the turn
    rsv_ball ball;       ///< around it, in the world
    rsv_ball lamps;      ///< around all sources
    bool lamps_bounded;  ///< false: some are infinitely far away
};

/// Between the world and the body's scene; lengths are kept.
RSV_INLINE rsv_vec3 rsv_mover_turn(const rsv_mover *m, rsv_vec3 d)
{
    return v3(m->cosine * d.x + m->sine * d.z, d.y, m->cosine * d.z - m->sine * d.x);
}

RSV_INLINE rsv_vec3 rsv_mover_turn_back(const rsv_mover *m, rsv_vec3 d)
{
    return v3(m->cosine * d.x - m->sine * d.z, d.y, m->cosine * d.z + m->sine * d.x);
}

RSV_INLINE rsv_vec3 rsv_mover_point_back(const rsv_mover *m, rsv_vec3 p)
{
    rsv_vec3 from_middle = v3_sub(p, v3_add(m->middle, m->offset));
    return v3_add(rsv_mover_turn_back(m, from_middle), m->middle);
}

float rsv_mover_passed(const rsv_mover *mover, const rsv_ray *ray);

/// Hits of a packet's rays on the object before their ends. @param body scratch
/// @return lanes that hit it, one bit each; the hits are in `body`
uint32_t rsv_mover_meet(const rsv_mover *mover, const rsv_ray_packet *packet, rsv_ray_packet *body);

/// Radiance of the object at a hit of rsv_mover_meet.
rsv_rgb rsv_mover_shown(const rsv_mover *mover, const rsv_ray_packet *body, uint32_t lane);

#define RSV_MOST_AIMED 192

/// Samples all sources. @param samples of emitters, suns and sky @param event [RSV_MOST_AIMED] out, with the rays to
/// trace
/// @return number of events
uint32_t rsv_mover_aim(const rsv_mover *mover, const rsv_receiver *receiver, uint32_t samples,
    uint32_t stream, rsv_next_event *event);

/// Whether the object may lie between a point and some lamp.
bool rsv_mover_may_shade(const rsv_mover *mover, rsv_vec3 point);

/// Irradiance that the object keeps from a point of the scene's surfaces.
rsv_rgb rsv_mover_shadow(const rsv_mover *mover, const rsv_receiver *receiver, uint32_t stream);

#endif
