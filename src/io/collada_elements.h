/// Which elements of a COLLADA file mean something to us.
#ifndef RSV_COLLADA_ELEMENTS_H
#define RSV_COLLADA_ELEMENTS_H

#include <stdbool.h>
#include <stddef.h>

/// Whether an element is read, is reported elsewhere (textures, animations, bones), or does not affect how a scene
/// looks.
bool rsv_collada_knows_element(const char *name, size_t length);

/// Whether an element belongs to the format but is not used here, along with everything inside it.
bool rsv_collada_passes_over(const char *name, size_t length);

#endif
