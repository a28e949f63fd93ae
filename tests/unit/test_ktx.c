/// KTX2 images: every supported format and compression, written here byte by byte, and files that are rejected. Those of
/// Basis Universal lie in `basis`, each beside the texels that the encoder's own decoder (1.15) finds in it: uastc.ktx2
/// has two random blocks of each mode, etc1s.ktx2 a picture with alpha and smaller levels.
#include "core/core.h"
#include "io/image_ktx.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <zlib.h>
#include <zstd.h>

enum { WIDTH = 3, HEIGHT = 2, TEXELS = WIDTH * HEIGHT, FILE_BYTES = 1024 };

typedef struct fixture {
    rsv_context *context;
    uint8_t bytes[FILE_BYTES];
    rsv_image_file file;
} fixture;

static int set_up(void **state)
{
    static fixture f;
    *state = &f;
    return rsv_context_create(NULL, &f.context);
}

static int tear_down(void **state)
{
    rsv_context_destroy(((fixture *)*state)->context);
    return 0;
}

static void put(uint8_t *to, uint64_t value, int bytes)
{
    for (int k = 0; k < bytes; k++)
        to[k] = (uint8_t)(value >> 8 * k);
}

/// @param pair a key, a zero and its value; NULL = none
static void write_file(fixture *f, uint32_t format, uint32_t packing, const void *texels,
    size_t size, size_t unpacked, const char *pair, size_t pair_bytes)
{
    const size_t pairs = 104, at = 160;
    memset(f->bytes, 0, sizeof f->bytes);
    memcpy(f->bytes, "\xabKTX 20\xbb\r\n\x1a\n", 12);
    put(f->bytes + 12, format, 4);
    put(f->bytes + 16, 1, 4);
    put(f->bytes + 20, WIDTH, 4);
    put(f->bytes + 24, HEIGHT, 4);
    put(f->bytes + 36, 1, 4); // faces
    put(f->bytes + 40, 1, 4); // levels
    put(f->bytes + 44, packing, 4);
    if (pair) {
        put(f->bytes + 56, pairs, 4);
        put(f->bytes + 60, 4 + pair_bytes, 4);
        put(f->bytes + pairs, pair_bytes, 4);
        memcpy(f->bytes + pairs + 4, pair, pair_bytes);
    }
    put(f->bytes + 80, at, 8);
    put(f->bytes + 88, size, 8);
    put(f->bytes + 96, unpacked, 8);
    memcpy(f->bytes + at, texels, size);
    f->file = (rsv_image_file){ "t.ktx2", f->bytes, at + size };
}

static void write_plain(fixture *f, uint32_t format, const void *texels, size_t size)
{
    write_file(f, format, 0, texels, size, size, NULL, 0);
}

static void decode(fixture *f, rsv_ktx_picture *p)
{
    assert_true(rsv_image_is_ktx(&f->file));
    if (rsv_ktx_decode(f->context, &f->file, p) != RSV_OK) fail_msg("%s", rsv_last_error());
    assert_true(p->width == WIDTH && p->height == HEIGHT);
}

static void expect(fixture *f, rsv_status status, const char *words)
{
    rsv_ktx_picture p;
    assert_int_equal(rsv_ktx_decode(f->context, &f->file, &p), status);
    assert_true(!p.codes && !p.values);
    if (!strstr(rsv_last_error(), words)) fail_msg("'%s' lacks '%s'", rsv_last_error(), words);
    assert_non_null(strstr(rsv_last_error(), "t.ktx2"));
}

static void fill(uint8_t *texels, size_t count)
{
    for (size_t i = 0; i < count; i++)
        texels[i] = (uint8_t)(7 * i + 1);
}

static void codes_of_8_bits_come_as_they_are(void **state)
{
    static const uint32_t formats[4][2] = { { 9, 15 }, { 16, 22 }, { 23, 29 }, { 37, 43 } };
    fixture *f = *state;
    uint8_t texels[4 * TEXELS];
    fill(texels, sizeof texels);
    for (size_t width = 1; width <= 4; width++)
        for (int srgb = 0; srgb < 2; srgb++) {
            rsv_ktx_picture p;
            write_plain(f, formats[width - 1][srgb], texels, width * TEXELS);
            decode(f, &p);
            assert_int_equal(p.channel_count, width == 4 ? 4 : 3);
            for (size_t i = 0; i < TEXELS; i++)
                for (size_t c = 0; c < p.channel_count; c++)
                    assert_int_equal(
                        p.codes[p.channel_count * i + c], c < width ? texels[width * i + c] : 0);
            rsv_ktx_free(f->context, &p);
        }
}

