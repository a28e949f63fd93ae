/// WebP, through libwebp.
#include "../core/srgb.h"
#include "texture_image.h"

#include <stdlib.h>
#include <webp/decode.h>

/// No honest picture packs more into a byte; but one of a single colour takes almost no bytes.
#define PIXELS_PER_BYTE (UINT64_C(1) << 20)

static rsv_status fail_webp(const rsv_image_file *file, VP8StatusCode code)
{
    const char *why = code == VP8_STATUS_NOT_ENOUGH_DATA ? "the file is truncated"
                      : code == VP8_STATUS_OUT_OF_MEMORY ? "out of memory"
                      : code == VP8_STATUS_UNSUPPORTED_FEATURE
                          ? "a kind of WebP that is not supported"
                          : "its WebP data are damaged";
    return rsv_fail(code == VP8_STATUS_OUT_OF_MEMORY ? RSV_ERROR_MEMORY : RSV_ERROR_FORMAT,
        "cannot read '%s': %s", file->path, why);
}

rsv_status rsv_image_decode_webp(const rsv_image_file *file, rsv_image_codes *codes)
{
    WebPDecoderConfig config;
    if (!WebPInitDecoderConfig(&config))
        return rsv_fail(RSV_ERROR_UNSUPPORTED, "the installed libwebp has an incompatible version");
    VP8StatusCode code = WebPGetFeatures(file->bytes, file->size, &config.input);
    if (code != VP8_STATUS_OK) return fail_webp(file, code);
    if (config.input.has_animation)
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "cannot read '%s': it is an animation; export a single picture", file->path);
    int width = config.input.width, height = config.input.height; // at most 16383 each
    if ((uint64_t)width * (uint64_t)height / PIXELS_PER_BYTE > file->size)
        return rsv_fail(RSV_ERROR_FORMAT,
            "cannot read '%s': %d x %d pixels do not fit in %zu bytes", file->path, width, height,
            file->size);
    size_t channels = config.input.has_alpha ? 4 : 3;
    size_t bytes = (size_t)width * (size_t)height * channels;
    uint8_t *pixel = malloc(bytes);
    if (!pixel) return fail_webp(file, VP8_STATUS_OUT_OF_MEMORY);
    config.output.colorspace = channels == 4 ? MODE_RGBA : MODE_RGB;
    config.output.is_external_memory = 1;
    config.output.u.RGBA.rgba = pixel;
    config.output.u.RGBA.stride = width * (int)channels;
    config.output.u.RGBA.size = bytes;
    code = WebPDecode(file->bytes, file->size, &config);
    WebPFreeDecBuffer(&config.output);
    if (code != VP8_STATUS_OK) {
        free(pixel);
        return fail_webp(file, code);
    }
    *codes = (rsv_image_codes){ pixel, (uint32_t)width, (uint32_t)height, (uint32_t)channels };
    return RSV_OK;
}

rsv_status rsv_image_decode_webp_picture(
    rsv_context *context, const rsv_image_file *file, rsv_image **image)
{
    rsv_status status;
    rsv_image_codes codes = { 0 };
    rsv_image *decoded = NULL;
    float linear[256];
    RSV_TRY(rsv_image_decode_webp(file, &codes));
    RSV_TRY(rsv_image_create(context, codes.width, codes.height, 1, &decoded));
    for (int k = 0; k < 256; k++)
        linear[k] = (float)rsv_srgb_decode(k / 255.0);
    for (size_t i = 0; i < (size_t)codes.width * codes.height; i++) {
        const uint8_t *c = codes.code + i * codes.channel_count;
        rsv_image_pixels(decoded, 0)[i] = (rsv_rgb){ linear[c[0]], linear[c[1]], linear[c[2]] };
    }
    *image = decoded;
cleanup:
    rsv_image_free_codes(&codes);
    return status;
}
