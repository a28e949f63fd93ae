#include "../core/vec.h"
#include "image_exr.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/// Which channels hold a layer: indices into the file's channel list, -1 = absent.
typedef struct layer_source {
    char name[RSV_LAYER_NAME_BYTES];
    int rgb[3];
    int luminance;
    bool has_chroma;
} layer_source;

typedef struct reader {
    rsv_context *context;
    rsv_exr_stream stream;
    exr_context_t exr;
    exr_attr_box2i_t data_window, display_window;
    const exr_attr_chlist_t *channels;
    layer_source *layers; // [layer_count]; layers that are pictures come first
    uint32_t layer_count;
    float *samples; // [channel_count][height][width] of the chunk being decoded
    rsv_image *image;
} reader;

static int64_t stream_size(exr_const_context_t exr, void *user)
{
    (void)exr;
    return (int64_t)((const rsv_exr_stream *)user)->input->size;
}

static int64_t read_stream(exr_const_context_t exr, void *user, void *data, uint64_t bytes,
    uint64_t offset, exr_stream_error_func_ptr_t fail)
{
    (void)exr, (void)fail; // the library reports a short read itself
    const rsv_image_file *file = ((const rsv_exr_stream *)user)->input;
    if (offset >= file->size) return 0;
    if (bytes > file->size - offset) bytes = file->size - offset;
    memcpy(data, file->bytes + offset, bytes);
    return (int64_t)bytes;
}

static int64_t box_width(exr_attr_box2i_t box) { return (int64_t)box.max.x - box.min.x + 1; }

static int64_t box_height(exr_attr_box2i_t box) { return (int64_t)box.max.y - box.min.y + 1; }

static rsv_status open_file(reader *in)
{
    rsv_status status = RSV_OK;
    const char *path = in->stream.input->path;
    exr_context_initializer_t settings = EXR_DEFAULT_CONTEXT_INITIALIZER;
    settings.error_handler_fn = rsv_exr_keep_silent;
    settings.user_data = &in->stream;
    settings.read_fn = read_stream;
    settings.size_fn = stream_size;
    settings.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    RSV_TRY(rsv_exr_check(&in->stream, exr_start_read(&in->exr, path, &settings)));
    RSV_TRY(rsv_exr_check(&in->stream, exr_get_data_window(in->exr, 0, &in->data_window)));
    RSV_TRY(rsv_exr_check(&in->stream, exr_get_display_window(in->exr, 0, &in->display_window)));
    RSV_TRY(rsv_exr_check(&in->stream, exr_get_channels(in->exr, 0, &in->channels)));
    RSV_TRY(rsv_image_check_size(path, box_width(in->data_window), box_height(in->data_window)));
    RSV_TRY(
        rsv_image_check_size(path, box_width(in->display_window), box_height(in->display_window)));
cleanup:
    return status;
}

/// Pixels outside the display window are cropped. Fails if none are left.
static rsv_status check_windows(const reader *in)
{
    exr_attr_box2i_t data = in->data_window, shown = in->display_window;
    bool apart = data.min.x > shown.max.x || data.max.x < shown.min.x || data.min.y > shown.max.y ||
                 data.max.y < shown.min.y;
    if (!apart) return RSV_OK;
    return rsv_fail(RSV_ERROR_FORMAT,
        "cannot read '%s': its pixels lie outside of its display window", in->stream.input->path);
}

/// Warns of what is not read: parts after the first, and primaries other than those of sRGB.
static void warn_of_losses(const reader *in)
{
    static const float usual[6] = { 0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f };
    const char *path = in->stream.input->path;
    exr_attr_chromaticities_t c;
    int parts = 1;
    if (exr_get_count(in->exr, &parts) == EXR_ERR_SUCCESS && parts > 1)
        rsv_log(in->context, RSV_LOG_WARNING, "'%s': only the first of its %d parts is used", path,
            parts);
    if (exr_attr_get_chromaticities(in->exr, 0, "chromaticities", &c) != EXR_ERR_SUCCESS) return;
    const float given[6] = { c.red_x, c.red_y, c.green_x, c.green_y, c.blue_x, c.blue_y };
    for (int k = 0; k < 6; k++) {
        if (fabsf(given[k] - usual[k]) <= 0.02f) continue;
        rsv_log(in->context, RSV_LOG_WARNING,
            "'%s': its chromaticities are ignored; its colours are assumed to be sRGB", path);
        return;
    }
}

