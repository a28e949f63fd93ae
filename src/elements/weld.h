/// Which corners of which faces are one: equal position, material and side, and normals that agree.
#ifndef RSV_WELD_H
#define RSV_WELD_H

#include "elements.h"

/// Fills face_corner and face_edge from face_triangle and face_back.
rsv_status rsv_weld_faces(rsv_elements *elements);

#endif
