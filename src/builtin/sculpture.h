/// Bodies of our own that stand in for scanned ones.
#ifndef RSV_SCULPTURE_H
#define RSV_SCULPTURE_H

#include "isosurface.h"

/// A body as a field and a box around it; y up, its front towards +z.
typedef struct rsv_sculpture {
    rsv_field field;
    rsv_vec3 low, high;
} rsv_sculpture;

/// A trefoil knot that swells and thins along its way.
rsv_sculpture rsv_sculpture_knot(void);

/// A generic head and shoulders.
rsv_sculpture rsv_sculpture_bust(void);

#endif
