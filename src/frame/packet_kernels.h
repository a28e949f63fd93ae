/// The loops over all pixels, compiled for several instruction sets from one source (packet_kernels_body.h). They use
/// no operation whose rounding could differ between those.
#ifndef RSV_PACKET_KERNELS_H
#define RSV_PACKET_KERNELS_H

#include "../sources/sky.h"
#include "../trace/packet.h"
#include "beam.h"
#include "clearance.h"
#include "glossy_cells.h"
#include "highlights.h"
#include "history.h"
#include "light_table.h"
#include "specular_lanes.h"
#include "tone.h"

/// Pixels of a packet lie in a block of this side; its first eight lanes are the upper half.
#define RSV_BLOCK 4
/// Blocks share a tile of this side, the unit of work of a thread.
#define RSV_TILE 32

/// Packets in hand at a time: being traced, located, followed down the table and looked up.
#define RSV_STAGES 4

/// How a frame's camera rays run.
typedef struct rsv_frame_aim {
    rsv_lens lens;
    uint32_t width, height;
    float place_x, place_y; ///< of the sample within each pixel
    float scatter;     ///< how far rsv_scatter moves it at most; 0 = the same place in all pixels
    uint32_t phase[2]; ///< of that, right and down
} rsv_frame_aim;

/// Moves a sample within its stratum, in pixels nearby by different amounts: the plastic number's lattice (Roberts
/// 2018).
RSV_INLINE float rsv_scatter(
    float place, float scatter, uint32_t phase, uint32_t along, uint32_t across)
{
    return place + scatter * rsv_unit_float(phase + 0xc13fa9a9u * along + 0x91e10da5u * across);
}

/// Where the rays of a packet ended: cells of the light table, and weights of their corners.
typedef struct rsv_packet_places {
    int cell[RSV_PACKET_WIDTH];
    float b0[RSV_PACKET_WIDTH], b1[RSV_PACKET_WIDTH], b2[RSV_PACKET_WIDTH];
} __attribute__((aligned(64))) rsv_packet_places;

RSV_INLINE rsv_grid_place rsv_packet_place(const rsv_packet_places *places, uint32_t lane)
{
    return rsv_grid_place_of(
        (uint32_t)places->cell[lane], places->b0[lane], places->b1[lane], places->b2[lane]);
}

/// Prefetches the triangles that lanes hit.
RSV_INLINE void rsv_prefetch_triangles(
    const rsv_scene_view *view, const rsv_ray_packet *p, uint32_t lanes)
{
    for (; lanes; lanes &= lanes - 1) {
        uint32_t triangle = p->triangle[__builtin_ctz(lanes)];
        if (triangle != RSV_NONE) __builtin_prefetch(view->triangle[triangle]);
    }
}

/// And then for their corners.
RSV_INLINE void rsv_prefetch_corners(
    const rsv_scene_view *view, const rsv_ray_packet *p, uint32_t lanes)
{
    for (; lanes; lanes &= lanes - 1) {
        uint32_t triangle = p->triangle[__builtin_ctz(lanes)];
        for (int c = 0; c < 3 && triangle != RSV_NONE; c++) {
            __builtin_prefetch(&view->position[view->triangle[triangle][c]]);
            __builtin_prefetch(&view->normal[view->triangle[triangle][c]]);
        }
    }
}

/// Of some lanes, those at surfaces that rsv_glossy_material describes.
RSV_INLINE uint32_t rsv_glossy_lanes(
    const rsv_light_table *table, const rsv_ray_packet *p, uint32_t lanes)
{
    uint32_t glossy = 0;
    for (uint32_t left = table->glossy ? lanes : 0; left; left &= left - 1) {
        uint32_t k = (uint32_t)__builtin_ctz(left);
        bool back = rsv_packet_meets_back(p, k);
        bool is = rsv_shown_side_of(table, p->triangle[k], back)->kind == RSV_SHOWN_GLOSSY;
        glossy |= (uint32_t)is << k;
    }
    return glossy;
}

/// Data common to all glossy surfaces of a frame.
typedef struct rsv_glossy_shading {
    const rsv_scene_view *view;
    const rsv_glossy_material *materials; ///< [material_count]
    bool shows_emission;
} rsv_glossy_shading;

/// Where lanes look up one level of a texture: the texels that their places lie between.
typedef struct rsv_texel_lanes {
    int index[4][RSV_PACKET_WIDTH]; ///< of their first codes
    float weight[4][RSV_PACKET_WIDTH];
} __attribute__((aligned(64))) rsv_texel_lanes;

/// Texels of the first map of some lanes of a packet, located and prefetched before they are read.
typedef struct rsv_texels_ahead {
    rsv_texel_lanes level[2];
    uint32_t lanes; ///< all of one material, a bit each; 0 = none
    bool both;      ///< whether two levels are read
} rsv_texels_ahead;

/// A block of a tile's pixels, from `first` on.
typedef struct rsv_glossy_block {
    rsv_glossy_tile *tile;
    uint32_t first;
    const rsv_texels_ahead *ahead; ///< of its packet; NULL = nothing is
} rsv_glossy_block;

/// Sixteen cells of a tile.
typedef struct rsv_cell_row {
    uint32_t column, row; ///< of the tile's pixels in the picture
    uint32_t line;        ///< of cells in the tile
} rsv_cell_row;

/// Sixteen pixels of a tile in a row.
typedef struct rsv_highlight_row {
    uint32_t column, row; ///< of the tile's pixels in the picture
    uint32_t first;       ///< of the pixels in the tile
    bool moves;           ///< the camera
} rsv_highlight_row;

