/// Makes textures of picture files of any supported format.
#ifndef RSV_TEXTURE_IMAGE_H
#define RSV_TEXTURE_IMAGE_H

#include "image_internal.h"
#include "resolvent/io.h"

/// Which channels of a texture a picture's values go to.
typedef enum rsv_texture_use {
    RSV_TEXTURE_AS_IT_IS,
    RSV_TEXTURE_GREY_IS_ALPHA, ///< the mean of the colours, unless the picture has alpha
    RSV_TEXTURE_GREY_IS_GREEN, ///< roughness; the other channels are 1
    RSV_TEXTURE_GREY_IS_BLUE,  ///< metalness; the other channels are 1
    RSV_TEXTURE_ARE_NORMALS,   ///< refused if the picture looks like heights
    RSV_TEXTURE_USES
} rsv_texture_use;

/// A picture file and the kind of texture to make of it.
typedef struct rsv_texture_source {
    rsv_image_file file; ///< its path is also the texture's name
    bool srgb;           ///< codes are sRGB colours; pictures of radiance (.hdr, .exr) have none
    bool shines;         ///< keep values above 1, which are cut off otherwise
    rsv_texture_use use;
    /// With RSV_TEXTURE_GREY_IS_GREEN: if above 0, grey times this Phong exponent is converted to roughness.
    float shininess;
    bool nearest;
    rsv_wrap wrap_u, wrap_v;
} rsv_texture_source;

/// Decodes PNG (8 and 16 bits), JPEG, TGA, BMP, GIF, WebP, KTX2, HDR or EXR, detected by the first bytes, and adds a
/// texture. RSV_ERROR_FORMAT, naming the file, if it cannot be read. @param id out
rsv_status rsv_texture_load(rsv_scene *scene, const rsv_texture_source *source, uint32_t *id);

/// Reads a whole file. @param file out: its bytes are to be freed by rsv_free, also after a failure
rsv_status rsv_image_file_read(
    rsv_context *context, const rsv_file_source *files, const char *path, rsv_image_file *file);

/// WebP as 8-bit codes: three channels, four where it has alpha. As rsv_image_decode_codes.
rsv_status rsv_image_decode_webp(const rsv_image_file *file, rsv_image_codes *codes);
/// The same as a picture; alpha is left out.
rsv_status rsv_image_decode_webp_picture(
    rsv_context *context, const rsv_image_file *file, rsv_image **image);
bool rsv_image_is_webp(const rsv_image_file *file);

/// Decodes a PNG of 16 bits per channel. @param code out: [height * width * channels] 0..65535, to be freed by
/// rsv_image_free_codes16
rsv_status rsv_image_decode_codes16(
    const rsv_image_file *file, uint16_t **code, rsv_image_codes *size);
void rsv_image_free_codes16(uint16_t *code);
bool rsv_image_is_16_bit(const rsv_image_file *file);

#endif
