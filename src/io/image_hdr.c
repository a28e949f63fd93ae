/// Radiance pictures (Ward, "Real Pixels", Graphics Gems II): three 8-bit mantissas, one exponent.
///
/// Our own few lines, because a reader must tell a truncated file from a black one and a writer
/// must round to nearest: truncating mantissas darkens a picture by 0.3 % on average.
#include "../core/number_text.h"
#include "../core/vec.h"
#include "image_internal.h"

#include <stdio.h>
#include <string.h>

typedef struct reader {
    const rsv_image_file *file;
    size_t position;
} reader;

static rsv_status fail_format(const reader *in, const char *problem)
{
    return rsv_fail(RSV_ERROR_FORMAT, "cannot read '%s': %s at byte %zu", in->file->path, problem,
        in->position);
}

/// Copies the next line, without its newline and cut to fit; false at the end of the file.
static bool next_line(reader *in, char *line, size_t line_bytes)
{
    const uint8_t *start = in->file->bytes + in->position;
    const uint8_t *end = memchr(start, '\n', in->file->size - in->position);
    if (!end) return false;
    size_t length = (size_t)(end - start);
    in->position += length + 1;
    if (length > 0 && start[length - 1] == '\r') length--;
    if (length > line_bytes - 1) length = line_bytes - 1;
    memcpy(line, start, length);
    line[length] = 0;
    return true;
}

/// @param exposure product of all EXPOSURE lines: what the radiances were multiplied by
static rsv_status read_header(reader *in, uint32_t *width, uint32_t *height, double *exposure)
{
    char line[256];
    long long columns, rows;
    *exposure = 1;
    if (!next_line(in, line, sizeof line) || strncmp(line, "#?", 2) != 0)
        return fail_format(in, "not a Radiance picture (no '#?' line)");
    do {
        if (!next_line(in, line, sizeof line)) return fail_format(in, "header without an end");
        if (strncmp(line, "FORMAT=", 7) == 0 && strcmp(line + 7, "32-bit_rle_rgbe") != 0)
            return rsv_fail(RSV_ERROR_UNSUPPORTED,
                "cannot read '%s': pixel format '%s' is not 32-bit_rle_rgbe", in->file->path,
                line + 7);
        if (strncmp(line, "EXPOSURE=", 9) == 0) *exposure *= rsv_number_value(line + 9, NULL);
    } while (line[0]);
    if (!(*exposure > 0 && *exposure < INFINITY)) return fail_format(in, "invalid EXPOSURE");
    if (!next_line(in, line, sizeof line)) return fail_format(in, "no resolution line");
    if (sscanf(line, "-Y %lld +X %lld", &rows, &columns) != 2)
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "cannot read '%s': resolution line '%s' is not of the form '-Y height +X width'",
            in->file->path, line);
    *width = (uint32_t)columns;
    *height = (uint32_t)rows;
    return rsv_image_check_size(in->file->path, columns, rows);
}

/// Pixels one after the other; (1, 1, 1, n) repeats the previous one n << 8k times, the k-th such
/// marker in a row.
static rsv_status read_flat_row(reader *in, uint32_t width, uint8_t (*row)[4])
{
    unsigned shift = 0;
    for (uint32_t x = 0; x < width;) {
        if (in->file->size - in->position < 4) return fail_format(in, "the file is truncated");
        const uint8_t *pixel = in->file->bytes + in->position;
        in->position += 4;
        if (pixel[0] != 1 || pixel[1] != 1 || pixel[2] != 1) {
            memcpy(row[x++], pixel, 4);
            shift = 0;
            continue;
        }
        size_t repeats = (size_t)pixel[3] << shift;
        if (x == 0 || shift > 16 || repeats > width - x) return fail_format(in, "invalid run");
        for (; repeats > 0; repeats--, x++)
            memcpy(row[x], row[x - 1], 4);
        shift += 8;
    }
    return RSV_OK;
}

/// One component of a row: a count above 128 announces a run, else so many literal bytes.
static rsv_status read_run_length_component(
    reader *in, uint32_t width, unsigned c, uint8_t (*row)[4])
{
    for (uint32_t x = 0; x < width;) {
        if (in->file->size - in->position < 2) return fail_format(in, "the file is truncated");
        uint8_t count = in->file->bytes[in->position++];
        bool is_run = count > 128;
        if (is_run) count -= 128;
        if (count == 0 || count > width - x) return fail_format(in, "invalid run");
        size_t stored = is_run ? 1 : count;
        if (in->file->size - in->position < stored) return fail_format(in, "the file is truncated");
        for (unsigned i = 0; i < count; i++)
            row[x++][c] = in->file->bytes[in->position + (is_run ? 0 : i)];
        in->position += stored;
    }
    return RSV_OK;
}

