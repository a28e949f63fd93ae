/// The header of a Stanford polygon file.
#ifndef RSV_PLY_HEADER_H
#define RSV_PLY_HEADER_H

#include "../core/core.h"

#define RSV_PLY_ELEMENTS 64
#define RSV_PLY_PROPERTIES 256

typedef enum rsv_ply_format { RSV_PLY_ASCII, RSV_PLY_LITTLE, RSV_PLY_BIG } rsv_ply_format;

/// The type that a number is stored as.
typedef enum rsv_ply_type {
    RSV_PLY_NONE,
    RSV_PLY_INT8,
    RSV_PLY_UINT8,
    RSV_PLY_INT16,
    RSV_PLY_UINT16,
    RSV_PLY_INT32,
    RSV_PLY_UINT32,
    RSV_PLY_FLOAT,
    RSV_PLY_DOUBLE
} rsv_ply_type;

/// What a property is used for: x, y, z, nx, ny, nz of vertices in this order, or the corners of faces.
typedef enum rsv_ply_role { RSV_PLY_UNUSED = 6, RSV_PLY_INDICES } rsv_ply_role;

typedef struct rsv_ply_property {
    rsv_ply_type type;
    rsv_ply_type count_type; ///< of a list; RSV_PLY_NONE = no list
    uint8_t role;            ///< 0 to 5, or rsv_ply_role
} rsv_ply_property;

typedef enum rsv_ply_kind {
    RSV_PLY_OTHER,
    RSV_PLY_VERTEX,
    RSV_PLY_FACE,
    RSV_PLY_STRIPS
} rsv_ply_kind;

typedef struct rsv_ply_element {
    rsv_ply_kind kind;
    uint64_t count;
    uint64_t row_bytes; ///< least that one of them takes
    uint32_t first_property, property_count;
} rsv_ply_element;

typedef struct rsv_ply_header {
    rsv_ply_format format;
    rsv_ply_element element[RSV_PLY_ELEMENTS];
    uint32_t element_count;
    rsv_ply_property property[RSV_PLY_PROPERTIES];
    uint32_t property_count;
    char unused[256]; ///< names of properties without effect, separated by commas
    size_t bytes;     ///< of the header
    size_t lines;
} rsv_ply_header;

/// Bytes of a number in a binary file.
unsigned rsv_ply_size(rsv_ply_type type);

/// RSV_OK if the header is well-formed, and the file large enough for the elements it announces.
/// @param bytes [size], a zero behind them
rsv_status rsv_ply_read_header(const char *bytes, size_t size, rsv_ply_header *header);

#endif