static void blue_may_come_first_and_channels_be_swizzled(void **state)
{
    fixture *f = *state;
    uint8_t texels[4 * TEXELS];
    rsv_ktx_picture p;
    fill(texels, sizeof texels);
    write_plain(f, 44, texels, sizeof texels);
    decode(f, &p);
    assert_true(p.codes[0] == texels[2] && p.codes[2] == texels[0] && p.codes[3] == texels[3]);
    rsv_ktx_free(f->context, &p);
    write_file(f, 16, 0, texels, 2 * TEXELS, 2 * TEXELS, "KTXswizzle\0rrrg", 16);
    decode(f, &p);
    assert_int_equal(p.channel_count, 4);
    for (size_t i = 0; i < TEXELS; i++) {
        assert_true(p.codes[4 * i] == texels[2 * i] && p.codes[4 * i + 2] == texels[2 * i]);
        assert_int_equal(p.codes[4 * i + 3], texels[2 * i + 1]);
    }
    rsv_ktx_free(f->context, &p);
    write_file(f, 16, 0, texels, 2 * TEXELS, 2 * TEXELS, "KTXswizzle\0rrrx", 16);
    expect(f, RSV_ERROR_FORMAT, "KTXswizzle");
}

static void rows_may_run_upwards(void **state)
{
    fixture *f = *state;
    uint8_t texels[3 * TEXELS];
    rsv_ktx_picture p;
    fill(texels, sizeof texels);
    write_file(f, 23, 0, texels, sizeof texels, sizeof texels, "KTXorientation\0ru", 18);
    decode(f, &p);
    assert_memory_equal(p.codes, texels + 3 * WIDTH, 3 * WIDTH);
    assert_memory_equal(p.codes + 3 * WIDTH, texels, 3 * WIDTH);
    rsv_ktx_free(f->context, &p);
}

static void wider_values_are_numbers(void **state)
{
    fixture *f = *state;
    // 1, 0.5, -2, the largest, the least above 0, infinity
    const uint16_t half[TEXELS] = { 0x3c00, 0x3800, 0xc000, 0x7bff, 0x0001, 0x7c00 };
    const float value[TEXELS] = { 1, 0.5f, -2, 65504, 0x1p-24f, INFINITY };
    uint8_t texels[4 * TEXELS];
    rsv_ktx_picture p;
    for (int k = 0; k < TEXELS; k++)
        put(texels + 2 * k, half[k], 2);
    write_plain(f, 76, texels, 2 * TEXELS);
    decode(f, &p);
    assert_false(p.are_codes);
    for (int k = 0; k < TEXELS; k++)
        assert_true(p.values[3 * k] == value[k] && p.values[3 * k + 1] == 0);
    rsv_ktx_free(f->context, &p);
    for (int k = 0; k < TEXELS; k++) {
        uint32_t bits;
        memcpy(&bits, &value[k], 4);
        put(texels + 4 * k, bits, 4);
    }
    write_plain(f, 100, texels, 4 * TEXELS);
    decode(f, &p);
    for (int k = 0; k < TEXELS; k++)
        assert_true(p.values[3 * k] == value[k]);
    rsv_ktx_free(f->context, &p);
    write_plain(f, 70, texels, 2 * TEXELS);
    decode(f, &p);
    assert_true(p.are_codes);
    assert_float_equal(p.values[3], (texels[2] | texels[3] << 8) / 65535.0, 1e-7);
    rsv_ktx_free(f->context, &p);
}

