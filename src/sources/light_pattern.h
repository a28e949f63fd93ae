/// A fixed set of points on a source, which shadow rays of neighbouring receivers share while the source moves.
#ifndef RSV_LIGHT_PATTERN_H
#define RSV_LIGHT_PATTERN_H

#include "lights.h"

/// Any four or sixteen places in a row (of those that begin at a multiple of that) are spread over the source, and so
/// are all.
#define RSV_PATTERN_PLACES 64
/// With up to this many emitters, Lambert's formula gives the irradiance from each.
#define RSV_PATTERN_POLYGONS 8

/// A place that stands for an equal share of the source's power.
typedef struct rsv_pattern_place {
    rsv_vec3 point, normal; ///< normal unit, of the front
    float area;             ///< that it stands for, m2
    rsv_rgb strength;       ///< mean radiance of its emitter times that area, W/sr
    float extent;           ///< for rsv_offset_origin
    bool double_sided;
} rsv_pattern_place;

typedef struct rsv_light_pattern {
    rsv_pattern_place place[RSV_PATTERN_PLACES];
    const rsv_emitter *polygon[RSV_PATTERN_POLYGONS];
    uint32_t polygons; ///< 0 = too many
    bool any;          ///< there are emitters to sample
} rsv_light_pattern;

/// Of the emitters that next-event estimation samples.
rsv_light_pattern rsv_light_pattern_of(const rsv_lights *lights);

#endif
