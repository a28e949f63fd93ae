/// Writes relit settings into the document.
#ifndef RSV_BAKE_RELIT_H
#define RSV_BAKE_RELIT_H

#include "bake_part.h"

/// Writes strengths, colours and positions of lights and lamps, and colours of materials, where the light's scene
/// differs from the document, because visible light is base colour times light. Moved lights get separate nodes.
/// Documents generated from the scene already have all of it.
/// @param primitive [parts->count], from rsv_bake_separate
rsv_status rsv_bake_follow_relight(const rsv_light_view *solution, const rsv_bake_parts *parts,
    cJSON **primitive, rsv_bake_document *document);

#endif
