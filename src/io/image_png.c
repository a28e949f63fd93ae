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

bool rsv_image_png_gamma_is_foreign(const rsv_image_file *file)
{
    const size_t around = 4 + 4 + 4; // length, name and check sum
    if (file->size < sizeof signature || memcmp(file->bytes, signature, sizeof signature) != 0)
        return false;
    bool foreign = false;
    for (size_t at = sizeof signature; file->size - at >= around;) {
        const uint8_t *chunk = file->bytes + at;
        size_t length = big_endian(chunk);
        if (length > file->size - at - around) return foreign;
        if (memcmp(chunk + 4, "sRGB", 4) == 0 || memcmp(chunk + 4, "iCCP", 4) == 0) return false;
        if (memcmp(chunk + 4, "IDAT", 4) == 0) return foreign;
        if (memcmp(chunk + 4, "gAMA", 4) == 0 && length == 4) {
            size_t gamma = big_endian(chunk + 8); // times 100,000; 45,455 is sRGB's, about
            foreign = gamma < 40000 || gamma > 50000;
        }
        at += around + length;
    }
    return foreign;
}
