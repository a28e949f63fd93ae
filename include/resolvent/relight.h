/// @file relight.h
/// Other lights and colours on a solved operator: rows of G stay as they are, no ray is traced for them.
#ifndef RESOLVENT_RELIGHT_H
#define RESOLVENT_RELIGHT_H

#include "resolvent/solve.h"

#ifdef __cplusplus
extern "C" {
#endif

/// A source by the name of its punctual light or emissive material; "environment" is the surroundings.
typedef struct rsv_light_scale {
    const char *name;
    rsv_rgb scale; ///< factors of its strength, 0..1e6; of the surroundings: all three alike
} rsv_light_scale;

/// A new base colour for a material that is diffuse, opaque and of one colour all over.
typedef struct rsv_albedo_change {
    const char *material;
    rsv_rgb base_color; ///< 0..1
} rsv_albedo_change;

typedef struct rsv_relight_desc {
    const rsv_light_scale *light; ///< [light_count]; sources that are not named stay as they are
    size_t light_count;
    const rsv_albedo_change *albedo; ///< [albedo_count]
    size_t albedo_count;
    bool turn;      ///< whether the surroundings turn to `rotation`
    float rotation; ///< degrees about +y, counter-clockwise from above, as in rsv_environment
} rsv_relight_desc;

/// Changes a solution from rsv_solution_load and its scene in place and solves again: E0 is the sum of the sources'
/// parts, each times its scale. The parts come from the file, or are sampled here if it has none. What translucent
/// bodies show directly is sampled anew, and so are the suns of surroundings that turn; the rest of these is known
/// direction by direction. Nobody else may use solution or scene meanwhile.
///
/// RSV_ERROR_ARGUMENT for unknown names (the message lists the known ones), factors out of range and surroundings that
/// are to turn where there are none,
/// RSV_ERROR_UNSUPPORTED for materials whose colour is part of G, and for unequal scales of lamps that only
/// gather rays find. After other errors the solution may be used no more.
/// @param scene that of the solution
RSV_API rsv_status rsv_solution_relight(
    rsv_solution *solution, rsv_scene *scene, const rsv_relight_desc *desc);

#ifdef __cplusplus
}
#endif

#endif
