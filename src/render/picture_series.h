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

/// What light gather rays bring.
typedef enum rsv_gathered {
    /// Indirect light, if the description has gather rays. What elements store of light from sources (that no shadow
    /// ray finds) is looked up, with the elements' error.
    RSV_GATHERED_INDIRECT,
    /// That light too, except caustics that no gather ray can find and light in fog: noisier, but without that error
    RSV_GATHERED_ALL
} rsv_gathered;

/// One of the pictures. All zero: one like any other.
typedef struct rsv_picture_pass {
    /// [height * width] camera rays of each pixel, borrowed; NULL: the same number in all
    const uint32_t *count;
    /// [height * width] 1 for pixels that gather, borrowed; NULL = all
    const uint8_t *where;
    rsv_gathered gathered;
    /// Every other one of the camera rays: two halves make one stratified picture
    bool is_half;
    /// Which one: 0, the larger of odd numbers, or 1
    uint32_t half;
    /// Gather rays of each half have a pattern of their own: independent noise, as comparisons need; the mean is noisier
    bool is_alone;
} rsv_picture_pass;

/// Renders one of the pictures.
/// @param desc may differ from that at creation in samples, noise, gather rays, layers and seed; with a count, its mean
/// as samples, without noise and shared pattern. Pixels without samples must not be used
/// @param pass NULL = all zero
rsv_status rsv_picture_series_take(const rsv_picture_series *series, const rsv_render_desc *desc,
    const rsv_picture_pass *pass, rsv_image **image);

/// Marks pixels that outlines cross (outlines.h).
/// @param picture of the series; it may be noisy @param is_outline [height * width] out
rsv_status rsv_picture_series_find_outlines(
    const rsv_picture_series *series, const rsv_image *picture, uint8_t *is_outline);

/// Whether such pictures have caustics from elements too.
bool rsv_picture_series_keeps_caustics(const rsv_picture_series *series);

#endif
