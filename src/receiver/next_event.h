/// Next-event estimation: draws a point on a source for a receiver, and weights the light that a shadow ray finds
/// unblocked. Callers supply random numbers and take means. Also for device code.
#ifndef RSV_NEXT_EVENT_H
#define RSV_NEXT_EVENT_H

#include "../sources/punctual_light.h"
#include "../trace/ray.h"
#include "receiver.h"

/// A sampled source: the shadow ray to it, and the sample's weight.
typedef struct rsv_next_event {
    rsv_ray ray; ///< t_max -1 = no ray is needed
    rsv_rgb
        open; ///< f / p by closed forms, visible or not; 0 if they do not cover the source
    rsv_rgb light; ///< f / p that is received if the way is free
    bool known;    ///< to closed forms: not a punctual light, nor chosen by the tree
} rsv_next_event;

RSV_INLINE void rsv_next_event_clear(rsv_next_event *event)
{
    event->ray = rsv_ray_to(v3(0, 0, 0), v3(0, 0, 0), -1);
    event->open = rgb_gray(0);
    event->light = rgb_gray(0);
    event->known = false;
}

/// Response of a surface to light from one direction.
typedef struct rsv_response {
    rsv_rgb share; ///< that enters it, or that a lobe scatters
    float factor;  ///< besides: the cosine, or the weight against draws by the lobe
} rsv_response;

/// A diffuse surface's.
RSV_INLINE rsv_response rsv_response_diffuse(const rsv_entrance *e, float cos)
{
    rsv_response response;
    response.share = rsv_entrance_share(e, cos);
    response.factor = cos;
    return response;
}

/// The sources as the receiver sees them.
RSV_INLINE void rsv_receiver_weigh(
    const rsv_receiver *r, const rsv_lights *lights, rsv_local_lights *local)
{
    rsv_lights_at(lights, r->point.position, r->point.normal, local);
}

/// The event of a place that was drawn, above the receiver's horizon.
RSV_INLINE void rsv_next_event_at_place(const rsv_receiver *r, const rsv_entrance *e,
    const rsv_lights *lights, const rsv_light_sample *sample, rsv_response response,
    rsv_next_event *event)
{
    rsv_rgb arriving = rgb_mul(rsv_entrance_weight(e, sample->distance), sample->radiance);
    if (!e->medium->depth)
        arriving = rgb_mul(arriving,
            rsv_air_transmittance(lights, r->point.position, sample->direction, sample->distance));
    event->light =
        rgb_mul(rgb_scale(arriving, response.factor / sample->pdf_solid_angle), response.share);
    event->ray =
        rsv_shadow_ray(lights, sample, r->point.position, rsv_receiver_start(r, sample->direction));
}

/// The event of a place that was drawn for a diffuse receiver.
RSV_INLINE void rsv_next_event_diffuse(const rsv_receiver *r, const rsv_entrance *e,
    const rsv_lights *lights, const rsv_light_sample *sample, rsv_next_event *event)
{
    float cos = v3_dot(r->point.normal, sample->direction);
    rsv_next_event_clear(event);
    event->known = rsv_light_sample_is_weighed(sample);
    event->open =
        rgb_scale(rgb_mul(e->weight, sample->mean_radiance), cos / sample->pdf_solid_angle);
    // directions below the geometric surface count as blocked
    if (rsv_surface_faces(&r->point, sample->direction))
        rsv_next_event_at_place(r, e, lights, sample, rsv_response_diffuse(e, cos), event);
}

/// Draws a place on an emitter or a sun, or in the sky, for a diffuse receiver.
/// @param local of the receiver @param u for the choice of a source and for the place on it, in [0, 1)
RSV_INLINE void rsv_next_event_draw(const rsv_receiver *r, const rsv_entrance *e,
    const rsv_local_lights *local, const float u[3], rsv_next_event *event)
{
    rsv_light_sample sample;
    if (rsv_local_lights_sample(local, u[0], u[1], u[2], &sample))
        rsv_next_event_diffuse(r, e, local->lights, &sample, event);
    else
        rsv_next_event_clear(event);
}

