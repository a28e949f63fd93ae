/// Two closed rooms with a thin wall between them and a door ajar. There is light only in the right room, and the
/// camera is in the left one. Floor, ceiling and long walls continue under the partition, and the partition cuts
/// through them: the classic test for light leaks.
#include "builtin.h"

#define HEIGHT 2.8f
#define HALF_DEPTH 1.5f   // z
#define HALF_LENGTH 4.05f // x: a room is 4 m long
#define HALF_WALL 0.05f
#define SUNK 0.02f // how far the partition reaches into floor, ceiling and walls
#define DOOR_HALF_WIDTH 0.45f
#define DOOR_HEIGHT 2.1f
#define DOOR_ANGLE (25 * RSV_PI / 180)

static rsv_status add_partition(rsv_scene *scene, uint32_t material)
{
    const float x = HALF_WALL, z = HALF_DEPTH + SUNK, top = HEIGHT + SUNK;
    rsv_status status;
    RSV_TRY(rsv_add_box((rsv_shape){ scene, "partition by the hinge", material, NULL },
        v3(-x, -SUNK, -z), v3(x, top, -DOOR_HALF_WIDTH)));
    RSV_TRY(rsv_add_box((rsv_shape){ scene, "partition by the latch", material, NULL },
        v3(-x, -SUNK, DOOR_HALF_WIDTH), v3(x, top, z)));
    RSV_TRY(rsv_add_box((rsv_shape){ scene, "lintel", material, NULL },
        v3(-x, DOOR_HEIGHT, -DOOR_HALF_WIDTH), v3(x, top, DOOR_HALF_WIDTH)));
cleanup:
    return status;
}

/// A slab that hangs in the doorway with a gap of 1 cm and opens into the left room.
static rsv_status add_door(rsv_scene *scene, uint32_t material)
{
    const float c = cosf(DOOR_ANGLE), s = sinf(DOOR_ANGLE), hinge_z = -DOOR_HALF_WIDTH + 0.02f;
    const float swing[16] = { c, 0, s, 0, 0, 1, 0, 0, -s, 0, c, 0, 0, 0, hinge_z, 1 };
    return rsv_add_box((rsv_shape){ scene, "door", material, swing }, v3(-0.02f, 0.01f, 0),
        v3(0.02f, DOOR_HEIGHT - 0.01f, 2 * DOOR_HALF_WIDTH - 0.03f));
}

static rsv_status add_furniture(rsv_scene *scene, uint32_t wood, uint32_t cloth)
{
    const struct {
        const char *name;
        uint32_t material;
        float x0, x1, z0, z1, top;
    } piece[] = {
        { "table", wood, 1.6f, 2.8f, -0.4f, 0.4f, 0.75f },
        { "cupboard", wood, 3.3f, 4.0f, -1.4f, -0.6f, 1.8f },
        { "sofa", cloth, -3.2f, -1.4f, -1.45f, -0.7f, 0.45f },
        { "stool", wood, -1.2f, -0.8f, 0.8f, 1.2f, 0.5f },
    };
    rsv_status status = RSV_OK;
    for (size_t i = 0; i < sizeof piece / sizeof *piece; i++) {
        const float footprint[4][2] = { { piece[i].x0, piece[i].z1 }, { piece[i].x1, piece[i].z1 },
            { piece[i].x1, piece[i].z0 }, { piece[i].x0, piece[i].z0 } };
        RSV_TRY(rsv_add_block((rsv_shape){ scene, piece[i].name, piece[i].material, NULL },
            footprint, 0, piece[i].top));
    }
cleanup:
    return status;
}

static rsv_status add_shell(rsv_scene *scene, uint32_t plaster, uint32_t boards)
{
    const float x = HALF_LENGTH, y = HEIGHT, z = HALF_DEPTH;
    const struct {
        const char *name;
        uint32_t material;
        rsv_vec3 corner[4];
    } side[] = {
        { "floor", boards, { { -x, 0, z }, { x, 0, z }, { x, 0, -z }, { -x, 0, -z } } },
        { "ceiling", plaster, { { -x, y, z }, { -x, y, -z }, { x, y, -z }, { x, y, z } } },
        { "far wall", plaster, { { -x, 0, -z }, { x, 0, -z }, { x, y, -z }, { -x, y, -z } } },
        { "near wall", plaster, { { x, 0, z }, { -x, 0, z }, { -x, y, z }, { x, y, z } } },
        { "left wall", plaster, { { -x, 0, z }, { -x, 0, -z }, { -x, y, -z }, { -x, y, z } } },
        { "right wall", plaster, { { x, 0, -z }, { x, 0, z }, { x, y, z }, { x, y, -z } } },
    };
    rsv_status status = RSV_OK;
    for (size_t i = 0; i < sizeof side / sizeof *side; i++)
        RSV_TRY(rsv_add_quad(
            (rsv_shape){ scene, side[i].name, side[i].material, NULL }, side[i].corner));
cleanup:
    return status;
}

