/// A gallery: rooms in a row, each with pictures under spotlights, a niche, a plinth and a panel in the ceiling; a
/// doorway leads on to the next. Light of every room reaches its neighbours, and little of it the room after those.
#include "../core/sampling.h"
#include "builtin.h"

#define LENGTH 6.0f // of a room, x
#define DEPTH 5.0f  // z
#define HEIGHT 3.6f
#define WALL 0.2f
#define DOOR_WIDTH 1.6f
#define DOOR_HEIGHT 2.6f
#define NICHE_WIDTH 1.2f
#define NICHE_DEPTH 0.5f
#define NICHE_BOTTOM 0.8f
#define NICHE_TOP 2.4f
#define SUNK 0.02f // how far walls reach into floor and ceiling
#define PICTURES 3 // on the long wall of a room
#define PAINTS 5

typedef struct gallery {
    rsv_scene *scene;
    uint32_t plaster, boards, wood, stone;
    uint32_t panel[2]; ///< warm and cold light
    uint32_t paint[PAINTS];
} gallery;

static rsv_status add_materials(gallery *g)
{
    static const rsv_rgb paint[PAINTS] = { { 0.55f, 0.1f, 0.08f }, { 0.08f, 0.2f, 0.5f },
        { 0.7f, 0.55f, 0.12f }, { 0.1f, 0.38f, 0.2f }, { 0.6f, 0.57f, 0.5f } };
    rsv_scene *s = g->scene;
    rsv_status status;
    RSV_TRY(rsv_add_lambert(s, "plaster", rgb(0.78f, 0.77f, 0.74f), rgb_gray(0), &g->plaster));
    RSV_TRY(rsv_add_lambert(s, "boards", rgb(0.38f, 0.27f, 0.18f), rgb_gray(0), &g->boards));
    RSV_TRY(rsv_add_lambert(s, "wood", rgb(0.3f, 0.2f, 0.1f), rgb_gray(0), &g->wood));
    RSV_TRY(rsv_add_lambert(s, "stone", rgb(0.6f, 0.6f, 0.58f), rgb_gray(0), &g->stone));
    RSV_TRY(rsv_add_lambert(s, "warm panel", rgb_gray(0), rgb(11, 9, 6.5f), &g->panel[0]));
    RSV_TRY(rsv_add_lambert(s, "cold panel", rgb_gray(0), rgb(7.5f, 9, 11), &g->panel[1]));
    for (int k = 0; k < PAINTS; k++)
        RSV_TRY(rsv_add_lambert(s, "paint", paint[k], rgb_gray(0), &g->paint[k]));
cleanup:
    return status;
}

static rsv_status add_box(
    const gallery *g, const char *name, uint32_t material, rsv_vec3 low, rsv_vec3 high)
{
    return rsv_add_box((rsv_shape){ g->scene, name, material, NULL }, low, high);
}

/// Floor and ceiling of the whole gallery, a little beyond its walls, and its long wall at the back.
static rsv_status add_shell(const gallery *g, float end)
{
    rsv_status status;
    const float beyond = WALL + SUNK, left = -beyond, right = end + beyond;
    const float back = -beyond, front = DEPTH + NICHE_DEPTH + beyond, top = HEIGHT + WALL;
    RSV_TRY(add_box(g, "floor", g->boards, v3(left, -WALL, back), v3(right, 0, front)));
    RSV_TRY(add_box(g, "ceiling", g->plaster, v3(left, HEIGHT, back), v3(right, top, front)));
    RSV_TRY(add_box(
        g, "long wall", g->plaster, v3(-WALL, -SUNK, -WALL), v3(end + WALL, HEIGHT + SUNK, 0)));
cleanup:
    return status;
}

/// Across the gallery at x, with or without a doorway in the middle.
static rsv_status add_cross_wall(const gallery *g, float x, bool doorway)
{
    rsv_status status;
    const float left = x - WALL / 2, right = x + WALL / 2, low = -SUNK, top = HEIGHT + SUNK;
    const float door = DEPTH / 2 - DOOR_WIDTH / 2, end = DEPTH + SUNK;
    if (!doorway)
        return add_box(g, "end wall", g->plaster, v3(left, low, -SUNK), v3(right, top, end));
    RSV_TRY(add_box(g, "wall by the door", g->plaster, v3(left, low, -SUNK), v3(right, top, door)));
    RSV_TRY(add_box(
        g, "wall by the door", g->plaster, v3(left, low, door + DOOR_WIDTH), v3(right, top, end)));
    RSV_TRY(add_box(
        g, "lintel", g->plaster, v3(left, DOOR_HEIGHT, door), v3(right, top, door + DOOR_WIDTH)));
cleanup:
    return status;
}

