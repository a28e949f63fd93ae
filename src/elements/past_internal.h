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
    rsv_scene_change change; ///< what is new, and what is gone
    rsv_box source[RSV_PAST_SOURCES];
    uint32_t source_count;
    rsv_vec3 sun[RSV_MAX_SUNS + RSV_PAST_SOURCES]; ///< unit, towards distant sources
    uint32_t sun_count;
    bool all_lit_anew; ///< sources are not what they were
    bool sky;          ///< light comes from everywhere above
};

/// Boxes around the sources of direct light.
void rsv_past_find_sources(rsv_past *past, const rsv_lights *lights);

rsv_box rsv_box_grow(rsv_box box, float by);
rsv_box rsv_box_of_cell(const rsv_elements *elements, uint32_t cell);
/// A cell with all that is asked of its surroundings.
rsv_box rsv_reach_of_cell(const rsv_elements *elements, uint32_t cell);

#endif
