/// How a camera is led by hand. Angles in degrees, lengths in metres; a picture's width and height are 1.
#ifndef CLI_VIEW_CAMERA_H
#define CLI_VIEW_CAMERA_H

#include "resolvent/scene.h"

/// Turns about where the camera stands: to the left and upwards, never past the zenith.
void cli_camera_look(rsv_camera *camera, float yaw, float pitch);

/// Turns about `pivot`, which stays where it is in the picture.
void cli_camera_orbit(rsv_camera *camera, rsv_vec3 pivot, float yaw, float pitch);

void cli_camera_fly(rsv_camera *camera, float right, float up, float forward);

/// Brings `pivot` nearer by `factor` (a half = twice as large).
void cli_camera_dolly(rsv_camera *camera, rsv_vec3 pivot, float factor);

/// Where a point is seen. @param aspect width / height of the picture @param place x to the right, y down
/// @return metres in front of the camera; 0 or less = not seen
float cli_camera_project(const rsv_camera *camera, float aspect, rsv_vec3 point, float place[2]);

/// By how much a point at `depth` moves, parallel to the picture, where it is dragged across it by (dx, dy).
rsv_vec3 cli_camera_drag(const rsv_camera *camera, float aspect, float depth, float dx, float dy);

#endif
