/// The chain of specular events `S*` between two diffuse surfaces, which is part of the propagation operator G.
/// Followed from receivers (rows of G, probes) and, in the adjoint direction, from lights.
#ifndef RSV_SPECULAR_PATH_H
#define RSV_SPECULAR_PATH_H

#include "specular_walk.h"

typedef enum rsv_specular_end {
    RSV_SPECULAR_ESCAPED,
    RSV_SPECULAR_ABSORBED,
    RSV_SPECULAR_DIFFUSE,
    RSV_SPECULAR_SCATTERED ///< in fog
} rsv_specular_end;

#define RSV_SPECULAR_MAX_EVENTS 256

/// Of a specular path after that many events, which only closed rooms of mirrors have.
#define RSV_SPECULAR_LONG_SURVIVAL 0.999f

/// Whether the path goes on: one that is longer than that plays roulette, so that nothing is lost on average.
RSV_INLINE bool rsv_specular_goes_on(rsv_specular_path *path, rsv_random *random)
{
    if (path->events < RSV_SPECULAR_MAX_EVENTS) return true;
    if (rsv_random_float(random) >= RSV_SPECULAR_LONG_SURVIVAL) return false;
    path->weight = rgb_scale(path->weight, 1 / RSV_SPECULAR_LONG_SURVIVAL);
    return true;
}

/// How the specular path's surface scatters there. @param storage may be used to hold it
RSV_SHARED const rsv_bsdf *rsv_specular_bsdf(
    const rsv_transport_scene *scene, const rsv_specular_path *path, rsv_bsdf *storage);

/// Shading normal (with its normal map) and geometric normal on the side the specular path arrived from.
RSV_SHARED void rsv_specular_normals(const rsv_transport_scene *scene,
    const rsv_specular_path *path, rsv_vec3 *shading, rsv_vec3 *geometric);

/// The same, with the normal for the BSDF: the visible one, unless mirrored light would be lost.
RSV_SHARED const rsv_bsdf *rsv_specular_scattering(const rsv_transport_scene *scene,
    const rsv_specular_path *path, rsv_vec3 *normal, rsv_bsdf *storage);

/// Branch weights at the path's surface. Light past its coverage counts as transmitted straight.
RSV_SHARED rsv_bsdf_branches rsv_specular_branches(
    const rsv_transport_scene *scene, const rsv_specular_path *path);

/// The same at a surface point that is known, with its normal map.
RSV_SHARED rsv_bsdf_branches rsv_specular_branches_at(
    const rsv_transport_scene *scene, const rsv_specular_path *path, const rsv_surface_point *seen);

/// Draws the event at the path's surface. The path may pass beside its coverage (RSV_LOBE_PASS).
RSV_SHARED rsv_bsdf_event rsv_specular_draw_event(
    const rsv_transport_scene *scene, const rsv_specular_path *path, rsv_random *random);

/// Draws among specular events only, without diffuse ones and gaps in coverage; the weight holds their probability.
/// @param u for the lobe and for the direction within it, in [0, 1)
RSV_SHARED rsv_bsdf_event rsv_specular_draw_specular(
    const rsv_transport_scene *scene, const rsv_specular_path *path, const float u[3]);

typedef enum rsv_specular_move {
    RSV_SPECULAR_MOVED,
    RSV_SPECULAR_LEFT_SCENE, ///< direction and weight say how
    RSV_SPECULAR_LOST ///< the direction belongs to the other side of the surface; nothing changed
} rsv_specular_move;

/// Leaves the surface by reflection or transmission and moves to the next one (rsv_specular_depart,
/// rsv_specular_set_out and rsv_specular_arrive in one).
/// @param weight multiplies the throughput
RSV_SHARED rsv_specular_move rsv_specular_step(const rsv_transport_scene *scene,
    rsv_specular_path *path, bool transmit, rsv_vec3 direction, rsv_rgb weight);

/// The same for an event that was drawn and is not diffuse.
RSV_SHARED rsv_specular_move rsv_specular_follow(const rsv_transport_scene *scene,
    rsv_specular_path *path, const rsv_bsdf_event *event, rsv_rgb weight);

/// Result of a gather path: the emission that counts, and where it ended.
typedef struct rsv_gather {
    rsv_specular_end end;
    rsv_specular_path
        path; ///< at the diffuse interface, if end is RSV_SPECULAR_DIFFUSE; its weight is then the
              ///< throughput of radiance, the coat of that interface included
    rsv_vec3
        place; ///< in the fog, if end is RSV_SPECULAR_SCATTERED; the path's weight is then its throughput
    rsv_rgb emission; ///< radiance emitted towards the receiver by the surfaces met
} rsv_gather;

/// Roulette: divides by the largest channel after having survived with that probability.
bool rsv_specular_survives(rsv_rgb *weight, rsv_random *random);

/// Whether to count emission of a surface hit after `turns` specular events (rsv_specular_path.turns).
typedef bool (*rsv_emission_filter)(const void *user, uint32_t triangle, uint32_t turns);

/// Called at the end of each segment after the first. @param from where it began @param left_scene it has no end
typedef void (*rsv_specular_visitor)(
    void *user, const rsv_specular_path *path, bool left_scene, rsv_vec3 from);

/// Receives the segments of a gather path; `visit` NULL = none.
typedef struct rsv_specular_witness {
    rsv_specular_visitor visit;
    void *user;
} rsv_specular_witness;

/// Follows a gather path to its diffuse end, drawing events by their probability. After Russian roulette, weights are
/// only colours: a colourless path keeps weight 1.
rsv_gather rsv_specular_gather(const rsv_transport_scene *scene, rsv_specular_path path,
    rsv_random *random, rsv_emission_filter filter, const void *user);

/// A path that is at no surface yet. @param medium that it runs through; NULL = the air @param direction unit, that it
/// came along
rsv_specular_path rsv_specular_in_air(
    const rsv_transport_scene *scene, const rsv_medium *medium, rsv_vec3 direction);

/// The emission to count.
typedef struct rsv_emission_wanted {
    rsv_emission_filter filter;
    const void *user;
} rsv_emission_wanted;

/// The same with a witness of its segments; NULL = none.
rsv_gather rsv_specular_gather_seen(const rsv_transport_scene *scene, rsv_specular_path path,
    rsv_random *random, const rsv_emission_wanted *wanted, const rsv_specular_witness *witness);

/// The same for a path that fog has met at a place before it came to any surface (rsv_specular_in_air): it ends there,
/// or is turned and goes on.
rsv_gather rsv_specular_gather_from_fog(const rsv_transport_scene *scene, rsv_specular_path path,
    rsv_vec3 place, rsv_random *random, const rsv_emission_wanted *wanted);

/// The same along a ray that meets nothing, unless there is fog. @param medium that it runs through
rsv_gather rsv_specular_gather_beyond(const rsv_transport_scene *scene, const rsv_medium *medium,
    const rsv_ray *ray, rsv_random *random, const rsv_emission_wanted *wanted);

#if defined(RSV_DEVICE_CODE)
#include "specular_path_body.h"
#endif

#endif
