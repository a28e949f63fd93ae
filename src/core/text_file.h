/// Text files as a whole.
#ifndef RSV_TEXT_FILE_H
#define RSV_TEXT_FILE_H

#include "core.h"

/// Reads a file that must be text, with a zero behind it. RSV_ERROR_IO if it cannot be read, RSV_ERROR_FORMAT if it holds
/// zeros or more than `most` bytes.
/// @param what it should be, for messages: "a luminaire" @param text out: to be released by rsv_free, after errors too
rsv_status rsv_read_text_file(
    rsv_context *context, const char *path, const char *what, size_t most, char **text);

#endif
