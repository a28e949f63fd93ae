/// Pictures as planes of one number per pixel, with a margin, so that windows and tiles need no limits.
#ifndef RSV_DENOISE_PLANES_H
#define RSV_DENOISE_PLANES_H

#include "../core/parallel.h"
#include "../core/vec.h"
#include "denoise.h"

/// Pixels are processed in tiles, whose width is that of vectors many times over.
#define TILE_WIDTH 64
#define TILE_HEIGHT 16
#define MARGIN 12 ///< at least a window's radius and a patch's

typedef struct rsv_plane_grid {
    rsv_context *context;
    uint32_t width, height;
    size_t stride, rows; ///< with margins, in whole tiles
} rsv_plane_grid;

rsv_plane_grid rsv_plane_grid_of(rsv_context *context, uint32_t width, uint32_t height);

static inline size_t rsv_plane_size(const rsv_plane_grid *grid)
{
    return grid->stride * grid->rows;
}

/// Index of a pixel.
static inline size_t rsv_plane_place(const rsv_plane_grid *grid, size_t x, size_t y)
{
    return (y + MARGIN) * grid->stride + x + MARGIN;
}

/// The pixel of the picture that stands at a place of a plane: in margins, the nearest one.
static inline size_t rsv_plane_source(const rsv_plane_grid *grid, size_t column, size_t row)
{
    size_t x = column < MARGIN ? 0 : column - MARGIN, y = row < MARGIN ? 0 : row - MARGIN;
    if (x >= grid->width) x = grid->width - 1;
    if (y >= grid->height) y = grid->height - 1;
    return y * grid->width + x;
}

/// Zeroed planes, one after the other; to be freed.
float *rsv_planes_create(const rsv_plane_grid *grid, size_t count);

/// Runs `body` for rows 0 <= y < rows on all workers.
void rsv_for_plane_rows(const rsv_plane_grid *grid, size_t rows,
    void (*body)(const void *job, size_t y), const void *job);

#endif
