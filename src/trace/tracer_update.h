/// Geometry that moves after a tracer was created.
#ifndef RSV_TRACER_UPDATE_H
#define RSV_TRACER_UPDATE_H

#include "resolvent/trace.h"

/// Sets the triangles of some materials apart, so that only these are rebuilt when they move. Only the first call has
/// an effect. The tracer must not be in use. @param moves [material_count]
rsv_status rsv_tracer_set_apart(rsv_tracer *tracer, const bool *moves);

/// The same for single triangles, on top of those that are set apart already.
/// @param moves [triangle_count] non-zero = set apart
rsv_status rsv_tracer_set_triangles_apart(rsv_tracer *tracer, const uint8_t *moves);

/// Whether that was done.
bool rsv_tracer_is_apart(const rsv_tracer *tracer);

/// Updates the positions of the triangles that were set apart. The tracer must not be in use.
rsv_status rsv_tracer_update(rsv_tracer *tracer);

#endif
