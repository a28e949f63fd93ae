/// Packs a glTF file, its buffers and its pictures into one piece of memory: binary glTF. The JSON and the binary chunk
/// are those of the file. Every other file that the JSON names by URI follows as a chunk of type "FILE", which readers
/// of glTF skip: the sizes of its name (with a final zero) and of its data as two numbers, the name as in the URI, and
/// the data.
#ifndef RSV_GLTF_ARCHIVE_H
#define RSV_GLTF_ARCHIVE_H

#include "gltf_document.h"

#ifdef __cplusplus
extern "C" {
#endif

#define RSV_GLB_MAGIC 0x46546c67u
#define RSV_GLB_JSON 0x4e4f534au
#define RSV_GLB_BINARY 0x004e4942u
#define RSV_GLB_FILE 0x454c4946u

/// Packs the files that a document was read from. RSV_ERROR_UNSUPPORTED beyond 4 GiB, the limit of binary glTF.
/// @param bytes out: [count], to be freed with rsv_free
rsv_status rsv_gltf_archive_pack(
    rsv_context *context, const rsv_gltf_document *document, uint8_t **bytes, size_t *count);

/// A part of an archive. Nothing of it is copied.
typedef struct rsv_gltf_chunk {
    uint32_t type;
    const uint8_t *data;
    size_t size;
    const char *uri; ///< of files; else NULL
} rsv_gltf_chunk;

/// The chunk at *at, which moves on to the next. False at the end and where the archive is damaged; *at is `count` only
/// at the end.
/// @param at begins at 0
bool rsv_gltf_archive_next(const uint8_t *archive, size_t count, size_t *at, rsv_gltf_chunk *chunk);

#ifdef __cplusplus
}
#endif

#endif
