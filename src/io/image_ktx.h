/// Pictures of KTX 2.0 files: texels as they are stored in 8 or 16 bits or floats, plain or packed by Zstandard or zlib.
/// What Basis Universal or a graphics card has compressed is refused.
#ifndef RSV_IMAGE_KTX_H
#define RSV_IMAGE_KTX_H

#include "image_internal.h"

/// The finest level of a picture, row 0 on top; alpha is there where the file has it.
typedef struct rsv_ktx_picture {
    uint32_t width, height, channel_count; ///< 3 or 4
    uint8_t *codes;                        ///< [height * width * channel_count], or NULL
    float *values;                         ///< likewise; the other is NULL
    bool are_codes;                        ///< `values` are codes of 16 bits over 65535, not linear
} rsv_ktx_picture;

bool rsv_image_is_ktx(const rsv_image_file *file);

/// RSV_ERROR_FORMAT for damaged files, RSV_ERROR_UNSUPPORTED for compressed texels, arrays, cubes and volumes: the message
/// names the file. @param picture to be released by rsv_ktx_free
rsv_status rsv_ktx_decode(
    rsv_context *context, const rsv_image_file *file, rsv_ktx_picture *picture);
void rsv_ktx_free(rsv_context *context, rsv_ktx_picture *picture);

#endif
