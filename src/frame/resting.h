/// Pictures at rest: from reused light to that of paths, without a jump.
///
/// Where the camera rests, some pixels of each frame are shown a second time, by a whole random path: right in the mean,
/// but noisy. How these differ from the frame is summed up for pixels and for squares of 2, 4, ... 32 pixels. Each square
/// corrects what is shown by as much of its mean difference as its standard error allows; in the end each pixel by its own.
#ifndef RSV_RESTING_H
#define RSV_RESTING_H

#include "../core/sampling.h"
#include "../core/vec.h"

#define RSV_RESTING_SIDE 32 ///< pixels of a tile
#define RSV_RESTING_PIXELS (RSV_RESTING_SIDE * RSV_RESTING_SIDE)
#define RSV_RESTING_BLOCKS 64 ///< of 4x4 pixels in a tile: one path each and frame at most

/// Whole paths of a frame in one tile.
typedef struct rsv_resting_paths {
    float radiance[RSV_RESTING_BLOCKS][4];
    uint16_t pixel[RSV_RESTING_BLOCKS]; ///< within the tile
    uint16_t open
        [RSV_RESTING_BLOCKS]; ///< pixels, a bit each, that may differ: not all they show is stored
    uint32_t count;
} rsv_resting_paths;

/// A square of pixels: sums over its samples.
typedef struct rsv_resting_node {
    float difference[4]; ///< of paths from frames: red, green, blue; number of samples
    float square;        ///< of the luminance of each
    float shown;         ///< luminance of the pixels that may differ
    float pixels;        ///< number of those
} rsv_resting_node;

/// What a square takes over from the larger ones that it lies in.
typedef struct rsv_resting_given {
    float correction[3];
    float variance; ///< of one difference
    float shown;    ///< mean luminance where the correction comes from
} rsv_resting_given;

/// Differences between paths and frames of a tile: sums over its samples.
typedef struct rsv_resting_tile {
    float difference[RSV_RESTING_PIXELS][4]; ///< as in rsv_resting_node
    float square[RSV_RESTING_PIXELS];
    uint16_t open[RSV_RESTING_BLOCKS]; ///< pixels that may differ, in any frame
    rsv_resting_node sum;
    rsv_resting_given given;
} rsv_resting_tile;

/// Pixel of a block of 4x4 that takes a path in this frame; -1 = none.
/// @param samples frames so far @param block a number of its own
int rsv_resting_lane(uint32_t samples, uint32_t block);

/// Adds the differences of a frame. @param radiance [RSV_RESTING_PIXELS] what the frame has at these places
void rsv_resting_add(
    rsv_resting_tile *tile, const rsv_resting_paths *paths, const float (*radiance)[4]);

/// Corrects what is shown, and finds the tile's sums. @param shown [RSV_RESTING_PIXELS] mean radiance of all frames, in and out
void rsv_resting_correct(const rsv_resting_tile *tile, float (*shown)[4], rsv_resting_node *sum);

/// What each tile takes over from squares of several, once all have their sums.
/// @param tile [across * down]
/// @param node [2 * across * down + 64] room to work in @param given likewise
void rsv_resting_share(rsv_resting_tile *tile, uint32_t across, uint32_t down,
    rsv_resting_node *node, rsv_resting_given *given);

#endif
