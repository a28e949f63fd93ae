#include "core/sampling.h"
#include "core/srgb.h"
#include "core/vec.h"
#include "io/atomic_file.h"
#include "resolvent/image.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

#include <dirent.h>
#include <limits.h>
#include <openexr.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#define LONGEST_NAME "a.layer.name.of.sixty-three.bytes.which.is.all.that.fits.in.it."

static char folder[] = "/tmp/resolvent-image-XXXXXX";
static rsv_context *context;
static int live_allocations, allocations_before_test;
static int allocations_left = INT_MAX; // until memory runs out

static void *counting_allocate(void *user, size_t bytes)
{
    (void)user;
    if (allocations_left == 0) return NULL;
    allocations_left--;
    live_allocations++;
    return aligned_alloc(64, bytes);
}

static void counting_release(void *user, void *memory)
{
    (void)user;
    live_allocations--;
    free(memory);
}

static int create_folder(void **state)
{
    (void)state;
    rsv_context_desc desc = rsv_default_context_desc();
    desc.allocate = counting_allocate;
    desc.release = counting_release;
    return !mkdtemp(folder) || rsv_context_create(&desc, &context) != RSV_OK;
}

static const char *path_of(const char *name)
{
    static char paths[4][512];
    static int next;
    char *path = paths[next++ % 4];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

/// Removes the folder's files; returns how many there were.
static int clear_folder(void)
{
    int count = 0;
    DIR *listing = opendir(folder);
    for (struct dirent *entry; (entry = readdir(listing));) {
        if (strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0) continue;
        remove(path_of(entry->d_name));
        count++;
    }
    closedir(listing);
    return count;
}

static int remove_folder(void **state)
{
    (void)state;
    clear_folder();
    rsv_context_destroy(context);
    return rmdir(folder);
}

static int start_clean(void **state)
{
    (void)state;
    clear_folder();
    allocations_before_test = live_allocations;
    return 0;
}

static int check_leaks(void **state)
{
    (void)state;
    return live_allocations != allocations_before_test;
}

static void write_bytes(const char *path, const void *bytes, size_t size)
{
    FILE *stream = fopen(path, "wb");
    assert_non_null(stream);
    assert_int_equal(fwrite(bytes, 1, size, stream), size);
    assert_int_equal(fclose(stream), 0);
}

static uint8_t *read_bytes(const char *path, size_t *size)
{
    struct stat properties;
    assert_int_equal(stat(path, &properties), 0);
    *size = (size_t)properties.st_size;
    uint8_t *bytes = malloc(*size + 1);
    FILE *stream = fopen(path, "rb");
    assert_int_equal(fread(bytes, 1, *size, stream), *size);
    fclose(stream);
    return bytes;
}

static uint32_t hash_state;

static float random_float(void)
{
    hash_state = hash_state * 1664525u + 1013904223u;
    return (float)(hash_state >> 8) * 0x1p-24f;
}

/// A smooth picture with some noise over six decades.
static rsv_image *make_image(uint32_t width, uint32_t height, uint32_t layer_count)
{
    rsv_image *image;
    assert_int_equal(rsv_image_create(context, width, height, layer_count, &image), RSV_OK);
    hash_state = 7;
    for (uint32_t layer = 0; layer < layer_count; layer++)
        for (uint32_t i = 0; i < width * height; i++) {
            float level = powf(10, 6 * (float)i / (float)(width * height) - 3);
            rsv_image_pixels(image, layer)[i] =
                rgb(level * random_float(), level * random_float(), level * random_float());
        }
    return image;
}

static rsv_image *read_image(const char *path)
{
    rsv_image *image = NULL;
    rsv_status status = rsv_image_read(context, path, &image);
    if (status != RSV_OK) fail_msg("%s", rsv_last_error());
    return image;
}

static void expect_failure(const char *path, rsv_status expected, const char *message_part)
{
    rsv_image *image = NULL;
    rsv_status status = rsv_image_read(context, path, &image);
    if (status != expected || !strstr(rsv_last_error(), message_part) ||
        !strstr(rsv_last_error(), path) || image)
        fail_msg("%s: status %d, message: %s", path, status, rsv_last_error());
}

// ---- OpenEXR ----

static void exr_keeps_every_bit_of_every_layer(void **state)
{
    (void)state;
    const char *names[] = { "", "direct", LONGEST_NAME };
    rsv_image *image = make_image(37, 53, 3);
    for (uint32_t i = 1; i < 3; i++)
        assert_int_equal(rsv_image_set_layer_name(image, i, names[i]), RSV_OK);
    rsv_image_pixels(image, 1)[0] = rgb(INFINITY, -0.0f, NAN);
    rsv_image_pixels(image, 1)[1] = rgb(1e-45f, 3.4e38f, -1);
    if (rsv_image_write(image, path_of("a.exr"), 3) != RSV_OK) fail_msg("%s", rsv_last_error());

    rsv_image *back = read_image(path_of("a.exr"));
    assert_int_equal(rsv_image_width(back), 37);
    assert_int_equal(rsv_image_height(back), 53);
    assert_int_equal(rsv_image_layer_count(back), 3);
    assert_string_equal(rsv_image_layer_name(back, 0), "");
    for (uint32_t i = 0; i < 3; i++) {
        uint32_t layer = rsv_image_find_layer(back, names[i]);
        assert_int_not_equal(layer, UINT32_MAX);
        assert_memory_equal(
            rsv_image_pixels(image, i), rsv_image_pixels(back, layer), 37 * 53 * sizeof(rsv_rgb));
    }
    assert_int_equal(rsv_image_find_layer(back, "bounce1"), UINT32_MAX);
    assert_int_equal(clear_folder(), 1);
    rsv_image_destroy(image);
    rsv_image_destroy(back);
}

/// Among pictures of more and more noise there are some whose chunks compress to the size of their pixels.
static void exr_keeps_what_hardly_compresses(void **state)
{
    (void)state;
    rsv_image *image = make_image(16, 16, 1);
    float *value = &rsv_image_pixels(image, 0)->r;
    size_t count = 3 * 16 * 16;
    for (uint32_t seed = 0; seed < 8; seed++) {
        hash_state = seed;
        memset(value, 0, count * sizeof *value);
        for (size_t k = 0; k < count; k++) {
            value[k * 77 % count] = random_float();
            if (k < count / 2 || k % 2) continue;
            rsv_status status = rsv_image_write(image, path_of("a.exr"), 0);
            if (status != RSV_OK) fail_msg("%s", rsv_last_error());
            rsv_image *back = read_image(path_of("a.exr"));
            assert_memory_equal(value, rsv_image_pixels(back, 0), count * sizeof *value);
            rsv_image_destroy(back);
        }
    }
    assert_int_equal(clear_folder(), 1);
    rsv_image_destroy(image);
}

/// What a foreign program might write.
typedef struct exr_variant {
    exr_storage_t storage;
    exr_compression_t compression;
    exr_pixel_type_t type;
    const char *channels[5];
    exr_attr_box2i_t data_window, display_window;
} exr_variant;

static float variant_value(int channel, int x, int y) { return (float)(16 * channel + x + 4 * y); }

static void fill_chunk(exr_encode_pipeline_t *encoder, float *values, int left, int top)
{
    int width = encoder->chunk.width, height = encoder->chunk.height;
    for (int c = 0; c < encoder->channel_count; c++) {
        for (int i = 0; i < width * height; i++)
            values[c * width * height + i] = variant_value(c, left + i % width, top + i / width);
        exr_coding_channel_info_t *channel = &encoder->channels[c];
        channel->encode_from_ptr = (const uint8_t *)(values + c * width * height);
        channel->user_pixel_stride = 4;
        channel->user_line_stride = 4 * width;
        channel->user_bytes_per_element = 4;
        channel->user_data_type = EXR_PIXEL_FLOAT;
    }
}

static void write_variant_chunk(exr_context_t exr, const exr_chunk_info_t *chunk, int left, int top)
{
    float values[4 * 16 * 16];
    exr_encode_pipeline_t encoder = EXR_ENCODE_PIPELINE_INITIALIZER;
    assert_int_equal(exr_encoding_initialize(exr, 0, chunk, &encoder), 0);
    fill_chunk(&encoder, values, left, top);
    assert_int_equal(exr_encoding_choose_default_routines(exr, 0, &encoder), 0);
    assert_int_equal(exr_encoding_run(exr, 0, &encoder), 0);
    exr_encoding_destroy(exr, &encoder);
}

/// At most 16 x 16 pixels and 4 channels; tiles of 4 x 4.
static void write_variant(const char *path, const exr_variant *variant)
{
    int part, rows;
    exr_context_t exr;
    exr_chunk_info_t chunk;
    exr_attr_v2f_t centre = { .x = 0, .y = 0 };
    const exr_attr_box2i_t *box = &variant->data_window;
    assert_int_equal(exr_start_write(&exr, path, EXR_WRITE_FILE_DIRECTLY, NULL), 0);
    assert_int_equal(exr_add_part(exr, "part", variant->storage, &part), 0);
    assert_int_equal(exr_initialize_required_attr(exr, 0, &variant->display_window, box, 1, &centre,
                         1, EXR_LINEORDER_INCREASING_Y, variant->compression),
        0);
    for (int c = 0; variant->channels[c]; c++)
        assert_int_equal(exr_add_channel(exr, 0, variant->channels[c], variant->type,
                             EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1),
            0);
    if (variant->storage == EXR_STORAGE_TILED)
        assert_int_equal(
            exr_set_tile_descriptor(exr, 0, 4, 4, EXR_TILE_ONE_LEVEL, EXR_TILE_ROUND_DOWN), 0);
    assert_int_equal(exr_write_header(exr), 0);
    if (variant->storage == EXR_STORAGE_TILED) {
        for (int y = 0; y <= box->max.y - box->min.y; y += 4)
            for (int x = 0; x <= box->max.x - box->min.x; x += 4) {
                assert_int_equal(exr_write_tile_chunk_info(exr, 0, x / 4, y / 4, 0, 0, &chunk), 0);
                write_variant_chunk(exr, &chunk, x, y);
            }
    } else {
        assert_int_equal(exr_get_scanlines_per_chunk(exr, 0, &rows), 0);
        for (int y = box->min.y; y <= box->max.y; y += rows) {
            assert_int_equal(exr_write_scanline_chunk_info(exr, 0, y, &chunk), 0);
            write_variant_chunk(exr, &chunk, 0, y - box->min.y);
        }
    }
    assert_int_equal(exr_finish(&exr), 0);
}

static void exr_reads_foreign_storage(void **state)
{
    (void)state;
    const exr_storage_t storages[] = { EXR_STORAGE_SCANLINE, EXR_STORAGE_TILED };
    const exr_compression_t compressions[] = { EXR_COMPRESSION_NONE, EXR_COMPRESSION_RLE,
        EXR_COMPRESSION_ZIPS, EXR_COMPRESSION_ZIP, EXR_COMPRESSION_PIZ, EXR_COMPRESSION_PXR24 };
    const exr_pixel_type_t types[] = { EXR_PIXEL_HALF, EXR_PIXEL_FLOAT, EXR_PIXEL_UINT };
    exr_variant variant = { .channels = { "A", "B", "G", "R" } };
    variant.data_window.max.x = variant.display_window.max.x = 12;
    variant.data_window.max.y = variant.display_window.max.y = 9;
    for (int i = 0; i < 2 * 6 * 3; i++) {
        variant.storage = storages[i % 2];
        variant.compression = compressions[i / 2 % 6];
        variant.type = types[i / 12];
        if (variant.storage == EXR_STORAGE_TILED && variant.compression == EXR_COMPRESSION_PXR24)
            continue; // OpenEXR 3.1.5 does not read back the tile of 1 x 2 pixels it writes
        write_variant(path_of("foreign.exr"), &variant);
        rsv_image *image = read_image(path_of("foreign.exr"));
        assert_int_equal(rsv_image_width(image), 13);
        assert_int_equal(rsv_image_height(image), 10);
        assert_int_equal(rsv_image_layer_count(image), 1);
        for (int p = 0; p < 130; p++) {
            rsv_rgb pixel = rsv_image_pixels(image, 0)[p];
            assert_float_equal(pixel.r, variant_value(3, p % 13, p / 13), 0);
            assert_float_equal(pixel.g, variant_value(2, p % 13, p / 13), 0);
            assert_float_equal(pixel.b, variant_value(1, p % 13, p / 13), 0);
        }
        rsv_image_destroy(image);
    }
}

static void exr_places_the_data_window_in_the_display_window(void **state)
{
    (void)state;
    exr_variant variant = { .compression = EXR_COMPRESSION_ZIP,
        .type = EXR_PIXEL_FLOAT,
        .channels = { "s.B", "s.G", "s.R" } };
    // five columns stand out on the left, two rows of the picture stay empty at the bottom
    variant.data_window = (exr_attr_box2i_t){ { .x = -5, .y = 2 }, { .x = 6, .y = 9 } };
    variant.display_window = (exr_attr_box2i_t){ { .x = 0, .y = 3 }, { .x = 6, .y = 11 } };
    for (int tiled = 0; tiled < 2; tiled++) {
        variant.storage = tiled ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE;
        write_variant(path_of("window.exr"), &variant);
        rsv_image *image = read_image(path_of("window.exr"));
        assert_string_equal(rsv_image_layer_name(image, 0), "s");
        assert_int_equal(rsv_image_width(image), 7);
        assert_int_equal(rsv_image_height(image), 9);
        for (int y = 0; y < 9; y++)
            for (int x = 0; x < 7; x++)
                assert_float_equal(rsv_image_pixels(image, 0)[7 * y + x].r,
                    y < 7 ? variant_value(2, x + 5, y + 1) : 0, 0);
        rsv_image_destroy(image);
    }
    variant.display_window = (exr_attr_box2i_t){ { .x = 50, .y = 3 }, { .x = 56, .y = 11 } };
    write_variant(path_of("apart.exr"), &variant);
    expect_failure(path_of("apart.exr"), RSV_ERROR_FORMAT, "outside of its display window");
}

static char logged[1024];

static void keep_log(void *user, rsv_log_level level, const char *message)
{
    (void)user, (void)level;
    snprintf(logged + strlen(logged), sizeof logged - strlen(logged), "%s\n", message);
}

/// Depth and named channels are not colours. Alpha is ignored without a warning.
static void exr_channels_that_are_no_colours_are_named(void **state)
{
    (void)state;
    exr_variant variant = { .compression = EXR_COMPRESSION_ZIP, .type = EXR_PIXEL_FLOAT };
    static const char *const named[][2] = { { "A", "" }, { "Z", "not used: Z\n" } };
    rsv_context *own;
    rsv_context_desc desc = rsv_default_context_desc();
    desc.log = keep_log;
    assert_int_equal(rsv_context_create(&desc, &own), RSV_OK);
    variant.data_window = variant.display_window =
        (exr_attr_box2i_t){ { .x = 0, .y = 0 }, { .x = 3, .y = 3 } };
    for (int k = 0; k < 2; k++) {
        rsv_image *image;
        memcpy(variant.channels, (const char *[5]){ "B", "G", "R", named[k][0] },
            sizeof variant.channels);
        logged[0] = '\0';
        write_variant(path_of("more.exr"), &variant);
        assert_int_equal(rsv_image_read(own, path_of("more.exr"), &image), RSV_OK);
        if (*named[k][1])
            assert_non_null(strstr(logged, named[k][1]));
        else
            assert_string_equal(logged, "");
        rsv_image_destroy(image);
    }
    rsv_context_destroy(own);
}

static void exr_refuses_what_the_library_misreads(void **state)
{
    (void)state;
    exr_variant variant = {
        .compression = EXR_COMPRESSION_B44, .type = EXR_PIXEL_HALF, .channels = { "B", "G", "R" }
    };
    write_variant(path_of("b44.exr"), &variant);
    expect_failure(path_of("b44.exr"), RSV_ERROR_UNSUPPORTED, "B44");
}

static void exr_reads_luminance_as_grey(void **state)
{
    (void)state;
    exr_variant variant = { .type = EXR_PIXEL_HALF, .channels = { "Y" } };
    write_variant(path_of("grey.exr"), &variant);
    rsv_image *image = read_image(path_of("grey.exr"));
    assert_float_equal(rsv_image_pixels(image, 0)->g, variant_value(0, 0, 0), 0);
    rsv_image_destroy(image);

    variant.channels[0] = "Z";
    write_variant(path_of("depth.exr"), &variant);
    expect_failure(path_of("depth.exr"), RSV_ERROR_UNSUPPORTED, "neither R, G, B");
    variant.channels[0] = "BY", variant.channels[1] = "RY", variant.channels[2] = "Y";
    write_variant(path_of("chroma.exr"), &variant);
    expect_failure(path_of("chroma.exr"), RSV_ERROR_UNSUPPORTED, "neither R, G, B");
}

/// R alone is grey, except next to a picture, where it may be a mask.
static void exr_reads_lone_red_as_grey(void **state)
{
    (void)state;
    exr_variant variant = { .type = EXR_PIXEL_HALF, .channels = { "A", "R" } };
    write_variant(path_of("red.exr"), &variant);
    rsv_image *image = read_image(path_of("red.exr"));
    rsv_rgb *pixels = rsv_image_pixels(image, 0);
    assert_float_equal(pixels->r, variant_value(1, 0, 0), 0);
    assert_float_equal(pixels->g, pixels->r, 0);
    assert_float_equal(pixels->b, pixels->r, 0);
    rsv_image_destroy(image);

    exr_variant masked = { .type = EXR_PIXEL_HALF, .channels = { "B", "G", "R", "mask.R" } };
    write_variant(path_of("masked.exr"), &masked);
    image = read_image(path_of("masked.exr"));
    assert_int_equal(rsv_image_layer_count(image), 1);
    assert_float_equal(rsv_image_pixels(image, 0)->b, variant_value(0, 0, 0), 0);
    rsv_image_destroy(image);

    exr_variant two = { .type = EXR_PIXEL_HALF, .channels = { "G", "R" } };
    write_variant(path_of("two.exr"), &two);
    expect_failure(path_of("two.exr"), RSV_ERROR_UNSUPPORTED, "neither R, G, B");
}

// ---- Radiance ----

static void hdr_rounds_to_the_nearest_mantissa(void **state)
{
    (void)state;
    rsv_image *image = make_image(64, 64, 1);
    rsv_rgb *pixels = rsv_image_pixels(image, 0);
    pixels[0] = rgb(NAN, -1, 0.5f);
    pixels[1] = rgb(INFINITY, 0, 0);
    pixels[2] = rgb(0.9999f, 0, 0); // rounds up into the next exponent
    assert_int_equal(rsv_image_write(image, path_of("a.hdr"), 5), RSV_OK);
    rsv_image *back = read_image(path_of("a.hdr"));
    const rsv_rgb *read = rsv_image_const_pixels(back, 0);
    assert_true(read[0].r == 0 && read[0].g == 0 && read[0].b == 0.5f);
    assert_float_equal(read[1].r, 0x1.fep+126f, 0);
    assert_float_equal(read[2].r, 1, 0);
    double sum = 0, sum_read = 0;
    for (int i = 3; i < 64 * 64; i++) {
        float half_step = rgb_max(pixels[i]) / 256; // the largest mantissa is at least 128
        assert_float_equal(read[i].r, pixels[i].r, half_step);
        assert_float_equal(read[i].g, pixels[i].g, half_step);
        assert_float_equal(read[i].b, pixels[i].b, half_step);
        sum += pixels[i].r;
        sum_read += read[i].r;
    }
    // 4096 rounding errors of at most 0.4 %, independent: 0.4 % / sqrt(3 * 4096) = 0.004 %
    assert_float_equal(sum_read / sum, 1, 2e-4);
    rsv_image_destroy(image);
    rsv_image_destroy(back);
}

static void hdr_reads_runs_and_exposure(void **state)
{
    (void)state;
    static const char header[] = "#?RADIANCE\nEXPOSURE=2\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 9\n";
    static const uint8_t rows[] = {
        2, 2, 0, 9,                                     // a row of components:
        128 + 9, 128,                                   // red: a run
        9, 0, 16, 32, 48, 64, 80, 96, 112, 128,         // green: literal
        4, 1, 2, 3, 4, 128 + 5, 5,                      // blue: both
        128 + 9, 129,                                   // exponent
        64, 128, 0, 129, 1, 1, 1, 7, 128, 128, 128, 128 // old style: one pixel seven more times
    };
    uint8_t file[sizeof header - 1 + sizeof rows];
    memcpy(file, header, sizeof header - 1);
    memcpy(file + sizeof header - 1, rows, sizeof rows);
    write_bytes(path_of("runs.hdr"), file, sizeof file);
    rsv_image *image = read_image(path_of("runs.hdr"));
    const rsv_rgb *pixels = rsv_image_const_pixels(image, 0);
    for (int x = 0; x < 9; x++) {
        assert_float_equal(pixels[x].r, 0.5, 0);
        assert_float_equal(pixels[x].g, (float)x * 0.0625f, 0);
        assert_float_equal(pixels[x].b, (float)(x < 4 ? x + 1 : 5) / 256, 0);
        assert_float_equal(pixels[9 + x].g, x < 8 ? 0.5 : 0.25, 0);
    }
    rsv_image_destroy(image);
}

/// A Radiance picture of flat pixels under a header of its own.
static void write_hdr(const char *path, const char *header, const uint8_t (*code)[4], size_t count)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    fprintf(file, "#?RADIANCE\n%s", header);
    assert_int_equal(fwrite(code, 4, count, file), count);
    fclose(file);
}