static layer_source *find_or_add_layer(reader *in, const char *name)
{
    for (uint32_t i = 0; i < in->layer_count; i++)
        if (strcmp(in->layers[i].name, name) == 0) return &in->layers[i];
    layer_source *added = &in->layers[in->layer_count++];
    *added = (layer_source){ .rgb = { -1, -1, -1 }, .luminance = -1 };
    strcpy(added->name, name);
    return added;
}

/// Adds to a list of names, with commas, while it has room.
static void note_unused(char *list, size_t size, const char *channel)
{
    size_t used = strlen(list);
    if (used + strlen(channel) + 3 < size)
        snprintf(list + used, size - used, "%s%s", used ? ", " : "", channel);
}

/// Channels of depth, names and the like are no colours; that there is alpha goes without saying.
static void register_channel(reader *in, int index, char *unused, size_t size)
{
    char name[RSV_LAYER_NAME_BYTES];
    const char *component;
    const char *channel = in->channels->entries[index].name.str;
    if (!rsv_exr_split_channel(channel, name, &component)) {
        rsv_log(in->context, RSV_LOG_WARNING, "'%s': channel '%s' left out: its name is too long",
            in->stream.input->path, channel);
        return;
    }
    layer_source *layer = find_or_add_layer(in, name);
    if (strcmp(component, "R") == 0) layer->rgb[0] = index;
    if (strcmp(component, "G") == 0) layer->rgb[1] = index;
    if (strcmp(component, "B") == 0) layer->rgb[2] = index;
    if (strcmp(component, "Y") == 0) layer->luminance = index;
    if (strcmp(component, "RY") == 0 || strcmp(component, "BY") == 0) layer->has_chroma = true;
    static const char *const known[] = { "R", "G", "B", "Y", "RY", "BY", "A" };
    for (size_t k = 0; k < sizeof known / sizeof *known; k++)
        if (strcmp(component, known[k]) == 0) return;
    note_unused(unused, size, channel);
}

/// A layer of grey counts as RGB with three times the same channel.
static void spread_grey(layer_source *layer, int channel)
{
    for (int c = 0; c < 3; c++)
        layer->rgb[c] = channel;
}

static bool is_picture(layer_source *layer)
{
    if (layer->rgb[0] >= 0 && layer->rgb[1] >= 0 && layer->rgb[2] >= 0) return true;
    if (layer->luminance < 0 || layer->has_chroma) return false;
    spread_grey(layer, layer->luminance);
    return true;
}

/// Some programs store grey in R alone. R is taken for grey only if there is nothing better, since a mask looks the
/// same.
static bool takes_red_for_grey(reader *in)
{
    for (uint32_t i = 0; i < in->layer_count; i++) {
        layer_source *layer = &in->layers[i];
        bool is_red = layer->rgb[0] >= 0 && layer->rgb[1] < 0 && layer->rgb[2] < 0;
        if (!is_red || layer->luminance >= 0 || layer->has_chroma) continue;
        spread_grey(layer, layer->rgb[0]);
        in->layers[0] = *layer;
        in->layer_count = 1;
        rsv_log(in->context, RSV_LOG_WARNING,
            "'%s': it has R and neither G nor B; R is used as grey", in->stream.input->path);
        return true;
    }
    return false;
}

/// Names the colours of a layer that is no picture.
static void note_partial(const layer_source *layer, char *unused, size_t size)
{
    static const char *const component[] = { "R", "G", "B" };
    for (int c = 0; c < 3; c++) {
        char name[RSV_LAYER_NAME_BYTES + 2];
        snprintf(name, sizeof name, "%s%s%s", layer->name, *layer->name ? "." : "", component[c]);
        if (layer->rgb[c] >= 0) note_unused(unused, size, name);
    }
}

/// Keeps the layers that are pictures, the unnamed one first. @return whether there are any
static bool select_layers(reader *in, char *unused, size_t size)
{
    uint32_t kept = 0;
    char partial[256] = "";
    for (uint32_t i = 0; i < in->layer_count; i++) {
        layer_source layer = in->layers[i];
        if (!is_picture(&layer)) {
            note_partial(&layer, partial, sizeof partial);
        } else if (!layer.name[0]) {
            memmove(in->layers + 1, in->layers, kept++ * sizeof *in->layers);
            in->layers[0] = layer;
        } else {
            in->layers[kept++] = layer;
        }
    }
    if (kept == 0) return takes_red_for_grey(in);
    if (*partial) note_unused(unused, size, partial);
    in->layer_count = kept;
    return true;
}

