/// What frames showed before, followed to where it lies now: temporal anti-aliasing (Karis 2014; Yang, Liu, Salvi 2020).
///
/// While the camera moves, the samples of successive frames lie at different places within the pixels. Each pixel looks up
/// where what it sees was shown in the frame before, and adds its own sample to the mean found there. The mean is kept
/// within what the pixel and its eight neighbours show now, so that nothing trails behind edges and reflections. Depths are
/// those along the whole path through mirrors and panes: images in them move as what lies at that distance behind them.
/// While the camera rests, what is shown goes over from the history to the mean of the frames at rest.
#ifndef RSV_FRAME_HISTORY_H
#define RSV_FRAME_HISTORY_H

#include "../trace/camera_ray.h"

#include <stddef.h>

/// Pixels on each side of a tile.
#define RSV_HISTORY_TILE 32
/// Frames that a pixel is the mean of at most.
#define RSV_HISTORY_FRAMES 8
/// Metres, for what is infinitely far away.
#define RSV_HISTORY_FAR 1e6f

typedef struct rsv_frame_history {
    rsv_context *context;
    uint32_t width, height,
        stride; ///< of the picture, pixels; stride is a multiple of RSV_HISTORY_TILE
    /// [stride * height] mean radiance, and the number of frames that it is the mean of
    float (*shown)[4], (*shown_before)[4];
    float *depth, *depth_before; ///< [stride * height] metres along the path to what a pixel shows
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
/// Begins anew with a picture that is no larger than the one it was created for.
void rsv_frame_history_resize(rsv_frame_history *history, uint32_t width, uint32_t height);
void rsv_frame_history_destroy(rsv_frame_history *history);

/// Before a frame. @param samples that the camera has rested for; 0 = it has moved @param x, y place of the frame's samples
void rsv_frame_history_begin(
    rsv_frame_history *history, const rsv_lens *lens, uint32_t samples, float x, float y);

/// Forgets a share of what was shown: the light has changed by so much. @param change 0 = not at all .. 1
void rsv_frame_history_forget(rsv_frame_history *history, float change);

/// Frames at rest after which they are shown alone.
#define RSV_HISTORY_SETTLED (4 * RSV_HISTORY_FRAMES)

/// Share of the mean of the frames at rest in what is shown; the history has the rest.
/// @param count frames that the history is the mean of, the first one at rest included @param samples of the mean at rest
RSV_INLINE float rsv_history_share_at_rest(float count, uint32_t samples)
{
    return samples >= RSV_HISTORY_SETTLED ? 1 : (float)samples / ((float)samples + count - 1);
}

RSV_INLINE size_t rsv_history_place(const rsv_frame_history *history, uint32_t column, uint32_t row)
{
    return (size_t)row * history->stride + column;
}

#endif