/// The first bytes of a file, not its name, decide its format. Messages are in our words.
static void pictures_are_told_by_their_content(void **state)
{
    (void)state;
    static const uint8_t code[1][4] = { { 128, 64, 32, 129 } };
    static const char text[] = "this is no picture at all, but some lines of text\n";
    static const char *const theirs[] = { "OpenEXR", "known type", "Corrupt", "corrupt", "zlib" };
    static const char *const names[] = { "text.png", "text.jpg", "text.exr", "text.hdr" };
    rsv_image *image = make_image(4, 3, 1);
    assert_int_equal(rsv_image_write(image, path_of("a.exr"), 0), RSV_OK);
    assert_int_equal(rename(path_of("a.exr"), path_of("a.png")), 0);
    rsv_image *read = read_image(path_of("a.png"));
    assert_int_equal(rsv_image_width(read), 4);
    rsv_image_destroy(read);
    rsv_image_destroy(image);
    write_hdr(path_of("a.exr"), "\n-Y 1 +X 1\n", code, 1);
    rsv_image_destroy(read_image(path_of("a.exr")));
    write_hdr(path_of("a.pic"), "\n-Y 1 +X 1\n", code, 1);
    rsv_image_destroy(read_image(path_of("a.pic")));
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        write_bytes(path_of(names[i]), text, sizeof text - 1);
        expect_failure(path_of(names[i]), RSV_ERROR_FORMAT, names[i]);
        for (size_t k = 0; k < sizeof theirs / sizeof *theirs; k++)
            assert_null(strstr(rsv_last_error(), theirs[k]));
        write_bytes(path_of(names[i]), text, 0);
        expect_failure(path_of(names[i]), RSV_ERROR_FORMAT, "empty");
    }
}

