/// Places charts in a lightmap.
#ifndef RSV_BAKE_PACK_H
#define RSV_BAKE_PACK_H

#include "bake_chart.h"

/// Places every chart in a map `width` wide, at `density` texels per metre times its detail. Charts are `padding`
/// texels apart, half as many if one is a rectangle. Starting with the largest, each chart goes to the first row, and
/// there the first column, where its shape fits, in the best of four rotations. Small charts thus fill the gaps of
/// large ones.
/// @param height out: number of rows; UINT32_MAX = more than `most_rows`, or a chart is too wide
rsv_status rsv_bake_pack(rsv_bake_charts *charts, float density, uint32_t padding, uint32_t width,
    uint32_t most_rows, uint32_t *height);

#endif
