/// How paths of the reference cross fog: free flights, and single scattering of light from sources.
///
/// On a segment from o along d, channels with extinction sigma, albedo a and throughput w scatter at distance s with
/// density
///
///     pdf(s) = density(s) sum_c p_c a_c sigma_c exp(-sigma_c column(s)),   p_c = w_c / sum w,
///
/// the mixture over channels of spectral multiple importance sampling (Wilkie et al. 2014); otherwise the path
/// continues to the end of the segment. Absorption is a weight and does not end paths. Three techniques find light from
/// a source at x that is scattered once at s. The power heuristic combines them over (s, direction):
///
/// - the path's own position s and direction, if it reaches x;
/// - the path's own position, with x sampled from there;
/// - x sampled by power for the whole segment, and s by equiangular sampling around it (Kulla and Fajardo 2012).
#ifndef RSV_PATH_FOG_H
#define RSV_PATH_FOG_H

#include "../media/fog_run.h"
#include "../sources/fog_lights.h"

struct rsv_light_path;

/// A scattering event in fog, with everything that determines the densities of the techniques.
typedef struct rsv_fog_vertex {
    bool by_collision; ///< in fog whose density varies: only the first two techniques are used, and `run` is not set
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

/// Follows a path along its ray through the fog, up to `length` metres; adds the fog's emission and single scattering.
rsv_fog_outcome rsv_path_cross_fog(struct rsv_light_path *path, float length);

/// Weight of the emission that a path has come to after it was scattered in fog.
float rsv_fog_emission_weight(const struct rsv_light_path *path, uint32_t emitter, rsv_vec3 place);
/// The same for the environment.
float rsv_fog_sky_weight(const struct rsv_light_path *path, rsv_vec3 direction);

/// What the fog of the scene leaves of light over `distance` metres from a point in the air, or an unbiased estimate of that
/// where its density varies; all without fog.
rsv_rgb rsv_path_fog_transmittance(
    struct rsv_light_path *path, rsv_vec3 point, rsv_vec3 direction, float distance);

/// Turns the path at its vertex, having gathered the sources there.
rsv_fog_outcome rsv_path_turn_in_fog(struct rsv_light_path *path);

#endif
