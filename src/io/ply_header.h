/// The header of a Stanford polygon file, checked before an importer is let near it.
#ifndef RSV_PLY_HEADER_H
#define RSV_PLY_HEADER_H

#include "resolvent/core.h"

/// RSV_OK if the header is well-formed, and the file large enough for the elements it announces. Names, in a warning, what it
/// announces that is not used.
rsv_status rsv_ply_check(const rsv_context *context, const char *path);

#endif
