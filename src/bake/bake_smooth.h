/// Removes noise of rows from stored light: the value of each node becomes that of a plane fitted to the nodes around
/// it, over as many of them as agree with a plane up to noise.
///
/// Nodes are computed independently, so noise varies from node to node. Fits over more nodes have less noise and more
/// bias. The largest fit is used whose confidence interval meets those of all smaller ones (Goldenshluger and
/// Nemirovski, "On spatially adaptive estimation of nonparametric regression", 1997). Edges of light and contact
/// shadows are kept. So are creases, because nodes on their two sides are not neighbours.
#ifndef RSV_BAKE_SMOOTH_H
#define RSV_BAKE_SMOOTH_H

#include "../solve/light.h"

/// A light whose indirect light and gathered light are smoothed.
typedef struct rsv_bake_smooth {
    rsv_context *context;
    rsv_light_view
        view; ///< of the same light: `indirect` is smoothed and holds `gathered` too, which is black
    rsv_rgb *indirect, *gathered; ///< [node_count]
} rsv_bake_smooth;

/// @param smooth out; destroy it before the light, even after an error
rsv_status rsv_bake_smooth_create(const rsv_light_view *light, rsv_bake_smooth *smooth);
void rsv_bake_smooth_destroy(rsv_bake_smooth *smooth);

#endif
