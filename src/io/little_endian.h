/// Numbers in files, the lowest byte first.
#ifndef RSV_LITTLE_ENDIAN_H
#define RSV_LITTLE_ENDIAN_H

#include "../core/vec.h"

RSV_INLINE uint32_t rsv_read_u32(const void *bytes)
{
    const uint8_t *b = (const uint8_t *)bytes;
    return b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

RSV_INLINE uint64_t rsv_read_u64(const void *bytes)
{
    const uint8_t *b = (const uint8_t *)bytes;
    return rsv_read_u32(b) | (uint64_t)rsv_read_u32(b + 4) << 32;
}

#endif
