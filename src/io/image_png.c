/// A walk over a PNG file's chunks (ISO/IEC 15948, 11.2.2).
#include "image_internal.h"

#include <string.h>

static const uint8_t signature[8] = { 0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n' };

static size_t big_endian(const uint8_t *b)
{
    return (size_t)b[0] << 24 | (size_t)b[1] << 16 | (size_t)b[2] << 8 | b[3];
}

rsv_status rsv_image_check_png(const rsv_image_file *file)
{
    const size_t head = 4 + 4, check_sum = 4;
    size_t at = sizeof signature;
    if (file->size < at || memcmp(file->bytes, signature, at) != 0) return RSV_OK; // another format
    while (file->size - at >= head) {
        const uint8_t *chunk = file->bytes + at;
        size_t length = big_endian(chunk);
        if (length > file->size - at - head)
            return rsv_fail(RSV_ERROR_FORMAT,
                "cannot read '%s': the file is truncated: the chunk at byte %zu says it has %zu "
                "bytes",
                file->path, at, length);
        if (memcmp(chunk + 4, "IEND", 4) == 0) return RSV_OK;
        at += head + length;
        at += file->size - at < check_sum ? file->size - at : check_sum;
    }
    return RSV_OK;
}