static void packed_texels_are_the_same(void **state)
{
    fixture *f = *state;
    uint8_t texels[3 * TEXELS], packed[256];
    fill(texels, sizeof texels);
    for (uint32_t packing = 2; packing <= 3; packing++) {
        uLongf size = sizeof packed;
        rsv_ktx_picture p;
        if (packing == 2)
            size = ZSTD_compress(packed, sizeof packed, texels, sizeof texels, 3);
        else
            assert_int_equal(compress(packed, &size, texels, sizeof texels), Z_OK);
        write_file(f, 29, packing, packed, size, sizeof texels, NULL, 0);
        decode(f, &p);
        assert_memory_equal(p.codes, texels, sizeof texels);
        rsv_ktx_free(f->context, &p);
        f->file.size--;
        put(f->bytes + 88, size - 1, 8);
        expect(f, RSV_ERROR_FORMAT, "damaged");
        write_file(f, 37, packing, packed, size, sizeof texels, NULL, 0);
        expect(f, RSV_ERROR_FORMAT, "damaged"); // texels are fewer than their format says
    }
}

/// Reads a file whole. @return to be freed
static uint8_t *load(const char *name, rsv_image_file *file)
{
    char path[1024];
    snprintf(path, sizeof path, "%s/%s", RSV_BASIS_FILES, name);
    FILE *stream = fopen(path, "rb");
    assert_non_null(stream);
    uint8_t *bytes = malloc(1 << 16);
    size_t size = fread(bytes, 1, 1 << 16, stream);
    fclose(stream);
    *file = (rsv_image_file){ "t.ktx2", bytes, size };
    return bytes;
}

/// @param differences allowed in red, green, blue and alpha, codes
static void assert_decoded(fixture *f, const char *name, const char *expected, const int most[4])
{
    rsv_image_file file[2];
    uint8_t *bytes[2] = { load(name, &file[0]), load(expected, &file[1]) };
    rsv_ktx_picture p[2];
    for (int k = 0; k < 2; k++)
        if (rsv_ktx_decode(f->context, &file[k], &p[k]) != RSV_OK) fail_msg("%s", rsv_last_error());
    assert_true(p[0].width == p[1].width && p[0].height == p[1].height);
    assert_true(p[0].channel_count == 4 && p[1].channel_count == 4);
    for (size_t i = 0; i < 4 * (size_t)p[0].width * p[0].height; i++)
        assert_true(abs(p[0].codes[i] - p[1].codes[i]) <= most[i % 4]);
    for (int k = 0; k < 2; k++) {
        rsv_ktx_free(f->context, &p[k]);
        free(bytes[k]);
    }
}

static void blocks_are_decoded_as_the_encoder_does(void **state)
{
    static const int same[4] = { 0, 0, 0, 0 };
    static const int almost[4] = { 0, 0, 0, 1 }; // the other decoder rounds alpha to EAC
    assert_decoded(*state, "uastc.ktx2", "uastc-decoded.ktx2", same);
    assert_decoded(*state, "etc1s.ktx2", "etc1s-decoded.ktx2", almost);
}

/// Every file with one byte changed, or cut short, is decoded or rejected.
static void damaged_blocks_are_harmless(void **state)
{
    static const char *const names[2] = { "uastc.ktx2", "etc1s.ktx2" };
    fixture *f = *state;
    for (int k = 0; k < 2; k++) {
        rsv_image_file file;
        uint8_t *bytes = load(names[k], &file);
        size_t size = file.size;
        for (size_t i = 0; i < 2 * size; i++) {
            rsv_ktx_picture p;
            uint8_t before = bytes[i / 2];
            file.size = i % 2 ? size : i / 2;
            if (i % 2 && (i / 2 < 20 || i / 2 >= 28))
                bytes[i / 2] ^= (uint8_t)(1 + 37 * i); // not the size
            if (file.size >= 12 && rsv_ktx_decode(f->context, &file, &p) == RSV_OK)
                rsv_ktx_free(f->context, &p);
            bytes[i / 2] = before;
        }
        free(bytes);
    }
}

