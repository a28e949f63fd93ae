#include "occlusion_view.h"

#include "../trace/packet.h"

#include <string.h>

#define LANES RSV_PACKET_WIDTH

void rsv_see_surfaces(const rsv_occlusion_job *job, uint32_t count, const float *x, const float *y,
    rsv_seen_surface *seen)
{
    const rsv_occlusion_setting *s = &job->shared->setting;
    rsv_ray_packet packet = { 0 };
    memset(packet.mask, 0xff, sizeof packet.mask);
    for (uint32_t k = 0; k < LANES; k++) {
        uint32_t place = k < count ? k : 0;
        rsv_ray ray = rsv_lens_ray(&job->lens, x[place], y[place]);
        ray.t_max = k < count ? INFINITY : -1;
        rsv_packet_set_ray(&packet, k, ray);
    }
    rsv_tracer_closest_packet(job->shared->tracer, &packet, true);
    for (uint32_t k = 0; k < count; k++) {
        rsv_vec3 direction =
            v3(packet.direction_x[k], packet.direction_y[k], packet.direction_z[k]);
        if (packet.triangle[k] != RSV_NONE)
            seen[k] = rsv_seen_surface_at(
                s, direction, packet.triangle[k], packet.u[k], packet.v[k], true);
        else
            seen[k] = rsv_seen_sky(s, direction);
    }
}
