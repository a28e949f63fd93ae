/// A folder for files that are of no use later.
#ifndef CLI_SCRATCH_FOLDER_H
#define CLI_SCRATCH_FOLDER_H

#include <limits.h>
#include <stdbool.h>

/// Makes one below TMPDIR. @param benchmark for its name @param path [PATH_MAX], out: "" = none was made
bool cli_make_scratch_folder(const char *benchmark, char *path);

/// Removes it with the files in it. @param path "" = nothing
void cli_remove_scratch_folder(const char *path);

/// Bytes of all files in it.
double cli_scratch_folder_bytes(const char *path);

#endif
