/// Where a piecewise linear field departs from its elements: the indicator that drives refinement.
#ifndef RSV_CURVATURE_H
#define RSV_CURVATURE_H

#include "elements.h"

/// A field whose curvature is looked for.
typedef struct rsv_curvature_field {
    const rsv_rgb *value; ///< [node_count]
    const float *
        deviation; ///< [node_count] noise of the luminance, which does not count as curvature; NULL = none
    float threshold; ///< share of the local level from which curvature is reported ...
    float floor;     ///< ... which is raised by so much
    const uint8_t
        *cells; ///< [cell_count] 0 = ignore the edges of this cell; NULL = use all
} rsv_curvature_field;

/// Called for two cells that share an edge across which `value` curves; at a border both are the same.
/// @param curvature compared with the threshold
typedef void (*rsv_curved_edge_found)(void *user, uint32_t cell, uint32_t other, float curvature);

typedef enum rsv_curved_edges {
    RSV_CURVED_EDGES,
    /// Also borders towards which the field rises or falls. In a corner between two surfaces, indirect light follows a
    /// fractional power of the distance, so a slope across large cells means that the steepest part is inside the last
    /// one. Edges next to smaller cells are treated in the same way, so that sizes grow slowly away from where light
    /// changes.

    RSV_CURVED_EDGES_AND_BORDERS
} rsv_curved_edges;

/// Reports edges across which the luminance departs from a plane by more than the threshold; linear interpolation then
/// errs by about a quarter of that. At borders the field is taken to go on as its mirror image.
rsv_status rsv_find_curved_edges(const rsv_elements *elements, const rsv_curvature_field *field,
    rsv_curved_edges places, rsv_curved_edge_found found, void *user);

/// Area-weighted mean luminance of a field.
double rsv_elements_mean_luminance(const rsv_elements *elements, const rsv_rgb *value);

#endif
