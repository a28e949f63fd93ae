/// What stb_image leaves unchecked in TGA (Truevision 2.0) and GIF (89a) files.
#include "image_internal.h"

#include <string.h>

/// Deflate packs at most 1032 bytes into one, of eight pixels each; a block of JPEG's takes a bit at least; a code of
/// GIF's has three bits at least and stands for up to 4096 pixels; a run of TGA's takes two bytes for 128.
enum {
    PIXELS_PER_BYTE_OF_PNG = 1032 * 8,
    PIXELS_PER_BYTE_OF_JPEG = 64 * 8,
    PIXELS_PER_BYTE_OF_GIF = 4096 * 8 / 3,
    PIXELS_PER_BYTE_OF_TGA = 64,
    PIXELS_PER_BYTE_OF_BMP = 8
};

typedef struct signature {
    const char *start;
    size_t pixels_per_byte;
} signature;

static const signature signatures[] = { { "\x89PNG", PIXELS_PER_BYTE_OF_PNG },
    { "\xff\xd8", PIXELS_PER_BYTE_OF_JPEG }, { "GIF8", PIXELS_PER_BYTE_OF_GIF },
    { "BM", PIXELS_PER_BYTE_OF_BMP } };

static const signature *find_signature(const rsv_image_file *file)
{
    for (size_t k = 0; k < sizeof signatures / sizeof *signatures; k++) {
        size_t length = strlen(signatures[k].start);
        if (file->size >= length && memcmp(file->bytes, signatures[k].start, length) == 0)
            return &signatures[k];
    }
    return NULL;
}

size_t rsv_image_pixels_per_byte(const rsv_image_file *file)
{
    const signature *found = find_signature(file);
    return found ? found->pixels_per_byte : PIXELS_PER_BYTE_OF_TGA;
}

// ---- TGA --------------------------------------------------------------------------------------------

enum {
    TGA_HEADER = 18,
    TGA_MAPPED = 1, ///< image types without compression
    TGA_COLORED,
    TGA_GREY,
    TGA_FROM_RIGHT = 0x10 ///< of the descriptor
};

static size_t little_endian(const uint8_t *b) { return (size_t)b[0] | (size_t)b[1] << 8; }

rsv_status rsv_image_check_tga(const rsv_image_file *file)
{
    const uint8_t *b = file->bytes;
    if (find_signature(file) || file->size < TGA_HEADER) return RSV_OK;
    if (b[2] < TGA_MAPPED || b[2] > TGA_GREY) return RSV_OK;
    size_t map = b[1] ? little_endian(b + 5) * ((b[7] + 7u) / 8) : 0;
    size_t pixels = little_endian(b + 12) * little_endian(b + 14);
    size_t needed = TGA_HEADER + b[0] + map + pixels * ((b[16] + 7u) / 8);
    if (needed <= file->size) return RSV_OK;
    return rsv_fail(RSV_ERROR_FORMAT,
        "cannot read '%s': the file is truncated, or not a picture: as TGA it would have %zu bytes",
        file->path, needed);
}

void rsv_image_tga_turn(
    const rsv_image_file *file, uint8_t *code, size_t width, size_t height, size_t channels)
{
    if (find_signature(file) || file->size < TGA_HEADER) return;
    if (!(file->bytes[17] & TGA_FROM_RIGHT)) return;
    for (size_t y = 0; y < height; y++) {
        uint8_t *line = code + y * width * channels;
        for (size_t x = 0; x < width / 2; x++)
            for (size_t c = 0; c < channels; c++) {
                uint8_t *left = &line[x * channels + c], kept = *left;
                uint8_t *right = &line[(width - 1 - x) * channels + c];
                *left = *right;
                *right = kept;
            }
    }
}

// ---- GIF --------------------------------------------------------------------------------------------

enum { GIF_HEADER = 13, GIF_IMAGE = 0x2c, GIF_EXTENSION = 0x21, GIF_IMAGE_HEADER = 10 };

/// Bytes of a colour table by the flags that announce it.
static size_t table_bytes(uint8_t flags) { return flags & 0x80 ? (size_t)6 << (flags & 7) : 0; }

/// Behind blocks that begin with their length, the last of which is empty.
static size_t skip_blocks(const rsv_image_file *file, size_t at)
{
    while (at < file->size && file->bytes[at])
        at += 1 + (size_t)file->bytes[at];
    return at + 1;
}

bool rsv_image_gif_moves(const rsv_image_file *file)
{
    size_t images = 0;
    if (file->size < GIF_HEADER || memcmp(file->bytes, "GIF8", 4) != 0) return false;
    for (size_t at = GIF_HEADER + table_bytes(file->bytes[10]); at < file->size;) {
        bool is_image = file->bytes[at] == GIF_IMAGE;
        if (is_image && ++images == 2) return true;
        if (is_image && file->size - at < GIF_IMAGE_HEADER) return false;
        if (is_image) // the size of codes stands before the blocks
            at = skip_blocks(file, at + GIF_IMAGE_HEADER + table_bytes(file->bytes[at + 9]) + 1);
        else if (file->bytes[at] == GIF_EXTENSION)
            at = skip_blocks(file, at + 2);
        else
            return false;
    }
    return false;
}