/// The places of a texel's channels follow from the data format descriptor.
static void blocks_know_their_channels(void **state)
{
    enum { CHANNEL = 28 + 3, TRANSFER = 14 };
    fixture *f = *state;
    rsv_image_file file;
    rsv_ktx_picture p[3];
    uint8_t *bytes = load("uastc.ktx2", &file), *descriptor = bytes + bytes[48];
    static const uint8_t channels[3] = { 3, 0, 5 }; // RGBA, RGB, red and green
    for (int k = 0; k < 3; k++) {
        descriptor[CHANNEL] = channels[k];
        assert_int_equal(rsv_ktx_decode(f->context, &file, &p[k]), RSV_OK);
    }
    assert_true(p[0].channel_count == 4 && p[1].channel_count == 3 && p[2].channel_count == 3);
    for (size_t i = 0; i < (size_t)p[0].width * p[0].height; i++) {
        assert_memory_equal(p[1].codes + 3 * i, p[0].codes + 4 * i, 3);
        assert_int_equal(p[2].codes[3 * i], p[0].codes[4 * i]);
        assert_int_equal(p[2].codes[3 * i + 1], p[0].codes[4 * i + 3]);
    }
    for (int k = 0; k < 3; k++)
        rsv_ktx_free(f->context, &p[k]);
    free(bytes);
}

static void what_is_not_read_is_refused(void **state)
{
    fixture *f = *state;
    uint8_t texels[4 * TEXELS] = { 0 };
    write_file(f, 0, 1, texels, 20, 0, NULL, 0);
    expect(f, RSV_ERROR_FORMAT, "descriptor");
    put(f->bytes + 48, 110, 4); // a descriptor of zeros
    put(f->bytes + 52, 44, 4);
    expect(f, RSV_ERROR_UNSUPPORTED, "colour model 0");
    write_plain(f, 145, texels, 16); // BC7
    expect(f, RSV_ERROR_UNSUPPORTED, "format 145");
    write_file(f, 37, 9, texels, 20, 0, NULL, 0);
    expect(f, RSV_ERROR_UNSUPPORTED, "packed");
    write_plain(f, 37, texels, sizeof texels);
    put(f->bytes + 36, 6, 4);
    expect(f, RSV_ERROR_UNSUPPORTED, "cube");
}

static void sizes_that_lie_are_refused(void **state)
{
    fixture *f = *state;
    uint8_t texels[4 * TEXELS] = { 0 };
    write_plain(f, 37, texels, sizeof texels);
    put(f->bytes + 20, 0x80000000u, 4);
    expect(f, RSV_ERROR_FORMAT, "2147483648 x 2");
    put(f->bytes + 20, 0, 4);
    expect(f, RSV_ERROR_FORMAT, "0 x 2");
    put(f->bytes + 20, 16384, 4);
    put(f->bytes + 24, 16384, 4);
    expect(f, RSV_ERROR_FORMAT, "do not fit in");
    put(f->bytes + 44, 2, 4);
    expect(f, RSV_ERROR_FORMAT, "do not fit in");
    write_plain(f, 37, texels, sizeof texels);
    put(f->bytes + 80, UINT64_MAX - 3, 8);
    expect(f, RSV_ERROR_FORMAT, "truncated");
    write_plain(f, 37, texels, sizeof texels);
    put(f->bytes + 56, 100, 4); // keys past the end, and a key longer than they are
    put(f->bytes + 60, UINT32_MAX, 4);
    rsv_ktx_picture p;
    decode(f, &p);
    rsv_ktx_free(f->context, &p);
    write_file(f, 37, 0, texels, sizeof texels, 0, "KTXswizzle\0rrrg", 16);
    put(f->bytes + 104, UINT32_MAX, 4);
    decode(f, &p);
    rsv_ktx_free(f->context, &p);
    size_t whole = f->file.size;
    for (f->file.size = 12; f->file.size < whole; f->file.size++)
        expect(f, RSV_ERROR_FORMAT, "truncated");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(codes_of_8_bits_come_as_they_are),
        cmocka_unit_test(blue_may_come_first_and_channels_be_swizzled),
        cmocka_unit_test(rows_may_run_upwards),
        cmocka_unit_test(wider_values_are_numbers),
        cmocka_unit_test(packed_texels_are_the_same),
        cmocka_unit_test(blocks_are_decoded_as_the_encoder_does),
        cmocka_unit_test(blocks_know_their_channels),
        cmocka_unit_test(damaged_blocks_are_harmless),
        cmocka_unit_test(what_is_not_read_is_refused),
        cmocka_unit_test(sizes_that_lie_are_refused),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
