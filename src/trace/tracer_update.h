/// Geometry that moves after a tracer was created.
#ifndef RSV_TRACER_UPDATE_H
#define RSV_TRACER_UPDATE_H

#include "resolvent/trace.h"

/// Takes the scene's vertices over again. Nobody else may use the tracer meanwhile.
rsv_status rsv_tracer_update(rsv_tracer *tracer);

#endif
