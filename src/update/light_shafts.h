/// Where the light of sources may be another after something moved: where a straight line from a cell to a source meets
/// a box around it.
#ifndef RSV_LIGHT_SHAFTS_H
#define RSV_LIGHT_SHAFTS_H

#include "../elements/elements.h"
#include "../sources/lights.h"
#include "scene_change.h"

/// Number of sources that are distinguished. With more, all direct light is computed again if any of them has changed.
#define RSV_HISTORY_SOURCES 64

/// Metres.
typedef struct rsv_box {
    rsv_vec3 low, high;
} rsv_box;

rsv_box rsv_box_grow(rsv_box box, float by);
rsv_box rsv_box_of_cell(const rsv_elements *elements, uint32_t cell);
/// A cell with all surroundings that affect it.
rsv_box rsv_reach_of_cell(const rsv_elements *elements, uint32_t cell);
/// Whether a box meets any of those around a change.
bool rsv_box_meets(const rsv_box *box, const rsv_scene_change *change);
/// Whether a change may affect a cell, or any cell whose light a node receives.
bool rsv_cell_is_beside(
    const rsv_elements *elements, uint32_t cell, const rsv_scene_change *change);
bool rsv_node_is_beside(
    const rsv_elements *elements, uint32_t node, const rsv_scene_change *change);

typedef struct rsv_light_shafts {
    const rsv_scene_change *change; ///< moved objects
    rsv_box source[RSV_HISTORY_SOURCES];
    uint32_t source_count;
    rsv_vec3 sun[RSV_MAX_SUNS + RSV_HISTORY_SOURCES]; ///< unit, towards distant sources
    uint32_t sun_count;
    bool all_light_changed; ///< sources have changed
    bool sky;               ///< light comes from everywhere above
} rsv_light_shafts;

/// Boxes around the sources of direct light; the other fields stand already.
void rsv_light_shafts_find_sources(rsv_light_shafts *shafts, const rsv_lights *lights);

/// Whether the light that reaches a cell straight from the sources may be another now.
bool rsv_light_shafts_meet(
    const rsv_light_shafts *shafts, const rsv_elements *elements, uint32_t cell);

/// Cells whose light may have changed. @param light_changed out: [cell_count], freed by the caller
rsv_status rsv_light_shafts_find_changed(
    const rsv_light_shafts *shafts, const rsv_elements *elements, uint8_t **light_changed);

/// The same of any cell whose light a node receives, those of its followers included.
/// @param cell_light_changed [cell_count] of the cells
bool rsv_node_light_is_changed(
    const rsv_elements *elements, uint32_t node, const uint8_t *cell_light_changed);

#endif
