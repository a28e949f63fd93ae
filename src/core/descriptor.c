#include "descriptor.h"

#include <string.h>

/// No descriptor is larger. A larger size is uninitialised memory.
enum { MOST_BYTES = 4096 };

static size_t size_of(const void *desc)
{
    size_t size;
    memcpy(&size, desc, sizeof size);
    return size;
}

void rsv_desc_fill(void *desc, size_t size, const void *defaults)
{
    const size_t known = size_of(defaults);
    memset(desc, 0, size);
    memcpy(desc, defaults, size < known ? size : known);
    memcpy(desc, &size, sizeof size);
}

static bool is_zero(const unsigned char *bytes, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (bytes[i]) return false;
    return true;
}

rsv_status rsv_desc_read(void *settings, const void *given, const char *type)
{
    if (!given) return RSV_OK;
    const size_t known = size_of(settings), size = size_of(given);
    if (size <= sizeof size || size > MOST_BYTES)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "%s.size is %zu: start from rsv_default_%s(), or set it to sizeof(%s)", type, size,
            type + strlen("rsv_"), type);
    if (size > known && !is_zero((const unsigned char *)given + known, size - known))
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "%s sets members that version %s of the library does not have: use a later version",
            type, RSV_VERSION_STRING);
    memcpy(settings, given, size < known ? size : known);
    memcpy(settings, &known, sizeof known);
    return RSV_OK;
}
