/// @file opfile.h
/// Solved operators as files: written once, then rendered, probed, certified and relit without tracing the operator's rays again.
///
/// A file is self-contained: it holds the scene, the elements, G, K, the sources and the solution, in the safetensors format
/// (a JSON header and flat arrays), which any language can read in a few lines. docs/operator-files.md lists every
/// array; samples/python/solve_operator.py reads a file and solves it again.
#ifndef RESOLVENT_OPFILE_H
#define RESOLVENT_OPFILE_H

#include "resolvent/solve.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Writes a solution with its scene, and the glTF file that this came from, where it keeps one (rsv_load_desc.keep_document):
/// what was read can be baked into that file. The same solution gives the same bytes, up to the times in its report, which are left
/// out. The file appears complete or not at all.
/// @param scene_name what the scene is called, for `info` and messages; NULL = "unnamed"
RSV_API rsv_status rsv_light_save(const rsv_light *light, const char *scene_name, const char *path);

/// Reads what rsv_light_save wrote: pictures and probes of it are the same bytes as of the solution that was saved. The
/// file is mapped and may be gone afterwards. It is treated as hostile: RSV_ERROR_IO if it cannot be read,
/// RSV_ERROR_FORMAT if it is cut off, foreign, changed (SHA-256) or inconsistent, RSV_ERROR_UNSUPPORTED if its
/// format is of another version.
/// @param scene out; owned by the caller
/// @param light out: the solution; destroy it before the scene
RSV_API rsv_status rsv_light_load(
    rsv_context *context, const char *path, rsv_scene **scene, rsv_light **light);

/// In a team, fails unless all processes run the same code and name the same operator file, by the checksum that it says it
/// has: for those who will read it each for themselves.
RSV_API rsv_status rsv_operator_compare(rsv_context *context, const char *path);

/// What the scene of an operator file is called: `scene_name` of rsv_light_save, cut to size.
/// @param name out [bytes]
RSV_API rsv_status rsv_operator_scene_name(
    rsv_context *context, const char *path, char *name, size_t bytes);

/// Whether a file looks like an operator file rather than a scene, by its first bytes. It may still be damaged.
RSV_API bool rsv_is_operator_file(const char *path);

#define RSV_FINGERPRINT_DIGITS 64

/// SHA-256 of all that a scene holds. @param digits out, in hexadecimal
RSV_API rsv_status rsv_scene_fingerprint(
    const rsv_scene *scene, char digits[RSV_FINGERPRINT_DIGITS + 1]);

/// In a team, fails unless all processes run the same code and hold the same scene, by SHA-256.
RSV_API rsv_status rsv_scene_compare(const rsv_scene *scene);

#ifdef __cplusplus
}
#endif

#endif
