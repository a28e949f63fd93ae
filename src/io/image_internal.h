/// Code shared by the readers and writers of pictures.
#ifndef RSV_IMAGE_INTERNAL_H
#define RSV_IMAGE_INTERNAL_H

#include "../core/core.h"
#include "atomic_file.h"
#include "resolvent/image.h"

#define RSV_IMAGE_MAX_SIDE 65536
#define RSV_IMAGE_MAX_PIXELS ((int64_t)1 << 28)
#define RSV_LAYER_NAME_BYTES 64

/// A whole file in memory, and its name for messages.
typedef struct rsv_image_file {
    const char *path;
    const uint8_t *bytes;
    size_t size;
} rsv_image_file;

rsv_context *rsv_image_context(const rsv_image *image);

/// Whether two layers can be compared: pictures of one size, whose every value is finite.
/// @param a the reference
rsv_status rsv_image_check_pair(
    const rsv_image *a, uint32_t layer_a, const rsv_image *b, uint32_t layer_b);

/// RSV_ERROR_FORMAT, naming the file, unless a picture of that size may be read.
rsv_status rsv_image_check_size(const char *path, int64_t width, int64_t height);

// Decoders: on success the caller owns *image. They need not clean up the file.
rsv_status rsv_image_decode_exr(
    rsv_context *context, const rsv_image_file *file, rsv_image **image);
rsv_status rsv_image_decode_hdr(
    rsv_context *context, const rsv_image_file *file, rsv_image **image);
/// PNG, JPEG, TGA, BMP and GIF (its first frame).
rsv_status rsv_image_decode_ldr(
    rsv_context *context, const rsv_image_file *file, rsv_image **image);

/// A picture as the codes it is stored as.
typedef struct rsv_image_codes {
    uint8_t *code; ///< [height * width * channel_count], row 0 on top
    uint32_t width, height, channel_count;
} rsv_image_codes;

/// PNG, JPEG, TGA, BMP and GIF as 8-bit codes, for textures: no side above RSV_TEXTURE_MAX_SIDE, and no more pixels
/// than the file's size can account for. Release with rsv_image_free_codes.
rsv_status rsv_image_decode_codes(const rsv_image_file *file, rsv_image_codes *codes);
void rsv_image_free_codes(rsv_image_codes *codes);

/// Refuses JPEG files that stb_image (2.27) does not survive: Huffman tables of more than 256 codes
/// overrun its arrays.
rsv_status rsv_image_check_jpeg(const rsv_image_file *file);

/// Refuses PNG files that end within a chunk. stb_image (2.27) would allocate the size that the chunk's header states,
/// up to 2 GiB, before reading it. Files of other formats pass.
rsv_status rsv_image_check_png(const rsv_image_file *file);

/// The PNG chunk, as messages call it, by which a file says that its codes are not sRGB; NULL = they are, or it is no
/// PNG.
/// @param frames out: whether the file holds more pictures than the one that is read
const char *rsv_image_png_unused(const rsv_image_file *file, bool *frames);

/// More pixels than this cannot come out of a byte of such a file.
size_t rsv_image_pixels_per_byte(const rsv_image_file *file);

/// Refuses uncompressed TGA files that are shorter than their header says. Files of other formats pass.
rsv_status rsv_image_check_tga(const rsv_image_file *file);

/// Turns round the lines of TGA files that run from right to left. Other files stay as they are.
/// @param code [height * width * channels]
void rsv_image_tga_turn(
    const rsv_image_file *file, uint8_t *code, size_t width, size_t height, size_t channels);

/// Whether a GIF file holds more pictures than the first.
bool rsv_image_gif_moves(const rsv_image_file *file);

// Encoders: append to an open file, which the caller commits or discards. `exposure` is in stops
// and ignored by formats that hold radiance.
rsv_status rsv_image_encode_exr(const rsv_image *image, float exposure, rsv_atomic_file *file);
rsv_status rsv_image_encode_hdr(const rsv_image *image, float exposure, rsv_atomic_file *file);
rsv_status rsv_image_encode_png(const rsv_image *image, float exposure, rsv_atomic_file *file);

#endif