static rsv_status find_layers(reader *in)
{
    const char *path = in->stream.input->path;
    in->layers = rsv_alloc(in->context, (size_t)in->channels->num_channels, sizeof *in->layers);
    if (!in->layers) return RSV_ERROR_MEMORY;
    char unused[512] = "";
    for (int i = 0; i < in->channels->num_channels; i++)
        register_channel(in, i, unused, sizeof unused);
    if (!select_layers(in, unused, sizeof unused))
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "cannot read '%s': its first part has neither R, G, B nor plain luminance (Y) channels",
            path);
    if (*unused)
        rsv_log(in->context, RSV_LOG_WARNING, "'%s': channels that are not used: %s", path, unused);
    return RSV_OK;
}

static rsv_status check_compression(const reader *in)
{
    exr_compression_t compression;
    rsv_status status = rsv_exr_check(&in->stream, exr_get_compression(in->exr, 0, &compression));
    if (status != RSV_OK) return status;
    if (compression != EXR_COMPRESSION_B44 && compression != EXR_COMPRESSION_B44A) return RSV_OK;
    // OpenEXR 3.1.5 decodes it without an error but wrongly, except for halves in 4 x 4 blocks
    return rsv_fail(RSV_ERROR_UNSUPPORTED,
        "cannot read '%s': B44 compression; save it with ZIP or PIZ", in->stream.input->path);
}

static rsv_status check_sampling(const reader *in)
{
    for (uint32_t i = 0; i < 3 * in->layer_count; i++) {
        const exr_attr_chlist_entry_t *channel =
            &in->channels->entries[in->layers[i / 3].rgb[i % 3]];
        if (channel->x_sampling != 1 || channel->y_sampling != 1)
            return rsv_fail(RSV_ERROR_UNSUPPORTED,
                "cannot read '%s': channel '%s' is subsampled; store it at full resolution",
                in->stream.input->path, channel->name.str);
    }
    return RSV_OK;
}

static rsv_status create_image(reader *in)
{
    rsv_status status = RSV_OK;
    RSV_TRY(rsv_image_create(in->context, (uint32_t)box_width(in->display_window),
        (uint32_t)box_height(in->display_window), in->layer_count, &in->image));
    for (uint32_t i = 0; i < in->layer_count; i++)
        RSV_TRY(rsv_image_set_layer_name(in->image, i, in->layers[i].name));
cleanup:
    return status;
}

/// Copies the decoded chunk to where it lies in the display window; the rest is cropped.
/// @param left, top the chunk's first pixel, relative to the display window
static void copy_chunk(reader *in, int64_t left, int64_t top, int64_t width, int64_t height)
{
    int64_t columns = rsv_image_width(in->image), rows = rsv_image_height(in->image);
    int64_t first_x = left < 0 ? -left : 0,
            last_x = width < columns - left ? width : columns - left;
    int64_t first_y = top < 0 ? -top : 0, last_y = height < rows - top ? height : rows - top;
    for (uint32_t layer = 0; layer < in->layer_count; layer++) {
        const float *plane[3];
        for (int c = 0; c < 3; c++)
            plane[c] = in->samples + in->layers[layer].rgb[c] * (width * height);
        rsv_rgb *pixels = rsv_image_pixels(in->image, layer);
        for (int64_t y = first_y; y < last_y; y++)
            for (int64_t x = first_x; x < last_x; x++) {
                int64_t i = y * width + x;
                pixels[(top + y) * columns + left + x] = rgb(plane[0][i], plane[1][i], plane[2][i]);
            }
    }
}

/// Decodes one chunk into `samples`: every channel, because the library crashes when it converts
/// halves and some channels are left out (OpenEXR issue 1991).
static rsv_status decode_chunk(
    reader *in, const exr_chunk_info_t *chunk, exr_decode_pipeline_t *decoder, bool is_first)
{
    rsv_status status = RSV_OK;
    RSV_TRY(
        rsv_exr_check(&in->stream, is_first ? exr_decoding_initialize(in->exr, 0, chunk, decoder)
                                            : exr_decoding_update(in->exr, 0, chunk, decoder)));
    for (int i = 0; i < decoder->channel_count; i++) {
        exr_coding_channel_info_t *channel = &decoder->channels[i];
        float *plane = in->samples + (int64_t)i * chunk->width * chunk->height;
        channel->decode_to_ptr = (uint8_t *)plane;
        channel->user_pixel_stride = sizeof(float);
        channel->user_line_stride = chunk->width * (int32_t)sizeof(float);
        channel->user_bytes_per_element = sizeof(float);
        channel->user_data_type = EXR_PIXEL_FLOAT;
    }
    RSV_TRY(rsv_exr_check(&in->stream, exr_decoding_choose_default_routines(in->exr, 0, decoder)));
    RSV_TRY(rsv_exr_check(&in->stream, exr_decoding_run(in->exr, 0, decoder)));
cleanup:
    return status;
}

