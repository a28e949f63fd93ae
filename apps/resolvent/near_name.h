/// Suggests a name for a mistyped one.
#ifndef CLI_NEAR_NAME_H
#define CLI_NEAR_NAME_H

#include <stddef.h>

/// The most characters of a name that are compared.
#define CLI_NAME_LENGTH 32

/// The candidate that takes the fewest changes to reach from `name`: characters added, left out, replaced or swapped
/// with their neighbour (Damerau 1964). The first of those as near.
/// @param candidates [count] @return NULL = none is near: a third of the name is changed, or more
const char *cli_near_name(const char *name, const char *const *candidates, size_t count);

#endif
