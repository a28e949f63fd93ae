/// Some sources of light by themselves, all others switched off.
#ifndef RSV_LIGHT_SUBSET_H
#define RSV_LIGHT_SUBSET_H

#include "lights.h"

typedef enum rsv_source_kind {
    RSV_SOURCE_MATERIAL, ///< everything with an emissive material
    RSV_SOURCE_LIGHT,    ///< a punctual light
    RSV_SOURCE_SURROUNDINGS
} rsv_source_kind;

typedef struct rsv_source {
    rsv_source_kind kind;
    uint32_t index; ///< of the material or light
    const char *name;
    const char *
        node; ///< node that placed the light, as a name for it alone if several share one; NULL = none
} rsv_source;

/// The sources of a scene: materials first, then lights, then the environment. @param sources out; freed by the caller
rsv_status rsv_list_sources(const rsv_lights *lights, rsv_source **sources, size_t *count);

/// The parts of some sources that next-event estimation, light tracing and probes find. Borrows from `lights`.
/// @param source [count]
rsv_status rsv_light_subset_create(
    const rsv_lights *lights, const rsv_source *source, size_t count, rsv_lights **subset);
void rsv_light_subset_destroy(rsv_lights *subset);

/// Lets the same emitters be found by gathering as in `like`, lights of the same scene at other strengths.
rsv_status rsv_lights_gather_like(rsv_lights *lights, const rsv_lights *like);

/// Lets materials be found by gathering, or not. @param source, gathered [count] those of other kinds are skipped
rsv_status rsv_lights_gather_sources(
    rsv_lights *lights, const rsv_source *source, const bool *gathered, size_t count);

/// Whether a material emits and is found by gathering.
bool rsv_is_gathered(const rsv_lights *lights, uint32_t material);

/// Mean fraction, 0..1, of the hemispheres above the scene's surfaces that a material's emission fills, as in
/// rsv_emitter_group.share.
double rsv_emission_share(const rsv_lights *lights, uint32_t material);

#endif
