#include "history.h"

#include "../core/core.h"

#include <string.h>

static void lay_out(rsv_frame_history *h, uint32_t width, uint32_t height)
{
    h->width = width;
    h->height = height;
    h->stride = (width + RSV_HISTORY_TILE - 1) / RSV_HISTORY_TILE * RSV_HISTORY_TILE;
    h->keep = 0;
}

rsv_status rsv_frame_history_create(
    rsv_context *context, uint32_t width, uint32_t height, rsv_frame_history *h)
{
    *h = (rsv_frame_history){ .context = context };
    lay_out(h, width, height);
    size_t pixels = (size_t)h->stride * height;
    h->shown = rsv_reserve(context, pixels, sizeof *h->shown);
    h->shown_before = rsv_reserve(context, pixels, sizeof *h->shown);
    h->depth = rsv_reserve(context, pixels, sizeof *h->depth);
    h->depth_before = rsv_reserve(context, pixels, sizeof *h->depth);
    return h->shown && h->shown_before && h->depth && h->depth_before ? RSV_OK : RSV_ERROR_MEMORY;
}

void rsv_frame_history_resize(rsv_frame_history *h, uint32_t width, uint32_t height)
{
    if (h->context) lay_out(h, width, height);
}

void rsv_frame_history_destroy(rsv_frame_history *h)
{
    if (!h->context) return;
    rsv_free(h->context, h->shown);
    rsv_free(h->context, h->shown_before);
    rsv_free(h->context, h->depth);
    rsv_free(h->context, h->depth_before);
    *h = (rsv_frame_history){ 0 };
}

void rsv_frame_history_begin(
    rsv_frame_history *h, const rsv_lens *lens, uint32_t samples, float x, float y)
{
    h->moves = samples == 0;
    if (!h->moves) return; // at rest, it stays where it is
    float(*shown)[4] = h->shown_before, *depth = h->depth_before;
    h->shown_before = h->shown;
    h->depth_before = h->depth;
    h->shown = shown;
    h->depth = depth;
    h->lens_before = h->lens;
    h->lens = *lens;
    h->place_x = x;
    h->place_y = y;
    h->frame++;
}

void rsv_frame_history_forget(rsv_frame_history *h, float change)
{
    h->keep *= f_max(1 - 16 * change, 0);
}
