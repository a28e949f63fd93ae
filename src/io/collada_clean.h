/// Rewrites those parts of a COLLADA file that Assimp would ignore.
#ifndef RSV_COLLADA_CLEAN_H
#define RSV_COLLADA_CLEAN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

/// How many numbers or words stand between here and the next tag.
size_t rsv_collada_count_values(const char *text);

/// Parses the contents of a <rotate>. @param rotation out: axis, normalised (or 0), and angle as given
/// @return whether there are an axis and an angle
bool rsv_collada_rotation(const char *text, double rotation[4]);

/// Skew transforms become matrices, rotation axes get length 1, rotations about a zero axis are removed, and the counts
/// of arrays are corrected.
/// @param size out: of the text, which is to be released by free @return NULL = nothing to change, or out of memory
char *rsv_collada_clean(FILE *file, size_t *size);

#endif
