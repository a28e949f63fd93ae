/// Light of many patches in regular grids: texels of a map, or points of triangles (bake_lattice.h).
///
/// It starts with few shadow rays. If those of a patch and its neighbours disagree, more are traced, as many as the
/// target error requires. Then the remaining noise is filtered (bake_filter.h).
#ifndef RSV_BAKE_GRID_LIGHT_H
#define RSV_BAKE_GRID_LIGHT_H

#include "bake_direct.h"

typedef struct rsv_bake_accuracy {
    float error;   ///< target of the median patch, relative
    float largest; ///< deviation, relative, beyond which a patch gets more rays
    float dark;    ///< W/m2, lower limit of the light to which errors are relative
    uint32_t seed;
} rsv_bake_accuracy;

typedef struct rsv_bake_grid {
    uint32_t width, height;
    const uint32_t
        *group; ///< [height * width] patches of one group lie on one surface; RSV_NONE = no patch
    uint32_t pilot_samples; ///< shadow rays of each half at first
    const void *user;
    /// @param patch out @return seed of its random numbers
    uint32_t (*patch)(const void *user, size_t index, rsv_bake_patch *patch);
} rsv_bake_grid;

/// Hidden patches (bake_open.h) get the light of the nearest visible one of their group.
/// @param light out: [height * width]; 0 where there is no patch
/// @param stand_in out: [height * width] the patch whose light each has: itself if it is visible; NULL = not needed
rsv_status rsv_bake_light_grid(const rsv_light_view *solution, const rsv_bake_grid *grid,
    const rsv_bake_accuracy *accuracy, rsv_rgb *light, uint32_t *stand_in);

#endif
