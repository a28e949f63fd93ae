/// The sources of one light: for shadow rays and photons, and in bins for rows that leave the scene.
#ifndef RSV_LIGHT_SOURCES_H
#define RSV_LIGHT_SOURCES_H

#include "../sources/fog_lights.h"
#include "../sources/light_subset.h"
#include "world.h"

typedef struct rsv_light_sources {
    rsv_context *context;
    uint32_t references; ///< holders
    rsv_lights *lights;
    rsv_fog_lights fog_lights;       ///< of those, where the scene has fog
    rsv_rgb *bin_radiance;           ///< [RSV_ESCAPE_BINS] of the surroundings
    struct rsv_light_sources *whole; ///< that these are some of; NULL = these are all
    rsv_environment_light
        *environment; ///< of their own, in place of that of the whole; NULL = none
} rsv_light_sources;

/// The sources of a world, divided into gathered and sampled ones.
/// @param like lights of the same scene whose division is used; NULL = choose the best
rsv_status rsv_light_sources_create(
    const rsv_world *world, const rsv_lights *like, rsv_light_sources **sources);

/// Some of the sources by themselves. Bins are those of the whole. @param source [count]
rsv_status rsv_light_sources_select(
    rsv_light_sources *whole, const rsv_source *source, size_t count, rsv_light_sources **sources);

/// The environment alone, with another rotation: degrees as in rsv_environment.
rsv_status rsv_light_sources_turn(
    rsv_light_sources *whole, const rsv_scene *scene, float rotation, rsv_light_sources **sources);

rsv_light_sources *rsv_light_sources_retain(rsv_light_sources *sources);
void rsv_light_sources_release(rsv_light_sources *sources); ///< NULL is allowed

#endif
