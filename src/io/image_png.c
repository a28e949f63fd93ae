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

/// What the chunks say of colours and frames.
typedef struct png_claims {
    bool srgb;       ///< sRGB, or a profile of that name
    bool profile;    ///< iCCP of another name
    bool code_point; ///< cICP of other colours
    bool coded;      ///< cICP, which counts before all others
    bool gamma, primaries;
    bool frames;
} png_claims;

/// Numbers are times 100,000; gamma 45,455 is sRGB's, about. @param data [length]
static void note_chunk(png_claims *claims, const uint8_t *name, const uint8_t *data, size_t length)
{
    static const size_t srgb[8] = { 31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000 };
    if (memcmp(name, "sRGB", 4) == 0) claims->srgb = true;
    if (memcmp(name, "acTL", 4) == 0 && length >= 4) claims->frames = big_endian(data) > 1;
    if (memcmp(name, "gAMA", 4) == 0 && length == 4)
        claims->gamma = big_endian(data) < 40000 || big_endian(data) > 50000;
    for (int k = 0; k < 8 && memcmp(name, "cHRM", 4) == 0 && length == 32; k++) {
        size_t value = big_endian(data + 4 * k);
        claims->primaries |= value + 1000 < srgb[k] || value > srgb[k] + 1000;
    }
    if (memcmp(name, "iCCP", 4) == 0) {
        char profile[80] = { 0 };
        memcpy(profile, data, length < 79 ? length : 79);
        *(strstr(profile, "sRGB") ? &claims->srgb : &claims->profile) = true;
    }
    if (memcmp(name, "cICP", 4) == 0 && length == 4) {
        claims->coded = true;
        claims->code_point = data[0] != 1 || data[1] != 13; // BT.709 and sRGB
    }
}

const char *rsv_image_png_unused(const rsv_image_file *file, bool *frames)
{
    const size_t around = 4 + 4 + 4; // length, name and check sum
    png_claims claims = { 0 };
    *frames = false;
    if (file->size < sizeof signature || memcmp(file->bytes, signature, sizeof signature) != 0)
        return NULL;
    for (size_t at = sizeof signature; file->size - at >= around;) {
        const uint8_t *chunk = file->bytes + at;
        size_t length = big_endian(chunk);
        if (length > file->size - at - around || memcmp(chunk + 4, "IDAT", 4) == 0) break;
        note_chunk(&claims, chunk + 4, chunk + 8, length);
        at += around + length;
    }
    *frames = claims.frames;
    if (claims.coded) return claims.code_point ? "colour space (cICP)" : NULL;
    if (claims.profile) return "colour profile (iCCP)";
    if (claims.srgb) return NULL;
    if (claims.primaries)
        return claims.gamma ? "gamma and primaries (gAMA, cHRM)" : "primaries (cHRM)";
    return claims.gamma ? "gamma (gAMA)" : NULL;
}
