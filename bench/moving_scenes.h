/// Scenes of `resolvent bench moving` other than the built-in ones, and the moving objects of each scene.
#ifndef CLI_MOVING_SCENES_H
#define CLI_MOVING_SCENES_H

#include "resolvent/scene.h"

/// A lit room with a moving object. @param name turning-mirror, lamp-shade or falling-boxes
/// @return RSV_ERROR_ARGUMENT for other names
rsv_status cli_build_moving_scene(rsv_context *context, const char *name, rsv_scene **scene);

/// How objects move. All objects of the name move in the same way, except for how far they fall.
typedef struct cli_motion {
    const char *scene; ///< a scene's name, or the end of a file's path
    const char *object;
    float axis[2];  ///< x, z of the upright axis of turns
    float turns[2]; ///< radians at first and in the end
    rsv_vec3 shift; ///< metres in the end
    bool rolls;     ///< turns as it rolls along x
    float
        fall; ///< metres that it falls in the end, faster and faster, or until it lies at height 0
} cli_motion;

/// The motion of a scene. NULL = none is defined
const cli_motion *cli_find_motion(const char *scene);

/// Where an object is after a part of its motion.
rsv_motion cli_motion_at(
    const cli_motion *motion, const rsv_scene *scene, uint32_t object, float share);

#endif
