/// Bytes as a URI.
#ifndef RSV_DATA_URI_H
#define RSV_DATA_URI_H

#include "../core/core.h"

/// "data:TYPE;base64,...", to be freed by rsv_free; NULL when out of memory.
char *rsv_data_uri(rsv_context *context, const char *type, const void *data, size_t bytes);

#endif
