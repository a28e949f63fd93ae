#include "view_camera.h"

#include <math.h>

/// Cosine of the smallest angle to the vertical.
#define STEEPEST 0.9998f

static const float radians = 3.14159265f / 180;

static rsv_vec3 plus(rsv_vec3 a, float s, rsv_vec3 b)
{
    return (rsv_vec3){ a.x + s * b.x, a.y + s * b.y, a.z + s * b.z };
}

static float dot(rsv_vec3 a, rsv_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

static rsv_vec3 cross(rsv_vec3 a, rsv_vec3 b)
{
    return (rsv_vec3){ a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x };
}

static rsv_vec3 unit(rsv_vec3 a)
{
    float length = sqrtf(dot(a, a));
    return length > 0 ? plus((rsv_vec3){ 0 }, 1 / length, a) : a;
}

/// Rodrigues' formula. @param axis unit
static rsv_vec3 turned(rsv_vec3 a, rsv_vec3 axis, float angle)
{
    float c = cosf(angle), s = sinf(angle);
    rsv_vec3 sideways = cross(axis, a);
    return plus(plus(plus((rsv_vec3){ 0 }, c, a), s, sideways), (1 - c) * dot(axis, a), axis);
}

static void turn(rsv_camera *camera, rsv_vec3 axis, float angle)
{
    camera->forward = unit(turned(camera->forward, axis, angle));
    camera->right = turned(camera->right, axis, angle);
    camera->right =
        unit(plus(camera->right, -dot(camera->right, camera->forward), camera->forward));
    camera->up = cross(camera->right, camera->forward);
}

void cli_camera_look(rsv_camera *camera, float yaw, float pitch)
{
    rsv_camera pitched = *camera;
    turn(&pitched, camera->right, pitch * radians);
    bool past = fabsf(pitched.forward.y) > STEEPEST || pitched.up.y < 0;
    bool steeper = fabsf(pitched.forward.y) > fabsf(camera->forward.y);
    if (!past || !steeper) *camera = pitched;
    turn(camera, (rsv_vec3){ 0, 1, 0 }, yaw * radians);
}

void cli_camera_orbit(rsv_camera *camera, rsv_vec3 pivot, float yaw, float pitch)
{
    rsv_vec3 to = plus(pivot, -1, camera->position);
    float right = dot(to, camera->right), up = dot(to, camera->up),
          ahead = dot(to, camera->forward);
    cli_camera_look(camera, yaw, pitch);
    camera->position =
        plus(plus(plus(pivot, -right, camera->right), -up, camera->up), -ahead, camera->forward);
}

void cli_camera_fly(rsv_camera *camera, float right, float up, float forward)
{
    camera->position = plus(plus(plus(camera->position, right, camera->right), up, camera->up),
        forward, camera->forward);
}

void cli_camera_dolly(rsv_camera *camera, rsv_vec3 pivot, float factor)
{
    camera->vertical_extent *= factor;
    camera->position = plus(pivot, factor, plus(camera->position, -1, pivot));
}

/// Metres that half the picture's height spans at a depth.
static float half_height(const rsv_camera *camera, float depth)
{
    return camera->vertical_fov > 0 ? depth * tanf(0.5f * camera->vertical_fov)
                                    : camera->vertical_extent;
}

float cli_camera_project(const rsv_camera *camera, float aspect, rsv_vec3 point, float place[2])
{
    rsv_vec3 to = plus(point, -1, camera->position);
    float depth = dot(to, camera->forward), half = half_height(camera, depth);
    place[0] = 0.5f + 0.5f * dot(to, camera->right) / (half * aspect);
    place[1] = 0.5f - 0.5f * dot(to, camera->up) / half;
    return isfinite(place[0] + place[1]) ? depth : 0;
}

rsv_vec3 cli_camera_drag(const rsv_camera *camera, float aspect, float depth, float dx, float dy)
{
    float height = 2 * half_height(camera, depth);
    return plus(
        plus((rsv_vec3){ 0 }, dx * height * aspect, camera->right), -dy * height, camera->up);
}
