#include "film.h"

#include "../core/core.h"
#include "../core/sampling.h"

/// Half the height of the film that an f-number is about: 24 x 36 mm, as photographers count.
#define HALF_FILM 0.012f
#define FAR_AWAY 1e6f ///< metres: what is in focus where nothing is

static bool is_finite(rsv_vec3 a) { return isfinite(a.x + a.y + a.z); }

rsv_status rsv_film_check(const rsv_film_desc *d, const rsv_camera *camera)
{
    if (!is_finite(camera->position) || !is_finite(camera->right) || !is_finite(camera->up) ||
        !is_finite(camera->forward) || !isfinite(camera->vertical_fov + camera->vertical_extent))
        return rsv_fail(RSV_ERROR_ARGUMENT, "film: the camera is not finite");
    if ((unsigned)d->projection > RSV_PROJECTION_FISHEYE)
        return rsv_fail(
            RSV_ERROR_ARGUMENT, "film: projection %d does not exist", (int)d->projection);
    if (!(d->f_number >= 0) || !isfinite(d->f_number) || !(d->focus_distance >= 0) ||
        !isfinite(d->focus_distance))
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "film: an f-number of %g and a focus at %g m are not possible", (double)d->f_number,
            (double)d->focus_distance);
    if (!(fabsf(d->shift[0]) <= 1e3f) || !(fabsf(d->shift[1]) <= 1e3f))
        return rsv_fail(RSV_ERROR_ARGUMENT, "film: a shift by (%g, %g) pictures is not possible",
            (double)d->shift[0], (double)d->shift[1]);
    bool is_flat = d->projection == RSV_PROJECTION_CAMERA && camera->vertical_fov > 0;
    if (d->f_number > 0 && !is_flat)
        return rsv_fail(RSV_ERROR_ARGUMENT,
            "film: depth of field needs a perspective camera; leave out the f-number");
    if ((d->shift[0] != 0 || d->shift[1] != 0) && d->projection != RSV_PROJECTION_CAMERA)
        return rsv_fail(RSV_ERROR_ARGUMENT, "film: pictures of all directions cannot be shifted");
    return RSV_OK;
}

/// Distance of what is at the centre of the picture, metres.
static float find_focus(const rsv_tracer *tracer, const rsv_lens *lens)
{
    const rsv_ray ahead = rsv_lens_ray(lens, lens->half_width, lens->half_height);
    rsv_hit hit;
    return rsv_tracer_closest(tracer, &ahead, &hit) ? hit.t : FAR_AWAY;
}

rsv_film rsv_film_of(const rsv_tracer *tracer, const rsv_film_desc *d, const rsv_camera *camera,
    uint32_t width, uint32_t height)
{
    rsv_film film = { .lens = rsv_lens_of(camera, width, height),
        .projection = d->projection,
        .shift = { d->shift[0] * (float)width, d->shift[1] * (float)height } };
    if (d->f_number == 0) return film;
    float focal_length = HALF_FILM / tanf(0.5f * camera->vertical_fov);
    film.radius = focal_length / (2 * d->f_number);
    film.focus = d->focus_distance > 0 ? d->focus_distance : find_focus(tracer, &film.lens);
    return film;
}

static rsv_vec3 direction_of(const rsv_camera *c, float right, float up, float forward)
{
    return v3_mad(v3_mad(v3_scale(c->forward, forward), right, c->right), up, c->up);
}

/// All directions: longitude along rows, ahead in the middle; latitude along columns.
static rsv_vec3 equirectangular(const rsv_lens *lens, float x, float y)
{
    float longitude = RSV_PI * (x / lens->half_width - 1);
    float latitude = 0.5f * RSV_PI * (1 - y / lens->half_height);
    return direction_of(&lens->camera, cosf(latitude) * sinf(longitude), sinf(latitude),
        cosf(latitude) * cosf(longitude));
}

/// Equidistant: angles off the axis grow evenly, to 90 degrees at the nearer edge of the picture.
/// @return false = outside of the circle
static bool fisheye(const rsv_lens *lens, float x, float y, rsv_vec3 *direction)
{
    float radius = f_min(lens->half_width, lens->half_height);
    float across = (x - lens->half_width) / radius, up = (lens->half_height - y) / radius;
    float r = sqrtf(across * across + up * up), angle = 0.5f * RSV_PI * r;
    if (r > 1) return false;
    float scale = r > 0 ? sinf(angle) / r : 0;
    *direction = direction_of(&lens->camera, across * scale, up * scale, cosf(angle));
    return true;
}

/// Lets a ray leave another place of the aperture for the same point in focus.
static void defocus(const rsv_film *film, const float uv[2], rsv_ray *ray)
{
    const rsv_camera *c = &film->lens.camera;
    float dx, dy;
    rsv_square_to_disk(uv[0], uv[1], &dx, &dy);
    float along = film->focus / v3_dot(ray->direction, c->forward);
    rsv_vec3 target = v3_mad(ray->origin, along, ray->direction);
    ray->origin =
        v3_mad(v3_mad(ray->origin, film->radius * dx, c->right), film->radius * dy, c->up);
    ray->direction = v3_normalize(v3_sub(target, ray->origin));
}

bool rsv_film_ray(const rsv_film *film, float x, float y, const float uv[2], rsv_ray *ray)
{
    bool sees = true;
    *ray = rsv_lens_ray(&film->lens, x + film->shift[0], y - film->shift[1]);
    if (film->projection == RSV_PROJECTION_CAMERA) {
        if (film->radius > 0) defocus(film, uv, ray);
        return true;
    }
    ray->origin = film->lens.camera.position;
    if (film->projection == RSV_PROJECTION_EQUIRECTANGULAR)
        ray->direction = equirectangular(&film->lens, x, y);
    else
        sees = fisheye(&film->lens, x, y, &ray->direction);
    ray->direction = v3_normalize(ray->direction);
    return sees;
}

float rsv_film_spread(const rsv_film *film)
{
    const rsv_lens *lens = &film->lens;
    if (film->projection == RSV_PROJECTION_CAMERA)
        return rsv_camera_spread(&lens->camera, (uint32_t)(2 * lens->half_height));
    if (film->projection == RSV_PROJECTION_EQUIRECTANGULAR)
        return 0.5f * RSV_PI / lens->half_height;
    return 0.5f * RSV_PI / f_min(lens->half_width, lens->half_height);
}
