#include "mover.h"

#include "../core/stratified.h"
#include "../trace/packet.h"
#include "../trace/passage.h"

float rsv_mover_passed(const rsv_mover *m, const rsv_ray *ray)
{
    rsv_ray turned = { rsv_mover_point_back(m, ray->origin), rsv_mover_turn_back(m, ray->direction),
        ray->t_max };
    return rsv_tracer_passed(m->tracer, &turned);
}

// ---- visibility of the object --------------------------------------------------------------------

static void turn_rays(const rsv_mover *m, const rsv_ray_packet *from, rsv_ray_packet *to)
{
    for (int k = 0; k < RSV_PACKET_WIDTH; k++) {
        rsv_vec3 origin =
            rsv_mover_point_back(m, v3(from->origin_x[k], from->origin_y[k], from->origin_z[k]));
        rsv_vec3 direction = rsv_mover_turn_back(
            m, v3(from->direction_x[k], from->direction_y[k], from->direction_z[k]));
        to->origin_x[k] = origin.x, to->origin_y[k] = origin.y, to->origin_z[k] = origin.z;
        to->direction_x[k] = direction.x;
        to->direction_y[k] = direction.y;
        to->direction_z[k] = direction.z;
        to->t_min[k] = to->time[k] = 0;
        to->t_max[k] = from->t_max[k];
        to->mask[k] = UINT32_MAX;
        to->id[k] = to->flags[k] = 0;
    }
}

uint32_t rsv_mover_meet(const rsv_mover *m, const rsv_ray_packet *packet, rsv_ray_packet *body)
{
    uint32_t met = 0;
    turn_rays(m, packet, body);
    rsv_tracer_closest_packet(m->tracer, body, true);
    for (uint32_t k = 0; k < RSV_PACKET_WIDTH; k++)
        met |= (uint32_t)(packet->t_max[k] > 0 && body->triangle[k] != RSV_NONE) << k;
    return met;
}

rsv_rgb rsv_mover_shown(const rsv_mover *m, const rsv_ray_packet *p, uint32_t k)
{
    if (rsv_packet_meets_back(p, k)) return rgb_gray(0);
    const uint32_t *corner = m->body->triangle[p->triangle[k]];
    rsv_rgb irradiance = rgb_scale(m->irradiance[corner[0]], 1 - p->u[k] - p->v[k]);
    irradiance = rgb_mad(irradiance, p->u[k], m->irradiance[corner[1]]);
    irradiance = rgb_mad(irradiance, p->v[k], m->irradiance[corner[2]]);
    rsv_rgb albedo = m->albedo[m->body->triangle_material[p->triangle[k]]];
    return rgb_scale(rgb_mul(albedo, irradiance), 1 / RSV_PI);
}

// ---- light from sources ---------------------------------------------------------------------------

static float ratio(float exact, float sampled) { return sampled > 0 ? exact / sampled : 1; }

/// Number of stratified samples that guarantees at least one in the closed forms.
#define FEWEST_KNOWN 2

/// Emitters, suns and sky. Where their unshadowed light is known in closed form, samples are scaled to it.
static uint32_t aim_at_emitters(const rsv_receiver *receiver, const rsv_entrance *entrance,
    const rsv_local_lights *local, uint32_t samples, uint32_t stream, rsv_next_event *event)
{
    uint32_t count = 0;
    rsv_rgb open = rgb_gray(0);
    for (uint32_t k = 0; k < samples; k++) {
        float u[3] = { rsv_stratified_1d(k, samples, rsv_hash2(stream, 1)), 0, 0 };
        rsv_stratified_2d(k, samples, rsv_hash2(stream, 2), &u[1], &u[2]);
        rsv_next_event_draw(receiver, entrance, local, u, &event[count]);
        open = rgb_add(open, event[count].open);
        count += rsv_next_event_asks(&event[count]);
    }
    // if there are few samples, all may belong to the tree, and a ratio would lose the others
    if (local->tree_share > 0 && (1 - local->tree_share) * (float)samples < FEWEST_KNOWN)
        return count;
    rsv_rgb scale = rgb(ratio(local->unshadowed.r, open.r), ratio(local->unshadowed.g, open.g),
        ratio(local->unshadowed.b, open.b));
    for (uint32_t k = 0; k < count; k++)
        if (event[k].known) event[k].light = rgb_mul(event[k].light, scale);
    return count;
}

