/// Descriptors of other versions of the library: each begins with its size.
#ifndef RSV_DESCRIPTOR_H
#define RSV_DESCRIPTOR_H

#include "core.h"

/// Writes defaults into a descriptor of `size` bytes, which may be one of another version: 0 stands beyond those known
/// here.
/// @param defaults begins with its own size
void rsv_desc_fill(void *desc, size_t size, const void *defaults);

/// Reads a caller's descriptor, possibly of another version. An earlier version is shorter, and `settings` keeps the
/// rest. RSV_ERROR_ARGUMENT if a later version sets fields that are unknown here, and for invalid sizes.
/// @param settings in: defaults, with the size of this version; out: the settings
/// @param given NULL = defaults
/// @param type name of the descriptor, for messages
rsv_status rsv_desc_read(void *settings, const void *given, const char *type);

/// The same; compilers see whether both are of that type.
#define RSV_READ_DESC(type, settings, given)                                                       \
    rsv_desc_read((type *){ settings }, (const type *){ given }, #type)

#endif
