/// Which side of a surface's light a file shows.
#ifndef RSV_BAKE_SIDE_H
#define RSV_BAKE_SIDE_H

#include "bake_part.h"

/// Files hold one light for both sides of a surface, and viewers draw a double-sided one from both. Its light is the front's,
/// but where modellers turned that away from the room: whole surfaces whose front is darker than their back, and
/// from where one does not see far, show that of their back.
/// @param part its `back` is allocated and set
rsv_status rsv_bake_choose_sides(const rsv_light_view *solution, rsv_bake_part *part);

#endif
