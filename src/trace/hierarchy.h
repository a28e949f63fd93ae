/// The hierarchy of a tracer's triangles for devices.
#ifndef RSV_HIERARCHY_H
#define RSV_HIERARCHY_H

#include "../bvh/bvh.h"
#include "resolvent/trace.h"

/// Built when it is first asked for, whichever thread that is, and kept for the tracer's life or until triangles move.
/// @param view out: the tracer's
rsv_status rsv_tracer_hierarchy(const rsv_tracer *tracer, rsv_bvh_view *view);

#endif
