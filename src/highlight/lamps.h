/// The light of all lamps.
#ifndef RSV_LAMPS_H
#define RSV_LAMPS_H

#include "highlights_internal.h"

/// Takes light of a source; RSV_NONE = of several.
typedef void (*rsv_light_taker)(void *user, uint32_t source, rsv_rgb radiance);

/// As many lamps as may be told apart; those that matter little together.
void rsv_lamps_light(const rsv_highlights *highlights, const rsv_highlight_lobes *lobes,
    rsv_light_taker take, void *user);

#endif
