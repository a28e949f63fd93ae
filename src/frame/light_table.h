/// Light of plain surfaces, for lookups by (triangle, u, v).
///
/// One table has the sum of all fields of a solution on their common refinement (light_refinement.h), times albedo / pi
/// and with the emission added: radiance at the three corners of each cell. Cells of surfaces with varying albedo, or
/// that are not only diffuse, have the irradiance instead; those of translucent surfaces the diffused one.
#ifndef RSV_LIGHT_TABLE_H
#define RSV_LIGHT_TABLE_H

#include "../solve/light.h"
#include "glossy_material.h"
#include "light_cells.h"
#include "resolvent/frame.h"

typedef struct rsv_light_table {
    rsv_context *context;
    const rsv_light_view *solution;
    const rsv_glossy_materials *glossy; ///< materials whose sides are marked; NULL = none
    uint32_t layer;                     ///< on show, RSV_NONE = all
    rsv_shown_side (*side)[2]; ///< [triangle_count + 1] front and back; the last: no triangle
    uint32_t triangle_count;
    uint32_t *face_cell; ///< [face_count + 1] first cell of each face
    uint8_t *face_level; ///< [face_count] of its grid
    rsv_light_cell *cell;
    uint32_t
        *child; ///< [cell_count] rsv_light_cell_child of each, close together for descents
    size_t cell_count;
    uint32_t source_state; ///< see rsv_source_state
} rsv_light_table;

/// @param glossy borrowed; NULL = all but plain diffuse surfaces are RSV_SHOWN_CHAIN
rsv_status rsv_light_table_create(
    const rsv_light_view *solution, const rsv_glossy_materials *glossy, rsv_light_table *table);
void rsv_light_table_destroy(rsv_light_table *table);

/// Fills the cells from the solution's fields. @param layer as for rsv_frame_renderer_show
/// @return by how much a cell or an emission has changed at most, 0..1, relative to its larger value, or where that is
/// less to a hundredth of the mean; 1 if sources that no surface shows have changed
float rsv_light_table_bake(rsv_light_table *table, uint32_t layer);

/// Whether cells of the face have the irradiance instead of the displayed radiance.
bool rsv_holds_irradiance(const rsv_light_table *table, uint32_t face);

/// The cells of a face.
RSV_INLINE rsv_shown_side rsv_face_grid(const rsv_light_table *table, uint32_t face)
{
    return (rsv_shown_side){ table->face_cell[face], table->face_level[face], RSV_SHOWN_STORED };
}

/// Radiance that a surface of any kind reflects diffusely in the layer on show. @param albedo of its exitance there
rsv_rgb rsv_shown_reflected(
    const rsv_light_table *table, uint32_t face, rsv_rgb albedo, float u, float v);

RSV_INLINE bool rsv_shows_emission(const rsv_light_table *table)
{
    return table->layer == RSV_NONE || table->layer == 0;
}

RSV_INLINE const rsv_shown_side *rsv_shown_side_of(
    const rsv_light_table *table, uint32_t triangle, bool back)
{
    return &table->side[triangle < table->triangle_count ? triangle : table->triangle_count][back];
}

typedef float rsv_float4 __attribute__((vector_size(16), aligned(16)));

/// Radiance in a whole cell; its fourth component means nothing.
RSV_INLINE rsv_float4 rsv_light_in_cell(const rsv_light_cell *cells, rsv_grid_place at)
{
    const rsv_float4 *corner = (const rsv_float4 *)cells[at.cell].corner;
    return corner[0] * at.b0 + corner[1] * at.b1 + corner[2] * at.b2;
}

#endif