/// Three columns and two rows; the red of a pixel says where it belongs: 16 (x + 1) + 64 y.
static void hdr_stands_upright_however_its_lines_run(void **state)
{
    (void)state;
    static const struct {
        const char *line;
        int red[6]; // as they lie in the file, in units of 16
    } form[] = { { "-Y 2 +X 3", { 1, 2, 3, 5, 6, 7 } }, { "-Y 2 -X 3", { 3, 2, 1, 7, 6, 5 } },
        { "+Y 2 +X 3", { 5, 6, 7, 1, 2, 3 } }, { "+Y 2 -X 3", { 7, 6, 5, 3, 2, 1 } },
        { "+X 3 -Y 2", { 1, 5, 2, 6, 3, 7 } }, { "+X 3 +Y 2", { 5, 1, 6, 2, 7, 3 } },
        { "-X 3 -Y 2", { 3, 7, 2, 6, 1, 5 } }, { "-X 3 +Y 2", { 7, 3, 6, 2, 5, 1 } } };
    for (size_t k = 0; k < sizeof form / sizeof *form; k++) {
        uint8_t code[6][4];
        char header[64];
        for (int i = 0; i < 6; i++)
            memcpy(code[i], ((uint8_t[4]){ (uint8_t)(16 * form[k].red[i]), 200, 0, 136 }), 4);
        snprintf(header, sizeof header, "FORMAT=32-bit_rle_rgbe\n\n%s\n", form[k].line);
        write_hdr(path_of("turned.hdr"), header, (const uint8_t(*)[4])code, 6);
        rsv_image *image = read_image(path_of("turned.hdr"));
        assert_int_equal(rsv_image_width(image), 3);
        assert_int_equal(rsv_image_height(image), 2);
        for (int i = 0; i < 6; i++)
            assert_float_equal(
                rsv_image_const_pixels(image, 0)[i].r, 16 * (i % 3 + 1) + 64 * (i / 3), 0);
        rsv_image_destroy(image);
    }
    static const uint8_t black[6][4];
    write_hdr(path_of("odd.hdr"), "\n-Y 2 +Y 3\n", black, 6);
    expect_failure(path_of("odd.hdr"), RSV_ERROR_UNSUPPORTED, "'-Y 2 +Y 3'");
    write_hdr(path_of("none.hdr"), "\n+X 0 -Y 3\n", black, 6);
    expect_failure(path_of("none.hdr"), RSV_ERROR_FORMAT, "size 0 x 3");
}

