/// Means over windows, weighted by likeness.
#ifndef RSV_DENOISE_WINDOW_H
#define RSV_DENOISE_WINDOW_H

#include "planes.h"

typedef enum rsv_mean_kind {
    RSV_MEAN_BY_LIGHT,    ///< by surfaces and the light of the other half
    RSV_MEAN_BY_SURFACES, ///< by surfaces alone
    RSV_MEAN_KINDS
} rsv_mean_kind;

/// Filtered light; all [plane].
typedef struct rsv_filtered_planes {
    float *half[RSV_MEAN_KINDS][2][3];
} rsv_filtered_planes;

/// @param least variance that counts as none
void rsv_filter_windows(const rsv_plane_grid *grid, const rsv_surface_planes *surfaces,
    const rsv_light_planes *light, float least, const rsv_filtered_planes *filtered);

#endif
