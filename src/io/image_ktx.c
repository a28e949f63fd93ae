/// KTX 2.0 (Khronos, "KTX File Format Specification", 2.0.4).
#include "image_ktx.h"

#include "basis_lz.h"
#include "basis_uastc.h"
#include "little_endian.h"
#include "resolvent/scene.h"

#include <math.h>
#include <string.h>
#include <zlib.h>
#include <zstd.h>

#define HEADER_BYTES 80
#define LEVEL_BYTES 24

/// The most that a byte packed by Zstandard can become, and more than one by zlib.
#define BYTES_PER_PACKED_BYTE 65536

// ---- the header ---------------------------------------------------------------------------------

typedef enum texel_type { UNORM8, UNORM16, FLOAT16, FLOAT32 } texel_type;

/// A format of Vulkan's that is read.
typedef struct texel_format {
    uint32_t number;
    texel_type type;
    uint32_t channels;
    bool blue_first;
} texel_format;

static const texel_format formats[] = { { 9, UNORM8, 1, false }, { 15, UNORM8, 1, false },
    { 16, UNORM8, 2, false }, { 22, UNORM8, 2, false }, { 23, UNORM8, 3, false },
    { 29, UNORM8, 3, false }, { 30, UNORM8, 3, true }, { 36, UNORM8, 3, true },
    { 37, UNORM8, 4, false }, { 43, UNORM8, 4, false }, { 44, UNORM8, 4, true },
    { 50, UNORM8, 4, true }, { 70, UNORM16, 1, false }, { 77, UNORM16, 2, false },
    { 84, UNORM16, 3, false }, { 91, UNORM16, 4, false }, { 76, FLOAT16, 1, false },
    { 83, FLOAT16, 2, false }, { 90, FLOAT16, 3, false }, { 97, FLOAT16, 4, false },
    { 100, FLOAT32, 1, false }, { 103, FLOAT32, 2, false }, { 106, FLOAT32, 3, false },
    { 109, FLOAT32, 4, false } };

static const size_t bytes_of_type[] = { [UNORM8] = 1, [UNORM16] = 2, [FLOAT16] = 2, [FLOAT32] = 4 };

enum { PLAIN, BASIS_LZ, ZSTANDARD, ZLIB };

/// How texels are encoded, besides the packing. Blocks of Basis Universal are decoded to 8-bit RGBA.
typedef enum encoding { TEXELS, ETC1S, UASTC } encoding;

static const texel_format decoded_blocks = { 0, UNORM8, 4, false };

/// The fields of a file that are used.
typedef struct ktx {
    const rsv_image_file *file;
    const texel_format *format;
    encoding encoding;
    bool srgb, opaque;       ///< of blocks
    rsv_basis_second second; ///< channel of blocks that lies apart from the others
    uint32_t width, height, packing;
    uint64_t at, size; ///< of the finest level
    size_t unpacked;   ///< bytes
    char swizzle[5];   ///< of "rgba01"
    bool bottom_up;
} ktx;

static rsv_status refuse(const ktx *k, rsv_status status, const char *why)
{
    return rsv_fail(status, "cannot read '%s': %s", k->file->path, why);
}

/// Numbers of the Khronos Data Format Specification.
enum { MODEL_ETC1S = 163, MODEL_UASTC = 166, TRANSFER_SRGB = 2, SAMPLE_BYTES = 16 };

/// Channel of a sample of the data format descriptor; -1 = it has fewer.
static int channel_of(const uint8_t *descriptor, size_t size, size_t sample)
{
    const size_t first = 28, end = first + (sample + 1) * SAMPLE_BYTES;
    return size < end ? -1 : descriptor[end - SAMPLE_BYTES + 3] & 15;
}

static rsv_basis_second second_of(encoding kind, int channel, int next)
{
    if (kind == UASTC)
        return channel == 3 ? RSV_BASIS_ALPHA : channel == 5 ? RSV_BASIS_GREEN : RSV_BASIS_NONE;
    return next == 15 ? RSV_BASIS_ALPHA : next == 4 ? RSV_BASIS_GREEN : RSV_BASIS_NONE;
}

