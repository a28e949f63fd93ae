/// What FBX files say of models in a way that Assimp passes over.
#ifndef RSV_FBX_SCAN_H
#define RSV_FBX_SCAN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

/// Makes the properties Visibility and Visibility Inheritance of a file, text or binary, of types that Assimp reads: they
/// become metadata of nodes. All else stays where it is. @return the file, to be freed; NULL = it has none of them
char *rsv_fbx_clean(FILE *file, size_t *size);

/// Whether some camera of a file has a film that is shifted. @param bytes [size], '\0' behind them
bool rsv_fbx_shifts_film(const char *bytes, size_t size);

#endif
