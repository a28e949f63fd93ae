/// Where in a lightmap each surface lies: charts made or kept, packed, and drawn.
#ifndef RSV_BAKE_LAYOUT_H
#define RSV_BAKE_LAYOUT_H

#include "bake_texels.h"
#include "resolvent/bake.h"

typedef struct rsv_bake_layout {
    const rsv_light_view *s;
    const rsv_bake_desc *desc;
    const rsv_bake_document *document;
    const rsv_bake_parts *parts;
    float **uv;      ///< [parts] second texture coordinates of the file; NULL = make new ones
    uint8_t **layer; ///< [parts] triangles that were set apart, by round; NULL = none
    rsv_bake_charts charts;
    rsv_bake_map map; ///< without light
    float density;    ///< texels per metre
    uint32_t side;    ///< texels that the map may have along a side
} rsv_bake_layout;

/// Borrows all its input. Destroy it even after an error.
rsv_status rsv_bake_layout_create(const rsv_light_view *solution, const rsv_bake_desc *desc,
    const rsv_bake_document *document, const rsv_bake_parts *parts, rsv_bake_layout *layout);

/// Gives selected charts, except large ones, twice as many texels along their sides, and creates the layout again.
/// @param chosen [charts.count] @param any out: whether there were any
rsv_status rsv_bake_layout_refine(rsv_bake_layout *layout, const uint8_t *chosen, bool *any);
void rsv_bake_layout_destroy(rsv_bake_layout *layout);

#endif