static rsv_status add_ceiling_lamp(rsv_scene *scene)
{
    const float y = HEIGHT - 0.002f;
    const rsv_vec3 corner[4] = { { 1.6f, y, 0.4f }, { 1.6f, y, -0.4f }, { 2.4f, y, -0.4f },
        { 2.4f, y, 0.4f } };
    rsv_status status;
    uint32_t lamp;
    RSV_TRY(rsv_add_lambert(scene, "lamp", rgb_gray(0), rgb(30, 27, 22), &lamp));
    RSV_TRY(rsv_add_quad((rsv_shape){ scene, "lamp", lamp, NULL }, corner));
cleanup:
    return status;
}

static rsv_status add_rooms(rsv_scene *scene)
{
    rsv_status status;
    uint32_t plaster, boards, wood, cloth;
    RSV_TRY(rsv_add_lambert(scene, "plaster", rgb(0.75f, 0.73f, 0.7f), rgb_gray(0), &plaster));
    RSV_TRY(rsv_add_lambert(scene, "boards", rgb(0.42f, 0.3f, 0.2f), rgb_gray(0), &boards));
    RSV_TRY(rsv_add_lambert(scene, "wood", rgb(0.55f, 0.4f, 0.25f), rgb_gray(0), &wood));
    RSV_TRY(rsv_add_lambert(scene, "cloth", rgb(0.2f, 0.3f, 0.5f), rgb_gray(0), &cloth));
    RSV_TRY(add_shell(scene, plaster, boards));
    RSV_TRY(add_partition(scene, plaster));
    RSV_TRY(add_door(scene, wood));
    RSV_TRY(add_furniture(scene, wood, cloth));
cleanup:
    return status;
}

rsv_status rsv_build_two_rooms(rsv_scene *scene)
{
    rsv_status status;
    rsv_camera camera = rsv_camera_look_at(
        "dark room", v3(-3.8f, 1.5f, 0.9f), v3(0, 1, -0.1f), 50 * RSV_PI / 180, 4.0f / 3);
    RSV_TRY(add_rooms(scene));
    RSV_TRY(add_ceiling_lamp(scene));
    RSV_TRY(rsv_scene_add_camera(scene, &camera));
cleanup:
    return status;
}

/// The two rooms lit by a spot light behind the door: what passes the gap is a shaft of light in the fog.
rsv_status rsv_build_fog_rooms(rsv_scene *scene)
{
    rsv_status status;
    const rsv_vec3 lamp = v3(2.6f, 1.9f, -1), gap = v3(-0.2f, 1.1f, 0.4f);
    const rsv_punctual_light spot = { .name = "spotlight",
        .kind = RSV_PUNCTUAL_SPOT,
        .position = lamp,
        .direction = v3_normalize(v3_sub(gap, lamp)),
        .intensity = { 400, 370, 310 },
        .inner_cone_angle = 9 * RSV_PI / 180,
        .outer_cone_angle = 12 * RSV_PI / 180 };
    rsv_camera camera = rsv_camera_look_at("shaft", v3(-3.7f, 1.5f, -1), v3(-0.6f, 1, 0.5f),
        55 * RSV_PI / 180, 4.0f / 3);
    RSV_TRY(add_rooms(scene));
    RSV_TRY(rsv_scene_add_camera(scene, &camera));
    RSV_TRY(rsv_scene_add_light(scene, &spot));
cleanup:
    return status;
}

rsv_status rsv_fill_fog_rooms(rsv_scene *scene)
{
    rsv_fog fog = rsv_default_fog();
    fog.extinction = rgb_gray(0.3f);
    fog.albedo = rgb_gray(0.9f);
    return rsv_scene_set_fog(scene, &fog);
}
