/// Rough lobes of a tile's pixels, until their light is known.
#ifndef RSV_GLOSSY_TILE_H
#define RSV_GLOSSY_TILE_H

#include "../core/vec.h"

/// Pixels in the order of a tile. Those without a lobe to light have depth 0 and no other valid data.
#define RSV_GLOSSY_TILE_PIXELS 1024
typedef float rsv_glossy_plane[RSV_GLOSSY_TILE_PIXELS];

typedef struct rsv_glossy_tile {
    rsv_glossy_plane depth;     ///< along the camera ray, metres
    rsv_glossy_plane normal[3]; ///< unit, towards the eye
    rsv_glossy_plane albedo[3]; ///< of the lobes, times `passed`
    rsv_glossy_plane passed[3]; ///< share of their light that gets through panes before them
    rsv_glossy_plane alpha;     ///< width of the narrowest
    rsv_glossy_plane even[3];   ///< radiance that the lobes would meet if all were even
    rsv_glossy_plane u, v;      ///< of the hit
    uint32_t triangle[RSV_GLOSSY_TILE_PIXELS];
    uint32_t count; ///< pixels that have one, at least
} __attribute__((aligned(64))) rsv_glossy_tile;

#endif
