/// Files that a solve keeps for the next one, damaged or forged.
#ifndef RSV_FUZZ_KEPT_FILES_H
#define RSV_FUZZ_KEPT_FILES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// Solves a small room after an edit, with one of its kept files replaced by these bytes; with rows, the same solve is
/// resumed, too. Checksums are corrected first, so that the code behind them is reached.
/// @param extension .history .scene .rows
void fuzz_kept_file(const char *extension, uint8_t *data, size_t size);

/// The same with the file as it was left, and copied to `path` before.
void fuzz_copy_kept_file(const char *extension, const char *path);

#endif
