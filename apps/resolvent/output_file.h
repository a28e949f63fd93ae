/// Text files that appear complete or not at all.
#ifndef CLI_OUTPUT_FILE_H
#define CLI_OUTPUT_FILE_H

#include "resolvent/core.h"

/// Whether the file's name has the extension `end` (".glb"), in letters large or small.
bool cli_ends_in(const char *path, const char *end);

/// Whether `path` can be written, to be checked before long work; prints an error if not.
bool cli_check_output(const char *path);

/// The folder `path`, made if it is not there; prints an error that names the option if it cannot be.
/// @param made out: whether it was not there; may be NULL
bool cli_make_folder(const char *option, const char *path, bool *made);

/// Whether writing `path` leaves the file `other` intact (either may be NULL: no file). Prints an error if they are the
/// same file.
bool cli_check_apart(const char *path, const char *other);

/// Writes a temporary file beside `path`, then renames it; a device or pipe is written in place. Prints errors on
/// standard error.
bool cli_write_file(const char *path, const char *text, size_t length);

struct cJSON;
/// The same for a JSON tree; `path` NULL prints it on standard output.
bool cli_write_json(const char *path, const struct cJSON *root);

#endif
