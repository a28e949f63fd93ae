/// What the parts of past.c share.
#ifndef RSV_PAST_INTERNAL_H
#define RSV_PAST_INTERNAL_H

#include "past_file.h"

#define RSV_PAST_SOURCES 64

/// Metres.
typedef struct rsv_box {
    rsv_vec3 low, high;
} rsv_box;

struct rsv_past {
    rsv_context *context;
    const rsv_past_header *header;
    rsv_past_layout layout;
    uint32_t
        *face_then[2]; ///< [triangle_count of the scene] by side: the same face; RSV_NONE = none
    rsv_scene_change change; ///< what is new, and what is gone
    rsv_box source[RSV_PAST_SOURCES];
    uint32_t source_count;
    rsv_vec3 sun[RSV_MAX_SUNS + RSV_PAST_SOURCES]; ///< unit, towards distant sources
    uint32_t sun_count;
    bool all_lit_anew; ///< sources are not what they were
    bool sky;          ///< light comes from everywhere above
};

/// Whether every face has a grid, and slots form trees below it. @param taken [slot_count], zeros
bool rsv_past_cells_are_sound(const rsv_past_cells *cells, uint8_t *taken);
/// Finds the faces of the scene again.
rsv_status rsv_past_find_faces(rsv_past *past, const rsv_scene_view *scene);

/// Whether something new or gone may reach what a cell is asked for.
bool rsv_past_is_beside(const rsv_past *past, const rsv_elements *elements, uint32_t cell);

/// Boxes around the sources of direct light.
void rsv_past_find_sources(rsv_past *past, const rsv_lights *lights);

rsv_box rsv_box_grow(rsv_box box, float by);
rsv_box rsv_box_of_cell(const rsv_elements *elements, uint32_t cell);
/// A cell with all that is asked of its surroundings.
rsv_box rsv_reach_of_cell(const rsv_elements *elements, uint32_t cell);

#endif
