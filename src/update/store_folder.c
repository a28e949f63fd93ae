/// Files in a folder, mapped into memory for reading.
#include "store.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#define PATH_BYTES 4096
/// Maximum length added to the name of the folder: the name of a file, and of a temporary file next to it.
#define MOST_ADDED_BYTES (RSV_STORE_NAME_BYTES + 32)

typedef struct folder_store {
    rsv_store store;
    char path[PATH_BYTES];
} folder_store;

static void path_of(const rsv_store *s, const char *name, char path[PATH_BYTES])
{
    snprintf(path, PATH_BYTES, "%s/%s", s->place, name);
}

// ---- reading --------------------------------------------------------------------------------------

typedef struct name_list {
    char (*name)[RSV_STORE_NAME_BYTES];
    size_t count, capacity;
} name_list;

static rsv_status add_name(rsv_context *context, name_list *list, const char *name)
{
    size_t length = strlen(name);
    if (length >= RSV_STORE_NAME_BYTES || name[0] == '.') return RSV_OK; // none of ours
    rsv_status status = rsv_grow(
        context, (void **)&list->name, &list->capacity, list->count + 1, sizeof *list->name);
    if (status == RSV_OK) memcpy(list->name[list->count++], name, length + 1);
    return status;
}

static int compare_names(const void *left, const void *right) { return strcmp(left, right); }

static rsv_status list(rsv_store *s, rsv_status (*visit)(void *user, const char *name), void *user)
{
    rsv_status status = RSV_OK;
    name_list names = { 0 };
    DIR *directory = opendir(s->place);
    if (!directory)
        return rsv_fail(
            RSV_ERROR_IO, "checkpoint: cannot open the folder '%s': %s", s->place, strerror(errno));
    for (struct dirent *entry; status == RSV_OK && (entry = readdir(directory));)
        status = add_name(s->context, &names, entry->d_name);
    closedir(directory);
    if (names.count) qsort(names.name, names.count, sizeof *names.name, compare_names);
    for (size_t k = 0; k < names.count && status == RSV_OK; k++)
        status = visit(user, names.name[k]);
    rsv_free(s->context, names.name);
    return status;
}

static rsv_status map_file(rsv_store *s, const char *name, size_t part, rsv_blob *blob)
{
    char path[PATH_BYTES];
    struct stat info;
    *blob = (rsv_blob){ 0 };
    if (part > 0) return RSV_OK;
    path_of(s, name, path);
    int descriptor = open(path, O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) return RSV_OK;
    size_t bytes = fstat(descriptor, &info) == 0 ? (size_t)info.st_size : 0;
    void *byte = bytes ? mmap(NULL, bytes, PROT_READ, MAP_PRIVATE, descriptor, 0) : NULL;
    int why = errno;
    close(descriptor);
    if (byte == MAP_FAILED)
        return rsv_fail(RSV_ERROR_IO, "checkpoint: cannot read '%s': %s", path, strerror(why));
    *blob = (rsv_blob){ byte, bytes };
    return RSV_OK;
}

static void unmap(rsv_store *s, rsv_blob *blob)
{
    (void)s;
    if (blob->count) munmap((void *)(uintptr_t)blob->byte, blob->count);
    *blob = (rsv_blob){ 0 };
}

// ---- writing --------------------------------------------------------------------------------------

/// Writes a temporary file, flushes it to disk, and renames it.
static int write_file(rsv_store *s, const char *name, const void *byte, size_t count)
{
    char path[PATH_BYTES], beside[PATH_BYTES];
    path_of(s, name, path);
    // the name is unique to this process: another run of the same scene has its own
    if (snprintf(beside, sizeof beside, "%s.%ld.part", path, (long)getpid()) >= (int)sizeof beside)
        return ENAMETOOLONG;
    FILE *file = fopen(beside, "wb");
    if (!file) return errno;
    errno = 0;
    bool written =
        fwrite(byte, 1, count, file) == count && fflush(file) == 0 && fsync(fileno(file)) == 0;
    int why = written ? 0 : errno ? errno : EIO;
    if (fclose(file) != 0 && !why) why = errno;
    if (!why && rename(beside, path) != 0) why = errno;
    if (why) remove(beside);
    return why;
}

static int open_end(rsv_store *s, const char *name, size_t keep, int *end)
{
    char path[PATH_BYTES];
    path_of(s, name, path);
    int descriptor = open(path, O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor < 0) return errno;
    if (ftruncate(descriptor, (off_t)keep) != 0 || lseek(descriptor, 0, SEEK_END) < 0) {
        int why = errno;
        close(descriptor);
        return why;
    }
    *end = descriptor;
    return 0;
}

static int append(rsv_store *s, int end, const void *byte, size_t count)
{
    (void)s;
    for (size_t done = 0; done < count;) {
        ssize_t written = write(end, (const uint8_t *)byte + done, count - done);
        if (written >= 0)
            done += (size_t)written;
        else if (errno != EINTR)
            return errno;
    }
    return 0;
}

static void close_end(rsv_store *s, int end)
{
    (void)s;
    close(end);
}

static size_t no_bytes(const rsv_store *s)
{
    (void)s;
    return 0;
}

static void destroy(rsv_store *s) { rsv_free(s->context, s); }

rsv_status rsv_store_folder(rsv_context *context, const char *path, rsv_store **store)
{
    static const rsv_store_table table = { list, map_file, unmap, write_file, open_end, append,
        close_end, no_bytes, destroy };
    size_t length = strlen(path);
    if (length + MOST_ADDED_BYTES > PATH_BYTES)
        return rsv_fail(RSV_ERROR_IO, "checkpoint: the name of the folder is too long");
    folder_store *s = rsv_alloc(context, 1, sizeof *s);
    if (!s) return RSV_ERROR_MEMORY;
    memcpy(s->path, path, length + 1);
    s->store = (rsv_store){ &table, context, "checkpoint", s->path, true };
    *store = &s->store;
    return RSV_OK;
}
