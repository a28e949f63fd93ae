/// Shared by the files of the tracer without Embree.
#ifndef RSV_OWN_INTERNAL_H
#define RSV_OWN_INTERNAL_H

#include "tracer_internal.h"

struct rsv_tracer {
    rsv_tracer_head head;
    rsv_bvh fixed, moving; ///< of triangles under the scene's numbers; moving: those set apart
    uint8_t *apart;        ///< [triangle_count] 1 = set apart; NULL = none is
};

#endif
