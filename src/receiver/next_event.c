#include "next_event.h"

#include "../trace/packet.h"

#include <string.h>

void rsv_next_events_passed(
    const rsv_tracer *tracer, const rsv_next_event *event, uint32_t count, float *passed)
{
    rsv_ray_packet packet;
    memset(&packet, 0, sizeof packet);
    memset(packet.mask, 0xff, sizeof packet.mask);
    for (uint32_t k = 0; k < RSV_PACKET_WIDTH; k++) {
        if (k < count && rsv_next_event_asks(&event[k]))
            rsv_packet_set_ray(&packet, k, event[k].ray);
        else
            packet.t_max[k] = -1;
    }
    rsv_tracer_passed_packet(tracer, &packet, true, passed);
}

rsv_rgb rsv_punctual_irradiance_at(const rsv_receiver *receiver, const rsv_entrance *entrance,
    const rsv_lights *lights, const rsv_tracer *tracer, float u, uint64_t *rays)
{
    rsv_rgb sum = rgb_gray(0);
    for (uint32_t k = 0; k < rsv_punctual_count(lights); k++) {
        rsv_next_event event;
        rsv_next_event_punctual(receiver, entrance, lights, k, u, &event);
        *rays += rsv_next_event_asks(&event);
        float passed = rsv_next_event_passed(tracer, &event);
        if (passed > 0) sum = rgb_mad(sum, passed, event.light);
    }
    return sum;
}
