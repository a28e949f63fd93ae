/// Caustics: light paths shot from the sources through at least one specular event to the first diffuse
/// interface (paths D S+ L), the adjoint of gathering.
#ifndef RSV_PHOTONS_H
#define RSV_PHOTONS_H

#include "../elements/elements.h"
#include "../sources/lights.h"
#include "../specular/specular_path.h"
#include "photon_map.h"

/// Whether the scene has anything that could cast a caustic, lit by a source that is not gathered.
bool rsv_photons_wanted(const rsv_transport_scene *scene, const rsv_lights *lights);

/// Receiver of photons. It gets every surface that one reaches after a specular event.
typedef struct rsv_photon_sink {
    void *user;
    /// Several threads may call it. @param slot whose photons these are: one thread at a time works for a slot, in an
    /// order that does not depend on the number of threads; below rsv_photon_slots @param flux W
    void (*land)(void *user, size_t slot, const rsv_specular_path *path, rsv_rgb flux);
    /// Called by the calling thread once all slots have had a few photons, and again after the next ones; may be NULL.
    /// @param slots number of slots with photons, which must be merged in ascending order
    void (*collect)(void *user, size_t slots);
    /// NULL, or whether a photon that lands there is of any use, as far as is known: most go where many are.
    bool (*wants)(void *user, const rsv_specular_path *path);
    /// Called for every segment through fog after a specular event, as `land` is; may be NULL. @param flux W, at the
    /// ray's start
    void (*cross)(void *user, const rsv_ray *ray, rsv_rgb flux);
} rsv_photon_sink;

/// Slots that sinks with `collect` have to serve.
size_t rsv_photon_slots(const rsv_context *context);

/// Shoots `count` light paths, guided towards directions in which each source sees specular surfaces that pass its
/// light on. Unbiased: the guide never excludes a direction.
rsv_status rsv_photons_trace(const rsv_transport_scene *scene, const rsv_lights *lights,
    uint32_t count, uint32_t seed, const rsv_photon_sink *sink, uint64_t *rays);

/// Where photons start, and a guide from each place: for more than one call of rsv_photons_deposit or rsv_photons_send.
typedef struct rsv_photon_shooter rsv_photon_shooter;

/// @param scene,lights borrowed until it is destroyed
/// @param sink whose needs guides follow during this call. NULL = every photon is useful
rsv_status rsv_photon_shooter_create(const rsv_transport_scene *scene, const rsv_lights *lights,
    uint32_t seed, const rsv_photon_sink *sink, rsv_photon_shooter **shooter, uint64_t *rays);
/// @param shooter NULL is allowed
void rsv_photon_shooter_destroy(rsv_photon_shooter *shooter);

/// Shoots `count` light paths, as rsv_photons_trace does, by guides that are there already.
rsv_status rsv_photons_send(const rsv_photon_shooter *shooter, uint32_t count, uint32_t seed,
    const rsv_photon_sink *sink, uint64_t *rays);

/// Sets of elements that photons are deposited on at once.
typedef struct rsv_photon_targets {
    const rsv_elements *const *elements; ///< [count]
    rsv_photon_map *map; ///< [count] out; destroyed by the caller, even after an error
    size_t count;
} rsv_photon_targets;

/// Shoots `count` light paths and deposits them.
rsv_status rsv_photons_deposit(const rsv_photon_shooter *shooter, uint32_t count,
    const rsv_photon_targets *targets, uint64_t *rays);

/// The same with a shooter of its own.
rsv_status rsv_photons_shoot(const rsv_transport_scene *scene, const rsv_lights *lights,
    uint32_t count, uint32_t seed, const rsv_photon_targets *targets, uint64_t *rays);

#endif
