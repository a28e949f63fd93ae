/// Properties of models in FBX files that are stored in a way that Assimp ignores.
#ifndef RSV_FBX_SCAN_H
#define RSV_FBX_SCAN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

/// Gives the properties Visibility and Visibility Inheritance, in text or binary, types that Assimp reads, so that they
/// become metadata of nodes. All other bytes stay in place. @return the file, to be freed; NULL = it has no such
/// property
char *rsv_fbx_clean(FILE *file, size_t *size);

/// Whether some camera of a file has a film that is shifted. @param bytes [size], '\0' behind them
bool rsv_fbx_shifts_film(const char *bytes, size_t size);

#endif
