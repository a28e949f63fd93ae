/// Pictures of KTX 2.0 files: texels of 8 bits, 16 bits or floats, and blocks of Basis Universal (ETC1S and UASTC), all
/// stored plainly or packed as the format allows. Other formats of graphics cards are not supported.
#ifndef RSV_IMAGE_KTX_H
#define RSV_IMAGE_KTX_H

#include "image_internal.h"

/// The finest level of a picture, top row first, with alpha if the file has it.
typedef struct rsv_ktx_picture {
    uint32_t width, height, channel_count; ///< 3 or 4
    uint8_t *codes;                        ///< [height * width * channel_count], or NULL
    float *values;                         ///< of the same size; the other array is NULL
    bool are_codes;                        ///< `values` are codes of 16 bits over 65535, not linear
} rsv_ktx_picture;

bool rsv_image_is_ktx(const rsv_image_file *file);

/// RSV_ERROR_FORMAT for damaged files, RSV_ERROR_UNSUPPORTED for other compressed texels, arrays, cubes and volumes.
/// Messages name the file. @param picture to be released by rsv_ktx_free
rsv_status rsv_ktx_decode(
    rsv_context *context, const rsv_image_file *file, rsv_ktx_picture *picture);
void rsv_ktx_free(rsv_context *context, rsv_ktx_picture *picture);

#endif
