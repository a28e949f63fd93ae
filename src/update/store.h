/// Storage for results that the next solve can reuse: blobs of bytes by name, in a folder or in memory. Users do not
/// know which.
#ifndef RSV_STORE_H
#define RSV_STORE_H

#include "../core/core.h"

#define RSV_STORE_NAME_BYTES 64 ///< of a blob, with the 0 at its end

typedef struct rsv_store rsv_store;

/// Bytes where they lie, at a multiple of 8; they stay there until they are released. Other processes may write over
/// those of a file meanwhile.
typedef struct rsv_blob {
    const uint8_t *byte;
    size_t count; ///< 0 = there are none
} rsv_blob;

/// Functions of a kind of store. Those that return an int return 0 or an errno.
typedef struct rsv_store_table {
    /// Names of all blobs, in ascending order, until `visit` fails.
    rsv_status (*list)(
        rsv_store *store, rsv_status (*visit)(void *user, const char *name), void *user);
    /// A blob that grew may lie in several parts, each of them bytes that were appended at once. @param part from 0 on
    rsv_status (*read)(rsv_store *store, const char *name, size_t part, rsv_blob *blob);
    void (*release)(rsv_store *store, rsv_blob *blob);
    /// Writes a blob atomically: readers get the old or the new contents.
    int (*write)(rsv_store *store, const char *name, const void *byte, size_t count);
    /// Begins to append to a blob, after its first `keep` bytes. @param end out: for append and close
    int (*open)(rsv_store *store, const char *name, size_t keep, int *end);
    /// Appended data survives the end of the process if the store does.
    int (*append)(rsv_store *store, int end, const void *byte, size_t count);
    void (*close)(rsv_store *store, int end);
    size_t (*bytes)(const rsv_store *store); ///< of memory that all blobs take
    void (*destroy)(rsv_store *store);
} rsv_store_table;

/// The beginning of each kind of store.
struct rsv_store {
    const rsv_store_table *table;
    rsv_context *context;
    const char *kind;  ///< for messages, at their beginning: "checkpoint", "update"
    const char *place; ///< for messages: the folder
    bool shared;       ///< all processes of a team have the same one
};

/// A folder of files, which must exist. @param path copied
rsv_status rsv_store_folder(rsv_context *context, const char *path, rsv_store **store);

/// Memory of the context.
rsv_status rsv_store_memory(rsv_context *context, rsv_store **store);

/// @param store NULL is allowed
static inline void rsv_store_destroy(rsv_store *store)
{
    if (store) store->table->destroy(store);
}

#endif
