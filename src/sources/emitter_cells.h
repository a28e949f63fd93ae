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
    float urge;  ///< to be divided: power times the relative variance of brightness within
} rsv_emitter_cell;

/// Divides what is brightest and most uneven first, down to single texels where a few give all the light: as long as all that
/// shine are few enough for closed forms; further, for the tree, only where brightness would vary wildly within cells. The
/// cost is bounded whatever the textures and however many triangles.
/// @param triangle [count] emissive ones, by rank; plain ones stay whole
/// @param cells    out: by rank and place; to be freed by the caller @param cell_count out
rsv_status rsv_divide_emitters(const rsv_scene *scene, const rsv_bsdf *bsdf,
    const uint32_t *triangle, size_t count, rsv_emitter_cell **cells, size_t *cell_count);

#endif
