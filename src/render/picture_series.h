/// Pictures of one light from one camera, modes operator and final. Their common data is computed once: where rough
/// surfaces see the sky, and guides for light paths towards matt coats.
#ifndef RSV_PICTURE_SERIES_H
#define RSV_PICTURE_SERIES_H

#include "resolvent/render.h"

typedef struct rsv_picture_series rsv_picture_series;

/// @param light borrowed, as desc->viewpoint is
rsv_status rsv_picture_series_create(
    const rsv_light *light, const rsv_render_desc *desc, rsv_picture_series **series);
/// @param series NULL is allowed
void rsv_picture_series_destroy(rsv_picture_series *series);

/// Renders one of the pictures.
/// @param desc may differ from that at creation in samples, noise, gather rays, layers and seed; with a count, its mean
/// as samples, without noise and shared pattern
/// @param count [height * width] camera rays of each pixel, borrowed; pixels without any must not be used. NULL: the
/// same number in all
rsv_status rsv_picture_series_take(const rsv_picture_series *series, const rsv_render_desc *desc,
    const uint32_t *count, rsv_image **image);

/// The same with gather rays that bring all light of sources too that elements store, except caustics that no gather
/// ray can find and light in fog: noisier, but without the elements' error in it.
/// @param where [height * width] 1 for pixels that gather, 0 for those that look light up; NULL = all gather
rsv_status rsv_picture_series_take_gathered(const rsv_picture_series *series,
    const rsv_render_desc *desc, const uint32_t *count, const uint8_t *where, rsv_image **image);

/// Marks pixels that outlines cross (outlines.h).
/// @param picture of the series; it may be noisy @param is_outline [height * width] out
rsv_status rsv_picture_series_find_outlines(
    const rsv_picture_series *series, const rsv_image *picture, uint8_t *is_outline);

/// Whether such pictures have caustics from elements too.
bool rsv_picture_series_keeps_caustics(const rsv_picture_series *series);

#endif
