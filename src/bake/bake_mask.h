/// Which texels a chart lies in: the shape that packing works with.
#ifndef RSV_BAKE_MASK_H
#define RSV_BAKE_MASK_H

#include "bake_chart.h"

/// Texels [begin, end) of a row.
typedef struct rsv_bake_run {
    uint32_t row, begin, end;
} rsv_bake_run;

/// Zero-initialised, a context set. Serves one chart after the other.
typedef struct rsv_bake_mask {
    rsv_context *context;
    rsv_bake_run *run; ///< [run_count] row by row, from left to right
    size_t run_count, run_capacity;
    bool is_whole; ///< filtering within the chart reads all texels of its rectangle: so do the runs
    // while it is drawn
    uint8_t *touched; ///< [texels of the chart]
    size_t touched_capacity;
} rsv_bake_mask;

/// Finds the texels whose squares a chart touches, the chart's own first one at (0, 0). Filtering reads those next to
/// them too, but none beyond the chart's rectangle, whose sides run through the middle of texels. Where that is all of
/// the rectangle, it is the shape.
rsv_status rsv_bake_mask_draw(
    rsv_bake_mask *mask, const rsv_bake_charts *charts, const rsv_bake_chart *chart);
void rsv_bake_mask_destroy(rsv_bake_mask *mask);

#endif
