/// The camera's surroundings, from six square pictures.
#include "view_frames.h"

#include "resolvent/frame.h"
#include "resolvent/image.h"

#include <math.h>
#include <stdlib.h>

enum { FACE = 512, FACES = 6, FACE_SAMPLES = 16, WIDTH = 2048, HEIGHT = 1024 };

/// Half the opening of a face, as a tangent: one pixel more than a right angle on each side.
static const float opening = (float)(FACE) / (FACE - 2);

static const float pi = 3.14159265f;

static rsv_vec3 cross(rsv_vec3 a, rsv_vec3 b)
{
    return (rsv_vec3){ a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x };
}

static float dot(rsv_vec3 a, rsv_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

static rsv_vec3 scaled(rsv_vec3 a, float s) { return (rsv_vec3){ a.x * s, a.y * s, a.z * s }; }

/// The camera, levelled: its heading stays, and the horizon is in the middle.
static rsv_camera level(const rsv_camera *camera)
{
    rsv_camera c = { .name = "panorama", .position = camera->position, .aspect = 1 };
    rsv_vec3 right = { camera->right.x, 0, camera->right.z };
    float length = sqrtf(dot(right, right));
    c.right = length > 0 ? scaled(right, 1 / length) : (rsv_vec3){ 1, 0, 0 };
    c.up = (rsv_vec3){ 0, 1, 0 };
    c.forward = cross(c.up, c.right);
    c.vertical_fov = 2 * atanf(opening);
    return c;
}

/// Ahead, right, behind, left, up, down.
static rsv_camera face_camera(const rsv_camera *level_camera, int face)
{
    rsv_camera c = *level_camera;
    rsv_vec3 f = c.forward, r = c.right, u = c.up;
    const rsv_vec3 forward[FACES] = { f, r, scaled(f, -1), scaled(r, -1), u, scaled(u, -1) };
    const rsv_vec3 up[FACES] = { u, u, u, u, scaled(f, -1), f };
    c.forward = forward[face];
    c.up = up[face];
    c.right = cross(c.forward, c.up);
    return c;
}

static rsv_status render_faces(const rsv_light *solution, const cli_view_state *state,
    const rsv_camera camera[FACES], rsv_rgb *radiance)
{
    rsv_frame_renderer *renderer = NULL;
    rsv_frame_desc desc = rsv_default_frame_desc();
    desc.width = desc.height = FACE;
    desc.gloss = RSV_GLOSS_PATHS;
    rsv_status status = rsv_frame_renderer_create(solution, &desc, &renderer);
    if (status == RSV_OK) rsv_frame_renderer_show(renderer, state->layer);
    for (int face = 0; face < FACES && status == RSV_OK; face++) {
        rsv_frame_view view = { .camera = { camera[face] } };
        for (int k = 0; k < FACE_SAMPLES && status == RSV_OK; k++)
            status = rsv_frame_render(renderer, &view, NULL);
        if (status == RSV_OK)
            rsv_frame_radiance(renderer, 0, radiance + (size_t)face * FACE * FACE);
    }
    rsv_frame_renderer_destroy(renderer);
    return status;
}

static rsv_rgb mix(rsv_rgb a, rsv_rgb b, float share)
{
    return (
        rsv_rgb){ a.r + share * (b.r - a.r), a.g + share * (b.g - a.g), a.b + share * (b.b - a.b) };
}

/// Between the four pixels around. @param x, y in -1 .. 1 of the right angle
static rsv_rgb look_up(const rsv_rgb *face, float x, float y)
{
    float column = 0.5f * (x / opening + 1) * FACE - 0.5f,
          row = 0.5f * (y / opening + 1) * FACE - 0.5f;
    int i = (int)fminf(fmaxf(column, 0), FACE - 2), j = (int)fminf(fmaxf(row, 0), FACE - 2);
    const rsv_rgb *at = face + (size_t)j * FACE + (size_t)i;
    float u = column - (float)i, v = row - (float)j;
    return mix(mix(at[0], at[1], u), mix(at[FACE], at[FACE + 1], u), v);
}

/// Looks a direction up in the face that it passes through.
static rsv_rgb radiance_along(
    const rsv_camera camera[FACES], const rsv_rgb *radiance, rsv_vec3 direction)
{
    int face = 0;
    for (int k = 1; k < FACES; k++)
        if (dot(direction, camera[k].forward) > dot(direction, camera[face].forward)) face = k;
    float depth = dot(direction, camera[face].forward);
    return look_up(radiance + (size_t)face * FACE * FACE,
        dot(direction, camera[face].right) / depth, -dot(direction, camera[face].up) / depth);
}

static void fill(const rsv_camera *ahead, const rsv_camera camera[FACES], const rsv_rgb *radiance,
    rsv_image *image)
{
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            float longitude = 2 * pi * ((float)x + 0.5f - 0.5f * WIDTH) / WIDTH;
            float latitude = pi * (0.5f * HEIGHT - (float)y - 0.5f) / HEIGHT;
            float f = cosf(latitude) * cosf(longitude), r = cosf(latitude) * sinf(longitude);
            rsv_vec3 direction = { f * ahead->forward.x + r * ahead->right.x, sinf(latitude),
                f * ahead->forward.z + r * ahead->right.z };
            rsv_image_pixels(image, 0)[(size_t)y * WIDTH + (size_t)x] =
                radiance_along(camera, radiance, direction);
        }
}

rsv_status cli_view_save_panorama(
    const rsv_light *solution, const cli_view_state *state, const char *path)
{
    rsv_context *context = rsv_scene_get_context(rsv_light_scene(solution));
    rsv_camera ahead = level(&state->camera), camera[FACES];
    rsv_image *image = NULL;
    rsv_rgb *radiance = malloc((size_t)FACES * FACE * FACE * sizeof *radiance);
    for (int face = 0; face < FACES; face++)
        camera[face] = face_camera(&ahead, face);
    rsv_status status = radiance ? RSV_OK : RSV_ERROR_MEMORY;
    if (status == RSV_OK) status = render_faces(solution, state, camera, radiance);
    if (status == RSV_OK) status = rsv_image_create(context, WIDTH, HEIGHT, 1, &image);
    if (status == RSV_OK) {
        fill(&ahead, camera, radiance, image);
        status = rsv_image_write(image, path, state->exposure);
    }
    rsv_image_destroy(image);
    free(radiance);
    return status;
}
