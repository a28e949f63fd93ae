/// PNG, JPEG, TGA, BMP and GIF, through stb_image and stb_image_write, which leaves compressing to zlib.
#include "../core/srgb.h"
#include "../core/vec.h"
#include "image_codes.h"
#include "image_internal.h"
#include "resolvent/scene.h"
#include "texture_image.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

/// stb_image_write's own does not notice where memory runs out, and packs worse.
static unsigned char *compress_bytes(unsigned char *bytes, int count, int *packed_count, int level)
{
    uLongf most = compressBound((uLong)count);
    unsigned char *packed = malloc(most);
    if (!packed) return NULL;
    if (compress2(packed, &most, bytes, (uLong)count, level) != Z_OK || most > INT_MAX) {
        free(packed);
        return NULL;
    }
    *packed_count = (int)most;
    return packed;
}

// the headers declare more functions than are used here
#pragma GCC diagnostic ignored "-Wunused-function"
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_ONLY_TGA
#define STBI_ONLY_BMP
#define STBI_ONLY_GIF
#define STBI_NO_STDIO
#define STBI_FAILURE_USERMSG
// pixels that a broken file leaves out become zeros, not uninitialised memory
#define STBI_MALLOC(bytes) calloc(1, bytes)
#define STBI_REALLOC realloc
#define STBI_FREE free
#include <stb/stb_image.h>
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#define STBIW_ZLIB_COMPRESS compress_bytes
#include <stb/stb_image_write.h>

/// A file being decoded. stb_image reads zeros past the end; `exhausted` records that.
typedef struct source {
    const rsv_image_file *file;
    size_t position;
    bool exhausted;
} source;

static int source_read(void *user, char *data, int size)
{
    source *from = user;
    size_t left = from->file->size - from->position;
    size_t count = (size_t)size < left ? (size_t)size : left;
    memcpy(data, from->file->bytes + from->position, count);
    from->position += count;
    if (count == 0) from->exhausted = true;
    return (int)count;
}

static void source_skip(void *user, int count)
{
    source *from = user;
    int64_t target = (int64_t)from->position + count;
    from->exhausted |= target > (int64_t)from->file->size;
    if (target < 0) target = 0;
    from->position = from->exhausted ? from->file->size : (size_t)target;
}

static int source_eof(void *user)
{
    source *from = user;
    return from->position == from->file->size;
}

static const stbi_io_callbacks source_callbacks = { source_read, source_skip, source_eof };

/// Translates the decoder's messages for users: its own words are meant for its developers.
static rsv_status fail_decoding(const source *from)
{
    static const char *const known[][2] = {
        { "not of any known", "it is not a PNG, JPEG, TGA, BMP or GIF, or its header is damaged" },
        { "not supported",
            "a kind of PNG, JPEG or TGA that is not supported; save it as plain 8-bit PNG" },
        { "BMP", "a kind of BMP that is not supported, or damaged; save it as plain 8-bit PNG" },
        { "memory", "it is damaged, or too large for memory" },
        { "PNG", "its PNG data are damaged" }, { "JPEG", "its JPEG data are damaged" }
    };
    const char *said = stbi_failure_reason(), *meaning = "its data are damaged";
    for (size_t k = sizeof known / sizeof *known; said && k-- > 0;)
        if (strstr(said, known[k][0])) meaning = known[k][1];
    return rsv_fail(RSV_ERROR_FORMAT, "cannot read '%s': %s", from->file->path,
        from->exhausted ? "the file is truncated" : meaning);
}

/// Any size of code: `codes` holds RGB triples of 8 or 16 bits.
static void decode_srgb(const void *codes, bool is_16_bit, size_t pixel_count, rsv_rgb *pixels)
{
    const stbi_uc *code8 = codes;
    const stbi_us *code16 = codes;
    float linear8[256];
    for (int i = 0; i < 256; i++)
        linear8[i] = (float)rsv_srgb_decode(i / 255.0);
    for (size_t i = 0; i < pixel_count; i++) {
        float v[3];
        for (int c = 0; c < 3; c++)
            v[c] = is_16_bit ? (float)rsv_srgb_decode(code16[3 * i + c] / 65535.0)
                             : linear8[code8[3 * i + c]];
        pixels[i] = rgb(v[0], v[1], v[2]);
    }
}

