/// Radiance pictures (Ward, "Real Pixels", Graphics Gems II): three 8-bit mantissas, one exponent.
///
/// Written here because a reader must tell a truncated file from a black one, and a writer must round
/// to nearest: truncating mantissas darkens a picture by 0.3 % on average.
#include "../core/number_text.h"
#include "../core/vec.h"
#include "image_internal.h"

#include <float.h>
#include <stdio.h>
#include <string.h>

typedef struct reader {
    const rsv_image_file *file;
    size_t position;
} reader;

/// Contents of the lines before the pixels.
typedef struct hdr_header {
    bool is_xyz; ///< pixels are CIE X, Y, Z
    double
        scale[3]; ///< to the radiance that was recorded, before exposures and corrections of colour
    uint32_t width, height;
    bool columns;                 ///< the file holds one column after the other
    bool from_right, from_bottom; ///< where columns and rows begin
    bool foreign_primaries;
} hdr_header;

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

/// EXPOSURE and COLORCORR lines give factors that the radiances were multiplied by. There may be several; all apply.
static rsv_status divide_by(const reader *in, const char *text, int count, hdr_header *h)
{
    double factor[3] = { 1, 1, 1 };
    for (int c = 0; c < count; c++) {
        char *end = NULL;
        factor[c] = rsv_number_value(text, &end);
        if (end == text || !(factor[c] > 0 && factor[c] < INFINITY))
            return fail_format(in, count == 1 ? "invalid EXPOSURE" : "invalid COLORCORR");
        text = end;
    }
    for (int c = 0; c < 3; c++)
        h->scale[c] /= factor[count == 1 ? 0 : c];
    return RSV_OK;
}

/// Whether a PRIMARIES line (x and y of red, green, blue and white) differs from the primaries assumed without one:
/// Radiance's own or those of sRGB, which are nearly the same.
static bool are_foreign(const char *text)
{
    static const double usual[6] = { 0.64, 0.33, 0.295, 0.6, 0.15, 0.06 };
    for (int i = 0; i < 6; i++) {
        char *end = NULL;
        double value = rsv_number_value(text, &end);
        if (end == text || fabs(value - usual[i]) > 0.02) return true;
        text = end;
    }
    return false;
}

static rsv_status read_variable(const reader *in, const char *line, hdr_header *h)
{
    if (strncmp(line, "FORMAT=", 7) == 0) {
        const char *format = line + 7 + strspn(line + 7, " \t");
        size_t length = strcspn(format, " \t");
        h->is_xyz = length == 15 && strncmp(format, "32-bit_rle_xyze", 15) == 0;
        if (!h->is_xyz && (length != 15 || strncmp(format, "32-bit_rle_rgbe", 15) != 0))
            return rsv_fail(RSV_ERROR_UNSUPPORTED,
                "cannot read '%s': pixel format '%.40s' is neither 32-bit_rle_rgbe nor "
                "32-bit_rle_xyze",
                in->file->path, format);
    }
    if (strncmp(line, "EXPOSURE=", 9) == 0) return divide_by(in, line + 9, 1, h);
    if (strncmp(line, "COLORCORR=", 10) == 0) return divide_by(in, line + 10, 3, h);
    if (strncmp(line, "PRIMARIES=", 10) == 0) h->foreign_primaries = are_foreign(line + 10);
    return RSV_OK;
}

/// "-Y height +X width" and its seven turned and mirrored forms: the axis that changes slowly comes first, and Y counts
/// upwards.
static rsv_status read_resolution(const reader *in, const char *line, hdr_header *h)
{
    char sign[2], axis[2];
    long long count[2];
    bool understood = sscanf(line, "%c%c %lld %c%c %lld", &sign[0], &axis[0], &count[0], &sign[1],
                          &axis[1], &count[1]) == 6;
    for (int i = 0; i < 2 && understood; i++)
        understood = (sign[i] == '+' || sign[i] == '-') && (axis[i] == 'X' || axis[i] == 'Y');
    if (!understood || axis[0] == axis[1])
        return rsv_fail(RSV_ERROR_UNSUPPORTED,
            "cannot read '%s': resolution line '%.60s' is not of a form such as '-Y height +X "
            "width'",
            in->file->path, line);
    h->columns = axis[0] == 'X';
    h->from_right = sign[h->columns ? 0 : 1] == '-';
    h->from_bottom = sign[h->columns ? 1 : 0] == '+';
    long long width = count[h->columns ? 0 : 1], height = count[h->columns ? 1 : 0];
    h->width = (uint32_t)width;
    h->height = (uint32_t)height;
    return rsv_image_check_size(in->file->path, width, height);
}

