/// Files of a scene: from the file system, or from callbacks of the caller (rsv_file_source; NULL = the file system).
#ifndef RSV_FILE_SOURCE_H
#define RSV_FILE_SOURCE_H

#include "../core/core.h"
#include "resolvent/io.h"

#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Bytes of a file; -1, and errno, if there is none. Folders, pipes and devices are no files.
int64_t rsv_file_size(const rsv_file_source *source, const char *path);

/// Opens a file for reading; close it with fclose. NULL, and errno, on failure.
FILE *rsv_file_open(const rsv_file_source *source, const char *path);

/// Reads a whole file of at most 4 GiB and puts a zero byte after it. Messages do not name the file.
/// @param bytes out: to be released by rsv_free, also after a failure
rsv_status rsv_file_read(rsv_context *context, const rsv_file_source *source, const char *path,
    char **bytes, size_t *size);

/// Reads the rest of a stream and puts a zero byte after it. @return to be freed by free; NULL = nothing left, or out
/// of memory
char *rsv_stream_read(FILE *file, size_t *size);

#define RSV_KNOWN_FILES 16

/// Files that are in memory.
typedef struct rsv_known_files {
    struct {
        const char *name, *bytes;
        size_t size;
    } file[RSV_KNOWN_FILES];
    size_t count;
} rsv_known_files;

/// Keeps a file, if there is one of that name.
rsv_status rsv_know_file(
    rsv_context *context, const rsv_file_source *source, const char *name, rsv_known_files *known);
void rsv_forget_files(rsv_context *context, rsv_known_files *known);

/// A file source that serves the files in `known`.
rsv_file_source rsv_known_source(rsv_known_files *known);

#ifdef __cplusplus
}
#endif

#endif
