/// Uncertainty of a solution's stored light, and its effect on a reading: the part that all readings share, which their
/// randomisations cannot show.
///
/// Nodes are computed independently, except caustics with few photons. The deviation of a field from planes across the
/// edges of its cells therefore shows both the noise of nodes and the curvature that interpolation misses: for four
/// nodes with variance v, that deviation has the variance 4 v.
#ifndef RSV_STORED_NOISE_H
#define RSV_STORED_NOISE_H

#include "../solve/light.h"

/// Variance of the luminance of a field that elements hold.
typedef struct rsv_field_noise {
    rsv_rgb *node; ///< [node_count] r: the variance, constrained; NULL = not known
    float *cell;   ///< [cell_count] as the cell's own edges show it
} rsv_field_noise;

typedef struct rsv_stored_noise {
    const rsv_light_view *solution;
    rsv_rgb *
        stored; ///< [node_count] r: variance of the luminance of indirect and gathered light; constrained
    rsv_field_noise caustic; ///< of the caustic level
    rsv_field_noise direct;  ///< of direct light, on the elements that hold it
    double coarse;    ///< area-weighted mean of the variance of everything on the coarse elements
    double light;     ///< area-weighted mean of the luminance of indirect and gathered light
    double reflected; ///< light after further reflections over that of the first: rho / (1 - rho)
    double nodes;     ///< that share it
} rsv_stored_noise;

/// @param direct whether direct light is looked up too
rsv_status rsv_stored_noise_create(
    const rsv_light_view *solution, bool direct, rsv_stored_noise *noise);
void rsv_stored_noise_destroy(rsv_stored_noise *noise);

/// Variance of the luminance of lookups at a point.
/// @param caustic of the caustic only
double rsv_stored_noise_at(
    const rsv_stored_noise *noise, uint32_t face, float u, float v, bool caustic);

/// Sums over all rays of one reading. A reading that gets the share a of its light from node j has the variance sum a^2
/// v: nodes are dealt out to a few sums with random signs, which have the same expectation (Charikar, Chen and
/// Farach-Colton 2002).
#define RSV_NOISE_SUMS 256

typedef struct rsv_shared_noise {
    float stored[RSV_NOISE_SUMS], caustic[RSV_NOISE_SUMS];
    double all;   ///< shares of all nodes
    double light; ///< luminance of the reading that they bring
} rsv_shared_noise;

/// A ray that ends at a surface.
typedef struct rsv_stored_lookup {
    uint32_t face;
    float u, v;
    float share; ///< luminance of the reading by that of the surface's light
    float light; ///< luminance that is stored there
} rsv_stored_lookup;

void rsv_shared_noise_add(
    rsv_shared_noise *sums, const rsv_stored_noise *noise, const rsv_stored_lookup *found);

/// Variance of the reading's luminance.
double rsv_shared_noise_variance(const rsv_shared_noise *sums, const rsv_stored_noise *noise);

#endif
