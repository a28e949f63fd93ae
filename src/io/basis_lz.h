/// Textures in the format ETC1S, compressed by BasisLZ (KTX File Format Specification 2.0.4, "BasisLZ Global Data" and
/// "BasisLZ/ETC1S Bitstream Specification").
#ifndef RSV_BASIS_LZ_H
#define RSV_BASIS_LZ_H

#include "../core/core.h"

/// The bytes of one level of a single picture.
typedef struct rsv_basis_lz {
    const uint8_t *global, *level; ///< global data of the file, and data of the level
    size_t global_size, level_size;
    uint32_t level_count; ///< of the file; the level is the first
    uint32_t width, height;
} rsv_basis_lz;

/// Where the second slice of a file goes, if it has one.
typedef enum rsv_basis_second { RSV_BASIS_NONE, RSV_BASIS_ALPHA, RSV_BASIS_GREEN } rsv_basis_second;

/// @param rgba out: [height * width * 4] row by row, as they lie in the file. A second slice that is not there leaves
///        alpha at 255, and green as the first slice has it.
/// @return RSV_ERROR_FORMAT for damaged data, without a message
rsv_status rsv_basis_lz_decode(
    rsv_context *context, const rsv_basis_lz *source, rsv_basis_second second, uint8_t *rgba);

#endif