/// X, Y, Z of the white of sRGB (D65), and of its red.
static void hdr_of_xyz_becomes_linear_srgb(void **state)
{
    (void)state;
    static const uint8_t code[2][4] = { { 122, 128, 139, 129 }, { 106, 54, 5, 128 } };
    write_hdr(path_of("xyz.hdr"), "FORMAT=32-bit_rle_xyze\nEXPOSURE=0.5\n\n-Y 1 +X 2\n", code, 2);
    rsv_image *image = read_image(path_of("xyz.hdr"));
    const rsv_rgb *pixel = rsv_image_const_pixels(image, 0);
    assert_float_equal(
        pixel[0].r, 2, 0.03); // a mantissa is known to 0.4 %, times what the matrix has
    assert_float_equal(pixel[0].g, 2, 0.03);
    assert_float_equal(pixel[0].b, 2, 0.03);
    assert_float_equal(pixel[1].r, 2, 0.03);
    assert_float_equal(pixel[1].g, 0, 0.03);
    assert_float_equal(pixel[1].b, 0, 0.03);
    rsv_image_destroy(image);
}

static void hdr_headers_of_other_programs_are_understood(void **state)
{
    (void)state;
    static const uint8_t code[1][4] = { { 128, 64, 32, 129 } };
    write_hdr(path_of("more.hdr"),
        "# made by hand\nVIEW= -vtv\nEXPOSURE=2\nEXPOSURE= 2\nCOLORCORR= 1 2 4\nPIXASPECT=1.0\n"
        "FORMAT= 32-bit_rle_rgbe \nGAMMA=1\n\n-Y 1 +X 1\n",
        code, 1);
    rsv_image *image = read_image(path_of("more.hdr"));
    rsv_rgb pixel = rsv_image_const_pixels(image, 0)[0];
    assert_float_equal(pixel.r, 0.25, 0);
    assert_float_equal(pixel.g, 0.0625, 0);
    assert_float_equal(pixel.b, 0.015625, 0);
    rsv_image_destroy(image);
    write_hdr(path_of("e.hdr"), "EXPOSURE=-1\n\n-Y 1 +X 1\n", code, 1);
    expect_failure(path_of("e.hdr"), RSV_ERROR_FORMAT, "invalid EXPOSURE");
    write_hdr(path_of("c.hdr"), "COLORCORR=1 2\n\n-Y 1 +X 1\n", code, 1);
    expect_failure(path_of("c.hdr"), RSV_ERROR_FORMAT, "invalid COLORCORR");
    static const uint8_t bright[1][4] = { { 255, 1, 0, 255 } };
    write_hdr(path_of("bright.hdr"), "EXPOSURE=1e-9\n\n-Y 1 +X 1\n", bright, 1);
    image = read_image(path_of("bright.hdr"));
    assert_true(isfinite(rsv_image_const_pixels(image, 0)[0].r));
    rsv_image_destroy(image);
}

// ---- PNG and JPEG ----

static void png_holds_the_nearest_srgb_code(void **state)
{
    (void)state;
    rsv_image *image = make_image(40, 50, 1);
    rsv_rgb *pixels = rsv_image_pixels(image, 0);
    for (int i = 0; i < 2000; i++)
        pixels[i] = rgb(random_float(), random_float() / 64, (float)i / 2000);
    pixels[0] = rgb(NAN, -3, INFINITY);
    pixels[1] = rgb(1.001f, 1, 0.5f);
    for (int stops = -2; stops <= 0; stops++) {
        assert_int_equal(rsv_image_write(image, path_of("a.PNG"), (float)stops), RSV_OK);
        rsv_image *back = read_image(path_of("a.PNG"));
        const rsv_rgb *read = rsv_image_const_pixels(back, 0);
        assert_true(read[0].r == 0 && read[0].g == 0 && read[0].b == 1);
        for (int i = 2; i < 2000; i++) {
            const float *wanted = &pixels[i].r, *got = &read[i].r;
            for (int c = 0; c < 3; c++)
                assert_float_equal(255 * rsv_srgb_encode(got[c]),
                    255 * rsv_srgb_encode(ldexp(wanted[c], stops)), 0.5001);
        }
        rsv_image_destroy(back);
    }
    rsv_image_destroy(image);
}

static void srgb_matches_its_definition(void **state)
{
    (void)state;
    assert_float_equal(rsv_srgb_decode(0.5), 0.21404114, 1e-8);
    assert_float_equal(rsv_srgb_encode(0.5), 0.73535698, 1e-8);
    assert_float_equal(rsv_srgb_decode(0.04045), 0.0031308, 1e-8);
    for (int i = 0; i < 256; i++)
        assert_float_equal(255 * rsv_srgb_encode(rsv_srgb_decode(i / 255.0)), i, 1e-4);
}

/// One pixel, uncompressed; decoders do not check the checksums, which are left 0.
static size_t make_png16(uint8_t *file, uint32_t width, uint32_t height, const uint16_t code[3])
{
    static const uint8_t start[] = { 137, 'P', 'N', 'G', 13, 10, 26, 10, 0, 0, 0, 13, 'I', 'H', 'D',
        'R', 0, 0, 0, 0, 0, 0, 0, 0, 16, 2, 0, 0, 0, 0, 0, 0, 0 };
    static const uint8_t data[] = { 0, 0, 0, 18, 'I', 'D', 'A', 'T', 0x78, 1, 1, 7, 0, 0xf8, 0xff,
        0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0 };
    static const uint8_t end[] = { 0, 0, 0, 0, 'I', 'E', 'N', 'D', 0, 0, 0, 0 };
    memcpy(file, start, sizeof start);
    memcpy(file + sizeof start, data, sizeof data);
    memcpy(file + sizeof start + sizeof data, end, sizeof end);
    for (int i = 0; i < 4; i++) {
        file[16 + i] = (uint8_t)(width >> (24 - 8 * i));
        file[20 + i] = (uint8_t)(height >> (24 - 8 * i));
    }
    for (int c = 0; c < 3; c++) {
        file[sizeof start + 16 + 2 * c] = (uint8_t)(code[c] >> 8);
        file[sizeof start + 17 + 2 * c] = (uint8_t)code[c];
    }
    return sizeof start + sizeof data + sizeof end;
}

static void png_with_16_bits_is_read_with_16_bits(void **state)
{
    (void)state;
    const uint16_t code[3] = { 32768, 257, 65535 };
    uint8_t file[128];
    write_bytes(path_of("deep.png"), file, make_png16(file, 1, 1, code));
    rsv_image *image = read_image(path_of("deep.png"));
    assert_float_equal(rsv_image_pixels(image, 0)->r, rsv_srgb_decode(32768 / 65535.0), 1e-7);
    assert_float_equal(rsv_image_pixels(image, 0)->g, rsv_srgb_decode(257 / 65535.0), 1e-9);
    assert_float_equal(rsv_image_pixels(image, 0)->b, 1, 0);
    rsv_image_destroy(image);
}

