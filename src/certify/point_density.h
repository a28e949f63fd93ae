/// Random points on everything that has an irradiance: a share of them uniform in area, the others where they matter.
///
/// The points of a mean square must lie where its integrand is. With density q, and p = 1 / area, a point counts with the
/// weight w = p / q: expectations are those of points uniform in area, whatever the indicator says, and as q holds
/// a share of p, no weight exceeds 1 / share.
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

/// Half of the points by area; a quarter by area x E~^2 as the solution's finest elements hold it, for errors are a share of
/// the light that is there, and a small bright spot may hold most of it; a quarter by the variance that stored light shows
/// (render/stored_noise.h), and where something stands on cells or close beside them.
rsv_status rsv_point_density_of_light(const rsv_light_view *solution, rsv_point_density *density);

void rsv_point_density_destroy(rsv_point_density *density);

/// Point `index` of `count`, one in each of as many strips of equal chance. Different seeds are independent.
/// @param weight out: p / q there
rsv_face_point rsv_point_density_draw(const rsv_point_density *density, uint32_t index,
    uint32_t count, uint32_t seed, double *weight);

#endif
