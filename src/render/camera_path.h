/// From the camera through mirrors and glass to every diffuse surface it sees: `C S* D`.
#ifndef RSV_CAMERA_PATH_H
#define RSV_CAMERA_PATH_H

#include "../sources/lights.h"
#include "../specular/specular_path.h"
#include "camera_step.h"
#include "pixel_sample.h"
#include "sky_visibility.h"

/// Specular events along a branch that are enough for any picture but of closed rooms of mirrors: branches of pictures that
/// go on after these play roulette.
#define RSV_CAMERA_PATH_DEPTH 64

/// What the specular paths of one picture have in common.
typedef struct rsv_camera_setting {
    const rsv_transport_scene *scene;
    const rsv_lights *lights;
    const rsv_sky_visibility *visibility; ///< of rough surfaces; NULL = not known
    uint32_t max_events;                  ///< specular ones along a branch at most
    bool shot;                            ///< leave out what rsv_shot_light_add adds
    /// Called for each segment through fog that leads on to a surface or out of the scene, from the second one on; adds what
    /// it scatters. NULL = the air is clear. @param throughput of the path up to it @param trail names it
    /// @return what the segment lets pass
    rsv_rgb (*cross_fog)(void *user, const rsv_ray *segment, rsv_rgb throughput, uint32_t trail);
    /// Widens rough lobes by so much, radian^2, as they reflect punctual lights (rsv_rough_widen): fewer sparks, blurred
    /// highlights; 0 = they stay as they are
    float widening;
} rsv_camera_setting;

/// Called for each diffuse interface a camera ray leads to.
/// @param weight radiance at the camera per B / pi of the surface
typedef void (*rsv_diffuse_end)(void *user, const rsv_specular_path *path, rsv_rgb weight);

/// Follows all ideal branches that matter, deterministically; branches fainter than one part in a hundred
/// survive by roulette, so that nothing is lost on average. Rough surfaces send on one branch at random.
/// @param trail names the branches that led to the specular path's surface; of a camera ray, its random number. What is
///             drawn depends on it alone, so a specular path may be followed in any order, or be continued midway.
/// @param sample stratifies what the first surface draws, if it is rough; NULL = `trail` alone
/// @return radiance towards the camera emitted by the surfaces on the way and by the surroundings
rsv_rgb rsv_camera_path(const rsv_camera_setting *setting, rsv_specular_path path, uint32_t trail,
    const rsv_pixel_sample *sample, rsv_diffuse_end end, void *user);

#endif