static rsv_status check_pixel_count(const rsv_image_file *file, int width, int height)
{
    size_t most = rsv_image_pixels_per_byte(file);
    if ((size_t)width * (size_t)height / most <= file->size) return RSV_OK;
    return rsv_fail(RSV_ERROR_FORMAT, "cannot read '%s': %d x %d pixels do not fit in %zu bytes",
        file->path, width, height, file->size);
}

static void warn_of_unused(rsv_context *context, const rsv_image_file *file)
{
    bool frames;
    const char *colors = rsv_image_png_unused(file, &frames);
    if (colors)
        rsv_log(context, RSV_LOG_WARNING,
            "picture '%s': not used: its %s; its values are assumed to be sRGB", file->path,
            colors);
    if (frames || rsv_image_gif_moves(file))
        rsv_log(context, RSV_LOG_WARNING, "picture '%s': only the first of its frames is used",
            file->path);
}

rsv_status rsv_image_decode_ldr(rsv_context *context, const rsv_image_file *file, rsv_image **image)
{
    rsv_status status = RSV_OK;
    source info = { .file = file }, depth = { .file = file }, from = { .file = file };
    rsv_image *decoded = NULL;
    void *codes = NULL;
    int width = 0, height = 0, channels;
    RSV_TRY(rsv_image_check_jpeg(file));
    RSV_TRY(rsv_image_check_png(file));
    RSV_TRY(rsv_image_check_tga(file));
    if (!stbi_info_from_callbacks(&source_callbacks, &info, &width, &height, &channels))
        RSV_TRY(fail_decoding(&info));
    RSV_TRY(rsv_image_check_size(file->path, width, height));
    RSV_TRY(check_pixel_count(file, width, height));
    warn_of_unused(context, file);
    bool is_16_bit = stbi_is_16_bit_from_callbacks(&source_callbacks, &depth);
    codes = is_16_bit ? (void *)stbi_load_16_from_callbacks(
                            &source_callbacks, &from, &width, &height, &channels, 3)
                      : (void *)stbi_load_from_callbacks(
                            &source_callbacks, &from, &width, &height, &channels, 3);
    if (!codes || from.exhausted) RSV_TRY(fail_decoding(&from));
    if (!is_16_bit) rsv_image_tga_turn(file, codes, (size_t)width, (size_t)height, 3);
    RSV_TRY(rsv_image_create(context, (uint32_t)width, (uint32_t)height, 1, &decoded));
    decode_srgb(codes, is_16_bit, (size_t)width * (size_t)height, rsv_image_pixels(decoded, 0));
    *image = decoded;
cleanup:
    stbi_image_free(codes);
    return status;
}

static rsv_status check_texture_size(const rsv_image_file *file, int width, int height)
{
    if (width < 1 || height < 1 || width > RSV_TEXTURE_MAX_SIDE || height > RSV_TEXTURE_MAX_SIDE)
        return rsv_fail(RSV_ERROR_FORMAT,
            "cannot read '%s': %d x %d pixels are not in 1 .. %u a side", file->path, width, height,
            RSV_TEXTURE_MAX_SIDE);
    return check_pixel_count(file, width, height);
}

/// Refuses files that the decoder cannot be trusted with.
static rsv_status check_texture_file(const rsv_image_file *file)
{
    rsv_status status;
    source info = { .file = file };
    int width = 0, height = 0, channels;
    RSV_TRY(rsv_image_check_jpeg(file));
    RSV_TRY(rsv_image_check_png(file));
    RSV_TRY(rsv_image_check_tga(file));
    if (!stbi_info_from_callbacks(&source_callbacks, &info, &width, &height, &channels))
        RSV_TRY(fail_decoding(&info));
    RSV_TRY(check_texture_size(file, width, height));
cleanup:
    return status;
}

bool rsv_image_is_16_bit(const rsv_image_file *file)
{
    source depth = { .file = file };
    return stbi_is_16_bit_from_callbacks(&source_callbacks, &depth);
}