/// Files without a format of Vulkan's describe it themselves.
static rsv_status find_basis_format(ktx *k)
{
    const uint8_t *head = k->file->bytes;
    size_t at = rsv_read_u32(head + 48), size = rsv_read_u32(head + 52);
    if (at > k->file->size || size > k->file->size - at || channel_of(head, size, 0) < 0)
        return refuse(k, RSV_ERROR_FORMAT, "its data format descriptor is damaged");
    const uint8_t *descriptor = head + at;
    uint8_t model = descriptor[12];
    k->encoding = model == MODEL_ETC1S ? ETC1S : UASTC;
    if ((model != MODEL_ETC1S && model != MODEL_UASTC) ||
        (k->packing == BASIS_LZ) != (k->encoding == ETC1S))
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "cannot read '%s': its texels are compressed in a way that is not supported (colour model %u, "
            "packing %u); export PNG, JPEG or WebP, or KTX2 with ETC1S or UASTC",
            k->file->path, model, k->packing);
    k->format = &decoded_blocks;
    k->srgb = descriptor[14] == TRANSFER_SRGB;
    k->second =
        second_of(k->encoding, channel_of(descriptor, size, 0), channel_of(descriptor, size, 1));
    k->opaque = k->second != RSV_BASIS_ALPHA;
    return RSV_OK;
}

static rsv_status find_format(ktx *k)
{
    uint32_t number = rsv_read_u32(k->file->bytes + 12);
    if (number == 0 || k->packing == BASIS_LZ) return find_basis_format(k);
    for (size_t i = 0; i < sizeof formats / sizeof *formats; i++)
        if (formats[i].number == number) k->format = &formats[i];
    if (k->format) return RSV_OK;
    return rsv_fail(RSV_ERROR_UNSUPPORTED,
        "cannot read '%s': its texels have Vulkan's format %u, which is not supported (8 or 16 bits or floats "
        "per channel are, and Basis Universal); export PNG, JPEG or WebP",
        k->file->path, number);
}

static rsv_status check_shape(const ktx *k)
{
    const uint8_t *head = k->file->bytes;
    if (rsv_read_u32(head + 28) > 1 || rsv_read_u32(head + 32) > 1 || rsv_read_u32(head + 36) != 1)
        return refuse(k, RSV_ERROR_UNSUPPORTED,
            "it is a volume, an array or a cube; a single picture is needed");
    if (k->width - 1u < RSV_TEXTURE_MAX_SIDE && k->height - 1u < RSV_TEXTURE_MAX_SIDE)
        return RSV_OK;
    return rsv_fail(RSV_ERROR_FORMAT, "cannot read '%s': %u x %u pixels are not in 1 .. %u a side",
        k->file->path, k->width, k->height, RSV_TEXTURE_MAX_SIDE);
}

/// Bytes before packing.
static size_t size_of_level(const ktx *k)
{
    if (k->encoding == UASTC)
        return (size_t)((k->width + 3) / 4) * ((k->height + 3) / 4) * RSV_UASTC_BLOCK_BYTES;
    return (size_t)k->width * k->height * k->format->channels * bytes_of_type[k->format->type];
}

/// The finest level, which is described first.
static rsv_status find_level(ktx *k)
{
    const uint8_t *level = k->file->bytes + HEADER_BYTES;
    if (k->file->size < HEADER_BYTES + LEVEL_BYTES)
        return refuse(k, RSV_ERROR_FORMAT, "the file is truncated");
    k->at = rsv_read_u64(level);
    k->size = rsv_read_u64(level + 8);
    k->unpacked = size_of_level(k);
    if (k->at > k->file->size || k->size > k->file->size - k->at)
        return refuse(k, RSV_ERROR_FORMAT, "the file is truncated");
    if (k->encoding == ETC1S) return RSV_OK;
    bool fits = k->packing == PLAIN ? k->size == k->unpacked
                                    : k->unpacked / BYTES_PER_PACKED_BYTE <= k->size;
    if (fits) return RSV_OK;
    return rsv_fail(RSV_ERROR_FORMAT, "cannot read '%s': %u x %u texels do not fit in %llu bytes",
        k->file->path, k->width, k->height, (unsigned long long)k->size);
}

/// The value of a key, with its size; NULL = there is none.
static const char *find_value(const ktx *k, const char *key, size_t *size)
{
    uint64_t at = rsv_read_u32(k->file->bytes + 56), end = at + rsv_read_u32(k->file->bytes + 60);
    size_t length = strlen(key) + 1;
    if (end > k->file->size) return NULL;
    while (end - at >= 4) {
        uint64_t entry = rsv_read_u32(k->file->bytes + at);
        const char *text = (const char *)k->file->bytes + at + 4;
        if (entry > end - at - 4) return NULL;
        *size = (size_t)entry - length;
        if (entry >= length && memcmp(text, key, length) == 0) return text + length;
        at += 4 + ((entry + 3) & ~UINT64_C(3));
        if (at > end) return NULL;
    }
    return NULL;
}

