/// Where a piecewise linear field departs from its elements: the indicator that drives refinement.
#ifndef RSV_BEND_H
#define RSV_BEND_H

#include "elements.h"

/// Called for two cells that share an edge across which `value` bends; at a border both are the same.
/// @param bend how strongly: what is compared with the threshold
typedef void (*rsv_bend_found)(void *user, uint32_t cell, uint32_t other, float bend);

typedef enum rsv_bend_places {
    RSV_BENDS,
    /// Also borders towards which the field rises or falls. In a corner between two surfaces indirect light
    /// follows a fractional power of the distance, so that a slope seen by large cells says that the
    /// steepest part hides in the last one. Edges where smaller cells follow are treated alike, so that
    /// sizes grow slowly away from where light changes.
    RSV_BENDS_AND_BORDERS
} rsv_bend_places;

/// Reports edges across which the luminance of `value` departs from a plane by more than `threshold` of
/// the local level plus `floor`; linear interpolation then errs by about a quarter of that. At borders the
/// field is taken to go on as its mirror image.
/// @param value [node_count]
/// @param deviation [node_count] noise of the luminance: what it explains is no bend; NULL = none
rsv_status rsv_find_bends(const rsv_elements *elements, const rsv_rgb *value,
    const float *deviation, float threshold, float floor, rsv_bend_places places,
    rsv_bend_found found, void *user);

/// Area-weighted mean luminance of a field.
double rsv_elements_mean_luminance(const rsv_elements *elements, const rsv_rgb *value);

#endif
