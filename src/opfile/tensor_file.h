/// Named arrays and notes in one file, in the safetensors layout: eight bytes with the length of the header
/// (little-endian), the header as JSON, and the arrays one after the other.
///
/// An *exchange* goes through the arrays of an object, for writing or for reading. Each array is named once, so that
/// reading matches writing. Files being read are hostile: header, sizes and checksum are checked when the file is
/// opened, the shape of each array when it is taken. The caller checks the meaning of the numbers, with the functions
/// at the end.
#ifndef RSV_TENSOR_FILE_H
#define RSV_TENSOR_FILE_H

#include "../core/core.h"

#include <cjson/cJSON.h>

typedef enum rsv_tensor_type {
    RSV_TENSOR_U8,
    RSV_TENSOR_U16,
    RSV_TENSOR_U32,
    RSV_TENSOR_U64,
    RSV_TENSOR_F32
} rsv_tensor_type;

#define RSV_TENSOR_RANK 3

typedef struct rsv_tensor {
    char *name;
    rsv_tensor_type type;
    uint32_t rank;
    size_t shape[RSV_TENSOR_RANK];
    const void *data; ///< borrowed, or of the mapped file
    void *owned;      ///< the same, freed with the file; NULL = borrowed
    /// In a team, for rows of which `data` has only this process's part: where they begin there and in the whole,
    /// [row_count + 1]; the process that has a row writes it. NULL = all processes have all rows
    const size_t *own_begin, *whole_begin;
    size_t row_count;
} rsv_tensor;

typedef struct rsv_tensor_file {
    rsv_context *context;
    const char *path; ///< borrowed
    bool reading;
    char prefix[64]; ///< put before the names of the arrays exchanged next
    cJSON *notes;    ///< "__metadata__": texts by name
    rsv_tensor *tensor;
    size_t count, capacity;
    uint8_t *map; ///< of a file being read
    size_t map_bytes;
} rsv_tensor_file;

size_t rsv_tensor_type_bytes(rsv_tensor_type type);
const char *rsv_tensor_type_name(rsv_tensor_type type); ///< "F32", ...
/// Numbers in a tensor.
size_t rsv_tensor_length(const rsv_tensor *tensor);

// ---- files ----------------------------------------------------------------------------------------

rsv_status rsv_tensor_file_begin(
    rsv_context *context, const char *path, rsv_tensor_file *file); ///< for writing
/// Writes everything that was exchanged. The file appears complete or not at all. The processes of a team write one
/// file together, which is the same as that of one process.
rsv_status rsv_tensor_file_write(rsv_tensor_file *file);

/// Maps a file and checks its header; nothing else of it is read.
rsv_status rsv_tensor_file_open(rsv_context *context, const char *path, rsv_tensor_file *file);
/// Compares the checksum with the file's content.
rsv_status rsv_tensor_file_verify(const rsv_tensor_file *file);

/// SHA-256 of everything exchanged for writing: arrays with their names, and notes.
/// @param digits [RSV_SHA256_DIGITS + 1]
void rsv_tensor_file_digest(const rsv_tensor_file *file, char *digits);

void rsv_tensor_file_end(rsv_tensor_file *file);

/// The note under which the checksum is kept: SHA-256 of the whole file with the checksum's own digits read as '0'.
#define RSV_CHECKSUM_NOTE "sha256"

// ---- exchange -------------------------------------------------------------------------------------

/// Sets a prefix for the following names. NULL = none.
void rsv_tensor_prefix(rsv_tensor_file *file, const char *prefix);

#define RSV_ANY_COUNT SIZE_MAX

/// An array of `*count` rows of `width` numbers each (1: shape [count], otherwise [count, width]).
/// @param array address of the pointer. Writing: borrowed until the end of the file. Reading: allocated
/// @param count reading: the required count, or RSV_ANY_COUNT, which is replaced by the count found
rsv_status rsv_tensor_exchange(rsv_tensor_file *file, const char *name, rsv_tensor_type type,
    size_t width, void *array, size_t *count);
/// The same for one that may be missing: NULL.
rsv_status rsv_tensor_exchange_optional(rsv_tensor_file *file, const char *name,
    rsv_tensor_type type, size_t width, void *array, size_t *count);

/// Writes an array that is only for other readers, or does not exist in memory. `data` is owned by the file, even on
/// failure.
rsv_status rsv_tensor_give(rsv_tensor_file *file, const char *name, rsv_tensor_type type,
    size_t width, size_t count, void *data);
/// Adds an array of any shape. @param data borrowed
rsv_status rsv_tensor_add(rsv_tensor_file *file, const char *name, rsv_tensor_type type,
    uint32_t rank, const size_t *shape, const void *data);
/// Declares that the last exchanged array has only the rows of this process. @param own, whole borrowed
void rsv_tensor_divide(
    rsv_tensor_file *file, size_t row_count, const size_t *own, const size_t *whole);
/// NULL if there is none of that name (the prefix is put before it).
const rsv_tensor *rsv_tensor_find(const rsv_tensor_file *file, const char *name);

rsv_status rsv_note_set(rsv_tensor_file *file, const char *name, const char *text);
/// NULL if there is no such note.
const char *rsv_note_get(const rsv_tensor_file *file, const char *name);

// ---- checks of data that was read ----------------------------------------------------------------

/// Whether all indices are below a bound.
rsv_status rsv_check_indices(const rsv_tensor_file *file, const char *name, const uint32_t *index,
    size_t count, size_t bound);
/// Whether rows begin at 0, never step back, and end at `entries`. @param begin [rows + 1]
rsv_status rsv_check_rows(const rsv_tensor_file *file, const char *name, const size_t *begin,
    size_t rows, size_t entries);
/// Whether all numbers are finite, so small that products of a few stay so, and not below `least`.
rsv_status rsv_check_numbers(
    const rsv_tensor_file *file, const char *name, const float *number, size_t count, float least);

/// Fails with "PATH: tensor 'PREFIX NAME' ...".
rsv_status rsv_tensor_fail(const rsv_tensor_file *file, const char *name, const char *format, ...)
    RSV_PRINTF(3, 4);

#endif