/// How channels and rows lie. Where nothing is said: red, green, blue, alpha; from the top.
static rsv_status read_order(ktx *k)
{
    size_t size;
    memcpy(k->swizzle, "rgba", 5);
    const char *value = find_value(k, "KTXswizzle", &size);
    if (value && size >= 4) memcpy(k->swizzle, value, 4);
    for (int c = 0; c < 4; c++)
        if (!strchr("rgba01", k->swizzle[c]) || !k->swizzle[c])
            return refuse(k, RSV_ERROR_FORMAT, "its KTXswizzle is not of r, g, b, a, 0 and 1");
    value = find_value(k, "KTXorientation", &size);
    k->bottom_up = value && size >= 2 && value[1] == 'u';
    return RSV_OK;
}

static rsv_status read_header(const rsv_image_file *file, ktx *k)
{
    rsv_status status;
    *k = (ktx){ .file = file };
    if (file->size < HEADER_BYTES) return refuse(k, RSV_ERROR_FORMAT, "the file is truncated");
    k->width = rsv_read_u32(file->bytes + 20);
    k->height = rsv_read_u32(file->bytes + 24);
    k->packing = rsv_read_u32(file->bytes + 44);
    RSV_TRY(find_format(k));
    RSV_TRY(check_shape(k));
    if (k->packing > ZLIB)
        RSV_TRY(refuse(k, RSV_ERROR_UNSUPPORTED,
            "it is packed in a way that is not supported (Zstandard and zlib are)"));
    RSV_TRY(find_level(k));
    RSV_TRY(read_order(k));
cleanup:
    return status;
}

// ---- packing ------------------------------------------------------------------------------------

/// Finds or unpacks the stored texels or blocks. @param owned to be freed; NULL = they lie in the file
static rsv_status unpack(
    rsv_context *context, const ktx *k, uint8_t **owned, const uint8_t **texels)
{
    *owned = NULL;
    *texels = k->file->bytes + k->at;
    if (k->packing == PLAIN || k->packing == BASIS_LZ) return RSV_OK;
    uint8_t *bytes = *owned = rsv_alloc(context, k->unpacked, 1);
    if (!bytes) return RSV_ERROR_MEMORY;
    size_t got;
    if (k->packing == ZSTANDARD) {
        got = ZSTD_decompress(bytes, k->unpacked, *texels, (size_t)k->size);
    } else {
        uLongf size = k->unpacked;
        got = uncompress(bytes, &size, *texels, (uLong)k->size) == Z_OK ? size : 0;
    }
    *texels = bytes;
    // errors of Zstandard are sizes that nothing has
    return got == k->unpacked ? RSV_OK
                              : refuse(k, RSV_ERROR_FORMAT, "its packed texels are damaged");
}

// ---- blocks -------------------------------------------------------------------------------------

static void decode_uastc_block(
    const ktx *k, const uint8_t *blocks, uint32_t x, uint32_t y, uint8_t *rgba)
{
    uint8_t texel[16][4];
    const uint8_t *block = blocks + ((size_t)y * ((k->width + 3) / 4) + x) * RSV_UASTC_BLOCK_BYTES;
    rsv_uastc_decode(block, k->srgb, texel);
    for (uint32_t i = 0; i < 16; i++) {
        uint32_t column = 4 * x + i % 4, row = 4 * y + i / 4;
        if (column >= k->width || row >= k->height) continue;
        if (k->second == RSV_BASIS_GREEN) texel[i][1] = texel[i][3];
        memcpy(rgba + 4 * ((size_t)row * k->width + column), texel[i], 4);
    }
}

static rsv_status decode_etc1s(rsv_context *context, const ktx *k, uint8_t *rgba)
{
    const uint8_t *head = k->file->bytes;
    uint64_t at = rsv_read_u64(head + 64), size = rsv_read_u64(head + 72);
    uint32_t levels = rsv_read_u32(head + 40);
    if (at > k->file->size || size > k->file->size - at)
        return refuse(k, RSV_ERROR_FORMAT, "the file is truncated");
    const rsv_basis_lz source = { head + at, head + k->at, (size_t)size, (size_t)k->size,
        levels ? levels : 1, k->width, k->height };
    rsv_status status = rsv_basis_lz_decode(context, &source, k->second, rgba);
    return status == RSV_ERROR_FORMAT ? refuse(k, status, "its compressed texels are damaged")
                                      : status;
}

