#include "file_source.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>

#define LARGEST_FILE ((int64_t)UINT32_MAX)

// ---- streams that call back -------------------------------------------------------------------------

typedef struct cookie {
    const rsv_file_source *source;
    char *path;
    int64_t size, at;
} cookie;

/// A callback may return fewer bytes than it was asked for; none before the end is a failure.
static ssize_t read_cookie(void *user, char *bytes, size_t count)
{
    cookie *c = user;
    size_t wanted = (int64_t)count < c->size - c->at ? count : (size_t)(c->size - c->at);
    if (c->at >= c->size) return 0;
    size_t got = c->source->read(c->source->user, c->path, (uint64_t)c->at, bytes, wanted);
    if (got == 0 || got > wanted) {
        errno = EIO;
        return -1;
    }
    c->at += (int64_t)got;
    return (ssize_t)got;
}

static int seek_cookie(void *user, off64_t *offset, int whence)
{
    cookie *c = user;
    int64_t from = whence == SEEK_SET ? 0 : whence == SEEK_CUR ? c->at : c->size;
    if (*offset < -from) return -1;
    *offset = c->at = from + *offset;
    return 0;
}

static int close_cookie(void *user)
{
    free(((cookie *)user)->path);
    free(user);
    return 0;
}

static FILE *open_cookie(const rsv_file_source *source, const char *path, int64_t size)
{
    const cookie_io_functions_t functions = {
        .read = read_cookie, .seek = seek_cookie, .close = close_cookie
    };
    cookie *c = malloc(sizeof *c);
    if (!c) return NULL;
    *c = (cookie){ .source = source, .path = strdup(path), .size = size };
    FILE *file = c->path ? fopencookie(c, "rb", functions) : NULL;
    if (!file) close_cookie(c);
    return file;
}

// ---- files ------------------------------------------------------------------------------------------

int64_t rsv_file_size(const rsv_file_source *source, const char *path)
{
    struct stat info;
    if (source) {
        int64_t size = source->size(source->user, path);
        if (size < 0) errno = ENOENT;
        return size < 0 ? -1 : size;
    }
    if (stat(path, &info) != 0) return -1;
    if (S_ISREG(info.st_mode)) return info.st_size;
    errno = S_ISDIR(info.st_mode) ? EISDIR : ENOTSUP;
    return -1;
}

FILE *rsv_file_open(const rsv_file_source *source, const char *path)
{
    int64_t size = rsv_file_size(source, path);
    if (size < 0) return NULL;
    return source ? open_cookie(source, path, size) : fopen(path, "rb");
}

static rsv_status fail_read(void)
{
    bool is_odd = errno == EISDIR || errno == ENOTSUP; // rsv_file_size says so
    return rsv_fail(
        RSV_ERROR_IO, "cannot be read: %s", is_odd ? "it is not a regular file" : strerror(errno));
}

rsv_status rsv_file_read(rsv_context *context, const rsv_file_source *source, const char *path,
    char **bytes, size_t *size)
{
    rsv_status status = RSV_OK;
    int64_t length = rsv_file_size(source, path);
    FILE *file = rsv_file_open(source, path);
    *bytes = NULL;
    *size = 0;
    if (!file || length < 0) RSV_TRY(fail_read());
    if (length > LARGEST_FILE)
        RSV_TRY(rsv_fail(RSV_ERROR_UNSUPPORTED, "is larger than 4 GiB; cut it into parts"));
    *bytes = rsv_reserve(context, (size_t)length + 1, 1);
    if (!*bytes) RSV_TRY(RSV_ERROR_MEMORY);
    *size = fread(*bytes, 1, (size_t)length, file);
    (*bytes)[*size] = '\0';
    if (ferror(file)) RSV_TRY(fail_read());
cleanup:
    if (file) fclose(file);
    return status;
}

char *rsv_stream_read(FILE *file, size_t *size)
{
    size_t capacity = 0;
    char *text = NULL;
    for (*size = 0;;) {
        if (capacity - *size < 2) {
            char *grown = realloc(text, capacity = 2 * capacity + 65536);
            if (!grown) break;
            text = grown;
        }
        size_t count = fread(text + *size, 1, capacity - *size - 1, file);
        *size += count;
        if (count > 0) continue;
        if (ferror(file)) break;
        text[*size] = '\0';
        if (*size) return text;
        break;
    }
    free(text);
    return NULL;
}

// ---- files in memory ----------------------------------------------------------------------------------

rsv_status rsv_know_file(
    rsv_context *context, const rsv_file_source *source, const char *name, rsv_known_files *known)
{
    size_t k = known->count;
    if (k == RSV_KNOWN_FILES || rsv_file_size(source, name) < 0) return RSV_OK;
    char *bytes = NULL;
    known->count++;
    known->file[k].name = rsv_copy_string(context, name);
    if (!known->file[k].name) return RSV_ERROR_MEMORY;
    rsv_status status = rsv_file_read(context, source, name, &bytes, &known->file[k].size);
    known->file[k].bytes = bytes;
    return status;
}

void rsv_forget_files(rsv_context *context, rsv_known_files *known)
{
    for (size_t k = 0; k < known->count; k++) {
        rsv_free(context, (void *)(uintptr_t)known->file[k].name);
        rsv_free(context, (void *)(uintptr_t)known->file[k].bytes);
    }
    known->count = 0;
}

static size_t find_known(const rsv_known_files *known, const char *name)
{
    size_t k = 0;
    while (k < known->count && strcmp(known->file[k].name, name) != 0)
        k++;
    return k;
}

static int64_t known_size(void *user, const char *name)
{
    const rsv_known_files *known = user;
    size_t k = find_known(known, name);
    return k < known->count ? (int64_t)known->file[k].size : -1;
}

static size_t known_read(void *user, const char *name, uint64_t offset, void *bytes, size_t count)
{
    const rsv_known_files *known = user;
    size_t k = find_known(known, name);
    memcpy(bytes, known->file[k].bytes + offset, count);
    return count;
}

rsv_file_source rsv_known_source(rsv_known_files *known)
{
    return (rsv_file_source){ .size = known_size, .read = known_read, .user = known };
}
