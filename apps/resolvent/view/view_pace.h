/// Frames that take too long get fewer pixels while the camera moves.
#ifndef CLI_VIEW_PACE_H
#define CLI_VIEW_PACE_H

#include "view_canvas.h"

typedef struct cli_view_pace {
    bool varies;         ///< or else every frame has all its pixels
    uint32_t coarseness; ///< pixels of the window along each side of one of the frame: 1, 2 or 4
    uint32_t moving;     ///< coarseness while the camera moves
    uint32_t slow, fast; ///< number of slow or fast frames in a row
    uint32_t rests;      ///< number of frames at rest in a row
} cli_view_pace;

/// To be called before a frame. @param rests whether nothing changes
void cli_view_pace_begin(cli_view_pace *pace, bool rests);

/// After a frame.
void cli_view_pace_note(cli_view_pace *pace, double frame_ms);

/// Copies a frame's pixels to (left, 0) of a canvas, each into a square. @param width, height of the frame's part of
/// the canvas
void cli_view_enlarge(const uint8_t (*pixel)[4], uint32_t coarseness, uint32_t width,
    uint32_t height, uint32_t left, cli_canvas *canvas);

#endif
