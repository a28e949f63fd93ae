/// Places charts in a lightmap.
#ifndef RSV_BAKE_PACK_H
#define RSV_BAKE_PACK_H

#include "bake_chart.h"

/// Gives every chart its texels, at `density` texels per metre times its detail and `padding` texels apart, half as
/// many where one is a rectangle, in a map `width` wide: from the largest to the smallest, each into the first row, and
/// there the first column, where its shape fits, in whichever of four quarter turns ends first. So small charts come to
/// lie within the gaps of large ones.
/// @param height out: rows that were needed; UINT32_MAX = more than `most_rows`, or a chart is too wide
rsv_status rsv_bake_pack(rsv_bake_charts *charts, float density, uint32_t padding, uint32_t width,
    uint32_t most_rows, uint32_t *height);

#endif
