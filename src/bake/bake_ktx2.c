#include "bake_ktx2.h"

#include "../core/vec.h"
#include "../io/atomic_file.h"

#include <math.h>
#include <string.h>

enum {
    MANTISSA_BITS = 9,
    BIAS = 15,
    VK_FORMAT_E5B9G9R9 = 123,
    HEADER_WORDS = 20, ///< with the index
    LEVEL_WORDS = 6,
    SAMPLE_COUNT = 6,
    BLOCK_BYTES = 24 + 16 * SAMPLE_COUNT,
    DESCRIPTOR_WORDS = 1 + BLOCK_BYTES / 4,
    DESCRIPTOR_AT = 4 * (HEADER_WORDS + LEVEL_WORDS),
    TEXELS_AT = DESCRIPTOR_AT + 4 * DESCRIPTOR_WORDS,
};

/// As in EXT_texture_shared_exponent.
uint32_t rsv_rgb9e5(rsv_rgb color)
{
    float c[3];
    for (int k = 0; k < 3; k++)
        c[k] = f_min(f_max((&color.r)[k], 0), RSV_RGB9E5_MOST); // NaN becomes 0
    float most = f_max(c[0], f_max(c[1], c[2]));
    int exponent = most > 0 ? (int)floorf(log2f(most)) : -BIAS - 1;
    exponent = (exponent > -BIAS - 1 ? exponent : -BIAS - 1) + 1 + BIAS;
    float step = ldexpf(1, exponent - BIAS - MANTISSA_BITS);
    if (floorf(most / step + 0.5f) >= (float)(1 << MANTISSA_BITS)) {
        step *= 2;
        exponent++;
    }
    uint32_t code = (uint32_t)exponent << 3 * MANTISSA_BITS;
    for (int k = 0; k < 3; k++)
        code |= (uint32_t)floorf(c[k] / step + 0.5f) << k * MANTISSA_BITS;
    return code;
}

/// The data format descriptor: of each channel nine bits of its own, and the exponent that all share.
static void describe(uint32_t word[DESCRIPTOR_WORDS])
{
    enum { RGBSDA = 1, BT709 = 1, LINEAR = 1, VERSION = 2, EXPONENT = 0x20 };
    const uint32_t head[7] = { 4 * DESCRIPTOR_WORDS, 0, VERSION | (uint32_t)BLOCK_BYTES << 16,
        RGBSDA | BT709 << 8 | LINEAR << 16, 0, 4, 0 };
    memcpy(word, head, sizeof head);
    for (uint32_t c = 0; c < 3; c++) {
        const uint32_t mantissa[4] = { MANTISSA_BITS * c | 8 << 16 | c << 24, 0, 0, 8448 };
        const uint32_t exponent[4] = { 27 | 4 << 16 | (c | EXPONENT) << 24, 0, BIAS, 31 };
        memcpy(word + 7 + 8 * c, mantissa, sizeof mantissa);
        memcpy(word + 11 + 8 * c, exponent, sizeof exponent);
    }
}

/// @param depth 0 = a flat map
static void write_head(rsv_atomic_file *file, uint32_t width, uint32_t height, uint32_t depth)
{
    static const uint8_t identifier[12] = { 0xab, 'K', 'T', 'X', ' ', '2', '0', 0xbb, '\r', '\n',
        0x1a, '\n' };
    const uint32_t bytes = 4 * width * height * (depth ? depth : 1);
    uint32_t descriptor[DESCRIPTOR_WORDS];
    const uint32_t rest[HEADER_WORDS - 3 + LEVEL_WORDS] = { VK_FORMAT_E5B9G9R9, 4, width, height,
        depth, 0, 1, 1, 0, DESCRIPTOR_AT, 4 * DESCRIPTOR_WORDS, 0, 0, 0, 0, 0, 0, TEXELS_AT, 0,
        bytes, 0, bytes, 0 };
    describe(descriptor);
    rsv_atomic_file_append(file, identifier, sizeof identifier);
    rsv_atomic_file_append(file, rest, sizeof rest);
    rsv_atomic_file_append(file, descriptor, sizeof descriptor);
}

rsv_status rsv_bake_write_ktx2(
    rsv_context *context, const char *path, uint32_t width, uint32_t height, const rsv_rgb *texel)
{
    return rsv_bake_write_ktx2_volume(context, path, (const uint32_t[]){ width, height, 0 }, texel);
}

rsv_status rsv_bake_write_ktx2_volume(
    rsv_context *context, const char *path, const uint32_t size[3], const rsv_rgb *texel)
{
    rsv_atomic_file file = { .descriptor = -1 };
    size_t count = (size_t)size[0] * size[1] * (size[2] ? size[2] : 1);
    uint32_t *code = rsv_alloc(context, count, sizeof *code);
    if (!code) return RSV_ERROR_MEMORY;
    rsv_status status = rsv_atomic_file_open(&file, path);
    if (status == RSV_OK) {
        for (size_t k = 0; k < count; k++)
            code[k] = rsv_rgb9e5(texel[k]);
        write_head(&file, size[0], size[1], size[2]);
        rsv_atomic_file_append(&file, code, count * sizeof *code);
        status = rsv_atomic_file_commit(&file);
    }
    rsv_free(context, code);
    return status;
}
