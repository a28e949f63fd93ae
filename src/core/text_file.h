/// Text files as a whole.
#ifndef RSV_TEXT_FILE_H
#define RSV_TEXT_FILE_H

#include "core.h"

/// Reads a text file, and appends a zero. RSV_ERROR_IO if it cannot be read, RSV_ERROR_FORMAT if it contains zeros or
/// more than `most` bytes.
/// @param what expected content, for messages: "a luminaire" @param text out: free it with rsv_free, also after errors
rsv_status rsv_read_text_file(
    rsv_context *context, const char *path, const char *what, size_t most, char **text);

#endif
