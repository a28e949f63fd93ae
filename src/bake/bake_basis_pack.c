#include "bake_basis_pack.h"

#include "../core/vec.h"

#include <math.h>
#include <string.h>
#include <zlib.h>

/// Halves of no more than this have room for rounding below the largest.
#define LARGEST 32768.0f

/// The half nearest to a number of at most LARGEST; of two, the even one.
static uint16_t half_of(float value)
{
    float size = fabsf(value);
    uint16_t sign = value < 0 ? 0x8000 : 0;
    int exponent;
    frexpf(size, &exponent);                         // size = [0.5, 1) times 2^exponent
    if (exponent < -13 || size == 0) exponent = -13; // denormal; frexpf has 0 for 0
    float step = ldexpf(1, exponent - 11);
    uint32_t count = (uint32_t)lrintf(size / step);
    return (uint16_t)(sign + ((uint32_t)(exponent + 13) << 10) + count);
}

/// Small differences of either sign as small numbers.
static uint16_t zigzag(uint16_t difference)
{
    return (uint16_t)(difference << 1 ^ (difference & 0x8000 ? 0xffff : 0));
}

/// A number of a receiver as a half; green and blue relative to the previous channel, which edges of shadows do not
/// change.
static uint16_t code_of(const float *value, size_t channel, float scale)
{
    uint16_t half = half_of(value[channel] / scale);
    return channel % 3 ? (uint16_t)(half - half_of(value[channel - 1] / scale)) : half;
}

/// Of each channel the low bytes of all receivers, then the high ones.
static void spread(const float *value, size_t receivers, size_t width, float scale, uint8_t *plane)
{
    for (size_t c = 0; c < width; c++) {
        uint8_t *low = plane + 2 * c * receivers, *high = low + receivers;
        uint16_t last = 0;
        for (size_t n = 0; n < receivers; n++) {
            uint16_t code = code_of(value + n * width, c, scale);
            uint16_t difference = zigzag((uint16_t)(code - last));
            low[n] = (uint8_t)difference;
            high[n] = (uint8_t)(difference >> 8);
            last = code;
        }
    }
}

rsv_status rsv_bake_pack_light(rsv_context *context, const float *value, size_t receivers,
    size_t width, rsv_packed_light *packed)
{
    rsv_status status;
    size_t bytes = 2 * receivers * width;
    float largest = 0;
    int exponent = 0;
    for (size_t k = 0; k < receivers * width; k++)
        largest = f_max(largest, fabsf(value[k]));
    frexpf(largest, &exponent);
    *packed = (rsv_packed_light){ .scale = largest > 0 ? ldexpf(1 / LARGEST, exponent) : 1 };
    uLongf room = compressBound(bytes);
    uint8_t *plane = rsv_alloc(context, bytes, 1);
    packed->bytes = rsv_alloc(context, room, 1);
    RSV_TRY(plane && packed->bytes ? RSV_OK : RSV_ERROR_MEMORY);
    spread(value, receivers, width, packed->scale, plane);
    RSV_TRY(compress2(packed->bytes, &room, plane, bytes, Z_BEST_COMPRESSION) == Z_OK
                ? RSV_OK
                : RSV_ERROR_MEMORY);
    packed->count = room;
cleanup:
    rsv_free(context, plane);
    return status;
}
