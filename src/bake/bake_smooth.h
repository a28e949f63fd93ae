/// Noise of rows taken out of stored light: each node's value becomes that of a plane fitted to the nodes around it, over as many
/// of them as agree with a plane but for noise.
///
/// Nodes are found independently, so noise is what departs from node to node. Fits over more and more nodes have less noise and
/// more bias; the largest is taken whose confidence interval meets those of all smaller ones (Goldenshluger and Nemirovski, "On
/// spatially adaptive estimation of nonparametric regression", 1997). Edges of light and contact shadows stay as they are, as do
/// creases, where nodes of both sides are no neighbours.
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

/// @param smooth out; to be destroyed even after an error, before the light
rsv_status rsv_bake_smooth_create(const rsv_light_view *light, rsv_bake_smooth *smooth);
void rsv_bake_smooth_destroy(rsv_bake_smooth *smooth);

#endif
