/// What was relit since the document was read, in the document.
#ifndef RSV_BAKE_RELIT_H
#define RSV_BAKE_RELIT_H

#include "bake_part.h"

/// Writes strengths, colours and places of lights and lamps, and colours of materials, where the light's scene has them
/// otherwise than the document: what is seen is base colour times light, and other lights than those that shone would
/// mislead. Lights that stand elsewhere get nodes of their own. Documents made of the scene have it all.
/// @param primitive [parts->count], from rsv_bake_separate
rsv_status rsv_bake_follow_relight(const rsv_light_view *solution, const rsv_bake_parts *parts,
    cJSON **primitive, rsv_bake_document *document);

#endif
