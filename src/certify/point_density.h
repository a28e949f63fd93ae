/// Random points on everything that has an irradiance: a fraction of them uniform in area, the others where they
/// matter.
///
/// For a mean square, points should be where the integrand is large. With density q, and p = 1 / area, a point has the
/// weight w = p / q. Expectations are those of points uniform in area, whatever the indicator. Because q contains a
/// fraction of p, no weight exceeds 1 / fraction.
#ifndef RSV_POINT_DENSITY_H
#define RSV_POINT_DENSITY_H

#include "../solve/light.h"
#include "surface_points.h"

/// A mixture over cells, uniform within each.
typedef struct rsv_point_density {
    const rsv_elements *
        elements; ///< whose cells they are, borrowed; their faces are those of all elements of a solution
    double area;   ///< of all cells, m2
    double *below; ///< [cell_count + 1] chances of the cells before each
} rsv_point_density;

/// How much a cell matters per area, 0 or more. Called by several threads.
typedef double (*rsv_cell_indicator)(const void *user, uint32_t cell);

/// @param even_share of the points that are uniform in area, in (0, 1]; all are where the indicator is 0 everywhere
rsv_status rsv_point_density_create(const rsv_elements *elements, double even_share,
    rsv_cell_indicator indicator, const void *user, rsv_point_density *density);

/// Half of the points are uniform in area. A quarter are by area x E~^2 on the solution's finest elements, because
/// errors are proportional to light, and a small bright spot may have most of it. A quarter are by the variance visible
/// in stored light (render/stored_noise.h), and at cells with contacts.
rsv_status rsv_point_density_of_light(const rsv_light_view *solution, rsv_point_density *density);

void rsv_point_density_destroy(rsv_point_density *density);

/// Point `index` of `count`, one in each of as many strips of equal chance. Different seeds are independent.
/// @param weight out: p / q there
rsv_face_point rsv_point_density_draw(const rsv_point_density *density, uint32_t index,
    uint32_t count, uint32_t seed, double *weight);

#endif
