#include "text_file.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#define PIECE 65535

rsv_status rsv_read_text_file(
    rsv_context *context, const char *path, const char *what, size_t most, char **text)
{
    size_t length = 0, capacity = 0;
    rsv_status status = RSV_OK;
    *text = NULL;
    FILE *file = fopen(path, "rb");
    if (!file) return rsv_fail(RSV_ERROR_IO, "%s: cannot be opened: %s", path, strerror(errno));
    while (status == RSV_OK && !feof(file) && !ferror(file)) {
        status = rsv_grow(context, (void **)text, &capacity, length + PIECE + 1, 1);
        if (status == RSV_OK) length += fread(*text + length, 1, PIECE, file);
        if (length > most)
            status = rsv_fail(RSV_ERROR_FORMAT, "%s: is too large for %s", path, what);
    }
    if (status == RSV_OK && ferror(file))
        status = rsv_fail(RSV_ERROR_IO, "%s: cannot be read: %s", path, strerror(errno));
    fclose(file);
    if (status != RSV_OK) return status;
    if (!*text) return RSV_ERROR_MEMORY;
    (*text)[length] = '\0';
    return memchr(*text, '\0', length) ? rsv_fail(RSV_ERROR_FORMAT, "%s: is not a text file", path)
                                       : RSV_OK;
}
