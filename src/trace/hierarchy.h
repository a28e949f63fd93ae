/// The hierarchy of a tracer's triangles for devices.
#ifndef RSV_HIERARCHY_H
#define RSV_HIERARCHY_H

#include "../bvh/bvh.h"
#include "resolvent/trace.h"

/// Built on first use, by any thread, and kept until the tracer is destroyed or triangles move.
/// @param view out: owned by the tracer
rsv_status rsv_tracer_hierarchy(const rsv_tracer *tracer, rsv_bvh_view *view);

#endif
