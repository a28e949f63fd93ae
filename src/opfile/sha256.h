/// SHA-256 (FIPS 180-4), for checksums that anybody can recompute.
#ifndef RSV_SHA256_H
#define RSV_SHA256_H

#include <stddef.h>
#include <stdint.h>

#define RSV_SHA256_BYTES 32
#define RSV_SHA256_DIGITS (2 * RSV_SHA256_BYTES) ///< in hexadecimal, without a terminator

typedef struct rsv_sha256 {
    uint32_t state[8];
    uint64_t byte_count;
    uint8_t block[64];
    void (*compress)(uint32_t *state, const uint8_t *block);
} rsv_sha256;

/// With the processor's own instructions, where it has them.
rsv_sha256 rsv_sha256_begin(void);
/// Without. The digits are the same.
rsv_sha256 rsv_sha256_begin_portable(void);
void rsv_sha256_add(rsv_sha256 *hash, const void *data, size_t bytes);
/// @param digits [RSV_SHA256_DIGITS + 1], lower-case hexadecimal
void rsv_sha256_end(rsv_sha256 *hash, char *digits);

#endif
