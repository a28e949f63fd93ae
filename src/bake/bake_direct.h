/// Light on one patch of a surface: the stored light of elements, and light of sources by shadow rays.
///
/// Elements are larger than texels and blur the edges of shadows. Of direct light, therefore, only the part of gather
/// rays and photons is looked up; sources are sampled from the patch itself. Their unshadowed light is known in closed
/// form (Lambert's formula), so only visibility is sampled, and there is no noise where all of a source is visible, or
/// none.
#ifndef RSV_BAKE_DIRECT_H
#define RSV_BAKE_DIRECT_H

#include "bake_patch.h"
#include "bake_sources.h"

/// Result of shadow rays.
typedef struct rsv_bake_estimate {
    rsv_rgb stored;   ///< looked up
    rsv_rgb punctual; ///< of punctual lights
    rsv_rgb half[2];  ///< of all other sources, by two sets of shadow rays that are independent
    float seen;       ///< visible fraction of the light in closed forms
    float open;       ///< luminance of it without shadows
    /// Variance of one shadow ray to emitters chosen by a tree, due to the choice; luminance.
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

/// Standard error of the mean of the halves, from the visible fraction of sources; W/m2, luminance.
float rsv_bake_estimate_error(const rsv_bake_estimate *estimate, uint32_t samples);

/// The light of a patch, with as many shadow rays as the target error requires, up to a limit.
/// @param error target, W/m2
rsv_rgb rsv_bake_light_patch(
    const rsv_bake_lamps *lamps, const rsv_bake_patch *patch, float error, uint32_t seed);

/// Stored light at a place, without the part that shadow rays find; for translucent surfaces, all of it.
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
