/// Light on one patch of a surface: what elements store of it, and what shadow rays find of sources there.
///
/// Elements are larger than texels, and smear the edges of shadows over them. So of direct light only what gather rays and
/// photons bring is looked up; sources are asked from the patch itself. What they would give without shadows is known in closed
/// form (Lambert's formula), so that only visibility is sampled, and no noise is left where all of a source is seen, or none.
#ifndef RSV_BAKE_DIRECT_H
#define RSV_BAKE_DIRECT_H

#include "bake_patch.h"
#include "bake_sources.h"

/// What shadow rays found.
typedef struct rsv_bake_estimate {
    rsv_rgb stored;   ///< looked up
    rsv_rgb punctual; ///< of punctual lights
    rsv_rgb half[2];  ///< of all other sources, by two sets of shadow rays that are independent
    float seen;       ///< share of the light of those that closed forms know
    float open;       ///< luminance of it without shadows
    /// Variance of what one shadow ray finds of emitters that a tree chose, by its choice; luminance.
    float choice;
} rsv_bake_estimate;

/// A light, and the sources that its shadow rays are sent to.
typedef struct rsv_bake_lamps {
    const rsv_light_view *light;
    rsv_bake_sources sources;
} rsv_bake_lamps;

/// Light on a patch.
/// @param samples shadow rays of each half @param seed of their random numbers
rsv_bake_estimate rsv_bake_estimate_patch(
    const rsv_bake_lamps *lamps, const rsv_bake_patch *patch, uint32_t samples, uint32_t seed);

/// Standard error of the mean of the halves, by what share of sources is seen; W/m2, luminance.
float rsv_bake_estimate_error(const rsv_bake_estimate *estimate, uint32_t samples);

/// The light of a patch, with as many shadow rays as the wanted error takes, up to a limit.
/// @param error wanted, W/m2
rsv_rgb rsv_bake_light_patch(
    const rsv_bake_lamps *lamps, const rsv_bake_patch *patch, float error, uint32_t seed);

/// What elements store of the light at a place, without what shadow rays find; of translucent surfaces, all.
rsv_rgb rsv_bake_stored(const rsv_light_view *light, const rsv_surface_place *place);

/// The mean of that over a patch.
rsv_rgb rsv_bake_stored_mean(const rsv_light_view *light, const rsv_bake_patch *patch);

/// Whether shadow rays have anything to find there: not on translucent surfaces, whose light is spread below them.
bool rsv_bake_is_sampled(const rsv_light_view *light, const rsv_surface_place *place);

static inline rsv_rgb rsv_bake_estimate_total(const rsv_bake_estimate *e)
{
    rsv_rgb sampled = rgb_scale(rgb_add(e->half[0], e->half[1]), 0.5f);
    return rgb_add(rgb_add(e->stored, e->punctual), sampled);
}

#endif
