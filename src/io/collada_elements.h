/// Which elements of a COLLADA file mean something to us.
#ifndef RSV_COLLADA_ELEMENTS_H
#define RSV_COLLADA_ELEMENTS_H

#include <stdbool.h>
#include <stddef.h>

/// Whether an element is read, is told of elsewhere (textures, animations, bones), or says nothing about how a scene looks.
bool rsv_collada_knows_element(const char *name, size_t length);

/// Whether an element is of the format and has no place here, with all that lies in it.
bool rsv_collada_passes_over(const char *name, size_t length);

#endif
