/// The map of one receiver, in 128 bytes: luminance on 8 x 8, 4 x 4 and 2 x 2 cells of its hemisphere (core/hemisphere.h),
/// the mean of all, and on 4 x 4 cells, as eyes are less keen to it, how far colour departs from that of the mean.
///
/// Coarser cells are means of the finer ones by projected solid angle: what a wide lobe sees of them. Codes are square
/// roots of shares of the largest luminance: light that is a hundredth of that keeps two digits.
#ifndef RSV_DIRECTIONAL_MAP_H
#define RSV_DIRECTIONAL_MAP_H

#include "../core/core.h"
#include "../operator/row_directions.h"

#define RSV_MAP_LEVELS 3
#define RSV_MAP_LUMA (64 + 16 + 4)
#define RSV_MAP_CHROMA 16
#define RSV_MAP_CHROMA_RANGE 2.0f ///< largest departure

typedef struct rsv_directional_map {
    float scale;                ///< the largest luminance, in RGB; 0 = black
    uint8_t luma[RSV_MAP_LUMA]; ///< level by level: Y = (code / 255)^2
    /// Co / 2 and Cg, less those of the mean per luminance: 2 (code / 127)^2 with the sign of the code
    int8_t chroma[RSV_MAP_CHROMA][2];
    int16_t mean[3];    ///< Y, Co / 2, Cg: code / 32767
    uint8_t tangent[2]; ///< of the frame of its cells, octahedral
} rsv_directional_map;

_Static_assert(sizeof(rsv_directional_map) == 128, "two lines of the cache");

/// Y, Co / 2 and Cg of a cell, linear in red, green and blue, times a weight, and that.
typedef float rsv_cell4 __attribute__((vector_size(16)));

/// Cells of all levels, finest first, and the mean.
typedef struct rsv_map_cells {
    rsv_cell4 cell[RSV_MAP_LUMA + 4];
} rsv_map_cells;

RSV_INLINE rsv_cell4 rsv_cell_of(rsv_rgb c)
{
    return (rsv_cell4){ 0.25f * (c.r + 2 * c.g + c.b), 0.25f * (c.r - c.b),
        0.25f * (2 * c.g - c.r - c.b), 0 };
}

RSV_INLINE rsv_rgb rsv_rgb_of_cell(float luma, float orange, float green)
{
    return rgb(luma + 2 * orange - green, luma + green, luma - 2 * orange - green);
}

/// Chroma per luminance. @param luma, chroma of the mean
RSV_INLINE float rsv_map_ratio(int16_t luma, int16_t chroma)
{
    return (float)chroma / f_max((float)luma, 1);
}

/// Fills all but the tangent.
/// @param cells of the finest level: radiance, and the share of each in the projected solid angle as its weight; those of
/// weight 0 get what is around them. The others are scratch
void rsv_directional_map_pack(rsv_map_cells *cells, rsv_directional_map *map);

#endif
