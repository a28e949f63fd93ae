/// Which side of a surface's light a file shows.
#ifndef RSV_BAKE_SIDE_H
#define RSV_BAKE_SIDE_H

#include "bake_part.h"

/// Selects the displayed side of double-sided surfaces. Files have one light for both sides of a surface. It is that of
/// the front, except where modellers turned the front away from the room: whole surfaces whose front is darker than
/// their back, and enclosed, show the light of their back.
/// @param part its `back` is allocated and set
rsv_status rsv_bake_choose_sides(const rsv_light_view *solution, rsv_bake_part *part);

#endif