/// The wall by the viewer, with a niche in the middle of the room.
static rsv_status add_niche_wall(const gallery *g, float x)
{
    rsv_status status;
    const float low = -SUNK, top = HEIGHT + SUNK, near = DEPTH, far = DEPTH + NICHE_DEPTH;
    const float left = x + (LENGTH - NICHE_WIDTH) / 2, right = left + NICHE_WIDTH;
    RSV_TRY(add_box(g, "niche wall", g->plaster, v3(x, low, near), v3(left, top, far)));
    RSV_TRY(add_box(g, "niche wall", g->plaster, v3(right, low, near), v3(x + LENGTH, top, far)));
    RSV_TRY(add_box(g, "niche sill", g->stone, v3(left, low, near), v3(right, NICHE_BOTTOM, far)));
    RSV_TRY(add_box(g, "niche head", g->plaster, v3(left, NICHE_TOP, near), v3(right, top, far)));
    RSV_TRY(add_box(g, "niche back", g->stone, v3(x, low, far), v3(x + LENGTH, top, far + WALL)));
cleanup:
    return status;
}

/// A canvas in its frame on the long wall, and the spotlight above it.
static rsv_status add_picture(const gallery *g, float x, uint32_t number)
{
    rsv_status status;
    const float half = 0.45f + 0.02f * (float)(rsv_hash(number) % 8), bottom = 1.15f, top = 2.05f;
    const float border = 0.06f, thickness = 0.04f;
    RSV_TRY(add_box(g, "frame", g->wood, v3(x - half - border, bottom - border, -SUNK),
        v3(x + half + border, top + border, thickness)));
    RSV_TRY(add_box(g, "canvas", g->paint[number % PAINTS], v3(x - half, bottom, 0),
        v3(x + half, top, thickness + 0.005f)));
    rsv_vec3 lamp = v3(x, HEIGHT - 0.15f, 1.2f);
    rsv_punctual_light spot = { .name = "spotlight",
        .kind = RSV_PUNCTUAL_SPOT,
        .position = lamp,
        .direction = v3_normalize(v3_sub(v3(x, (bottom + top) / 2, 0), lamp)),
        .intensity = { 14, 13, 11 },
        .inner_cone_angle = 14 * RSV_PI / 180,
        .outer_cone_angle = 24 * RSV_PI / 180 };
    RSV_TRY(rsv_scene_add_light(g->scene, &spot));
cleanup:
    return status;
}

static rsv_status add_ceiling_panel(const gallery *g, float x, uint32_t room)
{
    const float y = HEIGHT - 0.005f, near = 0.65f * DEPTH, far = 0.45f * DEPTH;
    const rsv_vec3 corner[4] = { { x - 0.6f, y, near }, { x - 0.6f, y, far }, { x + 0.6f, y, far },
        { x + 0.6f, y, near } };
    return rsv_add_quad((rsv_shape){ g->scene, "panel", g->panel[room % 2], NULL }, corner);
}

static rsv_status add_room(const gallery *g, uint32_t room, uint32_t rooms)
{
    rsv_status status;
    const float x = (float)room * LENGTH, middle = x + LENGTH / 2, gap = 1e-4f;
    RSV_TRY(add_cross_wall(g, x, room > 0));
    if (room + 1 == rooms) RSV_TRY(add_cross_wall(g, x + LENGTH, false));
    RSV_TRY(add_niche_wall(g, x));
    for (uint32_t k = 0; k < PICTURES; k++)
        RSV_TRY(add_picture(g, x + LENGTH * ((float)k + 0.5f) / PICTURES, PICTURES * room + k));
    RSV_TRY(add_ceiling_panel(g, middle, room));
    RSV_TRY(
        add_box(g, "plinth", g->stone, v3(middle - 0.25f, gap, 3.7f), v3(middle + 0.25f, 1, 4.2f)));
    RSV_TRY(rsv_add_sphere((rsv_shape){ g->scene, "sphere", g->paint[room % PAINTS], NULL },
        v3(middle, 1.25f + gap, 3.95f), 0.25f, 3));
cleanup:
    return status;
}

rsv_status rsv_build_gallery(rsv_scene *scene, double rooms)
{
    rsv_status status;
    gallery g = { .scene = scene };
    RSV_TRY(add_materials(&g));
    RSV_TRY(add_shell(&g, (float)rooms * LENGTH));
    for (uint32_t room = 0; room < (uint32_t)rooms; room++)
        RSV_TRY(add_room(&g, room, (uint32_t)rooms));
    rsv_camera camera = rsv_camera_look_at(
        "entrance", v3(0.4f, 1.6f, 4.6f), v3(6, 1.4f, 1.6f), 55 * RSV_PI / 180, 16.0f / 9);
    RSV_TRY(rsv_scene_add_camera(scene, &camera));
cleanup:
    return status;
}
