/// Pictures of one light from one camera, modes operator and final. What they have in common is found once: where rough
/// surfaces see the sky, and guides for the light that is shot at matt coats.
#ifndef RSV_PICTURE_SERIES_H
#define RSV_PICTURE_SERIES_H

#include "resolvent/render.h"

typedef struct rsv_picture_series rsv_picture_series;

/// @param light borrowed, as desc->viewpoint is
rsv_status rsv_picture_series_create(
    const rsv_light *light, const rsv_render_desc *desc, rsv_picture_series **series);
/// @param series NULL is allowed
void rsv_picture_series_destroy(rsv_picture_series *series);

/// One of the pictures. @param desc may differ from that at creation in samples, noise, gather rays, layers and seed
rsv_status rsv_picture_series_take(
    const rsv_picture_series *series, const rsv_render_desc *desc, rsv_image **image);

/// The same with a number of camera rays for each pixel; one with none is not to be used.
/// @param desc with their mean as samples, without noise and shared pattern @param count [height * width] borrowed
rsv_status rsv_picture_series_take_uneven(const rsv_picture_series *series,
    const rsv_render_desc *desc, const uint32_t *count, rsv_image **image);

#endif
