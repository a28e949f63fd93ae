#include "passage.h"

#include "ray.h"
#include "tracer_internal.h"

float rsv_tracer_passed(const rsv_tracer *tracer, const rsv_ray *ray)
{
    if (!rsv_tracer_occluded(tracer, ray)) return 1;
    return rsv_tracer_head_of(tracer)->blended
               ? rsv_pass_blended(
                     tracer, rsv_scene_get_view(rsv_tracer_head_of(tracer)->scene), *ray)
               : 0;
}

static rsv_ray ray_of_lane(const rsv_ray_packet *p, uint32_t k, float t_max)
{
    return (rsv_ray){ v3(p->origin_x[k], p->origin_y[k], p->origin_z[k]),
        v3(p->direction_x[k], p->direction_y[k], p->direction_z[k]), t_max };
}

void rsv_tracer_passed_packet(
    const rsv_tracer *tracer, rsv_ray_packet *packet, bool coherent, float *passed)
{
    const rsv_scene_view *scene = rsv_scene_get_view(rsv_tracer_head_of(tracer)->scene);
    float t_max[RSV_PACKET_WIDTH];
    for (uint32_t k = 0; k < RSV_PACKET_WIDTH; k++)
        t_max[k] = packet->t_max[k];
    rsv_tracer_occluded_packet(tracer, packet, coherent);
    for (uint32_t k = 0; k < RSV_PACKET_WIDTH; k++) {
        passed[k] = packet->t_max[k] > 0;
        if (!rsv_tracer_head_of(tracer)->blended || passed[k] > 0 || !(t_max[k] > 0)) continue;
        passed[k] = rsv_pass_blended(tracer, scene, ray_of_lane(packet, k, t_max[k]));
        if (passed[k] > 0) packet->t_max[k] = t_max[k];
    }
}
