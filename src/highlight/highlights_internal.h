/// What highlights are made of.
#ifndef RSV_HIGHLIGHTS_INTERNAL_H
#define RSV_HIGHLIGHTS_INTERNAL_H

#include "lamp_tree.h"
#include "sky_map.h"

struct rsv_highlights {
    rsv_context *context;
    const rsv_lights *lights;
    rsv_highlights_desc desc;
    uint32_t group_count, sun_count, punctual_count; ///< sources, in this order; then the sky
    rsv_lamp_tree lamps;
    rsv_sky_map sky;
};

#define RSV_MOST_POLYGONS 64

RSV_INLINE uint32_t rsv_highlights_sky(const rsv_highlights *h)
{
    return h->group_count + h->sun_count + h->punctual_count;
}

/// Rough light of a node of lamps towards the eye, by which nodes are chosen; 0 only if it gives none.
/// @param detail how much nodes below it may differ, 0..1
float rsv_lamp_urge(const rsv_highlights *highlights, const rsv_highlight_lobes *lobes,
    uint32_t node, float *detail);

#endif
