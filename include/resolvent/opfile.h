/// @file opfile.h
/// Operator files. A solved operator is saved once, and then rendered, probed, certified and relit without tracing its
/// rays again.
///
/// A file contains the scene, the elements, G, K, the sources and the solution. Its format is safetensors (a JSON
/// header and flat arrays), which any language can read in a few lines. docs/operator-files.md lists all arrays.
/// samples/python/solve_operator.py reads a file and solves it again.
#ifndef RESOLVENT_OPFILE_H
#define RESOLVENT_OPFILE_H

#include "resolvent/solve.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Writes a solution with its scene. If the scene keeps its glTF file (rsv_load_desc.keep_document), the file contains
/// that too, so that light can be baked into it. The same solution gives the same bytes; times are left out. The file
/// appears complete or not at all.
/// @param scene_name name of the scene, for `info` and messages; NULL = "unnamed"
RSV_API rsv_status rsv_light_save(const rsv_light *light, const char *scene_name, const char *path);

/// Reads a file from rsv_light_save. Pictures and probes give the same bytes as the saved solution. The file is mapped
/// into memory, and may be deleted after this call. It is treated as hostile: RSV_ERROR_IO if it cannot be read,
/// RSV_ERROR_FORMAT if it is truncated, altered (SHA-256), inconsistent or not an operator file, RSV_ERROR_UNSUPPORTED
/// for other versions of the format.
/// @param scene out; owned by the caller
/// @param light out; destroy it before the scene
RSV_API rsv_status rsv_light_load(
    rsv_context *context, const char *path, rsv_scene **scene, rsv_light **light);

/// In a team: fails unless all processes run the same code and name the same operator file, judged by the checksum that
/// the file states. For processes that each read the file themselves.
RSV_API rsv_status rsv_operator_compare(rsv_context *context, const char *path);

/// Name of the scene of an operator file (`scene_name` of rsv_light_save), truncated if necessary.
/// @param name out, [bytes]
RSV_API rsv_status rsv_operator_scene_name(
    rsv_context *context, const char *path, char *name, size_t bytes);

/// Whether a file looks like an operator file rather than a scene, by its first bytes. It may still be damaged.
RSV_API bool rsv_is_operator_file(const char *path);

#define RSV_FINGERPRINT_DIGITS 64

/// SHA-256 of everything in a scene. @param digits out, hexadecimal
RSV_API rsv_status rsv_scene_fingerprint(
    const rsv_scene *scene, char digits[RSV_FINGERPRINT_DIGITS + 1]);

/// In a team: fails unless all processes run the same code and have the same scene, judged by SHA-256.
RSV_API rsv_status rsv_scene_compare(const rsv_scene *scene);

#ifdef __cplusplus
}
#endif

#endif