static rsv_status read_header(reader *in, hdr_header *h)
{
    char line[256];
    *h = (hdr_header){ .scale = { 1, 1, 1 } };
    if (!next_line(in, line, sizeof line) || strncmp(line, "#?", 2) != 0)
        return fail_format(in, "not a Radiance picture (no '#?' line)");
    do {
        if (!next_line(in, line, sizeof line)) return fail_format(in, "header without an end");
        rsv_status status = read_variable(in, line, h);
        if (status != RSV_OK) return status;
    } while (line[0]);
    if (!next_line(in, line, sizeof line)) return fail_format(in, "no resolution line");
    return read_resolution(in, line, h);
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

/// Decodes one component of a row: a count above 128 starts a run, any other a number of literal bytes.
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

/// The radiance of a pixel, with the exposure undone. Values that exceed a float become the largest float.
static rsv_rgb decode_pixel(const uint8_t code[4], const hdr_header *h)
{
    if (code[3] == 0) return rgb_gray(0);
    double unit = ldexp(1, code[3] - (128 + 8)), v[3];
    for (int c = 0; c < 3; c++)
        v[c] = code[c] * unit * h->scale[c];
    if (h->is_xyz) { // to the primaries and the white of sRGB (IEC 61966-2-1)
        static const double row[3][3] = { { 3.2404542, -1.5371385, -0.4985314 },
            { -0.9692660, 1.8760108, 0.0415560 }, { 0.0556434, -0.2040259, 1.0572252 } };
        const double x = v[0], y = v[1], z = v[2];
        for (int c = 0; c < 3; c++)
            v[c] = row[c][0] * x + row[c][1] * y + row[c][2] * z;
    }
    for (int c = 0; c < 3; c++)
        v[c] = fmax(fmin(v[c], (double)FLT_MAX), h->is_xyz ? 0 : -INFINITY);
    return rgb((float)v[0], (float)v[1], (float)v[2]);
}

/// A line of the file, a row or a column, to its place in the picture.
static void place_line(
    const hdr_header *h, uint32_t line, const uint8_t (*code)[4], rsv_rgb *pixels)
{
    uint32_t length = h->columns ? h->height : h->width;
    for (uint32_t i = 0; i < length; i++) {
        uint32_t x = h->columns ? line : i, y = h->columns ? i : line;
        if (h->from_right) x = h->width - 1 - x;
        if (h->from_bottom) y = h->height - 1 - y;
        pixels[(size_t)y * h->width + x] = decode_pixel(code[i], h);
    }
}

rsv_status rsv_image_decode_hdr(rsv_context *context, const rsv_image_file *file, rsv_image **image)
{
    rsv_status status = RSV_OK;
    reader in = { .file = file };
    hdr_header h;
    rsv_image *decoded = NULL;
    uint8_t(*line)[4] = NULL;
    RSV_TRY(read_header(&in, &h));
    uint32_t lines = h.columns ? h.width : h.height, length = h.columns ? h.height : h.width;
    // no encoding needs fewer bytes: never allocate because of a header alone
    if ((file->size - in.position) / sizeof *line < lines)
        RSV_TRY(fail_format(&in, "the file is truncated: fewer bytes than its rows need"));
    line = rsv_alloc(context, length, sizeof *line);
    if (!line) RSV_TRY(RSV_ERROR_MEMORY);
    RSV_TRY(rsv_image_create(context, h.width, h.height, 1, &decoded));
    for (uint32_t i = 0; i < lines; i++) {
        RSV_TRY(read_row(&in, length, line));
        place_line(&h, i, (const uint8_t(*)[4])line, rsv_image_pixels(decoded, 0));
    }
    if (h.foreign_primaries)
        rsv_log(context, RSV_LOG_WARNING,
            "picture '%s': its PRIMARIES are ignored; its colours are assumed to be sRGB",
            file->path);
    *image = decoded;
    decoded = NULL;
cleanup:
    rsv_image_destroy(decoded);
    rsv_free(context, line);
    return status;
}

/// Negative values and NaN become 0; values beyond the format become its largest.
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