/// Replaces blocks by texels. @param owned, texels as for unpack
static rsv_status decode_blocks(
    rsv_context *context, const ktx *k, uint8_t **owned, const uint8_t **texels)
{
    if (k->encoding == TEXELS) return RSV_OK;
    rsv_status status = RSV_OK;
    uint8_t *rgba = rsv_alloc(context, (size_t)k->width * k->height, 4);
    if (!rgba) return RSV_ERROR_MEMORY;
    if (k->encoding == ETC1S) status = decode_etc1s(context, k, rgba);
    for (uint32_t y = 0; k->encoding == UASTC && y < (k->height + 3) / 4; y++)
        for (uint32_t x = 0; x < (k->width + 3) / 4; x++)
            decode_uastc_block(k, *texels, x, y, rgba);
    rsv_free(context, *owned);
    *owned = rgba;
    *texels = rgba;
    return status;
}

// ---- texels -------------------------------------------------------------------------------------

static float half_to_float(uint32_t bits)
{
    uint32_t exponent = bits >> 10 & 31, fraction = bits & 1023;
    float value = exponent == 0    ? (float)fraction * 0x1p-24f
                  : exponent == 31 ? (fraction ? NAN : INFINITY)
                                   : ldexpf((float)(1024 + fraction), (int)exponent - 25);
    return bits & 0x8000 ? -value : value;
}

static float channel_value(const ktx *k, const uint8_t *texel, uint32_t channel)
{
    float value;
    uint32_t bits;
    switch (k->format->type) {
    case UNORM8:
        return (float)texel[channel];
    case UNORM16:
        return (float)(texel[2 * channel] | texel[2 * channel + 1] << 8) / 65535.0f;
    case FLOAT16:
        return half_to_float(texel[2 * channel] | (uint32_t)texel[2 * channel + 1] << 8);
    default:
        bits = rsv_read_u32(texel + 4 * (size_t)channel);
        memcpy(&value, &bits, sizeof value);
        return value;
    }
}

/// In "rgba01".
static size_t place_of(char channel)
{
    static const char all[] = "rgba01";
    return (size_t)(strchr(all, channel) - all);
}

/// Red, green, blue and alpha, as the file's own order and swizzle have them.
static void read_texel(const ktx *k, const uint8_t *texel, float rgba[4])
{
    const float one = k->format->type == UNORM8 ? 255 : 1;
    float stored[6] = { 0, 0, 0, one, 0, one }; // r g b a 0 1
    for (uint32_t c = 0; c < k->format->channels; c++)
        stored[k->format->blue_first && c < 3 ? 2 - c : c] = channel_value(k, texel, c);
    for (int c = 0; c < 4; c++)
        rgba[c] = stored[place_of(k->swizzle[c])];
}

static bool has_alpha(const ktx *k)
{
    char from = k->swizzle[3];
    return from != '1' && !(from == 'a' && (k->opaque || k->format->channels < 4));
}

static rsv_status convert(
    rsv_context *context, const ktx *k, const uint8_t *texels, rsv_ktx_picture *p)
{
    size_t count = (size_t)k->width * k->height, channels = has_alpha(k) ? 4 : 3;
    size_t bytes = k->format->channels * bytes_of_type[k->format->type];
    *p = (rsv_ktx_picture){ k->width, k->height, (uint32_t)channels, NULL, NULL,
        k->format->type == UNORM16 };
    if (k->format->type == UNORM8)
        p->codes = rsv_alloc(context, count * channels, 1);
    else
        p->values = rsv_alloc(context, count * channels, sizeof *p->values);
    if (!p->codes && !p->values) return RSV_ERROR_MEMORY;
    for (size_t i = 0; i < count; i++) {
        float rgba[4];
        size_t row = i / k->width, from = k->bottom_up ? k->height - 1 - row : row;
        read_texel(k, texels + (from * k->width + i % k->width) * bytes, rgba);
        for (size_t c = 0; c < channels; c++)
            if (p->codes)
                p->codes[channels * i + c] = (uint8_t)rgba[c];
            else
                p->values[channels * i + c] = rgba[c];
    }
    return RSV_OK;
}

rsv_status rsv_ktx_decode(
    rsv_context *context, const rsv_image_file *file, rsv_ktx_picture *picture)
{
    ktx k;
    uint8_t *owned = NULL;
    const uint8_t *texels;
    *picture = (rsv_ktx_picture){ 0 };
    rsv_status status = read_header(file, &k);
    if (status == RSV_OK) status = unpack(context, &k, &owned, &texels);
    if (status == RSV_OK) status = decode_blocks(context, &k, &owned, &texels);
    if (status == RSV_OK) status = convert(context, &k, texels, picture);
    rsv_free(context, owned);
    return status;
}

void rsv_ktx_free(rsv_context *context, rsv_ktx_picture *picture)
{
    rsv_free(context, picture->codes);
    rsv_free(context, picture->values);
}
