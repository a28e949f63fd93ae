/// Writes what Assimp passes over in a COLLADA file in another way.
#ifndef RSV_COLLADA_CLEAN_H
#define RSV_COLLADA_CLEAN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

/// How many numbers or words stand between here and the next tag.
size_t rsv_collada_count_values(const char *text);

/// Reads what stands in a <rotate>. @param rotation out: axis, of length 1 or 0; its length as it is given
/// @return whether there are an axis and an angle
bool rsv_collada_rotation(const char *text, double rotation[4]);

/// Skew transforms become matrices, axes of rotations get length 1, rotations about nothing are left out, and arrays say
/// as many numbers as they hold.
/// @param size out: of the text, which is to be released by free @return NULL = it can stay as it is, or there is no memory
char *rsv_collada_clean(FILE *file, size_t *size);

#endif
