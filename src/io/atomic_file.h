/// Files that appear complete or not at all: written under a temporary name in the same folder,
/// then renamed over the target.
#ifndef RSV_ATOMIC_FILE_H
#define RSV_ATOMIC_FILE_H

#include "../core/core.h"

#ifdef __cplusplus
extern "C" {
#endif

#define RSV_PATH_BYTES 4096

/// One file being written by one thread. Writes remember their first failure, so that callers check
/// once, at the commit.
typedef struct rsv_atomic_file {
    int descriptor; ///< -1 = closed
    int error;      ///< errno of the first failed write, 0 = none
    uint64_t end;   ///< where the next append goes
    char target[RSV_PATH_BYTES];
    char temporary[RSV_PATH_BYTES];
} rsv_atomic_file;

/// Checks that `path` can become a regular file and opens a temporary one beside it, under a name
/// no other writer has. A symbolic link is followed; a replaced file's permissions are kept. After
/// a failure nothing is left behind and rsv_atomic_file_discard does nothing.
rsv_status rsv_atomic_file_open(rsv_atomic_file *file, const char *path);

/// Opens the temporary file of another process, to write into it; ends with rsv_atomic_file_close.
rsv_status rsv_atomic_file_join(rsv_atomic_file *file, const char *temporary);
/// Flushes to the disk and closes, and leaves the commit to the process that opened the file.
rsv_status rsv_atomic_file_close(rsv_atomic_file *file);

void rsv_atomic_file_append(rsv_atomic_file *file, const void *data, size_t bytes);
void rsv_atomic_file_write_at(
    rsv_atomic_file *file, uint64_t offset, const void *data, size_t bytes);

/// Reads back data that was written before.
void rsv_atomic_file_read_at(rsv_atomic_file *file, uint64_t offset, void *data, size_t bytes);

/// Flushes to the disk and renames. On failure of this or any earlier write the temporary is
/// removed and the target is as it was.
rsv_status rsv_atomic_file_commit(rsv_atomic_file *file);

/// Removes the temporary of a file not committed; nothing to do after a commit.
void rsv_atomic_file_discard(rsv_atomic_file *file);

#ifdef __cplusplus
}
#endif

#endif
