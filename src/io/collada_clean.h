/// Writes what Assimp passes over in a COLLADA file in another way.
#ifndef RSV_COLLADA_CLEAN_H
#define RSV_COLLADA_CLEAN_H

#include <stddef.h>
#include <stdio.h>

/// Skew transforms become matrices.
/// @param size out: of the text, which is to be released by free @return NULL = it can stay as it is, or there is no memory
char *rsv_collada_clean(FILE *file, size_t *size);

#endif