uint32_t rsv_mover_aim(const rsv_mover *m, const rsv_receiver *receiver, uint32_t samples,
    uint32_t stream, rsv_next_event *event)
{
    const rsv_lights *lights = m->solution->lights;
    const rsv_medium outside = { .depth = 0 };
    rsv_entrance entrance = rsv_entrance_through(&outside, m->solution->bsdf, RSV_COVER_NONE);
    uint32_t count = 0;
    if (rsv_lights_any_sampled(lights)) {
        rsv_local_lights local;
        rsv_receiver_weigh(receiver, lights, &local);
        entrance.weight = rgb_gray(1 / (float)samples);
        count = aim_at_emitters(receiver, &entrance, &local, samples, stream, event);
        entrance.weight = rgb_gray(1);
    }
    float u = rsv_unit_float(rsv_hash2(stream, 3));
    for (uint32_t k = 0; k < rsv_punctual_count(lights) && count < RSV_MOST_AIMED; k++) {
        rsv_next_event_punctual(receiver, &entrance, lights, k, u, &event[count]);
        count += rsv_next_event_asks(&event[count]);
    }
    return count;
}

/// Two balls share a direction if their middles, as seen, are no farther apart than their angular radii together.
bool rsv_mover_may_shade(const rsv_mover *m, rsv_vec3 point)
{
    if (!m->lamps_bounded) return true;
    rsv_vec3 to = v3_sub(m->ball.centre, point), way = v3_sub(m->lamps.centre, point);
    float near = v3_length(to), far = v3_length(way);
    if (near <= m->ball.radius || far <= m->lamps.radius) return true;
    if (near - m->ball.radius > far + m->lamps.radius) return false;
    float sine = m->ball.radius / near, lamp_sine = m->lamps.radius / far;
    float cosine = sqrtf(1 - sine * sine), lamp_cosine = sqrtf(1 - lamp_sine * lamp_sine);
    float widest = cosine * lamp_cosine - sine * lamp_sine;
    return v3_dot(to, way) >= (widest - 1e-5f) * near * far; // 1e-5: rounding
}

/// Whether all of the object lies behind a surface.
static bool is_behind(const rsv_mover *m, const rsv_surface_point *point)
{
    return v3_dot(v3_sub(m->ball.centre, point->position), point->geometric) < -m->ball.radius;
}

/// Whether a ray passes the object's ball: most do.
static bool misses_ball(const rsv_mover *m, const rsv_ray *ray)
{
    rsv_vec3 to = v3_sub(m->ball.centre, ray->origin);
    float along = v3_dot(to, ray->direction) / v3_dot(ray->direction, ray->direction);
    rsv_vec3 apart = v3_mad(to, -f_max(along, 0), ray->direction);
    return v3_length(apart) > 1.001f * m->ball.radius;
}

rsv_rgb rsv_mover_shadow(const rsv_mover *m, const rsv_receiver *receiver, uint32_t stream)
{
    rsv_rgb kept = rgb_gray(0);
    const rsv_surface_point *point = &receiver->point;
    if (is_behind(m, point) || !rsv_mover_may_shade(m, point->position)) return kept;
    rsv_next_event event[RSV_MOST_AIMED];
    uint32_t samples = (m->desc.light_samples + 3) / 4;
    uint32_t count = rsv_mover_aim(m, receiver, samples, stream, event);
    for (uint32_t k = 0; k < count; k++) {
        if (misses_ball(m, &event[k].ray)) continue;
        float lost = 1 - rsv_mover_passed(m, &event[k].ray);
        if (lost > 0) lost *= rsv_next_event_passed(m->solution->tracer, &event[k]);
        kept = rgb_mad(kept, lost, event[k].light);
    }
    return kept;
}
