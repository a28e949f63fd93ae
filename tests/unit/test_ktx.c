/// KTX2 images, written here byte by byte: every supported format and compression, and files that are rejected.
#include "core/core.h"
#include "io/image_ktx.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
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

static void what_is_not_read_is_refused(void **state)
{
    fixture *f = *state;
    uint8_t texels[4 * TEXELS] = { 0 };
    write_file(f, 0, 1, texels, 20, 0, NULL, 0);
    expect(f, RSV_ERROR_UNSUPPORTED, "Basis");
    write_file(f, 0, 2, texels, 20, 0, NULL, 0);
    expect(f, RSV_ERROR_UNSUPPORTED, "Basis");
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
        cmocka_unit_test(what_is_not_read_is_refused),
        cmocka_unit_test(sizes_that_lie_are_refused),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
