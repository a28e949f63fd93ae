/// Guides photons towards useful directions: a distribution over the unit square, from which the directions of a
/// source's rays are drawn.
///
/// Its bins form a grid whose lines are close together where there is something to hit: a sun that shines on a
/// landscape finds the window of the only room in it.
#ifndef RSV_PHOTON_GUIDE_H
#define RSV_PHOTON_GUIDE_H

#include "../core/core.h"
#include "../core/sampling.h"

#define RSV_GUIDE_SIDE 64 ///< bins along each side of the square
#define RSV_GUIDE_RAYS 4  ///< pilot rays per bin

/// Lines between the bins, from 0 to 1.
typedef struct rsv_guide_grid {
    float x[RSV_GUIDE_SIDE + 1], y[RSV_GUIDE_SIDE + 1];
} rsv_guide_grid;

typedef struct rsv_photon_guide {
    rsv_guide_grid grid;
    float useful;    ///< mean worth of the source's rays
    float *row_cdf;  ///< [RSV_GUIDE_SIDE]
    float *cell_cdf; ///< [RSV_GUIDE_SIDE * RSV_GUIDE_SIDE], per row
    float *density;  ///< [RSV_GUIDE_SIDE * RSV_GUIDE_SIDE] over the square; nowhere 0
} rsv_photon_guide;

/// Bins of one size.
rsv_guide_grid rsv_guide_grid_even(void);

/// Moves the lines of a grid closer together around the useful bins. False if that is not worth it, because these fill
/// the finer part of the grid.
/// @param useful [RSV_GUIDE_SIDE * RSV_GUIDE_SIDE] sum of the usefulness of each bin's pilot rays
bool rsv_guide_grid_zoom(rsv_guide_grid *grid, const float *useful);

/// @param useful as above, on `grid`
rsv_status rsv_photon_guide_create(
    rsv_context *context, const rsv_guide_grid *grid, const float *useful, rsv_photon_guide *guide);
void rsv_photon_guide_destroy(rsv_context *context, rsv_photon_guide *guide);

/// From the place in a bin to that in the square.
RSV_INLINE float rsv_guide_place(const float *line, float within)
{
    return f_min(line[0] + (line[1] - line[0]) * within, 0x1.fffffep-1f);
}

/// Warps a uniform point of the unit square by the guide, neighbours to neighbours, so that points of a
/// quasi-random set stay spread out. @return the density there
RSV_INLINE float rsv_photon_guide_warp(const rsv_photon_guide *guide, float *x, float *y)
{
    uint32_t row = rsv_invert_cdf(guide->row_cdf, RSV_GUIDE_SIDE, y);
    uint32_t column = rsv_invert_cdf(guide->cell_cdf + row * RSV_GUIDE_SIDE, RSV_GUIDE_SIDE, x);
    *x = rsv_guide_place(guide->grid.x + column, *x);
    *y = rsv_guide_place(guide->grid.y + row, *y);
    return guide->density[row * RSV_GUIDE_SIDE + column];
}

#endif
