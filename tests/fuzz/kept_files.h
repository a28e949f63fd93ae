/// Files that a solve keeps for the next one, as somebody else may have left them.
#ifndef RSV_FUZZ_KEPT_FILES_H
#define RSV_FUZZ_KEPT_FILES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// Solves a small room after an edit, with one of the files that its past left changed to these bytes; rows also where
/// the same solve would go on. Checksums are mended first, so that what lies behind them is reached.
/// @param extension .history .scene .rows
void fuzz_kept_file(const char *extension, uint8_t *data, size_t size);

/// The same with the file as it was left, and copied to `path` before.
void fuzz_copy_kept_file(const char *extension, const char *path);

#endif
