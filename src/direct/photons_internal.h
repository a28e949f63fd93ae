/// Photons of a scene's sources, for shooting them all (photons.c) and for keeping their paths (photon_log.c).
#ifndef RSV_PHOTONS_INTERNAL_H
#define RSV_PHOTONS_INTERNAL_H

#include "../core/team.h"
#include "direct_constants.h"
#include "photon_path.h"
#include "photons.h"

struct rsv_photon_shooter {
    const rsv_transport_scene *scene;
    const rsv_lights *lights;
    rsv_photon_origins origins;
    rsv_photon_source source[OWN_GUIDES + 1];
    size_t source_count;
    rsv_shooting shooting;
    const rsv_photon_sink *sink;
    rsv_team_place place; ///< in the team whose processes take turns with chunks
};

/// Empty maps. @param targets maps must be zeroed
rsv_status rsv_photon_maps_create(
    const rsv_photon_shooter *shooter, const rsv_photon_targets *targets);

/// Call it once all photons have landed.
void rsv_photon_maps_finish(const rsv_photon_targets *targets);

#endif
