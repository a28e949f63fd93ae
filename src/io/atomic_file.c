#include "atomic_file.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

_Static_assert(RSV_PATH_BYTES >= PATH_MAX, "realpath writes up to PATH_MAX bytes");

#define PERMISSIONS_NEW_FILE 0666
#define TEMPORARY_NAMES 10000

static rsv_status fail_write(const char *path, int error)
{
    return rsv_fail(RSV_ERROR_IO, "cannot write '%s': %s", path, strerror(error));
}

/// Finds the final target: `path`, or the file that a symbolic link there points to. Stores the
/// permissions of the file to be replaced, 0 if there is none.
static rsv_status find_target(rsv_atomic_file *file, const char *path, mode_t *permissions)
{
    struct stat existing;
    *permissions = 0;
    if (strlen(path) >= sizeof file->target) return fail_write(path, ENAMETOOLONG);
    if (!*path) return rsv_fail(RSV_ERROR_IO, "cannot write a file without a name");
    if (stat(path, &existing) != 0) {
        strcpy(file->target, path);
        return errno == ENOENT ? RSV_OK : fail_write(path, errno);
    }
    if (S_ISDIR(existing.st_mode))
        return rsv_fail(RSV_ERROR_IO, "cannot write '%s': it is a folder; name a file", path);
    if (!S_ISREG(existing.st_mode))
        return rsv_fail(RSV_ERROR_IO, "cannot write '%s': it is not a regular file", path);
    if (!realpath(path, file->target)) return fail_write(path, errno);
    *permissions = existing.st_mode & 07777;
    return RSV_OK;
}

/// O_EXCL makes the name unique among processes and threads without any shared counter.
static int open_temporary(rsv_atomic_file *file, int folder_length)
{
    for (int i = 0; i < TEMPORARY_NAMES; i++) {
        int length = snprintf(file->temporary, sizeof file->temporary, "%.*s.resolvent-%ld-%d.tmp",
            folder_length, file->target, (long)getpid(), i);
        if (length >= (int)sizeof file->temporary) {
            errno = ENAMETOOLONG;
            return -1;
        }
        int descriptor =
            open(file->temporary, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, PERMISSIONS_NEW_FILE);
        if (descriptor >= 0 || errno != EEXIST) return descriptor;
    }
    return -1;
}

rsv_status rsv_atomic_file_open(rsv_atomic_file *file, const char *path)
{
    mode_t permissions;
    file->descriptor = -1;
    file->error = 0;
    file->end = 0;
    rsv_status status = find_target(file, path, &permissions);
    if (status != RSV_OK) return status;

    const char *slash = strrchr(file->target, '/');
    int folder_length = slash ? (int)(slash - file->target) + 1 : 0;
    file->descriptor = open_temporary(file, folder_length);
    if (file->descriptor < 0)
        return rsv_fail(RSV_ERROR_IO, "cannot write '%s' into folder '%.*s': %s%s", path,
            slash ? folder_length : 1, slash ? file->target : ".", strerror(errno),
            errno == ENOENT ? "; create the folder first" : "");
    if (permissions && fchmod(file->descriptor, permissions) != 0) file->error = errno;
    return RSV_OK;
}

rsv_status rsv_atomic_file_join(rsv_atomic_file *file, const char *temporary)
{
    *file = (rsv_atomic_file){ .descriptor = open(temporary, O_WRONLY | O_CLOEXEC) };
    return file->descriptor >= 0 ? RSV_OK : fail_write(temporary, errno);
}

rsv_status rsv_atomic_file_close(rsv_atomic_file *file)
{
    if (!file->error && fsync(file->descriptor) != 0) file->error = errno;
    if (close(file->descriptor) != 0 && !file->error) file->error = errno;
    file->descriptor = -1;
    return file->error ? fail_write("its part of the file", file->error) : RSV_OK;
}

void rsv_atomic_file_append(rsv_atomic_file *file, const void *data, size_t bytes)
{
    rsv_atomic_file_write_at(file, file->end, data, bytes);
}

void rsv_atomic_file_write_at(
    rsv_atomic_file *file, uint64_t offset, const void *data, size_t bytes)
{
    const char *next = data;
    while (bytes > 0 && !file->error) {
        ssize_t written = pwrite(file->descriptor, next, bytes, (off_t)offset);
        if (written < 0) {
            if (errno != EINTR) file->error = errno;
            continue;
        }
        next += written;
        offset += (uint64_t)written;
        bytes -= (size_t)written;
    }
    if (offset > file->end) file->end = offset;
}

void rsv_atomic_file_read_at(rsv_atomic_file *file, uint64_t offset, void *data, size_t bytes)
{
    char *next = data;
    while (bytes > 0 && !file->error) {
        ssize_t got = pread(file->descriptor, next, bytes, (off_t)offset);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) {
            file->error = got < 0 ? errno : EIO;
            return;
        }
        next += got;
        offset += (uint64_t)got;
        bytes -= (size_t)got;
    }
}

rsv_status rsv_atomic_file_commit(rsv_atomic_file *file)
{
    if (!file->error && fsync(file->descriptor) != 0) file->error = errno;
    if (close(file->descriptor) != 0 && !file->error) file->error = errno;
    file->descriptor = -1;
    if (!file->error && rename(file->temporary, file->target) != 0) file->error = errno;
    if (!file->error) return RSV_OK;
    unlink(file->temporary);
    return fail_write(file->target, file->error);
}

void rsv_atomic_file_discard(rsv_atomic_file *file)
{
    if (file->descriptor < 0) return;
    close(file->descriptor);
    file->descriptor = -1;
    if (*file->temporary) unlink(file->temporary); // of a part, it is another process's
}