rsv_status rsv_image_decode_codes16(
    const rsv_image_file *file, uint16_t **code, rsv_image_codes *size)
{
    rsv_status status;
    source from = { .file = file };
    int width = 0, height = 0, channels;
    RSV_TRY(check_texture_file(file));
    *code = stbi_load_16_from_callbacks(&source_callbacks, &from, &width, &height, &channels, 0);
    if (!*code || from.exhausted) RSV_TRY(fail_decoding(&from));
    *size = (rsv_image_codes){ NULL, (uint32_t)width, (uint32_t)height, (uint32_t)channels };
cleanup:
    return status;
}

void rsv_image_free_codes16(uint16_t *code) { stbi_image_free(code); }

rsv_status rsv_image_decode_codes(const rsv_image_file *file, rsv_image_codes *codes)
{
    rsv_status status = RSV_OK;
    source from = { .file = file };
    int width = 0, height = 0, channels;
    RSV_TRY(check_texture_file(file));
    codes->code = stbi_load_from_callbacks(&source_callbacks, &from, &width, &height, &channels, 0);
    if (!codes->code || from.exhausted) RSV_TRY(fail_decoding(&from));
    rsv_image_tga_turn(file, codes->code, (size_t)width, (size_t)height, (size_t)channels);
    codes->width = (uint32_t)width;
    codes->height = (uint32_t)height;
    codes->channel_count = (uint32_t)channels;
    return RSV_OK;
cleanup:
    rsv_image_free_codes(codes);
    return status;
}

void rsv_image_free_codes(rsv_image_codes *codes)
{
    stbi_image_free(codes->code);
    *codes = (rsv_image_codes){ 0 };
}

/// The nearest code; NaN and negative light are black.
static uint8_t encode_srgb(double radiance)
{
    if (!(radiance > 0)) return 0;
    return (uint8_t)(255 * rsv_srgb_encode(fmin(radiance, 1)) + 0.5);
}

static void append_to_file(void *user, void *data, int size)
{
    rsv_atomic_file_append(user, data, (size_t)size);
}

rsv_status rsv_image_encode_png(const rsv_image *image, float exposure, rsv_atomic_file *file)
{
    rsv_status status = RSV_OK;
    uint32_t width = rsv_image_width(image), height = rsv_image_height(image);
    size_t pixel_count = (size_t)width * height;
    const rsv_rgb *pixels = rsv_image_const_pixels(image, 0);
    double gain = exp2(exposure);
    uint8_t(*codes)[3] = rsv_alloc(rsv_image_context(image), pixel_count, sizeof *codes);
    if (!codes) return RSV_ERROR_MEMORY;
    for (size_t i = 0; i < pixel_count; i++) {
        codes[i][0] = encode_srgb(gain * pixels[i].r);
        codes[i][1] = encode_srgb(gain * pixels[i].g);
        codes[i][2] = encode_srgb(gain * pixels[i].b);
    }
    if (!stbi_write_png_to_func(
            append_to_file, file, (int)width, (int)height, 3, codes, (int)(3 * width)))
        status = rsv_fail(RSV_ERROR_MEMORY, "out of memory compressing '%s'", file->target);
    rsv_free(rsv_image_context(image), codes);
    return status;
}

typedef struct growing_bytes {
    rsv_context *context;
    uint8_t *bytes;
    size_t count, capacity;
    rsv_status status;
} growing_bytes;

static void append_to_memory(void *user, void *data, int size)
{
    growing_bytes *g = user;
    size_t needed = g->count + (size_t)size;
    if (g->status == RSV_OK)
        g->status = rsv_grow(g->context, (void **)&g->bytes, &g->capacity, needed, 1);
    if (g->status != RSV_OK) return;
    memcpy(g->bytes + g->count, data, (size_t)size);
    g->count = needed;
}

rsv_status rsv_image_png_from_codes(rsv_context *context, const uint8_t (*codes)[3], uint32_t width,
    uint32_t height, uint8_t **bytes, size_t *count)
{
    growing_bytes g = { .context = context };
    if (!stbi_write_png_to_func(
            append_to_memory, &g, (int)width, (int)height, 3, codes, (int)(3 * width)) &&
        g.status == RSV_OK)
        g.status = rsv_fail(RSV_ERROR_MEMORY, "out of memory compressing a picture");
    if (g.status != RSV_OK) {
        rsv_free(context, g.bytes);
        return g.status;
    }
    *bytes = g.bytes;
    *count = g.count;
    return RSV_OK;
}
