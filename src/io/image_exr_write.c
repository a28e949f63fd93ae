#include "image_exr.h"

#include <stdio.h>
#include <string.h>

// deflate level 4 is within a few per cent of the smallest size at a third of the time
#define ZIP_LEVEL 4
#define CHANNEL_NAME_BYTES (RSV_LAYER_NAME_BYTES + 2)
#define SHORT_CHANNEL_NAME 31

static int64_t write_stream(exr_const_context_t exr, void *user, const void *data, uint64_t bytes,
    uint64_t offset, exr_stream_error_func_ptr_t fail)
{
    (void)exr, (void)fail; // the file remembers the failure
    rsv_exr_stream *stream = user;
    rsv_atomic_file_write_at(stream->output, offset, data, bytes);
    return stream->output->error ? -1 : (int64_t)bytes;
}

static rsv_status add_channels(
    const rsv_exr_stream *stream, exr_context_t exr, const rsv_image *image)
{
    rsv_status status = RSV_OK;
    bool long_names = false;
    for (uint32_t layer = 0; layer < rsv_image_layer_count(image); layer++) {
        const char *name = rsv_image_layer_name(image, layer);
        for (const char *component = "BGR"; *component; component++) {
            char channel[CHANNEL_NAME_BYTES];
            snprintf(channel, sizeof channel, "%s%s%c", name, *name ? "." : "", *component);
            if (!long_names && strlen(channel) > SHORT_CHANNEL_NAME) {
                long_names = true;
                RSV_TRY(rsv_exr_check(stream, exr_set_longname_support(exr, 1)));
            }
            RSV_TRY(rsv_exr_check(stream, exr_add_channel(exr, 0, channel, EXR_PIXEL_FLOAT,
                                              EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1)));
        }
    }
cleanup:
    return status;
}

static rsv_status write_header(
    const rsv_exr_stream *stream, exr_context_t exr, const rsv_image *image)
{
    rsv_status status = RSV_OK;
    int part;
    RSV_TRY(rsv_exr_check(stream, exr_add_part(exr, "radiance", EXR_STORAGE_SCANLINE, &part)));
    RSV_TRY(rsv_exr_check(
        stream, exr_initialize_required_attr_simple(exr, part, (int32_t)rsv_image_width(image),
                    (int32_t)rsv_image_height(image), EXR_COMPRESSION_ZIP)));
    RSV_TRY(add_channels(stream, exr, image));
    RSV_TRY(rsv_exr_check(stream, exr_write_header(exr)));
cleanup:
    return status;
}

/// Points the encoder's channels at the rows from `y` on.
static void aim_channels(exr_encode_pipeline_t *encoder, const rsv_image *image, int y)
{
    uint32_t width = rsv_image_width(image);
    for (int i = 0; i < encoder->channel_count; i++) {
        exr_coding_channel_info_t *channel = &encoder->channels[i];
        char name[RSV_LAYER_NAME_BYTES];
        const char *component;
        rsv_exr_split_channel(channel->channel_name, name, &component);
        uint32_t layer = rsv_image_find_layer(image, name);
        const float *row = &rsv_image_const_pixels(image, layer)[(size_t)y * width].r;
        channel->encode_from_ptr = (const uint8_t *)(row + (strchr("RGB", *component) - "RGB"));
        channel->user_pixel_stride = sizeof(rsv_rgb);
        channel->user_line_stride = (int32_t)(width * sizeof(rsv_rgb));
        channel->user_bytes_per_element = sizeof(float);
        channel->user_data_type = EXR_PIXEL_FLOAT;
    }
}

/// Readers take a chunk as large as its pixels for uncompressed, but OpenEXR 3.1 keeps compressed data that happens to
/// have that size. This stores the pixels instead. @param encoder its encoding_user_data is the library's own
/// compress_fn
static exr_result_t compress_chunk(exr_encode_pipeline_t *encoder)
{
    exr_result_t (*const *compress)(exr_encode_pipeline_t *) = encoder->encoding_user_data;
    exr_result_t result = (*compress)(encoder);
    if (result == EXR_ERR_SUCCESS && encoder->compressed_bytes == encoder->packed_bytes)
        memcpy(encoder->compressed_buffer, encoder->packed_buffer, encoder->packed_bytes);
    return result;
}

static rsv_status write_chunks(
    const rsv_exr_stream *stream, exr_context_t exr, const rsv_image *image)
{
    rsv_status status = RSV_OK;
    exr_encode_pipeline_t encoder = EXR_ENCODE_PIPELINE_INITIALIZER;
    exr_chunk_info_t chunk;
    int rows;
    RSV_TRY(rsv_exr_check(stream, exr_get_scanlines_per_chunk(exr, 0, &rows)));
    for (int y = 0; y < (int)rsv_image_height(image); y += rows) {
        RSV_TRY(rsv_exr_check(stream, exr_write_scanline_chunk_info(exr, 0, y, &chunk)));
        RSV_TRY(rsv_exr_check(stream, y == 0 ? exr_encoding_initialize(exr, 0, &chunk, &encoder)
                                             : exr_encoding_update(exr, 0, &chunk, &encoder)));
        aim_channels(&encoder, image, y);
        RSV_TRY(rsv_exr_check(stream, exr_encoding_choose_default_routines(exr, 0, &encoder)));
        exr_result_t (*compress)(exr_encode_pipeline_t *) = encoder.compress_fn;
        encoder.encoding_user_data = &compress;
        encoder.compress_fn = compress_chunk;
        RSV_TRY(rsv_exr_check(stream, exr_encoding_run(exr, 0, &encoder)));
    }
cleanup:
    exr_encoding_destroy(exr, &encoder);
    return status;
}

rsv_status rsv_image_encode_exr(const rsv_image *image, float exposure, rsv_atomic_file *file)
{
    (void)exposure;
    rsv_status status = RSV_OK;
    exr_context_t exr = NULL;
    rsv_exr_stream stream = { .output = file };
    exr_context_initializer_t settings = EXR_DEFAULT_CONTEXT_INITIALIZER;
    settings.error_handler_fn = rsv_exr_keep_silent;
    settings.user_data = &stream;
    settings.write_fn = write_stream;
    settings.zip_level = ZIP_LEVEL;
    RSV_TRY(rsv_exr_check(
        &stream, exr_start_write(&exr, file->target, EXR_WRITE_FILE_DIRECTLY, &settings)));
    RSV_TRY(write_header(&stream, exr, image));
    RSV_TRY(write_chunks(&stream, exr, image));
    exr_result_t finished = exr_finish(&exr);
    RSV_TRY(rsv_exr_check(&stream, finished));
cleanup:
    if (exr) exr_finish(&exr);
    return status;
}