/// The event of a punctual light above the receiver's horizon.
RSV_INLINE void rsv_next_event_at_light(const rsv_receiver *r, const rsv_entrance *e,
    const rsv_lights *lights, const rsv_punctual_sample *light, rsv_response response,
    rsv_next_event *event)
{
    rsv_rgb arriving = rgb_mul(rsv_entrance_weight(e, light->distance), light->irradiance);
    if (!e->medium->depth)
        arriving = rgb_mul(arriving,
            rsv_air_transmittance(lights, r->point.position, light->direction, light->distance));
    event->light = rgb_mul(rgb_scale(arriving, response.factor), response.share);
    event->ray = rsv_punctual_ray(light, rsv_receiver_start(r, light->direction));
}

/// The k-th punctual light (rsv_punctual_at) for a diffuse receiver. @param u in [0, 1), the same for all k
RSV_INLINE void rsv_next_event_punctual(const rsv_receiver *r, const rsv_entrance *e,
    const rsv_lights *lights, uint32_t k, float u, rsv_next_event *event)
{
    const rsv_surface_point *point = &r->point;
    rsv_punctual_sample light;
    rsv_next_event_clear(event);
    if (!rsv_punctual_at(lights, point->position, point->normal, k, u, &light) ||
        !rsv_surface_faces(point, light.direction))
        return;
    float cos = v3_dot(point->normal, light.direction);
    rsv_next_event_at_light(r, e, lights, &light, rsv_response_diffuse(e, cos), event);
}

RSV_INLINE bool rsv_next_event_asks(const rsv_next_event *event) { return event->ray.t_max > 0; }

/// Share of the event's light that arrives.
RSV_INLINE float rsv_next_event_passed(const rsv_tracer *tracer, const rsv_next_event *event)
{
    return rsv_next_event_asks(event) ? rsv_ray_passed(tracer, &event->ray) : 0;
}

/// The same for up to RSV_PACKET_WIDTH events. @param passed [RSV_PACKET_WIDTH] out
void rsv_next_events_passed(
    const rsv_tracer *tracer, const rsv_next_event *event, uint32_t count, float *passed);

/// Irradiance on a diffuse receiver from all punctual lights, with one shadow ray each. @param rays out: number of rays
rsv_rgb rsv_punctual_irradiance_at(const rsv_receiver *receiver, const rsv_entrance *entrance,
    const rsv_lights *lights, const rsv_tracer *tracer, float u, uint64_t *rays);

// ---- sums -----------------------------------------------------------------------------------------

/// Sums over events. Light partly transmitted by blended surfaces counts as visible in that proportion.
typedef struct rsv_event_sums {
    rsv_rgb open;          ///< f / p of light that closed forms cover, visible or not
    rsv_rgb visible;       ///< f / p of those of them that are visible, as it is received
    rsv_rgb further;       ///< the same for emitters chosen by a tree, which `open` does not include
    float further_squared; ///< luminance
    /// Luminance of `visible` that is partly blocked, times the fraction lost.
    float veiled;
    uint32_t seen, hidden; ///< numbers of events in `open`
} rsv_event_sums;

RSV_INLINE rsv_event_sums rsv_event_sums_zero(void)
{
    rsv_event_sums sums;
    sums.open = sums.visible = sums.further = rgb_gray(0);
    sums.further_squared = sums.veiled = 0;
    sums.seen = sums.hidden = 0;
    return sums;
}

/// @param passed share of the event's light that arrives
RSV_INLINE void rsv_event_sums_add(rsv_event_sums *sums, const rsv_next_event *event, float passed)
{
    bool seen = passed > 0;
    sums->open = rgb_add(sums->open, event->open);
    sums->seen += seen && event->known;
    sums->hidden += !seen && event->known;
    if (!seen) return;
    rsv_rgb arriving = rgb_scale(event->light, passed);
    if (event->known) {
        sums->visible = rgb_add(sums->visible, arriving);
        sums->veiled += (1 - passed) * rgb_luminance(arriving);
        return;
    }
    float luminance = rgb_luminance(arriving);
    sums->further = rgb_add(sums->further, arriving);
    sums->further_squared += luminance * luminance;
}

RSV_INLINE rsv_event_sums rsv_event_sums_merge(rsv_event_sums a, rsv_event_sums b)
{
    a.open = rgb_add(a.open, b.open);
    a.visible = rgb_add(a.visible, b.visible);
    a.further = rgb_add(a.further, b.further);
    a.further_squared += b.further_squared;
    a.veiled += b.veiled;
    a.seen += b.seen;
    a.hidden += b.hidden;
    return a;
}

#endif
