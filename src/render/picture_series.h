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

/// One of the pictures.
/// @param desc may differ from that at creation in samples, noise, gather rays, layers and seed; with a count, the mean of it
/// as samples, without noise and shared pattern
/// @param count [height * width] camera rays of each pixel, borrowed; one with none is not to be used. NULL: as many in all
rsv_status rsv_picture_series_take(const rsv_picture_series *series, const rsv_render_desc *desc,
    const uint32_t *count, rsv_image **image);

#endif
