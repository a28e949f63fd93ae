/// Selects the cells of a triangle's quadtree to divide so that light is linear between corners, within the tolerance.
#ifndef RSV_BAKE_CELLS_H
#define RSV_BAKE_CELLS_H

#include "bake_lattice.h"
#include "bake_tessellate.h"

typedef struct rsv_bake_cells {
    const rsv_light_view *s;
    const rsv_bake_part *part;
    const rsv_bake_lattices *lattices; ///< of it
    const rsv_bake_tessellation *desc;
    uint8_t *split; ///< of the quadtree at hand, in the order of a heap
    uint32_t t;     ///< triangle at hand
    int depth;      ///< of its quadtree
} rsv_bake_cells;

/// Cells of a quadtree that can be divided: length of `split`.
#define RSV_BAKE_CELLS (((size_t)1 << 2 * RSV_BAKE_DEEPEST) / 3 + 1)

/// Finds `split` and `depth` of triangle `t`.
void rsv_bake_cells_decide(rsv_bake_cells *cells);

rsv_bake_receiver rsv_bake_cells_receiver(const rsv_bake_cells *cells, float w1, float w2);
/// A second position for reading a corner's light: slightly towards the centre (m1, m2) of its cell, on the right side
/// of jumps; if it is hidden, that of its substitute.
rsv_bake_receiver rsv_bake_cells_pulled(
    const rsv_bake_cells *cells, float w1, float w2, float m1, float m2);
/// Irradiance there.
rsv_rgb rsv_bake_cells_light(const rsv_bake_cells *cells, float w1, float w2);
/// Whether two lights differ by no more than a share.
bool rsv_bake_cells_agree(const rsv_bake_cells *cells, rsv_rgb a, rsv_rgb b, float tolerance);

#endif
