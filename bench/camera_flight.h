/// A camera that flies through a scene, the same way every time.
#ifndef CLI_CAMERA_FLIGHT_H
#define CLI_CAMERA_FLIGHT_H

#include "resolvent/trace.h"

/// A loop about each camera of a scene in turn: ahead, to both sides, up and down, looking around; never through
/// a surface.
typedef struct cli_flight {
    struct {
        rsv_camera camera;
        float ahead, side, rise; ///< metres at most
    } station[8];
    uint32_t station_count;
} cli_flight;

/// Frames that one loop takes: a cut to the next camera follows.
enum { cli_flight_loop = 120 };

/// From the scene's cameras. A scene without any is seen from the most open place inside, where walls surround it, or
/// else as a whole from outside.
rsv_status cli_flight_plan(const rsv_scene *scene, cli_flight *flight);

/// Where the camera is in a frame; in frame 0, where the scene has its first one.
rsv_camera cli_flight_camera(const cli_flight *flight, uint32_t frame);

#endif
