/// Free flights: where fog scatters the light of a ray.
///
/// A gather ray ends in the fog with the probability that its light is extinguished there, and otherwise where it would
/// have ended in clear air. The optical depth is drawn for one channel, in proportion to the throughput. The weight is
/// the ratio of each channel's density to that of the mixture (Wilkie et al. 2014), 1 if all channels have the same
/// extinction.
#ifndef RSV_FOG_FLIGHT_H
#define RSV_FOG_FLIGHT_H

#include "../media/fog_run.h"
#include "specular_walk.h"

typedef struct rsv_fog_flight {
    bool lands;
    rsv_vec3 place; ///< where; of a ray that does not land, nowhere
    rsv_rgb weight;
} rsv_fog_flight;

RSV_INLINE bool rsv_fog_is_gray(const rsv_fog *fog)
{
    return fog->extinction.r == fog->extinction.g && fog->extinction.g == fog->extinction.b;
}

/// Fog that scatters and emits nothing only dims, which takes no random number.
RSV_INLINE bool rsv_fog_only_dims(const rsv_fog *fog)
{
    return rgb_is_black(fog->albedo) && rgb_is_black(fog->emission);
}

/// Density of the mixture per that of each channel, turned over.
RSV_INLINE rsv_rgb rsv_fog_mixture_weight(rsv_rgb density, rsv_rgb share)
{
    double mixture = (double)share.r * (double)density.r + (double)share.g * (double)density.g +
                     (double)share.b * (double)density.b;
    return mixture > 0 ? rgb_scale(density, (float)(1 / mixture)) : rgb_gray(0);
}

RSV_INLINE rsv_fog_flight rsv_fog_dim(const rsv_fog *fog, const rsv_fog_run *run)
{
    rsv_fog_flight flight = { false, v3(0, 0, 0), rsv_fog_transmittance(fog, run->column) };
    return flight;
}

/// @param direction unit @param length metres; may be INFINITY @param throughput of the ray so far
/// @param u_channel, u in [0, 1)
RSV_INLINE rsv_fog_flight rsv_fog_fly(
    const rsv_fog *fog, const rsv_ray *ray, rsv_rgb throughput, float u_channel, float u)
{
    rsv_fog_run run = rsv_fog_run_of(fog, ray->origin, ray->direction, ray->t_max);
    rsv_fog_flight flight = { false, v3(0, 0, 0), rgb_gray(1) };
    float sum = throughput.r + throughput.g + throughput.b;
    if (!(run.column > 0) || !(sum > 0)) return flight;
    if (rsv_fog_only_dims(fog)) return rsv_fog_dim(fog, &run);
    rsv_rgb share = rgb_scale(throughput, 1 / sum);
    int c = u_channel < share.r ? 0 : u_channel < share.r + share.g ? 1 : 2;
    double column = rsv_fog_free_column((&fog->extinction.r)[c], u);
    flight.lands = column < run.column;
    if (flight.lands) {
        // before the end of the ray, despite rounding
        double distance = fmin(rsv_fog_find(&run, column), (1 - 1e-5) * (double)ray->t_max);
        flight.place = v3_mad(ray->origin, (float)distance, ray->direction);
    }
    if (rsv_fog_is_gray(fog)) return flight;
    rsv_rgb passed = rsv_fog_transmittance(fog, flight.lands ? column : run.column);
    rsv_rgb density = flight.lands ? rgb_mul(fog->extinction, passed) : passed;
    flight.weight = rsv_fog_mixture_weight(density, share);
    return flight;
}

/// Radiance that the fog emits towards a ray that lands in it: emission per extinction.
RSV_INLINE rsv_rgb rsv_fog_glow(const rsv_fog *fog)
{
    rsv_rgb e = fog->emission, s = fog->extinction;
    return rgb(s.r > 0 ? e.r / s.r : 0, s.g > 0 ? e.g / s.g : 0, s.b > 0 ? e.b / s.b : 0);
}

/// The segment that a specular path has come along, or is about to leave the scene along.
RSV_INLINE rsv_ray rsv_specular_segment(
    const rsv_transport_scene *scene, const rsv_specular_path *path, bool leaves)
{
    rsv_surface_point point =
        rsv_surface_point_at(scene->view, path->triangle, path->u, path->v, path->back);
    rsv_ray ray = { point.position, path->direction, leaves ? INFINITY : path->length };
    if (!leaves) ray.origin = v3_mad(point.position, -path->length, path->direction);
    return ray;
}

/// Attenuates a specular path by the fog on its last segment.
RSV_INLINE void rsv_specular_dim(const rsv_transport_scene *scene, rsv_specular_path *path)
{
    const rsv_fog *fog = scene->view->fog;
    if (!fog || path->medium.depth || !(path->length > 0)) return;
    rsv_ray ray = rsv_specular_segment(scene, path, false);
    rsv_fog_run run = rsv_fog_run_of(fog, ray.origin, ray.direction, ray.t_max);
    path->weight = rgb_mul(path->weight, rsv_fog_transmittance(fog, run.column));
    path->length = 0;
}

/// A direction after one along `forward` by the uneven part of the phase function, whose anisotropy g is not 0.
rsv_vec3 rsv_fog_draw_turn(float g, rsv_vec3 forward, rsv_random *random);

typedef enum rsv_fog_fate {
    RSV_FOG_MEETS,   ///< the path is at a surface
    RSV_FOG_ESCAPES, ///< its direction says how it leaves the scene
    RSV_FOG_LANDS,   ///< where fog scatters light isotropically
    RSV_FOG_ABSORBS
} rsv_fog_fate;

/// Receives each segment in fog of a path that carries light. @param weight of the path at the start of the segment
typedef struct rsv_fog_witness {
    void *user;
    void (*cross)(void *user, const rsv_ray *ray, rsv_rgb weight);
} rsv_fog_witness;

/// Result of a path's segment in fog.
typedef struct rsv_fog_crossing {
    const rsv_fog_witness *witness; ///< NULL = the path gathers light: sources are sampled where it is turned
    rsv_vec3 place; ///< where it lands
    rsv_rgb
        emission; ///< radiance that fog emitted and turned into the path where it did not end it, times its throughput: added to
} rsv_fog_crossing;

/// Follows a specular path through the fog on its last segment; its weight becomes that of the transmitted light. There
/// is no fog in solid bodies.
///
/// The isotropic part of a phase function ends paths, as diffuse reflection does. The directional part turns them, as
/// specular events do, and gathers light straight from sources there.
/// @param leaves whether the path leaves the scene, so that the segment begins at the path's surface
rsv_fog_fate rsv_specular_cross_fog(const rsv_transport_scene *scene, rsv_specular_path *path,
    bool leaves, rsv_random *random, rsv_fog_crossing *crossing);

/// The same for a path at no surface yet (rsv_specular_in_air), along a ray that meets nothing.
rsv_fog_fate rsv_specular_cross_beyond(const rsv_transport_scene *scene, rsv_specular_path *path,
    const rsv_ray *ray, rsv_random *random, rsv_fog_crossing *crossing);

/// The same for a path that fog has met at a place.
rsv_fog_fate rsv_specular_meet_fog(const rsv_transport_scene *scene, rsv_specular_path *path,
    rsv_vec3 place, rsv_random *random, rsv_fog_crossing *crossing);

#endif
