/// From the camera through mirrors and glass to every diffuse surface it sees: `C S* D`.
#ifndef RSV_CAMERA_PATH_H
#define RSV_CAMERA_PATH_H

#include "../sources/lights.h"
#include "../specular/specular_path.h"
#include "camera_step.h"
#include "pixel_sample.h"
#include "sky_visibility.h"

/// Specular events along a branch that are enough for any picture but of closed rooms of mirrors: branches of pictures
/// that go on after these play roulette.
#define RSV_CAMERA_PATH_DEPTH 64

/// Data common to the specular paths of one picture.
typedef struct rsv_camera_setting {
    const rsv_transport_scene *scene;
    const rsv_lights *lights;
    const rsv_sky_visibility *visibility; ///< of rough surfaces; NULL = not known
    uint32_t max_events;                  ///< specular ones along a branch at most
    bool shot;                            ///< omit the light that rsv_shot_light_add adds
    /// Called for each segment through fog that leads to a surface or out of the scene, from the second one on; adds
    /// scattered light. NULL = the air is clear. @param throughput of the path up to it @param trail identifies it
    /// @return transmittance of the segment
    rsv_rgb (*cross_fog)(void *user, const rsv_ray *segment, rsv_rgb throughput, uint32_t trail);
    /// Widens rough lobes by so much, radian^2, as they reflect punctual lights (rsv_rough_widen): fewer sparks,
    /// blurred highlights; 0 = they stay as they are
    float widening;
    bool averages; ///< highlights smaller than a footprint become its mean (rsv_rough_find_turns)
    bool no_highlights; ///< punctual lights do not light the first surface, if it is rough
} rsv_camera_setting;

/// Called for each diffuse interface a camera ray leads to.
/// @param weight radiance at the camera per B / pi of the surface
typedef void (*rsv_diffuse_end)(void *user, const rsv_specular_path *path, rsv_rgb weight);

/// Follows all ideal branches that matter, deterministically. Branches fainter than 1 % survive by Russian roulette,
/// which is unbiased. Rough surfaces send one branch at random.
/// @param trail identifies the branches up to the specular path's surface; for a camera ray, its random number. Random
/// numbers depend
///             only on it, so specular paths may be followed in any order, or continued midway.
/// @param sample stratifies the random numbers of the first surface, if it is rough; NULL = only `trail`
/// @return radiance towards the camera emitted by surfaces on the way and by the environment
rsv_rgb rsv_camera_path(const rsv_camera_setting *setting, rsv_specular_path path, uint32_t trail,
    const rsv_pixel_sample *sample, rsv_diffuse_end end, void *user);

#endif
