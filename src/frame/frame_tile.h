/// Tiles of a picture: the units of work of threads.
#ifndef RSV_FRAME_TILE_H
#define RSV_FRAME_TILE_H

#include "fog_front.h"
#include "glossy_rays.h"
#include "history.h"
#include "resting.h"
#include "specular_queue.h"

#define RSV_TILE_PIXELS (RSV_TILE * RSV_TILE)

/// Data of one thread.
typedef struct rsv_tile_worker {
    _Alignas(64) float radiance[RSV_TILE_PIXELS][4];
    rsv_ray_packet packet[RSV_STAGES]; ///< of the last blocks
    rsv_packet_places places[RSV_STAGES];
    rsv_beam beam;               ///< of the tile
    uint32_t left[RSV_STAGES];   ///< lanes of theirs that are not in the table
    uint32_t begins[RSV_STAGES]; ///< lanes that specular paths begin at
    uint32_t glossy[RSV_STAGES]; ///< lanes that are shaded by rsv_glossy_material
    uint32_t sky[RSV_STAGES];    ///< lanes that see the sky directly
    rsv_texels_ahead ahead[RSV_STAGES];
    rsv_glossy_tile gloss;
    rsv_specular_lanes paths; ///< of a block
    rsv_ray_packet body;      ///< camera rays as a mover meets them
    rsv_specular_queue queue;
    rsv_glossy_rays rays;
    rsv_resting_paths *whole; ///< of the tile in hand; NULL = none
    rsv_resting_tile *resting;
    float depth
        [RSV_TILE_PIXELS]; ///< metres to the hits of camera rays, if fog or the history needs them
    float carried[RSV_TILE_PIXELS]; ///< see rsv_specular_light
    rsv_history_window window;
    double camera_seconds, path_seconds, gloss_seconds, display_seconds; ///< of the frame
} rsv_tile_worker;

/// One eye's picture.
typedef struct rsv_eye_picture {
    float (*base)
        [4]; ///< [tiles][RSV_TILE_PIXELS] radiance of glossy tiles without their lobes; may be NULL
    float (*sum)[4];           ///< [tiles][RSV_TILE_PIXELS] radiance of all samples
    uint8_t (*pixel)[4];       ///< [height * width]
    uint32_t samples;          ///< frames that the camera has rested for
    uint32_t dropped;          ///< of these, the first one if it is not in the sums
    rsv_frame_history history; ///< where lobes are shared, or else empty
    rsv_glossy_cells cells;
    rsv_glossy_pixels *lobes;  ///< [tile_count] of this frame; NULL = paths follow rough lobes
    uint8_t *glossy;           ///< [tile_count] whether a tile has any
    rsv_resting_paths *whole;  ///< [tile_count] whole paths of this frame; may be NULL
    rsv_resting_tile *resting; ///< [tile_count] of frames at rest from the second on; may be NULL
    rsv_resting_node *squares; ///< [2 * tile_count + 64] room for rsv_resting_share
    rsv_resting_given *given;  ///< may be NULL
    rsv_camera camera;         ///< that they are of
    // of the frame in the making
    rsv_frame_aim aim;
    rsv_beam_lens beam_lens;
    rsv_frame_tone tone;
    rsv_medium medium;     ///< the camera's
    uint8_t medium_number; ///< in the list of media
    float spread;
    rsv_fog_front fog; ///< before it; slice NULL = the air is clear
} rsv_eye_picture;

/// Samples in the sums once the frame in the making is added.
static inline uint32_t rsv_eye_samples(const rsv_eye_picture *eye)
{
    return eye->samples + 1 - eye->dropped;
}

/// Data common to all tiles.
typedef struct rsv_tiling {
    const rsv_light_view *solution;
    const rsv_light_table *table;
    const rsv_packet_kernels *kernels;
    const rsv_specular_media *media;
    const rsv_clearances *clearances;
    const rsv_beams *beams;
    uint32_t width, height;      ///< of a picture
    uint32_t across, tile_count; ///< tiles of a picture
    uint32_t seed;
    bool final;                ///< whole paths are those of mode final
    rsv_highlights highlights; ///< of the frame in the making
    rsv_glossy_shading shading;
    const rsv_mover *mover;     ///< of the frame in the making; NULL = none
    const rsv_fog_shine *shine; ///< NULL = the air is clear
} rsv_tiling;

rsv_status rsv_tile_worker_create(
    const rsv_tiling *tiling, uint32_t path_depth, rsv_tile_worker *worker);
void rsv_tile_worker_destroy(rsv_tile_worker *worker);

/// Where a pixel lies in an eye's sums.
RSV_INLINE size_t rsv_tile_place(const rsv_tiling *tiling, uint32_t column, uint32_t row)
{
    size_t tile = (size_t)(row / RSV_TILE) * tiling->across + column / RSV_TILE;
    return tile * RSV_TILE_PIXELS + row % RSV_TILE * RSV_TILE + column % RSV_TILE;
}

/// Adds one sample to each pixel and shows the sums. Tiles that are glossy wait for rsv_tile_finish.
void rsv_tile_render(
    const rsv_tiling *tiling, rsv_eye_picture *eye, uint32_t tile, rsv_tile_worker *worker);

/// Mean radiance of all frames, as it is shown. @param radiance [RSV_TILE_PIXELS] out
void rsv_tile_shown(
    const rsv_tiling *tiling, const rsv_eye_picture *eye, uint32_t tile, float (*radiance)[4]);

/// The same for a glossy tile, once all cells have their light.
void rsv_tile_finish(
    const rsv_tiling *tiling, rsv_eye_picture *eye, uint32_t tile, rsv_tile_worker *worker);

/// After all tiles have their samples: combines them with earlier frames, and displays the result.
void rsv_tile_recall(
    const rsv_tiling *tiling, rsv_eye_picture *eye, uint32_t tile, rsv_tile_worker *worker);

/// Traces only the camera rays.
void rsv_tile_trace_only(
    const rsv_tiling *tiling, rsv_eye_picture *eye, uint32_t tile, rsv_tile_worker *worker);

#endif
