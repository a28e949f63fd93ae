/// Receivers of direct light: which nodes, from which points, with how many rays.
#ifndef RSV_DIRECT_RECEIVER_H
#define RSV_DIRECT_RECEIVER_H

#include "../elements/elements.h"
#include "../sources/lights.h"
#include "../specular/specular_path.h"
#include "direct_sample.h"

/// All nodes of a pass.
typedef struct rsv_direct_job {
    const rsv_transport_scene *scene;
    const rsv_elements *elements;
    rsv_direct_setting setting;
    /// Shadow rays per node to emitters, a multiple of 16; punctual lights get one per point. Less than 16: a preview
    /// from four points, and 16 rays where these see not the same.
    uint32_t samples;
    const uint16_t
        *valid_points; ///< [node_count] from rsv_find_buried with the setting's points and seed
    /// [node_count] light of a whole of which the lights are a part: each node gets shadow rays by the part's share of
    /// it, at least 16, and none where the whole is dark. NULL = all nodes get the same. Devices ignore it.
    const rsv_rgb *whole;
} rsv_direct_job;

/// Result of a pass.
typedef struct rsv_direct_light {
    rsv_rgb *irradiance; ///< [node_count]
    float *
        deviation; ///< [node_count] estimated standard deviation of the luminance of each estimate; NULL = not needed
    uint64_t rays;
} rsv_direct_light;

/// Edge of the patch over which a node's points average a normal map: finer ones must not show as noise from node to
/// node.
static inline float rsv_direct_width(const rsv_elements *e, uint32_t node)
{
    return sqrtf(e->node_area[node]);
}

/// Sets up some of a node's points. @param valid required points, at least one
void rsv_direct_receive(
    const rsv_direct_job *job, uint32_t node, uint32_t valid, rsv_node_receivers *receivers);

/// Whether nodes are previewed at first.
bool rsv_direct_previews(const rsv_direct_job *job);
/// The points of a node that a preview is from.
uint32_t rsv_direct_preview_points(const rsv_direct_job *job, uint32_t node);
/// Its rays, one from each of them.
rsv_direct_rays rsv_direct_preview_rays(const rsv_direct_job *job);
/// Rays of a node that a preview has seen in part, or of any where there are none.
rsv_direct_rays rsv_direct_look_rays(const rsv_direct_job *job);
/// How many of these the share of a whole asks for. @param unshadowed light of the part at the node
uint32_t rsv_direct_samples_by_share(
    const rsv_direct_job *job, uint32_t node, rsv_rgb unshadowed, uint32_t samples);

#endif
