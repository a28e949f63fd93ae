/// Origins of photons: groups of emitters that are not gathered, punctual lights and suns.
#ifndef RSV_PHOTON_ORIGIN_H
#define RSV_PHOTON_ORIGIN_H

#include "../core/alias_table.h"
#include "../elements/elements.h"
#include "../sources/lights.h"
#include "../specular/specular_path.h"

typedef enum rsv_origin_kind { RSV_ORIGIN_GROUP, RSV_ORIGIN_LIGHT, RSV_ORIGIN_SUN } rsv_origin_kind;

typedef struct rsv_photon_origin {
    rsv_origin_kind kind;
    uint32_t index;
    double flux;       ///< luminance, W
    float probability; ///< of being drawn among the origins that share a source
    rsv_medium medium; ///< around it
} rsv_photon_origin;

typedef struct rsv_photon_origins {
    const rsv_transport_scene *scene;
    const rsv_lights *lights;
    rsv_photon_origin *origin; ///< [count] the strongest first
    size_t count;
    rsv_alias_entry
        *origin_table; ///< [count] by flux within each run of origins that share a source
    rsv_alias_entry *emitter_table; ///< [emitter_count] by power within each group
    rsv_vec3 centre;                ///< of the scene's bounding sphere
    float radius;
} rsv_photon_origins;

/// A photon as it leaves.
typedef struct rsv_photon_emission {
    rsv_vec3 origin, direction;
    rsv_rgb flux; ///< of all origins that share the source if they all sent it like this: W
    const rsv_medium *medium;
} rsv_photon_emission;

/// @param own the first `own` origins are sources of their own, all others share one
rsv_status rsv_photon_origins_create(const rsv_transport_scene *scene, const rsv_lights *lights,
    size_t own, rsv_photon_origins *origins);
void rsv_photon_origins_destroy(rsv_photon_origins *origins);

/// A photon of one of the origins [first, first + count), which must share a source.
/// @param x,y in the unit square: its direction
RSV_SHARED rsv_photon_emission rsv_photon_emit(const rsv_photon_origins *origins, uint32_t first,
    uint32_t count, float x, float y, rsv_random *random);

#if defined(RSV_DEVICE_CODE)
#include "photon_origin_body.h"
#endif

#endif
