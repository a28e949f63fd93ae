/// Camera rays of pictures that are more than a pinhole's: with depth of field, a shifted film, or all directions
/// around.
#ifndef RSV_FILM_H
#define RSV_FILM_H

#include "camera_ray.h"

typedef struct rsv_film {
    rsv_lens lens;
    rsv_projection projection;
    float radius;   ///< of the aperture, metres; 0 = a pinhole
    float focus;    ///< metres along the axis
    float shift[2]; ///< pixels
} rsv_film;

/// RSV_ERROR_ARGUMENT for values that no camera has.
rsv_status rsv_film_check(const rsv_film_desc *desc, const rsv_camera *camera);

/// @param tracer finds the distance in focus if the description does not give it
rsv_film rsv_film_of(const rsv_tracer *tracer, const rsv_film_desc *desc, const rsv_camera *camera,
    uint32_t width, uint32_t height);

/// The ray of a place in the picture through a place of the aperture. A pinhole's is that of rsv_lens_ray.
/// @param x, y in pixels @param u, v in 0 .. 1, uniform over the aperture
/// @return false = nothing is seen there: the picture is black
bool rsv_film_ray(const rsv_film *film, float x, float y, const float uv[2], rsv_ray *ray);

/// The angle that a pixel sees, radians, as rsv_camera_spread.
float rsv_film_spread(const rsv_film *film);

/// Whether all rays leave one point for a planar picture, which rsv_lens_see can invert.
static inline bool rsv_film_is_plain(const rsv_film_desc *desc)
{
    return desc->projection == RSV_PROJECTION_CAMERA && desc->f_number == 0 &&
           desc->shift[0] == 0 && desc->shift[1] == 0;
}

#endif
