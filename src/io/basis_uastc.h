/// Blocks of 4 x 4 texels in the format UASTC (Khronos Data Format Specification 1.4, "Universal ASTC Compressed
/// Texture Images").
#ifndef RSV_BASIS_UASTC_H
#define RSV_BASIS_UASTC_H

#include <stdbool.h>
#include <stdint.h>

#define RSV_UASTC_BLOCK_BYTES 16

/// Invalid blocks become magenta, as the specification says.
/// @param srgb whether colours are encoded by sRGB, which changes how they are rounded
/// @param texel out: 16 colours, row by row: red, green, blue, alpha
void rsv_uastc_decode(const uint8_t block[RSV_UASTC_BLOCK_BYTES], bool srgb, uint8_t texel[16][4]);

#endif
