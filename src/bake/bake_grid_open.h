/// Which patches of a grid can be seen, and which stand in for those that cannot.
#ifndef RSV_BAKE_GRID_OPEN_H
#define RSV_BAKE_GRID_OPEN_H

#include "bake_grid_light.h"
#include "bake_open.h"

typedef struct rsv_bake_grid_open {
    rsv_context *context;
    const rsv_light_view *s;
    const rsv_bake_grid *grid;
    rsv_bake_cover cover;
    size_t count;
    uint16_t *covered; ///< [count] places of each patch, bit by bit
    uint32_t *group;   ///< [count] that of the grid; RSV_NONE = all of the patch is covered
    /// [count] the nearest patch in the open of the same group, steps counted along rows and columns; itself, if it is
    /// one; RSV_NONE where there is no patch
    uint32_t *stand_in;
} rsv_bake_grid_open;

/// Every other patch of every other row looks around; near those that are covered all do, from all of their places.
rsv_status rsv_bake_grid_open_create(
    const rsv_light_view *solution, const rsv_bake_grid *grid, rsv_bake_grid_open *open);
void rsv_bake_grid_open_destroy(rsv_bake_grid_open *open);

/// Gives patches that are covered the light of those that stand in for them.
void rsv_bake_grid_open_fill(const rsv_bake_grid_open *open, rsv_rgb *light);

#endif
