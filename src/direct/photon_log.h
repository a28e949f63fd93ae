/// Photons whose paths are kept while surfaces of the scene move: only those that a motion may have met are shot again.
#ifndef RSV_PHOTON_LOG_H
#define RSV_PHOTON_LOG_H

#include "../update/scene_change.h"
#include "photons.h"

/// The paths and landings of all photons, with the guides that they were shot by.
typedef struct rsv_photon_log rsv_photon_log;

/// Whether photons are worth keeping through a motion. Bodies whose light all goes on, such as those of glass and metal,
/// move away from where guides send photons.
/// @param moved [triangle_count] non-zero = it moved
bool rsv_photons_can_be_kept(const rsv_transport_scene *scene, const uint8_t *moved);

/// Whether kept photons are as many as wanted, of the same seed, in a scene of the same size. @param log NULL = none
bool rsv_photon_log_fits(
    const rsv_photon_log *log, const rsv_transport_scene *scene, uint32_t count, uint32_t seed);

/// Prepares for photons, none of which has been shot.
/// @param scene, lights borrowed until it is destroyed, or until rsv_photon_log_deposit gets others
rsv_status rsv_photon_log_create(const rsv_transport_scene *scene, const rsv_lights *lights,
    uint32_t count, uint32_t seed, rsv_photon_log **log, uint64_t *rays);

/// Shoots the photons that meet boxes around what moved, or all the first time, and deposits all of them.
/// @param rays is increased
rsv_status rsv_photon_log_deposit(rsv_photon_log *log, const rsv_transport_scene *scene,
    const rsv_lights *lights, const rsv_scene_change *change, const rsv_photon_targets *targets,
    uint64_t *rays);

/// @param log NULL is allowed
void rsv_photon_log_destroy(rsv_photon_log *log);

#endif
