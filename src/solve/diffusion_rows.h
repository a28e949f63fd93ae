/// The diffusion P of translucent bodies (diffusion/subsurface.h) as plain arrays: rows of nodes and clusters, and the
/// means of clusters, in levels that only depend on earlier ones.
#ifndef RSV_DIFFUSION_ROWS_H
#define RSV_DIFFUSION_ROWS_H

#include "../diffusion/subsurface.h"

typedef struct rsv_diffusion_rows {
    size_t row_count;
    uint32_t *node;         ///< [row_count] nodes that have a row; other nodes keep their entering light
    size_t *row_begin;      ///< [row_count + 1] into column and weight
    const uint32_t *column; ///< nodes, then node_count + cluster; the subsurface's
    const rsv_rgb *weight;  ///< the same length as its columns
    size_t mean_count;      ///< clusters
    uint32_t *mean;         ///< [mean_count] node_count + cluster, level by level
    uint32_t *mean_begin;   ///< [mean_count + 1] into source and share
    uint32_t *source;       ///< nodes and other means
    float *share;
    size_t level_count;
    uint32_t *level_begin; ///< [level_count + 1] into mean
} rsv_diffusion_rows;

/// @param subsurface borrowed
rsv_status rsv_diffusion_rows_create(const rsv_subsurface *subsurface, rsv_diffusion_rows *rows);
void rsv_diffusion_rows_destroy(rsv_context *context, rsv_diffusion_rows *rows);

#endif
