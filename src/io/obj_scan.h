/// What Wavefront files say that Assimp ignores silently, and why it refuses some of them.
#ifndef RSV_OBJ_SCAN_H
#define RSV_OBJ_SCAN_H

#include "resolvent/io.h"

#include <stdio.h>

/// Names, in one warning, the statements of an .obj or .mtl file that have no effect.
/// @param is_library .mtl
void rsv_obj_warn_of_unused(
    const rsv_context *context, const rsv_file_source *files, const char *path, bool is_library);

/// Returns the text of a file in a form that the importer understands: statements without effect, some of which it
/// would mistake for others, become comments; lines end in '\n'; there is no byte order mark. If all vertices lie far
/// from the origin, their common offset is subtracted, as importers keep single precision.
/// @param file open for reading, at its start @param size out @param origin out: the offset
/// @return malloc'ed; NULL = out of memory, or unreadable
char *rsv_obj_clean(FILE *file, bool is_library, size_t *size, double origin[3]);

/// Names of materials, each once, with a '\n' before and behind it.
typedef struct rsv_obj_names {
    char *text; ///< malloc'ed; NULL = none
    size_t size, capacity;
} rsv_obj_names;

/// Adds the names that statements give. @param text from rsv_obj_clean @param word the statement: "usemtl" or "newmtl"
void rsv_obj_note_names(const char *text, const char *word, rsv_obj_names *names);

/// Names, in one warning, the materials that are used and not defined.
void rsv_obj_warn_of_unknown(const rsv_context *context, const char *path,
    const rsv_obj_names *used, const rsv_obj_names *defined);

/// The first thing that is wrong with an .obj file, as the error message, with its line. RSV_OK if nothing is found.
rsv_status rsv_obj_explain(const rsv_file_source *files, const char *path);

#endif
