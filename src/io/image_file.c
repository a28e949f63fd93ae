#include "image_internal.h"
#include "texture_image.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

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

/// By the first bytes, whatever the name says; NULL = they say nothing.
static const image_format *format_of_content(const uint8_t *bytes, size_t size)
{
    static const struct {
        const char *start, *extension;
    } known[] = { { "\x76\x2f\x31\x01", ".exr" }, { "#?", ".hdr" }, { "\x89PNG", ".png" },
        { "\xff\xd8\xff", ".jpg" } };
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

static rsv_status fail_read(const char *path, int error)
{
    return rsv_fail(RSV_ERROR_IO, "cannot read '%s': %s", path, strerror(error));
}

/// @param bytes the whole file; freed by the caller, also after a failure
static rsv_status read_bytes(rsv_context *context, const char *path, uint8_t **bytes, size_t *size)
{
    rsv_status status = RSV_OK;
    struct stat properties;
    FILE *stream = fopen(path, "rb");
    if (!stream) return fail_read(path, errno);
    if (fstat(fileno(stream), &properties) != 0) {
        status = fail_read(path, errno);
        goto cleanup;
    }
    if (!S_ISREG(properties.st_mode)) {
        status = rsv_fail(RSV_ERROR_IO, "cannot read '%s': it is not a regular file", path);
        goto cleanup;
    }
    *bytes = rsv_alloc(context, (size_t)properties.st_size, 1);
    if (!*bytes) {
        status = RSV_ERROR_MEMORY;
        goto cleanup;
    }
    *size = fread(*bytes, 1, (size_t)properties.st_size, stream);
    if (ferror(stream)) status = fail_read(path, errno);
cleanup:
    fclose(stream);
    return status;
}

static rsv_status fail_unknown(const char *path)
{
    return rsv_fail(RSV_ERROR_UNSUPPORTED,
        "cannot read '%s' as an image: the name must end in .exr, .hdr, .png, .jpg or .webp", path);
}

rsv_status rsv_image_file_read(rsv_context *context, const char *path, rsv_image_file *file)
{
    uint8_t *bytes = NULL;
    *file = (rsv_image_file){ .path = path };
    rsv_status status = read_bytes(context, path, &bytes, &file->size);
    file->bytes = bytes;
    return status;
}

rsv_status rsv_image_read(rsv_context *context, const char *path, rsv_image **image)
{
    rsv_status status = RSV_OK;
    uint8_t *bytes = NULL;
    rsv_image_file file = { .path = path };
    const image_format *format = find_format(path);
    status = read_bytes(context, path, &bytes, &file.size);
    if (status != RSV_OK && !format) RSV_TRY(fail_unknown(path));
    RSV_TRY(status);
    file.bytes = bytes;
    const image_format *told = format_of_content(bytes, file.size);
    if (told) format = told;
    if (!format) RSV_TRY(fail_unknown(path));
    if (file.size == 0)
        RSV_TRY(rsv_fail(RSV_ERROR_FORMAT, "cannot read '%s': the file is empty", path));
    RSV_TRY(format->decode(context, &file, image));
cleanup:
    rsv_free(context, bytes);
    return status;
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
    // trying is the only check that knows read-only mounts, quotas and access lists
    if (status == RSV_OK) status = rsv_atomic_file_open(&file, path);
    if (status == RSV_OK) rsv_atomic_file_discard(&file);
    return status;
}
