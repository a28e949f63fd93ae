#include "view_pace.h"

#include <string.h>

/// Milliseconds of a frame that is too slow to steer by, and of one fast enough for four times the pixels.
#define SLOW_MS 150
#define FAST_MS 25
/// Frames in a row before anything changes: one may be slow by chance.
#define SLOW_FRAMES 2
#define FAST_FRAMES 16
/// Frames at rest before the picture gets all its pixels.
#define RESTING_FRAMES 3
#define MOST_COARSENESS 4

void cli_view_pace_begin(cli_view_pace *p, bool rests)
{
    p->rests = rests ? p->rests + 1 : 0;
    if (!p->moving) p->moving = 1;
    p->coarseness = p->varies && p->rests < RESTING_FRAMES ? p->moving : 1;
}

void cli_view_pace_note(cli_view_pace *p, double frame_ms)
{
    if (p->rests >= RESTING_FRAMES) return;
    p->slow = frame_ms > SLOW_MS ? p->slow + 1 : 0;
    p->fast = frame_ms < FAST_MS ? p->fast + 1 : 0;
    bool less = p->slow >= SLOW_FRAMES && p->moving < MOST_COARSENESS;
    bool more = p->fast >= FAST_FRAMES && p->moving > 1;
    if (!less && !more) return;
    p->moving = less ? 2 * p->moving : p->moving / 2;
    p->slow = p->fast = 0;
}

void cli_view_enlarge(const uint8_t (*pixel)[4], uint32_t coarseness, uint32_t width,
    uint32_t height, uint32_t left, cli_canvas *canvas)
{
    uint32_t across = (width + coarseness - 1) / coarseness;
    for (uint32_t y = 0; y < height; y++) {
        uint8_t(*out)[4] = canvas->pixel + (size_t)y * canvas->width + left;
        const uint8_t(*row)[4] = pixel + (size_t)(y / coarseness) * across;
        if (coarseness == 1)
            memcpy(out, row, width * sizeof *out);
        else
            for (uint32_t x = 0; x < width; x++)
                memcpy(out[x], row[x / coarseness], sizeof *out);
    }
}
