/// Sources as a receiver sees them (light.h).
#ifndef RSV_LOCAL_LIGHTS_BODY_H
#define RSV_LOCAL_LIGHTS_BODY_H

#include "local_lights.h"

RSV_SHARED void rsv_lights_at(
    const rsv_lights *lights, rsv_vec3 point, rsv_vec3 normal, rsv_local_lights *local)
{
    rsv_weigh_lights(lights, point, normal, false, local);
}

RSV_SHARED void rsv_lights_about(
    const rsv_lights *lights, rsv_vec3 point, rsv_vec3 normal, rsv_local_lights *local)
{
    rsv_weigh_lights(lights, point, normal, true, local);
}

RSV_SHARED bool rsv_local_lights_sample(
    const rsv_local_lights *local, float u_select, float u1, float u2, rsv_light_sample *sample)
{
    if (!rsv_draw_light(local, u_select, u1, u2, sample)) return false;
    if (sample->emitter != RSV_NONE && local->lights->emitter[sample->emitter].varies)
        sample->radiance = rsv_emitter_radiance(
            local->lights, sample->emitter, sample->back, sample->u, sample->v);
    return true;
}

// ---- densities ----------------------------------------------------------------------------------

RSV_INLINE double rsv_selection_probability(const rsv_local_lights *local, uint32_t entry)
{
    if (entry < local->count) return local->probability[entry];
    if (!local->lights->emitter_tree) return 0;
    return local->tree_share * rsv_light_tree_probability(local->lights->emitter_tree, local->point,
                                   local->normal, entry - local->count);
}

/// Entry among lights->sampled[first..end), which ascend, that holds `emitter`, or RSV_NONE.
RSV_INLINE uint32_t rsv_find_between(
    const rsv_lights *lights, size_t first, size_t end, uint32_t emitter)
{
    size_t low = first, high = end;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (lights->sampled[middle] < emitter)
            low = middle + 1;
        else
            high = middle;
    }
    return low < end && lights->sampled[low] == emitter ? (uint32_t)low : RSV_NONE;
}

/// Entry of lights->sampled that holds `emitter`, or RSV_NONE.
RSV_INLINE uint32_t rsv_find_sampled(const rsv_lights *lights, uint32_t emitter)
{
    uint32_t weighed = rsv_find_between(lights, 0, lights->weighed_count, emitter);
    if (weighed != RSV_NONE) return weighed;
    return rsv_find_between(lights, lights->weighed_count, lights->sampled_count, emitter);
}

RSV_SHARED float rsv_local_lights_sky_pdf(const rsv_local_lights *local, rsv_vec3 direction)
{
    const rsv_environment_light *environment = local->lights->environment;
    if (!environment || !(v3_dot(direction, local->normal) > 0)) return 0;
    return local->probability[local->count + environment->sun_count] *
           rsv_sky_pdf(&environment->sampler, direction);
}

RSV_SHARED float rsv_local_lights_sun_pdf(
    const rsv_local_lights *local, uint32_t k, rsv_vec3 direction)
{
    const rsv_sun *sun = &local->lights->environment->sun[k];
    if (v3_dot(direction, sun->direction) < sun->cos_radius) return 0;
    return local->probability[local->count + k] / sun->solid_angle;
}

RSV_SHARED float rsv_local_lights_pdf(
    const rsv_local_lights *local, uint32_t emitter, rsv_vec3 direction, float distance)
{
    uint32_t entry = rsv_find_sampled(local->lights, emitter);
    if (entry == RSV_NONE || !(v3_dot(direction, local->normal) > 0)) return 0;
    double probability = rsv_selection_probability(local, entry);
    rsv_triangle_view view;
    if (!(probability > 0) ||
        !rsv_view_emitter(&local->lights->emitter[emitter], local->point, &view))
        return 0;
    return (float)(probability * rsv_triangle_pdf(&view, direction, distance));
}

#endif