static rsv_status read_row(reader *in, uint32_t width, uint8_t (*row)[4])
{
    const uint8_t *start = in->file->bytes + in->position;
    bool is_run_length = in->file->size - in->position >= 4 && start[0] == 2 && start[1] == 2 &&
                         start[2] < 128 && width >= 8;
    if (!is_run_length) return read_flat_row(in, width, row);
    if ((uint32_t)(start[2] << 8 | start[3]) != width)
        return fail_format(in, "row length differs from the picture's width");
    in->position += 4;
    for (unsigned c = 0; c < 4; c++) {
        rsv_status status = read_run_length_component(in, width, c, row);
        if (status != RSV_OK) return status;
    }
    return RSV_OK;
}

static rsv_rgb decode_rgbe(const uint8_t rgbe[4], double scale)
{
    if (rgbe[3] == 0) return rgb_gray(0);
    double unit = ldexp(scale, rgbe[3] - (128 + 8));
    return rgb((float)(rgbe[0] * unit), (float)(rgbe[1] * unit), (float)(rgbe[2] * unit));
}

rsv_status rsv_image_decode_hdr(rsv_context *context, const rsv_image_file *file, rsv_image **image)
{
    rsv_status status = RSV_OK;
    reader in = { .file = file };
    rsv_image *decoded = NULL;
    uint8_t(*row)[4] = NULL;
    uint32_t width = 0, height = 0;
    double exposure = 1;
    RSV_TRY(read_header(&in, &width, &height, &exposure));
    // no row is stored in less: memory is not taken for a header alone
    if ((file->size - in.position) / sizeof *row < height)
        RSV_TRY(fail_format(&in, "the file is truncated: fewer bytes than its rows need"));
    row = rsv_alloc(context, width, sizeof *row);
    if (!row) RSV_TRY(RSV_ERROR_MEMORY);
    RSV_TRY(rsv_image_create(context, width, height, 1, &decoded));
    rsv_rgb *pixel = rsv_image_pixels(decoded, 0);
    for (uint32_t y = 0; y < height; y++) {
        RSV_TRY(read_row(&in, width, row));
        for (uint32_t x = 0; x < width; x++)
            *pixel++ = decode_rgbe(row[x], 1 / exposure);
    }
    *image = decoded;
    decoded = NULL;
cleanup:
    rsv_image_destroy(decoded);
    rsv_free(context, row);
    return status;
}

/// Negative and NaN become 0; what exceeds the format becomes its largest value.
static float clamp_to_rgbe(float v)
{
    const float largest = 0x1.fep+126f;
    return v > 0 ? f_min(v, largest) : 0;
}

static void encode_rgbe(rsv_rgb colour, uint8_t rgbe[4])
{
    float r = clamp_to_rgbe(colour.r), g = clamp_to_rgbe(colour.g), b = clamp_to_rgbe(colour.b);
    float largest = f_max(r, f_max(g, b));
    int exponent;
    memset(rgbe, 0, 4);
    if (largest < 0x1p-127f) return;
    frexpf(largest, &exponent);
    if (ldexp(largest, 8 - exponent) >= 255.5) exponent++; // would round up to 256
    rgbe[0] = (uint8_t)(ldexp(r, 8 - exponent) + 0.5);
    rgbe[1] = (uint8_t)(ldexp(g, 8 - exponent) + 0.5);
    rgbe[2] = (uint8_t)(ldexp(b, 8 - exponent) + 0.5);
    rgbe[3] = (uint8_t)(exponent + 128);
}

/// Rows are stored flat. No reader can mistake one for a run: the largest mantissa is at least 128.
rsv_status rsv_image_encode_hdr(const rsv_image *image, float exposure, rsv_atomic_file *file)
{
    (void)exposure;
    rsv_context *context = rsv_image_context(image);
    uint32_t width = rsv_image_width(image), height = rsv_image_height(image);
    const rsv_rgb *pixel = rsv_image_const_pixels(image, 0);
    uint8_t(*row)[4] = rsv_alloc(context, width, sizeof *row);
    if (!row) return RSV_ERROR_MEMORY;
    char header[128];
    int length = snprintf(header, sizeof header,
        "#?RADIANCE\nSOFTWARE=resolvent\nFORMAT=32-bit_rle_rgbe\n\n-Y %u +X %u\n", height, width);
    rsv_atomic_file_append(file, header, (size_t)length);
    for (uint32_t y = 0; y < height; y++) {
        for (uint32_t x = 0; x < width; x++)
            encode_rgbe(*pixel++, row[x]);
        rsv_atomic_file_append(file, row, width * sizeof *row);
    }
    rsv_free(context, row);
    return RSV_OK;
}
