/// Light of many patches that lie side by side in grids: texels of a map, or points of triangles (bake_lattice.h).
///
/// Few shadow rays at first; more where those of a patch and its neighbours do not agree, as many as the wanted error takes;
/// then noise that is left is filtered out (bake_filter.h).
#ifndef RSV_BAKE_GRID_LIGHT_H
#define RSV_BAKE_GRID_LIGHT_H

#include "bake_direct.h"

typedef struct rsv_bake_accuracy {
    float error;   ///< wanted of the median patch, relative
    float largest; ///< deviation, relative, beyond which a patch gets more rays
    float dark;    ///< W/m2 beside which errors are measured
    uint32_t seed;
} rsv_bake_accuracy;

typedef struct rsv_bake_grid {
    uint32_t width, height;
    const uint32_t
        *group; ///< [height * width] patches of one group lie on one surface; RSV_NONE = no patch
    uint32_t pilot_samples; ///< shadow rays of each half at first
    const void *user;
    /// @param patch out @return what its random numbers depend on
    uint32_t (*patch)(const void *user, size_t index, rsv_bake_patch *patch);
} rsv_bake_grid;

/// Patches that nobody sees (bake_open.h) get the light of the nearest one of their group in the open.
/// @param light out: [height * width]; 0 where there is no patch
/// @param stand_in out: [height * width] the patch whose light each has: itself, if it is in the open; NULL = not asked for
rsv_status rsv_bake_light_grid(const rsv_light_view *solution, const rsv_bake_grid *grid,
    const rsv_bake_accuracy *accuracy, rsv_rgb *light, uint32_t *stand_in);

#endif
