/// One step of a camera path: the light at the surface where it has arrived, and the branches that leave from there.
/// Callers follow paths one by one (camera_path.c), sixteen at a time (frame/specular_arrival.c), or in waves on a
/// device (gpu/frame_kernels.h). Plain C, also for device code.
#ifndef RSV_CAMERA_STEP_H
#define RSV_CAMERA_STEP_H

#include "../core/sampling.h"
#include "../specular/specular_walk.h"
#include "rough_light.h"

// ---- light at a surface --------------------------------------------------------------------------

/// Whether a path still runs along the camera's ray, at most through panes and past surfaces that do not cover. Positions
/// are known to about 1e-6 of their distance, so directions are compared with a tolerance. @param start, now unit
RSV_INLINE bool rsv_runs_straight(rsv_vec3 start, rsv_vec3 now)
{
    return v3_dot(start, now) > 0.999999f;
}

/// Whether a side of a surface shows its emission, or is unlit.
RSV_INLINE bool rsv_side_shows_emission(const rsv_bsdf *bsdf, bool back)
{
    return (bsdf->emissive || bsdf->unlit) && (!back || bsdf->double_sided);
}

// ---- ideal branches -------------------------------------------------------------------------------

#define RSV_FAINT_BRANCH 0.01f ///< branches below this weight play roulette

/// Whether to follow an ideal branch.
/// @param carried weight of the specular path so far @param weight of the branch; increased to make up for dropped ones
RSV_INLINE bool rsv_weight_survives(rsv_rgb carried, uint32_t trail, bool transmit, rsv_rgb *weight)
{
    float most = rgb_max(rgb_mul(carried, *weight));
    if (most <= 0) return false;
    if (most >= RSV_FAINT_BRANCH) return true;
    if (rsv_unit_float(rsv_hash2(trail, transmit)) * RSV_FAINT_BRANCH >= most) return false;
    *weight = rgb_scale(*weight, RSV_FAINT_BRANCH / most);
    return true;
}

RSV_INLINE bool rsv_branch_survives(
    const rsv_specular_path *path, uint32_t trail, bool transmit, rsv_rgb *weight)
{
    return rsv_weight_survives(path->weight, trail, transmit, weight);
}

/// The trail of the link at the end of an ideal branch.
RSV_INLINE uint32_t rsv_branch_trail(uint32_t trail, bool transmit)
{
    return rsv_hash2(trail, 2 + transmit);
}

/// A branch to follow.
typedef struct rsv_camera_branch {
    bool transmit;
    rsv_vec3 direction;
    rsv_rgb weight; ///< multiplies the specular path's
    uint32_t trail; ///< its name
} rsv_camera_branch;

/// One ideal branch of a surface, if it is to be followed. @param trail of the specular path @param max_events limit of
/// specular ones
RSV_INLINE bool rsv_ideal_branch(const rsv_specular_path *path, uint32_t trail, uint32_t max_events,
    bool transmit, const rsv_bsdf_branches *branches, rsv_camera_branch *branch)
{
    branch->transmit = transmit;
    branch->direction = transmit ? branches->transmit_direction : branches->reflect_direction;
    branch->weight = transmit ? branches->transmit : branches->reflect;
    branch->trail = rsv_branch_trail(trail, transmit);
    return path->events < max_events && rsv_branch_survives(path, trail, transmit, &branch->weight);
}

// ---- the branch of rough lobes --------------------------------------------------------------------

/// Random numbers of a rough surface.
typedef struct rsv_rough_numbers {
    float kept, light[3], direction[3], sky[3];
} rsv_rough_numbers;

/// @param trail as in camera_path.h
RSV_INLINE rsv_rough_numbers rsv_rough_numbers_of(uint32_t trail, uint32_t triangle)
{
    rsv_rough_numbers n;
    rsv_random random = rsv_random_from(trail, triangle, 0x17c3u);
    n.kept = rsv_random_float(&random);
    for (int k = 0; k < 3; k++)
        n.light[k] = rsv_random_float(&random);
    for (int k = 0; k < 3; k++)
        n.direction[k] = rsv_random_float(&random);
    for (int k = 0; k < 3; k++)
        n.sky[k] = rsv_random_float(&random);
    return n;
}

/// Rough lobes are looked at as often as they are this many times the diffuse one's share.
#define RSV_ROUGH_WORTH 10

/// Probability of sampling rough lobes: wide ones that are faint compared with the diffuse lobe are not worth two rays
/// each time.
RSV_INLINE float rsv_rough_chance(
    const rsv_rough_surface *surface, const rsv_bsdf_branches *branches)
{
    const rsv_bsdf *bsdf = surface->bsdf;
    if (!rsv_rough_is_wide(bsdf)) return 1;
    float rough = rsv_bsdf_specular_chance(bsdf, surface->wo, surface->normal, surface->front);
    float diffuse = rgb_luminance(rgb_mul(branches->diffuse, bsdf->base_color));
    return RSV_ROUGH_WORTH * rough < diffuse ? RSV_ROUGH_WORTH * rough / diffuse : 1;
}

/// Whether an event of rsv_rough_draw sends the specular path on.
RSV_INLINE bool rsv_rough_goes_on(const rsv_bsdf_event *event)
{
    bool specular = event->lobe == RSV_LOBE_REFLECT || event->lobe == RSV_LOBE_TRANSMIT;
    return specular && event->pdf_solid_angle > 0;
}

/// Whether the lobes of a rough surface that was seen are looked at; if so, it is lifted, and the path made up for
/// those that are not. @param path in and out: the surface's from now on
RSV_INLINE bool rsv_rough_arrive(rsv_specular_path *path, const rsv_rough_numbers *numbers,
    const rsv_bsdf_branches *branches, rsv_rough_surface *surface)
{
    float chance = rsv_rough_chance(surface, branches);
    if (numbers->kept >= chance) return false;
    path->weight = rgb_scale(path->weight, 1 / chance);
    surface->path = path;
    rsv_rough_lift(surface);
    return true;
}

/// The branch that its lobes draw. @param trail of the specular path @param max_events specular ones at most
RSV_INLINE bool rsv_rough_branch(const rsv_rough_surface *surface, const rsv_rough_numbers *numbers,
    uint32_t trail, uint32_t max_events, rsv_camera_branch *branch)
{
    rsv_bsdf_event event = rsv_rough_draw(surface, numbers->direction);
    branch->transmit = event.lobe == RSV_LOBE_TRANSMIT;
    branch->direction = event.direction;
    branch->weight = event.weight;
    branch->trail = rsv_branch_trail(trail, false);
    return rsv_rough_goes_on(&event) && surface->path->events < max_events;
}

#endif
