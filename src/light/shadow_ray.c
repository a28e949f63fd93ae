#include "light.h"

rsv_ray rsv_shadow_ray(
    const rsv_lights *lights, const rsv_light_sample *sample, rsv_vec3 point, rsv_vec3 origin)
{
    if (sample->emitter == RSV_NONE) return (rsv_ray){ origin, sample->direction, INFINITY };
    const rsv_emitter *emitter = &lights->emitter[sample->emitter];
    bool front = v3_dot(emitter->normal, sample->direction) < 0;
    rsv_vec3 side = front ? emitter->normal : v3_neg(emitter->normal);
    // the target is reached from the receiver, so the rounding of both ends and of the way enters
    float extent = rsv_triangle_extent(lights->scene, emitter->triangle);
    extent = f_max(f_max(extent, sample->distance), v3_max_abs(point));
    rsv_vec3 target =
        rsv_offset_origin(v3_mad(point, sample->distance, sample->direction), side, extent);
    return (rsv_ray){ origin, v3_sub(target, origin), 1 };
}

rsv_ray rsv_punctual_ray(const rsv_punctual_sample *sample, rsv_vec3 origin)
{
    if (!(sample->distance < INFINITY)) return (rsv_ray){ origin, sample->direction, INFINITY };
    return (rsv_ray){ origin, v3_sub(sample->light->position, origin), 1 };
}
