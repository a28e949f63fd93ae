/// Means over windows, weighted by likeness.
#ifndef RSV_DENOISE_WINDOW_H
#define RSV_DENOISE_WINDOW_H

#include "surfaces.h"

#define RSV_KINDS_OF_LIGHT 2

/// Light that is filtered; all [plane].
typedef struct rsv_light_planes {
    float *half[2][3];
    float *variance;       ///< of a half: sum over channels
    float least;           ///< variance that counts as none
    float *filtered[2][3]; ///< out: the halves; as they were where there is no variance
} rsv_light_planes;

/// Filters several kinds of light by the same surfaces.
void rsv_filter_windows(const rsv_plane_grid *grid, const rsv_surface_planes *surfaces,
    const rsv_light_planes *light, int count);

#endif
