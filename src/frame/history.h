/// Earlier frames, reprojected to the present one: temporal anti-aliasing (Karis 2014; Yang, Liu, Salvi 2020).
///
/// While the camera moves, the samples of successive frames are at different positions within the pixels. Each pixel
/// finds where its surface was in the previous frame, and adds its own sample to the mean found there. The mean is
/// clamped to the range of the pixel and its eight neighbours in the present frame, so that nothing trails behind edges
/// and reflections. Depths are those along the whole path through mirrors and panes, because images in them move like
/// objects at that distance behind them. While the camera rests, the picture changes gradually from the history to the
/// mean of the frames at rest.
#ifndef RSV_FRAME_HISTORY_H
#define RSV_FRAME_HISTORY_H

#include "../trace/camera_ray.h"

#include <stddef.h>

/// Pixels on each side of a tile.
#define RSV_HISTORY_TILE 32
/// Frames that a pixel is the mean of at most.
#define RSV_HISTORY_FRAMES 8
/// Metres, for infinite distances.
#define RSV_HISTORY_FAR 1e6f

typedef struct rsv_frame_history {
    rsv_context *context;
    uint32_t width, height,
        stride; ///< of the picture, pixels; stride is a multiple of RSV_HISTORY_TILE
    /// [stride * height] mean radiance, and the number of frames that it is the mean of
    float (*shown)[4], (*shown_before)[4];
    float *depth, *depth_before; ///< [stride * height] metres along the path to the pixel's surface
    rsv_lens lens, lens_before;
    float place_x, place_y; ///< of the frame's samples within their pixels
    float keep;             ///< share of the frames before that still count; 0 = there are none
    uint32_t frame;         ///< number of frames so far while the camera moved
    bool moves;             ///< in the frame in the making
} rsv_frame_history;

/// A tile and the pixels around it. Beyond the picture, its border is repeated.
typedef struct rsv_history_window {
    float now[RSV_HISTORY_TILE + 2][RSV_HISTORY_TILE + 2][4]; ///< radiance of this frame
    float depth[RSV_HISTORY_TILE + 2][RSV_HISTORY_TILE + 2];
} __attribute__((aligned(64))) rsv_history_window;

/// @param width, height of the picture, pixels
rsv_status rsv_frame_history_create(
    rsv_context *context, uint32_t width, uint32_t height, rsv_frame_history *history);
/// Starts again with a picture no larger than the one at creation.
void rsv_frame_history_resize(rsv_frame_history *history, uint32_t width, uint32_t height);
void rsv_frame_history_destroy(rsv_frame_history *history);

/// Before a frame. @param samples that the camera has rested for; 0 = it has moved @param x, y place of the frame's
/// samples
void rsv_frame_history_begin(
    rsv_frame_history *history, const rsv_lens *lens, uint32_t samples, float x, float y);

/// Discards a part of the history after a change of light. @param change 0 = none .. 1
void rsv_frame_history_forget(rsv_frame_history *history, float change);

/// Number of frames at rest after which only these are displayed.
#define RSV_HISTORY_SETTLED (4 * RSV_HISTORY_FRAMES)

/// Weight of the mean of the frames at rest in the picture; the history has the rest.
/// @param count frames in the history, with the first one at rest @param samples of the mean at rest
RSV_INLINE float rsv_history_share_at_rest(float count, uint32_t samples)
{
    return samples >= RSV_HISTORY_SETTLED ? 1 : (float)samples / ((float)samples + count - 1);
}

RSV_INLINE size_t rsv_history_place(const rsv_frame_history *history, uint32_t column, uint32_t row)
{
    return (size_t)row * history->stride + column;
}

#endif
