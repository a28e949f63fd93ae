/// Light on rough lobes from frame to frame: one cell for 2x2 pixels, with each quantity in a separate plane.
///
/// Some cells of a frame trace one ray each (glossy_rays.h). Each cell takes the samples of its neighbours on the same
/// surface, and those stored at its position in the previous frame. Cells that then have few samples search further
/// around. The stored quantity is radiance divided by the albedo of the lobes, which is as smooth as the light.
#ifndef RSV_GLOSSY_CELLS_H
#define RSV_GLOSSY_CELLS_H

#include "../trace/camera_ray.h"
#include "glossy_tile.h"

typedef struct rsv_glossy_geometry {
    float *x, *y, *z;    ///< of a point of the surface
    float *depth;        ///< distance from the eye; 0 = nothing glossy
    float *nx, *ny, *nz; ///< unit normal towards the eye
    float *alpha;        ///< width of the lobes
} rsv_glossy_geometry;

typedef struct rsv_glossy_light {
    float *r, *g, *b;
    float *count; ///< samples that it is the mean of
    float *reach; ///< mean distance that their rays went
} rsv_glossy_light;

/// Planes are [stride * (height + 2 * RSV_GLOSSY_MARGIN)], with empty cells around.
typedef struct rsv_glossy_cells {
    rsv_context *context;
    float *memory; ///< all planes
    size_t floats; ///< of these
    uint32_t width, height, stride;
    size_t first; ///< index of cell (0, 0)
    rsv_glossy_geometry now, before;
    rsv_glossy_light fresh; ///< samples of this frame
    rsv_glossy_light even;  ///< r, g, b: if all light were even
    rsv_glossy_light kept, kept_before;
    rsv_glossy_light shown; ///< r, g, b
    rsv_lens lens, lens_before;
    uint32_t frame;     ///< number of frames so far, which seeds random numbers
    uint32_t poor_turn; ///< frames until a cell of few samples sends a ray again
    float keep;         ///< share of the samples of the frame before that still count
    float most;         ///< samples that count at most
} rsv_glossy_cells;

#define RSV_GLOSSY_MARGIN 4 ///< rows above and below

/// Pixels of a tile as they are kept until the light is known.
typedef struct rsv_glossy_pixels {
    uint16_t albedo[3][RSV_GLOSSY_TILE_PIXELS]; ///< 0..65535 for 0..1
    int16_t normal[3][RSV_GLOSSY_TILE_PIXELS];  ///< -32767..32767
    float depth[RSV_GLOSSY_TILE_PIXELS];
} __attribute__((aligned(64))) rsv_glossy_pixels;

/// @param width, height of the picture, pixels
rsv_status rsv_glossy_cells_create(
    rsv_context *context, uint32_t width, uint32_t height, rsv_glossy_cells *cells);
/// Empty cells for a picture that is no larger than the one they were created for.
void rsv_glossy_cells_resize(rsv_glossy_cells *cells, uint32_t width, uint32_t height);
void rsv_glossy_cells_destroy(rsv_glossy_cells *cells);

/// Before a frame: makes `now` the `before`. @param rests the camera has not moved
void rsv_glossy_cells_begin(rsv_glossy_cells *cells, const rsv_lens *lens, bool rests);

/// Samples below which a cell is poor: it has no similar neighbours, and was not visible before.
#define RSV_GLOSSY_POOR 3.0f

/// After a frame: poor cells take turns as often as a frame can afford. @param poor number of them
void rsv_glossy_cells_pace(rsv_glossy_cells *cells, uint64_t poor);

/// Discards a part of the stored light after a change of light. @param change 0 = none .. 1
void rsv_glossy_cells_forget(rsv_glossy_cells *cells, float change);

/// Pixel of a cell that stands for it, in this frame: column + 2 * row. The next ones stand in for it.
#define RSV_GLOSSY_TURN 8 ///< frames until another one does
RSV_INLINE uint32_t rsv_glossy_speaker(uint32_t frame, uint32_t k)
{
    const uint32_t order[4] = { 0, 3, 1, 2 };
    return order[(frame / RSV_GLOSSY_TURN + k) & 3];
}

#endif
