#include "camera_flight.h"

#include <math.h>
#include <string.h>

static const float pi = 3.14159265f;

/// Radians that the camera looks to either side.
static const float yaw = 0.35f;

static rsv_vec3 mad(rsv_vec3 a, float s, rsv_vec3 b)
{
    return (rsv_vec3){ a.x + s * b.x, a.y + s * b.y, a.z + s * b.z };
}

static float dot(rsv_vec3 a, rsv_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

static rsv_vec3 cross(rsv_vec3 a, rsv_vec3 b)
{
    return (rsv_vec3){ a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x };
}

static float diagonal(const rsv_scene_view *scene)
{
    rsv_vec3 extent = mad(scene->bounds_max, -1, scene->bounds_min);
    return sqrtf(dot(extent, extent));
}

/// Metres up to the first surface; `limit` if there is none before.
static float free_distance(
    const rsv_tracer *tracer, rsv_vec3 origin, rsv_vec3 direction, float limit)
{
    rsv_ray ray = { .origin = origin, .direction = direction, .t_max = limit };
    rsv_hit hit;
    return rsv_tracer_closest(tracer, &ray, &hit) ? hit.t : limit;
}

// ---- loops --------------------------------------------------------------------------------------

static rsv_camera on_loop(const cli_flight *flight, uint32_t station, float turn)
{
    rsv_camera c = flight->station[station].camera;
    float s = sinf(2 * pi * turn), angle = yaw * s;
    rsv_vec3 forward = c.forward, right = c.right;
    c.position = mad(
        c.position, flight->station[station].ahead * sinf(pi * turn) * sinf(pi * turn), forward);
    c.position = mad(c.position, flight->station[station].side * s, right);
    c.position = mad(c.position, flight->station[station].rise * sinf(4 * pi * turn), c.up);
    c.forward = mad(mad((rsv_vec3){ 0 }, cosf(angle), forward), sinf(angle), right);
    c.right = mad(mad((rsv_vec3){ 0 }, cosf(angle), right), -sinf(angle), forward);
    return c;
}

rsv_camera cli_flight_camera(const cli_flight *flight, uint32_t frame)
{
    uint32_t station = frame / cli_flight_loop % flight->station_count;
    return on_loop(flight, station, (float)(frame % cli_flight_loop) / cli_flight_loop);
}

/// Whether no surface lies across the loop, or nearer to it than `margin`.
static bool is_free(
    const cli_flight *flight, uint32_t station, const rsv_tracer *tracer, float margin)
{
    for (uint32_t k = 0; k < cli_flight_loop; k++) {
        rsv_vec3 here = on_loop(flight, station, (float)k / cli_flight_loop).position;
        rsv_vec3 next = on_loop(flight, station, (float)(k + 1) / cli_flight_loop).position;
        rsv_ray step = { .origin = here, .direction = mad(next, -1, here), .t_max = 1 };
        rsv_hit hit;
        if (rsv_tracer_occluded(tracer, &step)) return false;
        if (rsv_tracer_nearest(tracer, here, step.direction, &hit) && hit.t < margin) return false;
    }
    return true;
}

/// Sets the extent of the loop, as shares of the free distance in each direction.
static void spread_loop(cli_flight *flight, uint32_t station, const rsv_tracer *tracer)
{
    const rsv_camera *c = &flight->station[station].camera;
    float limit = 0.5f * diagonal(rsv_scene_get_view(rsv_tracer_scene(tracer)));
    rsv_vec3 zero = { 0 };
    float ahead = free_distance(tracer, c->position, c->forward, limit);
    float side = fminf(free_distance(tracer, c->position, c->right, ahead),
        free_distance(tracer, c->position, mad(zero, -1, c->right), ahead));
    float rise = fminf(free_distance(tracer, c->position, c->up, ahead),
        free_distance(tracer, c->position, mad(zero, -1, c->up), ahead));
    float share = 0.3f;
    for (int k = 0; k < 6; k++, share *= 0.5f) {
        flight->station[station].ahead = share * ahead;
        flight->station[station].side = 0.5f * share * side;
        flight->station[station].rise = 0.25f * share * rise;
        if (is_free(flight, station, tracer, 0.02f * share * ahead)) return;
    }
    flight->station[station].ahead = flight->station[station].side = 0;
    flight->station[station].rise = 0;
}

// ---- scenes without a camera --------------------------------------------------------------------

/// Whether the ray ends on the front of a surface, as it does on the walls of a room and not inside a body.
static bool meets_front(const rsv_tracer *tracer, const rsv_ray *ray, float *distance)
{
    const rsv_scene_view *scene = rsv_scene_get_view(rsv_tracer_scene(tracer));
    rsv_hit hit;
    if (!rsv_tracer_closest(tracer, ray, &hit)) return false;
    const uint32_t *corner = scene->triangle[hit.triangle];
    rsv_vec3 a = scene->position[corner[0]];
    rsv_vec3 normal =
        cross(mad(scene->position[corner[1]], -1, a), mad(scene->position[corner[2]], -1, a));
    *distance = hit.t;
    return dot(normal, ray->direction) < 0;
}

/// Metres to the nearest surface around a point inside a room; 0 outside and in bodies.
/// @param view out: the level direction in which most is free
static float open_space(const rsv_tracer *tracer, rsv_vec3 point, rsv_vec3 *view)
{
    float nearest = INFINITY, farthest = 0;
    int fronts = 0, rays = 0;
    for (int pitch = -1; pitch <= 1; pitch++)
        for (int k = 0; k < 8; k++, rays++) {
            float turn = 0.25f * pi * (float)k, level = pitch ? 0.7071f : 1, distance = INFINITY;
            rsv_vec3 d = { level * cosf(turn), 0.7071f * (float)pitch, level * sinf(turn) };
            rsv_ray ray = { .origin = point, .direction = d, .t_max = INFINITY };
            fronts += meets_front(tracer, &ray, &distance);
            nearest = fminf(nearest, distance);
            if (pitch || !(distance > farthest) || isinf(distance)) continue;
            farthest = distance;
            *view = d;
        }
    return fronts >= 0.8 * rays ? nearest : 0;
}

/// Puts the camera inside a room that has none, if it is one.
static void step_inside(const rsv_tracer *tracer, rsv_camera *camera)
{
    enum { places = 5 };
    const rsv_scene_view *scene = rsv_scene_get_view(rsv_tracer_scene(tracer));
    rsv_vec3 low = scene->bounds_min, extent = mad(scene->bounds_max, -1, low), view = { 0 };
    float best = 0;
    for (int k = 0; k < places * places * places; k++) {
        float x = (float)(k % places + 1) / (places + 1);
        float y = (float)(k / places % places + 1) / (places + 1);
        float z = (float)(k / places / places + 1) / (places + 1);
        rsv_vec3 point = { low.x + x * extent.x, low.y + y * extent.y, low.z + z * extent.z };
        float space = open_space(tracer, point, &view);
        if (!(space > best)) continue;
        best = space;
        *camera =
            rsv_camera_look_at("inside", point, mad(point, 1, view), 60 * pi / 180, camera->aspect);
    }
}

rsv_status cli_flight_plan(const rsv_scene *scene, cli_flight *flight)
{
    const rsv_scene_view *view = rsv_scene_get_view(scene);
    const size_t most = sizeof flight->station / sizeof *flight->station;
    rsv_tracer *tracer = NULL;
    rsv_status status = rsv_tracer_create(scene, &tracer);
    if (status != RSV_OK) return status;
    flight->station_count = (uint32_t)(view->camera_count < most ? view->camera_count : most);
    for (uint32_t k = 0; k < flight->station_count; k++) {
        rsv_camera *camera = &flight->station[k].camera;
        *camera = view->camera[k];
        if (camera->name && strcmp(camera->name, "framing") == 0) step_inside(tracer, camera);
        spread_loop(flight, k, tracer);
    }
    rsv_tracer_destroy(tracer);
    return RSV_OK;
}
