/// Solved light for a camera ray of a picture: stored, gathered once more, or left to its pixel.
#ifndef RSV_PICTURE_SHADE_H
#define RSV_PICTURE_SHADE_H

#include "picture_row.h"

/// Adds radiance to the picture and, if requested, to the layer of its order: 0 = emission, 1 = direct.
void rsv_picture_add_light(rsv_picture_row *row, uint32_t column, uint32_t order, rsv_rgb radiance);

/// A diffuse surface seen by the camera: callback of rsv_camera_path. @param user the rsv_picture_row
void rsv_picture_shade(void *user, const rsv_specular_path *path, rsv_rgb weight);

/// Gathers indirect light at a point in the fog: gather rays in uniform directions.
/// @param weight radiance at the camera per radiance averaged over all directions
void rsv_picture_gather_in_fog(
    rsv_picture_row *row, rsv_vec3 place, rsv_rgb weight, rsv_random *random);

#endif
