/// A lightmap in its files.
#ifndef RSV_BAKE_LIGHTMAP_FILE_H
#define RSV_BAKE_LIGHTMAP_FILE_H

#include "bake_layout.h"

typedef struct rsv_lightmap_bake {
    const rsv_light_view *s;
    const rsv_bake_desc *desc;
    rsv_bake_document document;
    rsv_bake_parts parts;
    cJSON **primitive; ///< [parts.count]
    rsv_bake_layout layout;
    float scale;      ///< W/m2 of the largest code
    double saturated; ///< share of the texels that are brighter
    double largest_seam;
} rsv_lightmap_bake;

/// Writes the glTF file, with the map as a texture of 8-bit codes, and separate images in full precision.
rsv_status rsv_lightmap_bake_write(rsv_lightmap_bake *bake, const char *output);

#endif
