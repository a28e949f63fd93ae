#include "row_reader.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

/// @param file out: empty if there is nothing to learn from it
static rsv_status map_file(rsv_row_reader *f, const char *path, rsv_mapped_file *file)
{
    struct stat info;
    *file = (rsv_mapped_file){ 0 };
    int descriptor = open(path, O_RDONLY | O_CLOEXEC);
    if (descriptor < 0 || fstat(descriptor, &info) != 0 || info.st_size == 0) {
        if (descriptor >= 0) close(descriptor);
        return RSV_OK;
    }
    void *byte = mmap(NULL, (size_t)info.st_size, PROT_READ, MAP_PRIVATE, descriptor, 0);
    close(descriptor);
    if (byte == MAP_FAILED)
        return rsv_fail(RSV_ERROR_IO, "checkpoint: cannot read '%s': %s", path, strerror(errno));
    rsv_status status =
        rsv_grow(f->context, (void **)&f->file, &f->capacity, f->file_count + 1, sizeof *f->file);
    *file = (rsv_mapped_file){ byte, (size_t)info.st_size };
    if (status == RSV_OK)
        f->file[f->file_count++] = *file;
    else
        munmap(byte, file->count);
    return status;
}

/// A record of a file, and whether it is what its writer wrote.
typedef struct listed_record {
    size_t at, bytes;
    uint32_t node;
    bool sound;
} listed_record;

/// Hops from head to head. @param list out, to be freed
static rsv_status list_records(const rsv_row_reader *f, const rsv_mapped_file *file,
    uint32_t ray_count, listed_record **list, size_t *count)
{
    size_t capacity = 0, at = 0;
    *list = NULL;
    *count = 0;
    for (;;) {
        listed_record r = { .at = at };
        r.bytes = rsv_row_record_bytes(
            file->byte + at, file->count - at, f->node_count, ray_count, &r.node);
        if (r.bytes == 0) return RSV_OK;
        rsv_status status =
            rsv_grow(f->context, (void **)list, &capacity, *count + 1, sizeof **list);
        if (status != RSV_OK) return status;
        (*list)[(*count)++] = r;
        at += r.bytes;
    }
}

/// Notes the records of a file. @param end out: bytes up to the first that is not sound
static rsv_status index_records(
    rsv_row_reader *f, const rsv_mapped_file *file, uint32_t ray_count, size_t *end)
{
    listed_record *list;
    size_t count;
    *end = 0;
    rsv_status status = list_records(f, file, ray_count, &list, &count);
#pragma omp parallel for schedule(static) num_threads(rsv_threads(f->context))
    for (size_t k = 0; k < count; k++)
        list[k].sound =
            rsv_row_record_is_sound(file->byte + list[k].at, list[k].bytes, f->node_count);
    for (size_t k = 0; k < count && list[k].sound; k++) {
        f->known[list[k].node] = file->byte + list[k].at;
        *end = list[k].at + list[k].bytes;
    }
    rsv_free(f->context, list);
    return status;
}

static bool is_named(const char *name, const char *key)
{
    size_t length = strlen(name), ending = strlen(".rows");
    return strncmp(name, key, RSV_ROW_KEY_DIGITS) == 0 && length > ending &&
           strcmp(name + length - ending, ".rows") == 0;
}

rsv_status rsv_row_reader_open(rsv_context *context, const char *folder, const char *key,
    size_t node_count, uint32_t ray_count, const char *own, size_t *own_bytes, rsv_row_reader *f)
{
    rsv_status status = RSV_OK;
    char path[RSV_ROW_PATH_BYTES];
    *f = (rsv_row_reader){ .context = context, .node_count = node_count, .ray_count = ray_count };
    f->known = rsv_alloc(context, node_count, sizeof *f->known);
    if (!f->known) return RSV_ERROR_MEMORY;
    DIR *directory = opendir(folder);
    if (!directory)
        return rsv_fail(
            RSV_ERROR_IO, "checkpoint: cannot open the folder '%s': %s", folder, strerror(errno));
    for (struct dirent *entry; status == RSV_OK && (entry = readdir(directory));) {
        rsv_mapped_file file;
        if (!is_named(entry->d_name, key)) continue;
        if (snprintf(path, sizeof path, "%s/%s", folder, entry->d_name) >= (int)sizeof path)
            continue;
        status = map_file(f, path, &file);
        size_t sound = 0;
        if (status == RSV_OK && file.byte) status = index_records(f, &file, ray_count, &sound);
        if (own && strcmp(path, own) == 0) *own_bytes = sound;
    }
    closedir(directory);
    return status;
}

static size_t bytes_from(const rsv_row_reader *f, const uint8_t *record)
{
    for (size_t k = 0; k < f->file_count; k++)
        if (record >= f->file[k].byte && record < f->file[k].byte + f->file[k].count)
            return (size_t)(f->file[k].byte + f->file[k].count - record);
    return 0;
}

const uint8_t *rsv_row_reader_find(const rsv_row_reader *f, uint32_t node)
{
    const uint8_t *record = f->known[node];
    uint32_t there;
    if (!record) return NULL;
    size_t bytes =
        rsv_row_record_bytes(record, bytes_from(f, record), f->node_count, f->ray_count, &there);
    bool sound = bytes && there == node && rsv_row_record_is_sound(record, bytes, f->node_count);
    return sound ? record : NULL;
}

void rsv_row_reader_close(rsv_row_reader *f)
{
    if (!f->context) return;
    for (size_t k = 0; k < f->file_count; k++)
        munmap(f->file[k].byte, f->file[k].count);
    rsv_free(f->context, f->file);
    rsv_free(f->context, f->known);
    *f = (rsv_row_reader){ 0 };
}