/// What a PNG says of its colours and frames beyond sRGB and the first.
static void png_chunks_that_are_not_used_are_named(void **state)
{
    (void)state;
    static const struct {
        const char *name, *data;
        uint8_t length;
        const char *warning; // "" = none
    } chunk[] = { { "gAMA", "\0\1\x86\xa0", 4, "gamma (gAMA)" }, { "gAMA", "\0\0\xb1\x8f", 4, "" },
        { "iCCP", "Display P3\0\0x", 13, "colour profile (iCCP)" },
        { "iCCP", "sRGB IEC\0\0x", 11, "" }, { "cICP", "\x09\x10\0\1", 4, "cICP" },
        { "cICP", "\1\x0d\0\1", 4, "" }, { "acTL", "\0\0\0\2\0\0\0\0", 8, "frames" },
        { "cHRM",
            "\0\0\x7a\x26\0\0\x80\x84\0\1\x09\xa0\0\0\x7d\0\0\0\x67\x84\0\1\x0d\x88\0\0\x3a\x98\0\0"
            "\x17\x70",
            32, "primaries (cHRM)" },
        { "cHRM",
            "\0\0\x7a\x26\0\0\x80\x84\0\0\xfa\0\0\0\x80\xe8\0\0\x75\x30\0\0\xea\x60\0\0\x3a\x98\0\0"
            "\x17\x70",
            32, "" } };
    enum { START = 33 }; // signature and header
    const uint16_t code[3] = { 1, 2, 3 };
    rsv_context *own;
    rsv_context_desc desc = rsv_default_context_desc();
    desc.log = keep_log;
    assert_int_equal(rsv_context_create(&desc, &own), RSV_OK);
    for (size_t k = 0; k < sizeof chunk / sizeof *chunk; k++) {
        uint8_t plain[128], file[192] = { 0 };
        size_t size = make_png16(plain, 1, 1, code), length = chunk[k].length;
        memcpy(file, plain, START);
        file[START + 3] = chunk[k].length;
        memcpy(file + START + 4, chunk[k].name, 4);
        memcpy(file + START + 8, chunk[k].data, length);
        memcpy(file + START + 12 + length, plain + START, size - START);
        write_bytes(path_of("said.png"), file, size + 12 + length);
        logged[0] = '\0';
        rsv_image *image;
        assert_int_equal(rsv_image_read(own, path_of("said.png"), &image), RSV_OK);
        rsv_image_destroy(image);
        if (*chunk[k].warning)
            assert_non_null(strstr(logged, chunk[k].warning));
        else
            assert_string_equal(logged, "");
    }
    rsv_context_destroy(own);
}

/// Sixteen by eight pixels of sRGB (200, 100, 50): quantisation tables of eights, then the rest.
static size_t make_jpeg(uint8_t *file)
{
    static const uint8_t start[] = { 0xff, 0xd8, 0xff, 0xdb, 0, 67, 0 };
    static const uint8_t frame[] = { 0xff, 0xc0, 0, 17, 8, 0, 8, 0, 16, 3, 1, 0x11, 0, 2, 0x11, 0,
        3, 0x11, 0 };
    static const uint8_t tables[] = { 0xff, 0xc4, 0, 45, // DC: sizes 0..6 in 3 bits, 7 in 4
        0, 0, 0, 7, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, //
        0x10, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0 }; // AC: end of block in 1 bit
    static const uint8_t scan[] = { 0xff, 0xda, 0, 12, 3, 1, 0, 2, 0, 3, 0, 0, 63, 0, 0x6d, 0x95,
        0x6d, 0x80, 0x01, 0xff, 0xd9 };
    uint8_t *end = file;
    end = (uint8_t *)memcpy(end, start, sizeof start) + sizeof start;
    end = (uint8_t *)memset(end, 8, 64) + 64;
    end = (uint8_t *)memcpy(end, frame, sizeof frame) + sizeof frame;
    end = (uint8_t *)memcpy(end, tables, sizeof tables) + sizeof tables;
    end = (uint8_t *)memcpy(end, scan, sizeof scan) + sizeof scan;
    return (size_t)(end - file);
}

static void jpeg_is_decoded_from_srgb(void **state)
{
    (void)state;
    uint8_t file[256];
    write_bytes(path_of("a.jpeg"), file, make_jpeg(file));
    rsv_image *image = read_image(path_of("a.jpeg"));
    assert_int_equal(rsv_image_width(image), 16);
    rsv_rgb pixel = rsv_image_pixels(image, 0)[100];
    assert_float_equal(255 * rsv_srgb_encode(pixel.r), 200, 1);
    assert_float_equal(255 * rsv_srgb_encode(pixel.g), 100, 1);
    assert_float_equal(255 * rsv_srgb_encode(pixel.b), 50, 1);
    rsv_image_destroy(image);
}

// ---- TGA, BMP and GIF ----

/// Red, green | blue, white.
static const uint8_t four_colors[4][3] = { { 255, 0, 0 }, { 0, 255, 0 }, { 0, 0, 255 },
    { 255, 255, 255 } };

/// Lines that run as `descriptor` says: 0x20 from the top, 0x10 from the right. @param packed in runs of one pixel
static size_t make_tga(uint8_t file[64], int descriptor, bool packed)
{
    const uint8_t header[18] = {
        [2] = packed ? 10 : 2, [12] = 2, [14] = 2, [16] = 24, [17] = (uint8_t)descriptor
    };
    uint8_t *end = (uint8_t *)memcpy(file, header, 18) + 18;
    for (int i = 0; i < 4; i++) {
        int y = descriptor & 0x20 ? i / 2 : 1 - i / 2, x = descriptor & 0x10 ? 1 - i % 2 : i % 2;
        if (packed) *end++ = 0x80;
        for (int c = 2; c >= 0; c--)
            *end++ = four_colors[2 * y + x][c];
    }
    return (size_t)(end - file);
}

static size_t make_bmp(uint8_t file[80])
{
    const uint8_t header[54] = { 'B', 'M',
        70, [10] = 54, [14] = 40, [18] = 2, [22] = 2, [26] = 1, [28] = 24 };
    uint8_t *end = (uint8_t *)memcpy(file, header, 54) + 54;
    for (int y = 1; y >= 0; y--, end += 2)
        for (int i = 0; i < 6; i++)
            *end++ = four_colors[2 * y + i / 3][2 - i % 3];
    memset(end - 2, 0, 2);
    return (size_t)(end - file);
}

/// Codes of three bits: clear, 0, 1, 2, and of four: 3, end. @param frames the same picture that many times
static size_t make_gif(uint8_t file[128], int frames)
{
    const uint8_t header[13] = { 'G', 'I', 'F', '8', '9', 'a', 2, 0, 2, 0, 0x81 };
    const uint8_t frame[] = { 0x2c, 0, 0, 0, 0, 2, 0, 2, 0, 0, 2, 3, 0x44, 0x34, 0x05, 0 };
    uint8_t *end = (uint8_t *)memcpy(file, header, 13) + 13;
    end = (uint8_t *)memcpy(end, four_colors, 12) + 12;
    for (int k = 0; k < frames; k++)
        end = (uint8_t *)memcpy(end, frame, sizeof frame) + sizeof frame;
    *end++ = 0x3b;
    return (size_t)(end - file);
}

static void expect_four_colors(const char *path)
{
    rsv_image *image = read_image(path);
    assert_int_equal(rsv_image_width(image), 2);
    assert_int_equal(rsv_image_height(image), 2);
    for (int i = 0; i < 4; i++) {
        rsv_rgb found = rsv_image_pixels(image, 0)[i];
        if (found.r != (float)(four_colors[i][0] / 255) ||
            found.g != (float)(four_colors[i][1] / 255) ||
            found.b != (float)(four_colors[i][2] / 255))
            fail_msg("%s, pixel %d: %g %g %g", path, i, (double)found.r, (double)found.g,
                (double)found.b);
    }
    rsv_image_destroy(image);
}

