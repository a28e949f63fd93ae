/// The scattering operator of translucent materials on elements: K = diag(albedo) P.
///
/// P maps the entering irradiance to the *diffused* irradiance, which would give the same exitance on a Lambert
/// surface. Row sums are at most 1: diffusion moves light, albedo absorbs it. Rows assume that irradiance is linear
/// between nodes, and are exact integrals of the profile over it, so a profile narrower than the elements gives the
/// identity.
#ifndef RSV_SUBSURFACE_H
#define RSV_SUBSURFACE_H

#include "scatter_sources.h"

/// P as compressed sparse rows. Far columns are clusters (mean over their cells), near ones nodes.
typedef struct rsv_subsurface {
    rsv_scatter_sources *sources;
    size_t row_count;  ///< node_count
    size_t *row_begin; ///< [row_count + 1]; nodes that hang or lie on no body have no entries
    uint32_t *column;
    rsv_rgb *weight;
    rsv_rgb *entered; ///< [node_count + cluster_count] of the product in hand
} rsv_subsurface;

/// @param subsurface out; NULL if the scene has no translucent material
rsv_status rsv_subsurface_create(const rsv_elements *elements, rsv_subsurface **subsurface);
void rsv_subsurface_destroy(rsv_subsurface *subsurface);

/// P from its rows; RSV_ERROR_FORMAT if their columns are past the end, or if the elements have no translucent
/// material.
/// @param rows taken over with their arrays, even on failure: row_count, row_begin, column, weight; row_begin is sound
rsv_status rsv_subsurface_restore(
    const rsv_elements *elements, const rsv_subsurface *rows, rsv_subsurface **subsurface);

/// Whether a node lies on a body and does not hang. At others light leaves where it enters.
bool rsv_subsurface_has_row(const rsv_subsurface *subsurface, uint32_t node);

size_t rsv_subsurface_entries(const rsv_subsurface *subsurface);
/// Memory of its rows. @param subsurface NULL = 0
size_t rsv_subsurface_bytes(const rsv_subsurface *subsurface);

/// diffused = P irradiance on bodies, a copy elsewhere. Not thread-safe.
/// @param subsurface NULL = a copy everywhere @param irradiance [node_count], hanging nodes interpolated
void rsv_subsurface_apply(rsv_subsurface *subsurface, const rsv_elements *elements,
    const rsv_rgb *irradiance, rsv_rgb *diffused);

/// irradiance = P* diffused: the importance of entering irradiance, for diffused irradiance with the weights
/// `diffused`. Not thread-safe.
/// @param diffused is overwritten
void rsv_subsurface_apply_transpose(rsv_subsurface *subsurface, const rsv_elements *elements,
    rsv_rgb *diffused, rsv_rgb *irradiance);

#endif
