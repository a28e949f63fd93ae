/// The surroundings as octahedral maps, each texel of one the mean of four of the next finer: light averaged over about any
/// solid angle at the cost of one lookup.
#ifndef RSV_SKY_MAP_H
#define RSV_SKY_MAP_H

#include "highlight.h"

#define RSV_SKY_LEVELS 12

typedef struct rsv_sky_map {
    rsv_rgb *texel; ///< all levels, the finest first; NULL = black
    size_t first[RSV_SKY_LEVELS];
    uint32_t side, levels;
} rsv_sky_map;

/// Without suns. @param side of the finest level; a power of two is made of it
rsv_status rsv_sky_map_create(
    const rsv_lights *lights, rsv_highlight_part part, uint32_t side, rsv_sky_map *map);

/// Mean radiance over about `solid_angle` around unit `direction`.
rsv_rgb rsv_sky_map_mean(const rsv_sky_map *map, rsv_vec3 direction, float solid_angle);

/// Radiance towards the eye from the surroundings, without occlusion.
rsv_rgb rsv_sky_map_light(const rsv_sky_map *map, const rsv_highlight_lobes *lobes);

/// Directions that stand for a lobe, of equal shares.
#define RSV_LOBE_TAPS 8

/// Direction k of a lobe in its frame, and the density there.
rsv_vec3 rsv_lobe_tap(const rsv_highlight_lobe *lobe, uint32_t k, float *density);

#endif
