/// Whole camera paths of frames at rest that end as those of mode final do: with direct light sampled at diffuse
/// surfaces.
#ifndef RSV_FINAL_PATH_H
#define RSV_FINAL_PATH_H

#include "specular_light.h"

/// Adds all of a path to the pixel in hand, as one sample of mode final.
void rsv_add_final_path(rsv_specular_light *light, const rsv_specular_path *path);

#endif
