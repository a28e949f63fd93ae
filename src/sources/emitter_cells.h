/// How triangles of textured brightness are divided into emitters.
#ifndef RSV_EMITTER_CELLS_H
#define RSV_EMITTER_CELLS_H

#include "lights.h"

/// A cell of a triangle.
typedef struct rsv_emitter_cell {
    uint32_t rank;  ///< of the triangle
    uint32_t place; ///< as in rsv_emitter
    uint8_t level;
    float power; ///< luminance flux, W
    float urge;  ///< priority of division: power times the relative variance of brightness inside
} rsv_emitter_cell;

/// Divides the brightest and most uneven triangles first, down to single texels if a few of them give all the light. It
/// continues while the emitting cells are few enough for closed forms, and beyond that, for the tree, only where
/// brightness varies strongly within cells. The cost is bounded for any textures and any number of triangles.
/// @param triangle [count] emissive triangles, by rank; untextured ones stay whole
/// @param cells    out: by rank and position; freed by the caller
/// @param cell_count out
rsv_status rsv_divide_emitters(const rsv_scene *scene, const rsv_bsdf *bsdf,
    const uint32_t *triangle, size_t count, rsv_emitter_cell **cells, size_t *cell_count);

#endif