static void tga_bmp_and_gif_are_read(void **state)
{
    (void)state;
    uint8_t file[128];
    for (int k = 0; k < 8; k++) {
        size_t size = make_tga(file, (k & 3) << 4, k & 4);
        write_bytes(path_of("four.tga"), file, size);
        expect_four_colors(path_of("four.tga"));
    }
    write_bytes(path_of("four.bmp"), file, make_bmp(file));
    expect_four_colors(path_of("four.bmp"));
    write_bytes(path_of("four.gif"), file, make_gif(file, 1));
    expect_four_colors(path_of("four.gif"));
}

static void frames_of_gif_are_named(void **state)
{
    (void)state;
    uint8_t file[128];
    rsv_context *talkative;
    rsv_context_desc desc = rsv_default_context_desc();
    desc.log = keep_log;
    assert_int_equal(rsv_context_create(&desc, &talkative), RSV_OK);
    logged[0] = '\0';
    for (int frames = 1; frames <= 2; frames++) {
        rsv_image *image;
        assert_string_equal(logged, "");
        write_bytes(path_of("frames.gif"), file, make_gif(file, frames));
        assert_int_equal(rsv_image_read(talkative, path_of("frames.gif"), &image), RSV_OK);
        rsv_image_destroy(image);
    }
    assert_non_null(strstr(logged, "only the first of its frames is used"));
    rsv_context_destroy(talkative);
}

static void announced_pixels_that_no_file_holds_are_refused(void **state)
{
    (void)state;
    uint8_t file[128];
    size_t size = make_tga(file, 0x20, false);
    memcpy(file + 12, "\xff\xff\xff\xff", 4);
    write_bytes(path_of("wide.tga"), file, size);
    expect_failure(path_of("wide.tga"), RSV_ERROR_FORMAT, "as TGA it would have");
    size = make_bmp(file);
    memcpy(file + 18, "\xff\xff\xff\x7f\xff\xff\xff\x7f", 8);
    write_bytes(path_of("wide.bmp"), file, size);
    expect_failure(path_of("wide.bmp"), RSV_ERROR_FORMAT, "2147483647 x 2147483647");
    size = make_gif(file, 1);
    memcpy(file + 6, "\xff\xff\xff\xff", 4);
    write_bytes(path_of("wide.gif"), file, size);
    expect_failure(path_of("wide.gif"), RSV_ERROR_FORMAT, "65535 x 65535");
}

// ---- hostile input ----

static const char *const sample_names[] = { "s.exr", "s.hdr", "s.png", "s.jpg", "s.tga", "p.tga",
    "s.bmp", "s.gif" };
enum { OWN_SAMPLES = 3, SAMPLES = sizeof sample_names / sizeof *sample_names };

static size_t make_foreign_sample(int i, uint8_t file[256])
{
    switch (i) {
    case 3:
        return make_jpeg(file);
    case 4:
    case 5:
        return make_tga(file, 0x20, i == 5);
    case 6:
        return make_bmp(file) - 2; // without the padding behind the last line
    default:
        return make_gif(file, 1) - 2; // without the empty block and the end
    }
}

static uint8_t *make_sample(int i, size_t *size)
{
    const char *path = path_of(sample_names[i]);
    if (i >= OWN_SAMPLES) {
        uint8_t file[256];
        write_bytes(path, file, make_foreign_sample(i, file));
    } else {
        rsv_image *image = make_image(29, 40, 2);
        assert_int_equal(rsv_image_write(image, path, 0), RSV_OK);
        rsv_image_destroy(image);
    }
    return read_bytes(path, size);
}

static void truncated_files_are_refused(void **state)
{
    (void)state;
    for (int i = 0; i < SAMPLES; i++) {
        size_t size;
        uint8_t *bytes = make_sample(i, &size);
        for (size_t part = 0; part < 16; part++) {
            write_bytes(path_of(sample_names[i]), bytes, size * part / 16);
            expect_failure(path_of(sample_names[i]), RSV_ERROR_FORMAT, "cannot read");
        }
        write_bytes(path_of(sample_names[i]), bytes, size - 1);
        expect_failure(path_of(sample_names[i]), RSV_ERROR_FORMAT, "cannot read");
        free(bytes);
    }
}

static void jpeg_with_an_oversized_huffman_table_is_refused(void **state)
{
    (void)state;
    uint8_t file[256];
    size_t size = make_jpeg(file);
    uint8_t *counts = memmem(file, size, "\xff\xc4", 2);
    counts[20] = 255;
    write_bytes(path_of("huffman.jpg"), file, size);
    expect_failure(path_of("huffman.jpg"), RSV_ERROR_FORMAT, "Huffman table");
}

/// More pixels than a file of this size can hold: nothing is decoded. Otherwise, the decoder would use uninitialised
/// memory as tables.
static void jpeg_whose_scan_lacks_a_table_is_refused(void **state)
{
    (void)state;
    uint8_t file[512];
    size_t size = make_jpeg(file);
    uint8_t *scan = memmem(file, size, "\xff\xda", 2);
    assert_non_null(scan);
    scan[6] |= 0x03; // AC table 3 of the first component: after marker, length, count and id
    write_bytes(path_of("tables.jpg"), file, size);
    expect_failure(path_of("tables.jpg"), RSV_ERROR_FORMAT,
        "a scan names a Huffman table that the file does not have");
}

static void jpeg_with_more_pixels_than_bits_is_refused(void **state)
{
    (void)state;
    uint8_t file[256];
    size_t size = make_jpeg(file);
    uint8_t *frame = memmem(file, size, "\xff\xc0", 2);
    memcpy(frame + 5, "\x10\x00\x10\x00", 4);
    write_bytes(path_of("wide.jpg"), file, size);
    expect_failure(path_of("wide.jpg"), RSV_ERROR_FORMAT, "4096 x 4096 pixels do not fit in");
}

/// A chunk of almost 2 GiB in a file of 63 bytes: no memory is allocated for it.
static void png_that_ends_within_a_chunk_is_refused(void **state)
{
    (void)state;
    const uint16_t code[3] = { 1, 2, 3 };
    uint8_t file[256];
    size_t size = make_png16(file, 1, 1, code);
    uint8_t *type = memmem(file, size, "IDAT", 4);
    memcpy(type - 4, "\x7f\xff\xff\xf0", 4);
    write_bytes(path_of("endless.png"), file, size);
    expect_failure(path_of("endless.png"), RSV_ERROR_FORMAT,
        "the chunk at byte 33 says it has 2147483632 bytes");
}

static void damaged_files_do_no_harm(void **state)
{
    (void)state;
    for (int i = 0; i < SAMPLES; i++) {
        size_t size;
        uint8_t *bytes = make_sample(i, &size);
        hash_state = 11;
        for (int round = 0; round < 200; round++) {
            // every second change hits the header, which is small and most sensitive
            size_t range = round % 2 && size > 128 ? 128 : size;
            size_t at = (size_t)(random_float() * (float)range);
            uint8_t kept = bytes[at];
            bytes[at] = (uint8_t)(256 * random_float());
            write_bytes(path_of(sample_names[i]), bytes, size);
            rsv_image *image = NULL;
            if (rsv_image_read(context, path_of(sample_names[i]), &image) != RSV_OK)
                assert_non_null(strstr(rsv_last_error(), sample_names[i]));
            rsv_image_destroy(image);
            bytes[at] = kept;
        }
        free(bytes);
    }
}