/// Decodes the picture in chunks of chunk_width x chunk_height: tiles of the finest level, or bands
/// of lines across the whole data window.
static rsv_status decode_chunks(
    reader *in, bool is_tiled, int64_t chunk_width, int64_t chunk_height)
{
    rsv_status status = RSV_OK;
    exr_decode_pipeline_t decoder = EXR_DECODE_PIPELINE_INITIALIZER;
    int64_t width = box_width(in->data_window), height = box_height(in->data_window);
    int64_t shift_x = (int64_t)in->data_window.min.x - in->display_window.min.x;
    int64_t shift_y = (int64_t)in->data_window.min.y - in->display_window.min.y;
    if (chunk_width > width) chunk_width = width;
    if (chunk_height > height) chunk_height = height;
    in->samples = rsv_alloc(in->context, (size_t)in->channels->num_channels,
        (size_t)(chunk_width * chunk_height) * sizeof *in->samples);
    if (!in->samples) RSV_TRY(RSV_ERROR_MEMORY);
    for (int64_t y = 0; y < height; y += chunk_height)
        for (int64_t x = 0; x < width; x += chunk_width) {
            exr_chunk_info_t chunk;
            RSV_TRY(rsv_exr_check(
                &in->stream, is_tiled ? exr_read_tile_chunk_info(in->exr, 0, (int)(x / chunk_width),
                                            (int)(y / chunk_height), 0, 0, &chunk)
                                      : exr_read_scanline_chunk_info(
                                            in->exr, 0, (int)(in->data_window.min.y + y), &chunk)));
            RSV_ASSERT(chunk.width <= chunk_width && chunk.height <= chunk_height);
            RSV_TRY(decode_chunk(in, &chunk, &decoder, x == 0 && y == 0));
            copy_chunk(in, shift_x + x, shift_y + y, chunk.width, chunk.height);
        }
cleanup:
    exr_decoding_destroy(in->exr, &decoder);
    return status;
}

static rsv_status decode_pixels(reader *in)
{
    rsv_status status = RSV_OK;
    exr_storage_t storage;
    int32_t width = (int32_t)box_width(in->data_window), height = 0;
    RSV_TRY(rsv_exr_check(&in->stream, exr_get_storage(in->exr, 0, &storage)));
    if (storage == EXR_STORAGE_SCANLINE)
        RSV_TRY(rsv_exr_check(&in->stream, exr_get_scanlines_per_chunk(in->exr, 0, &height)));
    else if (storage == EXR_STORAGE_TILED)
        RSV_TRY(rsv_exr_check(&in->stream, exr_get_tile_sizes(in->exr, 0, 0, 0, &width, &height)));
    else
        RSV_TRY(rsv_fail(RSV_ERROR_UNSUPPORTED,
            "cannot read '%s': it holds deep pixels; flatten it first", in->stream.input->path));
    if (width < 1 || height < 1)
        RSV_TRY(rsv_fail(
            RSV_ERROR_FORMAT, "cannot read '%s': invalid tile size", in->stream.input->path));
    RSV_TRY(create_image(in));
    RSV_TRY(decode_chunks(in, storage == EXR_STORAGE_TILED, width, height));
cleanup:
    return status;
}

rsv_status rsv_image_decode_exr(rsv_context *context, const rsv_image_file *file, rsv_image **image)
{
    rsv_status status = RSV_OK;
    reader in = { .context = context, .stream = { .input = file } };
    RSV_TRY(open_file(&in));
    RSV_TRY(check_windows(&in));
    RSV_TRY(check_compression(&in));
    RSV_TRY(find_layers(&in));
    RSV_TRY(check_sampling(&in));
    warn_of_losses(&in);
    RSV_TRY(decode_pixels(&in));
    *image = in.image;
    in.image = NULL;
cleanup:
    rsv_image_destroy(in.image);
    rsv_free(context, in.samples);
    rsv_free(context, in.layers);
    if (in.exr) exr_finish(&in.exr);
    return status;
}
