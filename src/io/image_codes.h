/// Pictures as the codes they are stored as.
#ifndef RSV_IMAGE_CODES_H
#define RSV_IMAGE_CODES_H

#include "../core/core.h"

/// Encodes 8-bit RGB codes as PNG, unchanged. @param bytes out: to be freed
rsv_status rsv_image_png_from_codes(rsv_context *context, const uint8_t (*codes)[3], uint32_t width,
    uint32_t height, uint8_t **bytes, size_t *count);

#endif
