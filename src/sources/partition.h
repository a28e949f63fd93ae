/// Which estimator counts which source: each path from a source to a receiver is counted once. Elements, pixels,
/// probes, frames, residuals and devices follow this table; the path tracer weights its own estimators instead.
///
/// | way from the source to the receiver | lamps, suns, sampled sky, punctual lights | gathered lamps and sky |
/// |---|---|---|
/// | straight, also through blended surfaces (trace/passage.h) | shadow rays (rsv_local_lights_sample) | gather rays |
/// | through specular surfaces, `turns` of them | photons; for the sampled sky, gather rays | gather rays |
///
/// Elements of the air store photons, as those of surfaces do (direct/photon_air.h). For receivers without photons,
/// such as probes and surfaces that store none, gather rays find that part too.
#ifndef RSV_PARTITION_H
#define RSV_PARTITION_H

#include "lights.h"

/// Whether a gather ray counts the emission of a triangle that it comes to.
/// @param turns of its specular path so far (rsv_specular_path.turns) @param by_photons photons bring their part to
/// this receiver
RSV_INLINE bool rsv_gathering_counts(
    const rsv_lights *lights, uint32_t triangle, uint32_t turns, bool by_photons)
{
    uint32_t emitter = lights->triangle_emitter[triangle];
    if (emitter == RSV_NONE) return false;
    const rsv_emitter_group *group = &lights->group[lights->emitter[emitter].group];
    return !group->muted && (group->gathered || (turns > 0 && !by_photons));
}

/// The environment as found by a gather ray that leaves the scene.
RSV_INLINE rsv_rgb rsv_gathering_sky(
    const rsv_lights *lights, rsv_vec3 direction, uint32_t turns, bool by_photons)
{
    const rsv_environment_light *environment = lights->environment;
    if (!environment) return rgb_gray(0);
    if (turns == 0) return rsv_sky_radiance(&environment->gathered, direction);
    return by_photons ? rsv_environment_light_sunless(environment, direction)
                      : rsv_sky_radiance(&environment->whole, direction);
}

#endif