/// From a packet to its radiance in four steps. Each prefetches the data of the next one, so that other packets' steps
/// in between hide the latency.

typedef struct rsv_packet_kernels {
    /// Camera rays of the block whose upper left pixel is (column, row); lanes outside the picture are switched off.
    void (*aim)(const rsv_frame_aim *aim, uint32_t column, uint32_t row, rsv_ray_packet *packet);
    /// Finds the triangles that the rays through a part of a picture may hit. @param low, high positions in the picture
    /// of the rays at the upper left and lower right @return false: too many, or not possible with beams
    bool (*gather)(const rsv_beams *beams, const rsv_beam_lens *lens, const float low[2],
        const float high[2], rsv_beam *beam);
    /// Traces rays of a beam, as rsv_tracer_closest_packet.
    void (*meet)(const rsv_beam *beam, rsv_ray_packet *packet);
    /// Once its rays are traced.
    void (*approach)(const rsv_light_table *table, const rsv_ray_packet *packet);
    /// Finds the cells of the hits. @return lanes whose side is not RSV_SHOWN_STORED, one bit each
    uint32_t (*locate)(
        const rsv_light_table *table, const rsv_ray_packet *packet, rsv_packet_places *places);
    /// Moves on to the parts of split cells, until all are whole.
    void (*descend)(const rsv_light_table *table, rsv_packet_places *places);
    /// Their radiance, a block of a tile's pixels. @param radiance [RSV_BLOCK][RSV_TILE]
    void (*look_up)(
        const rsv_light_table *table, const rsv_packet_places *places, float (*radiance)[4]);
    /// Radiance of the sky in lanes whose rays left the scene. @param radiance as in look_up
    void (*show_sky)(
        const rsv_sky *sky, const rsv_ray_packet *packet, uint32_t lanes, float (*radiance)[4]);
    /// Finds texels that shade_glossy is going to read, of the first of the materials that lanes are at.
    void (*find_ahead)(const rsv_glossy_shading *shading, const rsv_ray_packet *packet,
        const float *width, uint32_t lanes, rsv_texels_ahead *ahead);
    /// Light of glossy surfaces, from the irradiance that was looked up: everything but the light of lobes that vary by
    /// direction, which goes to the tile of `block`. @param lanes at such surfaces @param radiance as in look_up, in
    /// and out
    /// @param width of each lane's footprint, metres
    /// @return lanes that are left out, because textures make them smooth
    uint32_t (*shade_glossy)(const rsv_glossy_shading *shading, const rsv_ray_packet *packet,
        const float *width, uint32_t lanes, float (*radiance)[4], rsv_glossy_block block);
    /// Sets cells, from those of their pixels that stand for them; their samples are none yet.
    /// @param speaker [16] pixels of the tile, out; -1 = none
    void (*fill_cells)(const rsv_glossy_tile *tile, const rsv_frame_aim *aim, rsv_cell_row row,
        const rsv_glossy_cells *cells, int *speaker);
    /// Finds shares of highlights that sixteen pixels in a row leave to cells.
    /// @return lanes with less than 1 of some light, a bit each
    uint32_t (*find_highlights)(const rsv_highlights *highlights, const rsv_glossy_tile *tile,
        const rsv_frame_aim *aim, rsv_highlight_row row, rsv_highlight_lanes *found);
    void (*pack_pixels)(const rsv_glossy_tile *tile, rsv_glossy_pixels *pixels);
    /// Combines this frame's samples around sixteen cells with those of earlier frames.
    void (*blend_cells)(const rsv_glossy_cells *cells, uint32_t column, uint32_t row);
    /// Light of sixteen cells, after all have been combined.
    void (*smooth_cells)(const rsv_glossy_cells *cells, uint32_t column, uint32_t row);
    /// Adds the light of the cells around to sixteen pixels. @param x, y of the first one in the tile
    /// @param cell index of the cell that it lies in @param radiance [RSV_TILE_PIXELS] of the tile
    void (*light_pixels)(const rsv_glossy_cells *cells, const rsv_glossy_pixels *pixels, uint32_t x,
        uint32_t y, size_t cell, float (*radiance)[4]);
    /// Adds a tile's row of samples to its sums, and shows the first `count` of them.
    /// @param sum, radiance [RSV_TILE] @param pixel [count]
    void (*display)(const rsv_frame_tone *tone, const float (*radiance)[4], float (*sum)[4],
        uint32_t count, uint8_t (*pixel)[4]);
    /// Adds a tile's row of samples to the mean of the history. @param column, row of its first pixel
    /// @param line of the tile @param radiance [RSV_TILE] out; the last channel is the number of frames
    void (*recall)(const rsv_frame_history *history, const rsv_history_window *window,
        uint32_t column, uint32_t row, uint32_t line, float (*radiance)[4]);
    /// The branches of specular paths at surfaces of one smooth material: reflected, transmitted. Results for other
    /// lanes are undefined.
    void (*leave_smooth)(const rsv_scene_view *view, const rsv_bsdf *bsdf,
        const rsv_clearances *clearances, const rsv_ray_packet *packet,
        const rsv_specular_lanes *paths, rsv_branch_lanes branch[2]);
} rsv_packet_kernels;

/// @param instructions BEST, or instructions that the CPU has; set to those in use
const rsv_packet_kernels *rsv_packet_kernels_for(rsv_instructions *instructions);

/// Whether the processor, and this build, have them.
bool rsv_has_instructions(rsv_instructions instructions);

extern const rsv_packet_kernels rsv_packet_kernels_portable, rsv_packet_kernels_avx2,
    rsv_packet_kernels_avx512;

#endif
