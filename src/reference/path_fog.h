/// How a path of the reference crosses fog: free flights, and light of sources that is scattered on the way.
///
/// On a segment from o along d, channels with extinction sigma, albedo a and throughput w scatter at distance s with density
///
///     pdf(s) = density(s) sum_c p_c a_c sigma_c exp(-sigma_c column(s)),   p_c = w_c / sum w,
///
/// the mixture over channels that spectral multiple importance sampling asks for (Wilkie et al. 2014); else the path goes
/// on to the segment's end. Absorption is a weight and ends no path. Light of a source at x that is scattered once at s is
/// found by three techniques, combined by the power heuristic over (s, direction):
///
/// - the path's own place s and direction, if it comes to x;
/// - the path's own place, with x drawn from there;
/// - x drawn by power for the whole segment, and s by equiangular sampling about it (Kulla and Fajardo 2012).
#ifndef RSV_PATH_FOG_H
#define RSV_PATH_FOG_H

#include "../media/fog_run.h"
#include "../sources/fog_lights.h"

struct rsv_light_path;

/// Where a path was scattered in fog, and all that the techniques' densities follow from.
typedef struct rsv_fog_vertex {
    bool is_last;     ///< the path's last event was this one
    rsv_vec3 origin;  ///< of the segment that led here
    rsv_vec3 forward; ///< its unit direction
    rsv_fog_run run;
    rsv_rgb share;   ///< p_c
    double distance; ///< along it
    double pdf;      ///< per metre, of this distance
    rsv_vec3 point;
    rsv_fog_choice choice; ///< of lights as the point sees them
} rsv_fog_vertex;

typedef enum rsv_fog_outcome {
    RSV_FOG_PASSED,    ///< goes on to the end of the segment
    RSV_FOG_SCATTERED, ///< has a new ray
    RSV_FOG_ABSORBED
} rsv_fog_outcome;

/// Takes a path along its ray through the fog, up to `length` metres; adds what the fog emits and scatters of sources.
rsv_fog_outcome rsv_path_cross_fog(struct rsv_light_path *path, float length);

/// Weight of the emission that a path has come to after it was scattered in fog.
float rsv_fog_emission_weight(const struct rsv_light_path *path, uint32_t emitter, rsv_vec3 place);
/// Of the surroundings likewise.
float rsv_fog_sky_weight(const struct rsv_light_path *path, rsv_vec3 direction);

/// What the fog of the scene leaves of light over `distance` metres from a point in the air; all without fog.
rsv_rgb rsv_path_fog_transmittance(
    const rsv_fog *fog, rsv_vec3 point, rsv_vec3 direction, float distance);

#endif