static void oversized_pictures_are_refused_before_allocating(void **state)
{
    (void)state;
    const uint16_t code[3] = { 0 };
    uint8_t png[128];
    write_bytes(path_of("wide.png"), png, make_png16(png, 65537, 1, code));
    expect_failure(path_of("wide.png"), RSV_ERROR_FORMAT, "size 65537 x 1");
    write_bytes(path_of("large.png"), png, make_png16(png, 16385, 16384, code));
    expect_failure(path_of("large.png"), RSV_ERROR_FORMAT, "size 16385 x 16384");
    const char hdr[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 65537 +X 1\n";
    write_bytes(path_of("tall.hdr"), hdr, sizeof hdr - 1);
    expect_failure(path_of("tall.hdr"), RSV_ERROR_FORMAT, "size 1 x 65537");
    write_bytes(path_of("huge.png"), png, make_png16(png, 0x7fffffff, 0x7fffffff, code));
    expect_failure(path_of("huge.png"), RSV_ERROR_FORMAT, "huge.png");
    const char huge[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2147483648 +X 2147483648\n";
    write_bytes(path_of("huge.hdr"), huge, sizeof huge - 1);
    expect_failure(path_of("huge.hdr"), RSV_ERROR_FORMAT, "size 2147483648 x 2147483648");
    const char announced[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 33041 +X 8041\n";
    write_bytes(path_of("announced.hdr"), announced, sizeof announced - 1);
    expect_failure(path_of("announced.hdr"), RSV_ERROR_FORMAT, "fewer bytes than its rows need");
}

static void missing_and_unknown_files_are_named(void **state)
{
    (void)state;
    expect_failure(path_of("none.exr"), RSV_ERROR_IO, "No such file or directory");
    expect_failure(path_of("none.tiff"), RSV_ERROR_UNSUPPORTED,
        ".exr, .hdr, .png, .jpg, .webp, .tga, .bmp or .gif");
    expect_failure(folder, RSV_ERROR_UNSUPPORTED, ".exr");
    assert_int_equal(mkdir(path_of("f.exr"), 0777), 0);
    expect_failure(path_of("f.exr"), RSV_ERROR_IO, "not a regular file");
}

// ---- writing ----

static void output_is_checked_before_the_work(void **state)
{
    (void)state;
    assert_int_equal(rsv_image_check_output(path_of("a.exr")), RSV_OK);
    assert_int_equal(rsv_image_check_output("a.hdr"), RSV_OK);
    assert_int_equal(rsv_image_check_output(path_of("a.jpg")), RSV_ERROR_ARGUMENT);
    assert_non_null(strstr(rsv_last_error(), ".exr, .hdr or .png"));
    assert_int_equal(rsv_image_check_output(path_of("png")), RSV_ERROR_ARGUMENT);
    assert_int_equal(rsv_image_check_output(path_of("none/a.exr")), RSV_ERROR_IO);
    assert_non_null(strstr(rsv_last_error(), "No such file or directory"));
    assert_int_equal(mkdir(path_of("f.exr"), 0777), 0);
    assert_int_equal(rsv_image_check_output(path_of("f.exr")), RSV_ERROR_IO);
    assert_non_null(strstr(rsv_last_error(), "is a folder"));
    assert_int_equal(clear_folder(), 1);
    if (geteuid() == 0) return; // the superuser may write everywhere
    assert_int_equal(chmod(folder, 0500), 0);
    assert_int_equal(rsv_image_check_output(path_of("a.exr")), RSV_ERROR_IO);
    assert_int_equal(chmod(folder, 0700), 0);
}

static void failed_writes_leave_the_old_file_and_nothing_else(void **state)
{
    (void)state;
    static const char *const names[] = { "a.exr", "a.hdr", "a.png" };
    rsv_image *image = make_image(64, 64, 1);
    struct rlimit limit;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &limit), 0);
    struct rlimit small = { 1000, limit.rlim_max };
    signal(SIGXFSZ, SIG_IGN);
    for (int i = 0; i < 3; i++) {
        write_bytes(path_of(names[i]), "old", 3);
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
        rsv_status status = rsv_image_write(image, path_of(names[i]), 0);
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
        assert_int_equal(status, RSV_ERROR_IO);
        assert_non_null(strstr(rsv_last_error(), names[i]));
        assert_non_null(strstr(rsv_last_error(), "File too large"));
        size_t size;
        uint8_t *bytes = read_bytes(path_of(names[i]), &size);
        assert_int_equal(size, 3);
        assert_memory_equal(bytes, "old", 3);
        free(bytes);
        assert_int_equal(clear_folder(), 1);
    }
    rsv_image_destroy(image);
}

static void running_out_of_memory_leaves_nothing(void **state)
{
    (void)state;
    rsv_image *image = make_image(5, 4, 2);
    for (int i = 0; i < 3; i++) {
        const char *path = path_of(sample_names[i]);
        rsv_status status = RSV_ERROR_MEMORY;
        for (int limit = 0; status != RSV_OK; limit++) {
            assert_int_equal(status, RSV_ERROR_MEMORY);
            assert_int_equal(clear_folder(), 0);
            allocations_left = limit;
            status = rsv_image_write(image, path, 0);
        }
        status = RSV_ERROR_MEMORY;
        for (int limit = 0; status != RSV_OK; limit++) {
            rsv_image *back = NULL;
            int live = live_allocations;
            assert_int_equal(status, RSV_ERROR_MEMORY);
            allocations_left = limit;
            status = rsv_image_read(context, path, &back);
            if (status != RSV_OK) assert_int_equal(live_allocations, live);
            rsv_image_destroy(back);
        }
        allocations_left = INT_MAX;
        clear_folder();
    }
    rsv_image_destroy(image);
}

static void replaced_files_keep_links_and_permissions(void **state)
{
    (void)state;
    rsv_image *image = make_image(4, 4, 1);
    struct stat properties;
    write_bytes(path_of("real.png"), "old", 3);
    assert_int_equal(chmod(path_of("real.png"), 0640), 0);
    assert_int_equal(symlink("real.png", path_of("link.png")), 0);
    assert_int_equal(rsv_image_write(image, path_of("link.png"), 0), RSV_OK);
    assert_int_equal(lstat(path_of("link.png"), &properties), 0);
    assert_true(S_ISLNK(properties.st_mode));
    assert_int_equal(stat(path_of("real.png"), &properties), 0);
    assert_int_equal(properties.st_mode & 0777, 0640);
    assert_true(properties.st_size > 3);
    rsv_image_destroy(image);
}

static void writers_of_one_name_do_not_clash(void **state)
{
    (void)state;
    rsv_atomic_file files[8];
    const char *path = path_of("shared.bin");
    for (int i = 0; i < 8; i++)
        assert_int_equal(rsv_atomic_file_open(&files[i], path), RSV_OK);
    for (int i = 0; i < 8; i++)
        rsv_atomic_file_append(&files[i], "01234567" + i, 1);
    for (int i = 7; i > 0; i--)
        assert_int_equal(rsv_atomic_file_commit(&files[i]), RSV_OK);
    rsv_atomic_file_discard(&files[0]);
    size_t size;
    uint8_t *bytes = read_bytes(path, &size);
    assert_int_equal(size, 1);
    assert_int_equal(bytes[0], '1');
    free(bytes);
    assert_int_equal(clear_folder(), 1);
}

// ---- the image itself ----

static void layers_have_distinct_names(void **state)
{
    (void)state;
    rsv_image *image = make_image(2, 2, 3);
    assert_string_equal(rsv_image_layer_name(image, 0), "");
    assert_int_equal(rsv_image_set_layer_name(image, 1, "direct"), RSV_OK);
    assert_int_equal(rsv_image_set_layer_name(image, 1, "direct"), RSV_OK);
    assert_int_equal(rsv_image_set_layer_name(image, 2, "direct"), RSV_ERROR_ARGUMENT);
    assert_int_equal(rsv_image_set_layer_name(image, 3, "late"), RSV_ERROR_ARGUMENT);
    assert_int_equal(rsv_image_set_layer_name(image, 2, LONGEST_NAME "x"), RSV_ERROR_ARGUMENT);
    assert_int_equal(rsv_image_find_layer(image, "direct"), 1);
    rsv_image_destroy(image);
    rsv_image_destroy(NULL);
    assert_int_equal(rsv_image_create(context, 0, 4, 1, &image), RSV_ERROR_ARGUMENT);
    assert_int_equal(rsv_image_create(context, 65537, 4, 1, &image), RSV_ERROR_ARGUMENT);
    assert_int_equal(rsv_image_create(context, 4, 4, 0, &image), RSV_ERROR_ARGUMENT);
}

static void compare_matches_hand_computation(void **state)
{
    (void)state;
    rsv_image *a, *b;
    assert_int_equal(rsv_image_create(context, 3, 1, 1, &a), RSV_OK);
    assert_int_equal(rsv_image_create(context, 3, 1, 2, &b), RSV_OK);
    const float reference[3] = { 1, 2, 0 }, other[3] = { 1.5f, 1, 0.25f };
    for (int i = 0; i < 3; i++) {
        rsv_image_pixels(a, 0)[i] = rgb_gray(reference[i]);
        rsv_image_pixels(b, 1)[i] = rgb_gray(other[i]);
    }
    rsv_image_pixels(b, 1)[1].b = 3; // differences: 0.5, (-1, -1, +1), 0.25; mean(a) = 1
    rsv_image_difference d;
    assert_int_equal(rsv_image_compare(a, 0, b, 1, &d), RSV_OK);
    double rmse = sqrt((0.25 + 1 + 0.0625) / 3);
    assert_float_equal(d.rmse, rmse, 1e-12);
    assert_float_equal(d.relative_mse, (0.25 / 1.01 + 1 / 4.01 + 0.0625 / 0.01) / 3, 1e-12);
    assert_float_equal(d.psnr, 20 * log10(2 / rmse), 1e-12);
    assert_float_equal(d.mean_ratio, (3 * 2.75 + 2) / 9, 1e-12);
    assert_float_equal(d.channel_mean_ratio[0], 2.75 / 3, 1e-12);
    assert_float_equal(d.channel_mean_ratio[2], 4.75 / 3, 1e-12);
    // relative luminance errors: 0.5, |0.9278 - 0.0722| / 2 = 0.4278, 0.25 / 1e-3
    assert_float_equal(d.median_relative_error, 0.5, 1e-6);
    rsv_image_destroy(a);
    rsv_image_destroy(b);
}

/// Two references with noise of 30 % around a gradient, and a picture that is 2 % too bright everywhere.
static void the_noise_of_two_references_is_no_error(void **state)
{
    (void)state;
    const uint32_t side = 128, layers[2] = { 0, 0 };
    rsv_image *a[2], *b;
    rsv_random random = rsv_random_from(1, 2, 3);
    assert_int_equal(rsv_image_create(context, side, side, 1, &b), RSV_OK);
    for (int k = 0; k < 2; k++)
        assert_int_equal(rsv_image_create(context, side, side, 1, &a[k]), RSV_OK);
    for (uint32_t i = 0; i < side * side; i++) {
        float truth = 1 + (float)(i % side) / (float)side;
        rsv_image_pixels(b, 0)[i] = rgb_gray(1.02f * truth);
        for (int k = 0; k < 2; k++) {
            float noise = 0.3f * sqrtf(12) * (rsv_random_float(&random) - 0.5f);
            rsv_image_pixels(a[k], 0)[i] = rgb_gray(truth * (1 + noise));
        }
    }
    rsv_image_difference d;
    rsv_image_judgement j;
    assert_int_equal(rsv_image_compare(a[0], 0, b, 0, &d), RSV_OK);
    assert_int_equal(rsv_image_judge((const rsv_image *const *)a, layers, b, 0, &j), RSV_OK);
    assert_true(d.relative_mse > 0.05);
    assert_float_equal(j.reference_mse, 0.3 * 0.3 / 2, 0.002);
    assert_float_equal(j.relative_mse_error, 0.3 * 0.3 / side, 1e-4);
    assert_float_equal(j.relative_mse, 0.02 * 0.02, 4 * j.relative_mse_error);
    rsv_image_destroy(a[0]);
    rsv_image_destroy(a[1]);
    rsv_image_destroy(b);
}

static void equal_pictures_compare_as_equal(void **state)
{
    (void)state;
    rsv_image *black, *image = make_image(5, 4, 1);
    assert_int_equal(rsv_image_create(context, 5, 4, 1, &black), RSV_OK);
    const rsv_image *pictures[] = { image, black };
    for (int i = 0; i < 2; i++) {
        rsv_image_difference d;
        assert_int_equal(rsv_image_compare(pictures[i], 0, pictures[i], 0, &d), RSV_OK);
        assert_true(d.rmse == 0 && d.relative_mse == 0 && isinf(d.psnr) && d.psnr > 0);
        assert_true(d.mean_ratio == 1 && d.channel_mean_ratio[1] == 1);
        assert_true(d.median_relative_error == 0);
    }
    rsv_image_destroy(image);
    rsv_image_destroy(black);
}

static void compare_refuses_what_has_no_answer(void **state)
{
    (void)state;
    rsv_image_difference d;
    rsv_image *a = make_image(3, 2, 1), *b = make_image(2, 3, 1), *c = make_image(3, 2, 1);
    assert_int_equal(rsv_image_compare(a, 0, b, 0, &d), RSV_ERROR_ARGUMENT);
    assert_non_null(strstr(rsv_last_error(), "3 x 2"));
    assert_non_null(strstr(rsv_last_error(), "2 x 3"));
    assert_int_equal(rsv_image_compare(a, 0, c, 1, &d), RSV_ERROR_ARGUMENT);
    rsv_image_pixels(c, 0)[4].g = NAN;
    assert_int_equal(rsv_image_compare(a, 0, c, 0, &d), RSV_ERROR_FORMAT);
    assert_non_null(strstr(rsv_last_error(), "(1, 1)"));
    assert_int_equal(rsv_image_compare(c, 0, a, 0, &d), RSV_ERROR_FORMAT);
    rsv_image_destroy(a);
    rsv_image_destroy(b);
    rsv_image_destroy(c);
}

#define IMAGE_TEST(name) cmocka_unit_test_setup_teardown(name, start_clean, check_leaks)

int main(void)
{
    const struct CMUnitTest tests[] = {
        IMAGE_TEST(exr_keeps_every_bit_of_every_layer),
        IMAGE_TEST(exr_keeps_what_hardly_compresses),
        IMAGE_TEST(exr_reads_foreign_storage),
        IMAGE_TEST(exr_places_the_data_window_in_the_display_window),
        IMAGE_TEST(exr_refuses_what_the_library_misreads),
        IMAGE_TEST(exr_reads_luminance_as_grey),
        IMAGE_TEST(exr_reads_lone_red_as_grey),
        IMAGE_TEST(hdr_rounds_to_the_nearest_mantissa),
        IMAGE_TEST(hdr_reads_runs_and_exposure),
        IMAGE_TEST(exr_channels_that_are_no_colours_are_named),
        IMAGE_TEST(pictures_are_told_by_their_content),
        IMAGE_TEST(hdr_stands_upright_however_its_lines_run),
        IMAGE_TEST(hdr_of_xyz_becomes_linear_srgb),
        IMAGE_TEST(hdr_headers_of_other_programs_are_understood),
        IMAGE_TEST(png_holds_the_nearest_srgb_code),
        IMAGE_TEST(srgb_matches_its_definition),
        IMAGE_TEST(png_with_16_bits_is_read_with_16_bits),
        IMAGE_TEST(png_chunks_that_are_not_used_are_named),
        IMAGE_TEST(tga_bmp_and_gif_are_read),
        IMAGE_TEST(frames_of_gif_are_named),
        IMAGE_TEST(announced_pixels_that_no_file_holds_are_refused),
        IMAGE_TEST(jpeg_is_decoded_from_srgb),
        IMAGE_TEST(truncated_files_are_refused),
        IMAGE_TEST(jpeg_with_an_oversized_huffman_table_is_refused),
        IMAGE_TEST(jpeg_whose_scan_lacks_a_table_is_refused),
        IMAGE_TEST(jpeg_with_more_pixels_than_bits_is_refused),
        IMAGE_TEST(png_that_ends_within_a_chunk_is_refused),
        IMAGE_TEST(damaged_files_do_no_harm),
        IMAGE_TEST(oversized_pictures_are_refused_before_allocating),
        IMAGE_TEST(missing_and_unknown_files_are_named),
        IMAGE_TEST(output_is_checked_before_the_work),
        IMAGE_TEST(failed_writes_leave_the_old_file_and_nothing_else),
        IMAGE_TEST(running_out_of_memory_leaves_nothing),
        IMAGE_TEST(replaced_files_keep_links_and_permissions),
        IMAGE_TEST(writers_of_one_name_do_not_clash),
        IMAGE_TEST(layers_have_distinct_names),
        IMAGE_TEST(compare_matches_hand_computation),
        IMAGE_TEST(the_noise_of_two_references_is_no_error),
        IMAGE_TEST(equal_pictures_compare_as_equal),
        IMAGE_TEST(compare_refuses_what_has_no_answer),
    };
    return cmocka_run_group_tests(tests, create_folder, remove_folder);
}
