/// Pictures at rest: a transition from reused light to that of paths, without a jump.
///
/// While the camera rests, some pixels of each frame are also rendered by a whole random path, which is unbiased but
/// noisy. The differences from the frame are summed up for pixels and for squares of 2, 4, ... 32 pixels, and of tiles.
/// The mean difference of the whole picture corrects all of it. Then each square takes over the correction of the
/// larger one, plus a fraction of what its own samples say beyond that: s^2 / (s^2 + v / n), which minimises the error
/// if squares of that size differ by s and the mean of n samples has the variance v / n (Wiener filter). Both s and v
/// are estimated over 4x4 squares. Finally, each pixel is corrected by its own samples.
///
/// Paths go where they are needed: to blocks of 4x4 pixels in proportion to the standard deviation of their samples,
/// relative to the displayed light (Neyman allocation).
#ifndef RSV_RESTING_H
#define RSV_RESTING_H

#include "../core/sampling.h"
#include "../core/vec.h"

#define RSV_RESTING_SIDE 32 ///< pixels of a tile
#define RSV_RESTING_PIXELS (RSV_RESTING_SIDE * RSV_RESTING_SIDE)
#define RSV_RESTING_BLOCKS 64     ///< of 4x4 pixels in a tile
#define RSV_RESTING_BLOCK_PATHS 4 ///< of a block in a frame at most

/// Whole paths of a frame in one tile.
typedef struct rsv_resting_paths {
    float radiance[RSV_RESTING_BLOCKS * RSV_RESTING_BLOCK_PATHS][4];
    uint16_t pixel[RSV_RESTING_BLOCKS * RSV_RESTING_BLOCK_PATHS]; ///< within the tile
    uint16_t open
        [RSV_RESTING_BLOCKS]; ///< pixels, a bit each, that may differ: not all they show is stored
    uint32_t count;
} rsv_resting_paths;

/// A square of pixels: sums over its samples.
typedef struct rsv_resting_node {
    float difference[4]; ///< of paths from frames: red, green, blue; weights of samples
    float square;        ///< of the luminance of each
    float weight_square;
    float shown;  ///< luminance of the pixels that may differ
    float pixels; ///< number of those
} rsv_resting_node;

/// Correction of a square by the larger squares around it.
typedef struct rsv_resting_given {
    float correction[3];
    float
        variance; ///< of one difference within squares of that size, relative to the square of the displayed light
    float shown; ///< mean luminance where the correction comes from
} rsv_resting_given;

/// Standard deviations of paths in a tile's blocks, relative to the displayed light; 0 where nothing can differ.
typedef float rsv_resting_noise[RSV_RESTING_BLOCKS];

/// Differences between paths and frames of a tile: sums over its samples.
typedef struct rsv_resting_tile {
    float difference[RSV_RESTING_PIXELS][4]; ///< as in rsv_resting_node
    float square[RSV_RESTING_PIXELS], weight_square[RSV_RESTING_PIXELS];
    uint16_t open[RSV_RESTING_BLOCKS];  ///< pixels that may differ, in any frame
    uint32_t turns[RSV_RESTING_BLOCKS]; ///< pixels whose turn it was
    float due[RSV_RESTING_BLOCKS];      ///< share of the next path
    rsv_resting_noise noise;
    float rate;      ///< paths of a block and frame, over its noise
    uint32_t frames; ///< so far
    rsv_resting_node sum;
    rsv_resting_given given;
} rsv_resting_tile;

/// Begins a tile's sums. @param seed of its own
void rsv_resting_begin(rsv_resting_tile *tile, uint32_t seed);

/// Paths that a block takes in this frame.
uint32_t rsv_resting_turns(rsv_resting_tile *tile, uint32_t block);

/// Pixel of a block of 4x4 whose turn it is. @param seed of the block's own
uint32_t rsv_resting_lane(rsv_resting_tile *tile, uint32_t block, uint32_t seed);

/// Adds the differences of a frame. @param radiance [RSV_RESTING_PIXELS] of the frame at these places
void rsv_resting_add(
    rsv_resting_tile *tile, const rsv_resting_paths *paths, const float (*radiance)[4]);

/// Corrects the displayed light. @param shown [RSV_RESTING_PIXELS] mean radiance of all frames, in and out
void rsv_resting_correct(const rsv_resting_tile *tile, float (*shown)[4]);

/// The same, and notes the tile's sums and noise for rsv_resting_share.
void rsv_resting_update(rsv_resting_tile *tile, float (*shown)[4]);

/// Corrections of each tile by squares of several tiles, and its number of paths, after all have their sums.
/// @param tile [across * down]
/// @param node [2 * across * down + 64] scratch memory @param given the same size
void rsv_resting_share(rsv_resting_tile *tile, uint32_t across, uint32_t down,
    rsv_resting_node *node, rsv_resting_given *given);

#endif
