#include "file_source.h"
#include "image_internal.h"
#include "image_ktx.h"
#include "texture_image.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

typedef struct image_format {
    const char *extension;
    rsv_status (*decode)(rsv_context *context, const rsv_image_file *file, rsv_image **image);
    rsv_status (*encode)(const rsv_image *image, float exposure, rsv_atomic_file *file);
} image_format;

static const image_format formats[] = {
    { ".exr", rsv_image_decode_exr, rsv_image_encode_exr },
    { ".hdr", rsv_image_decode_hdr, rsv_image_encode_hdr },
    { ".png", rsv_image_decode_ldr, rsv_image_encode_png },
    { ".jpg", rsv_image_decode_ldr, NULL },
    { ".jpeg", rsv_image_decode_ldr, NULL },
    { ".tga", rsv_image_decode_ldr, NULL },
    { ".bmp", rsv_image_decode_ldr, NULL },
    { ".gif", rsv_image_decode_ldr, NULL },
    { ".webp", rsv_image_decode_webp_picture, NULL },
};

static const image_format *find_format(const char *path)
{
    const char *name = strrchr(path, '/');
    const char *extension = strrchr(name ? name + 1 : path, '.');
    for (size_t i = 0; extension && i < sizeof formats / sizeof *formats; i++)
        if (strcasecmp(extension, formats[i].extension) == 0) return &formats[i];
    return NULL;
}

bool rsv_image_is_webp(const rsv_image_file *file)
{
    return file->size >= 12 && memcmp(file->bytes, "RIFF", 4) == 0 &&
           memcmp(file->bytes + 8, "WEBP", 4) == 0;
}

bool rsv_image_is_ktx(const rsv_image_file *file)
{
    static const uint8_t identifier[12] = { 0xab, 'K', 'T', 'X', ' ', '2', '0', 0xbb, '\r', '\n',
        0x1a, '\n' };
    return file->size >= sizeof identifier &&
           memcmp(file->bytes, identifier, sizeof identifier) == 0;
}

/// The format told by the first bytes, whatever the name; NULL = not recognised.
static const image_format *format_of_content(const uint8_t *bytes, size_t size)
{
    static const struct {
        const char *start, *extension;
    } known[] = { { "\x76\x2f\x31\x01", ".exr" }, { "#?", ".hdr" }, { "\x89PNG", ".png" },
        { "\xff\xd8\xff", ".jpg" }, { "BM", ".bmp" }, { "GIF8", ".gif" } };
    const rsv_image_file file = { .bytes = bytes, .size = size };
    if (rsv_image_is_webp(&file)) return find_format(".webp");
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        size_t length = strlen(known[i].start);
        if (size >= length && memcmp(bytes, known[i].start, length) == 0)
            return find_format(known[i].extension);
    }
    return NULL;
}

static rsv_status find_output_format(const char *path, const image_format **format)
{
    *format = find_format(path);
    if (*format && (*format)->encode) return RSV_OK;
    return rsv_fail(
        RSV_ERROR_ARGUMENT, "cannot write '%s': the name must end in .exr, .hdr or .png", path);
}

static rsv_status fail_unknown(const char *path)
{
    return rsv_fail(RSV_ERROR_UNSUPPORTED,
        "cannot read '%s' as an image: the name must end in .exr, .hdr, .png, .jpg, "
        ".webp, .tga, .bmp or .gif",
        path);
}

static rsv_status fail_read(rsv_status status, const char *path)
{
    char message[256];
    snprintf(message, sizeof message, "%s", rsv_last_error());
    const char *why = strncmp(message, "cannot be read: ", 16) == 0 ? message + 16 : message;
    return rsv_fail(status, "cannot read '%s': %s", path, why);
}

rsv_status rsv_image_file_read(
    rsv_context *context, const rsv_file_source *files, const char *path, rsv_image_file *file)
{
    char *bytes = NULL;
    *file = (rsv_image_file){ .path = path };
    rsv_status status = rsv_file_read(context, files, path, &bytes, &file->size);
    file->bytes = (const uint8_t *)bytes;
    return status == RSV_OK || status == RSV_ERROR_MEMORY ? status : fail_read(status, path);
}

static rsv_status decode(rsv_context *context, const rsv_image_file *file, rsv_image **image)
{
    const image_format *format = format_of_content(file->bytes, file->size);
    if (!format) format = find_format(file->path);
    if (!format) return fail_unknown(file->path);
    if (file->size == 0)
        return rsv_fail(RSV_ERROR_FORMAT, "cannot read '%s': the file is empty", file->path);
    return format->decode(context, file, image);
}

rsv_status rsv_image_read(rsv_context *context, const char *path, rsv_image **image)
{
    rsv_image_file file;
    rsv_status status = rsv_image_file_read(context, NULL, path, &file);
    if (status == RSV_OK) status = decode(context, &file, image);
    // a file that cannot be opened and has no picture's extension most likely has a mistake in its name
    else if (status != RSV_ERROR_MEMORY && !find_format(path))
        status = fail_unknown(path);
    rsv_free(context, (void *)(uintptr_t)file.bytes);
    return status;
}

rsv_status rsv_image_read_memory(
    rsv_context *context, const char *name, const void *bytes, size_t count, rsv_image **image)
{
    return decode(context, &(rsv_image_file){ .path = name, .bytes = bytes, .size = count }, image);
}

rsv_status rsv_image_write(const rsv_image *image, const char *path, float exposure)
{
    rsv_status status = RSV_OK;
    rsv_atomic_file file = { .descriptor = -1 };
    const image_format *format;
    RSV_TRY(find_output_format(path, &format));
    RSV_TRY(rsv_atomic_file_open(&file, path));
    RSV_TRY(format->encode(image, exposure, &file));
    RSV_TRY(rsv_atomic_file_commit(&file));
cleanup:
    rsv_atomic_file_discard(&file);
    return status;
}

rsv_status rsv_image_check_output(const char *path)
{
    rsv_atomic_file file;
    const image_format *format;
    rsv_status status = find_output_format(path, &format);
    // only trying reveals read-only mounts, quotas and access lists
    if (status == RSV_OK) status = rsv_atomic_file_open(&file, path);
    if (status == RSV_OK) rsv_atomic_file_discard(&file);
    return status;
}
