#include "moving_scenes.h"

#include "box_mesh.h"
#include "moved_scene.h"

#include <math.h>
#include <string.h>

enum { SIDES = 16, BOXES = 100 };

static rsv_status add_material(rsv_scene *scene, rsv_rgb color, rsv_rgb emission, uint32_t *id)
{
    rsv_material m = rsv_default_material();
    m.base_color = color;
    m.metallic = 0;
    m.specular = 0;
    m.emission = emission;
    m.double_sided = true;
    return rsv_scene_add_material(scene, &m, id);
}

/// Four metres wide and three high, of albedo 0.7.
static rsv_status add_room(rsv_scene *scene)
{
    uint32_t white;
    rsv_status status =
        add_material(scene, (rsv_rgb){ 0.7f, 0.7f, 0.7f }, (rsv_rgb){ 0, 0, 0 }, &white);
    if (status != RSV_OK) return status;
    return cli_add_box(
        scene, "room", (rsv_vec3){ -2, 0, -2 }, (rsv_vec3){ 2, 3, 2 }, CLI_FACES_INWARDS, white);
}

/// @param radius half a side, metres
static rsv_status add_lamp(rsv_scene *scene, rsv_vec3 at, float radius, float radiance)
{
    uint32_t lamp;
    rsv_status status = add_material(
        scene, (rsv_rgb){ 0, 0, 0 }, (rsv_rgb){ radiance, radiance, 0.8f * radiance }, &lamp);
    if (status != RSV_OK) return status;
    const rsv_vec3 low = { at.x - radius, at.y - 0.05f, at.z - radius },
                   high = { at.x + radius, at.y + 0.05f, at.z + radius };
    return cli_add_box(scene, "lamp", low, high, CLI_FACES_OUTWARDS, lamp);
}

static rsv_status add_mirror(rsv_scene *scene)
{
    rsv_material m = rsv_default_material();
    uint32_t mirror;
    m.base_color = (rsv_rgb){ 0.95f, 0.95f, 0.95f };
    m.metallic = 1;
    m.roughness = 0;
    rsv_status status = add_lamp(scene, (rsv_vec3){ 0.8f, 2.8f, 0.8f }, 0.2f, 40);
    if (status == RSV_OK) status = rsv_scene_add_material(scene, &m, &mirror);
    if (status != RSV_OK) return status;
    return cli_add_box(scene, "mirror", (rsv_vec3){ -0.6f, 0.2f, -0.02f },
        (rsv_vec3){ 0.6f, 1.4f, 0.02f }, CLI_FACES_OUTWARDS, mirror);
}

/// A cone without ends, wider below, which hangs above its bulb at first.
static rsv_status add_shade(rsv_scene *scene)
{
    rsv_vec3 corner[2 * SIDES];
    uint32_t index[6 * SIDES], cloth, mesh;
    for (uint32_t k = 0; k < SIDES; k++) {
        float angle = 6.2831853f * (float)k / SIDES, c = cosf(angle), s = sinf(angle);
        uint32_t next = (k + 1) % SIDES;
        corner[2 * k] = (rsv_vec3){ 0.35f * c, 2.3f, 0.35f * s };
        corner[2 * k + 1] = (rsv_vec3){ 0.15f * c, 2.6f, 0.15f * s };
        const uint32_t two[6] = { 2 * k, 2 * k + 1, 2 * next, 2 * next, 2 * k + 1, 2 * next + 1 };
        memcpy(index + (size_t)6 * k, two, sizeof two);
    }
    rsv_status status = add_lamp(scene, (rsv_vec3){ 0, 2.1f, 0 }, 0.05f, 200);
    if (status == RSV_OK)
        status = add_material(scene, (rsv_rgb){ 0.6f, 0.5f, 0.3f }, (rsv_rgb){ 0, 0, 0 }, &cloth);
    if (status != RSV_OK) return status;
    const rsv_mesh_desc shade = { .size = sizeof shade,
        .name = "shade",
        .positions = corner,
        .vertex_count = (size_t)2 * SIDES,
        .indices = index,
        .triangle_count = (size_t)2 * SIDES,
        .material = cloth };
    status = rsv_scene_add_mesh(scene, &shade, &mesh);
    return status == RSV_OK ? rsv_scene_add_instance(scene, mesh, NULL, NULL) : status;
}

/// Boxes of three colours on a lattice, at heights of their own.
static rsv_status add_boxes(rsv_scene *scene)
{
    static const rsv_rgb color[3] = { { 0.7f, 0.1f, 0.1f }, { 0.1f, 0.6f, 0.1f },
        { 0.1f, 0.2f, 0.7f } };
    uint32_t paint[3];
    rsv_status status = add_lamp(scene, (rsv_vec3){ 0, 2.85f, 0 }, 0.4f, 15);
    for (int k = 0; k < 3 && status == RSV_OK; k++)
        status = add_material(scene, color[k], (rsv_rgb){ 0, 0, 0 }, &paint[k]);
    for (uint32_t k = 0; k < BOXES && status == RSV_OK; k++) {
        const rsv_vec3 low = { -1.7f + 0.35f * (float)(k % 10),
            0.3f + 0.017f * (float)((61 * k) % BOXES), -1.7f + 0.35f * (float)(k / 10) };
        const rsv_vec3 high = { low.x + 0.15f, low.y + 0.15f, low.z + 0.15f };
        status = cli_add_box(scene, "box", low, high, CLI_FACES_OUTWARDS, paint[k % 3]);
    }
    return status;
}

rsv_status cli_build_moving_scene(rsv_context *context, const char *name, rsv_scene **scene)
{
    static const struct {
        const char *name;
        rsv_status (*add)(rsv_scene *scene);
    } known[] = { { "turning-mirror", add_mirror }, { "lamp-shade", add_shade },
        { "falling-boxes", add_boxes } };
    for (size_t k = 0; k < sizeof known / sizeof *known; k++) {
        if (strcmp(name, known[k].name) != 0) continue;
        rsv_status status = rsv_scene_create(context, scene);
        if (status == RSV_OK) status = add_room(*scene);
        if (status == RSV_OK) status = known[k].add(*scene);
        return status == RSV_OK ? rsv_scene_commit(*scene) : status;
    }
    return RSV_ERROR_ARGUMENT;
}

// ---- motions --------------------------------------------------------------------------------------

static const cli_motion known_motions[] = {
    { .scene = "cornell-blocks", .object = "short block", .shift = { -0.1f, 0, 0 } },
    // nearly shut (at 0.22) to wide open
    { .scene = "two-rooms", .object = "door", .axis = { 0, -0.43f }, .turns = { 0.18f, -0.68f } },
    { .scene = "cornell-spheres",
        .object = "front sphere",
        .shift = { 0.05f, 0, 0 },
        .rolls = true },
    { .scene = "turning-mirror", .object = "mirror", .turns = { 0, 0.7f } },
    { .scene = "lamp-shade", .object = "shade", .shift = { 0, -0.35f, 0 } },
    { .scene = "falling-boxes", .object = "box", .fall = 2 },
    // from bench/part_of_scene.py; half a metre in each of 6 frames
    { .scene = "chair.glb", .object = "chair", .shift = { 0, 0, 2.5f } },
    // a bin
    { .scene = "japanese_classroom.glb", .object = "Mesh047", .shift = { -0.5f, 0, 0 } },
};

const cli_motion *cli_find_motion(const char *scene)
{
    size_t length = strlen(scene);
    for (size_t k = 0; k < sizeof known_motions / sizeof *known_motions; k++) {
        size_t own = strlen(known_motions[k].scene);
        if (own <= length && strcmp(scene + length - own, known_motions[k].scene) == 0)
            return &known_motions[k];
    }
    return NULL;
}

/// Turned about an axis along z through a point.
static rsv_motion roll(uint32_t object, float angle, float x, float y, float shift)
{
    float c = cosf(angle), s = sinf(angle);
    return (rsv_motion){ .object = object,
        .matrix = { c, s, 0, 0, -s, c, 0, 0, 0, 0, 1, 0, x - c * x + s * y + shift,
            y - s * x - c * y, 0, 1 } };
}

rsv_motion cli_motion_at(const cli_motion *m, const rsv_scene *scene, uint32_t object, float share)
{
    rsv_vec3 low, high;
    cli_object_bounds(scene, object, &low, &high);
    float shift = share * m->shift.x;
    if (m->rolls)
        return roll(object, -2 * shift / (high.y - low.y), 0.5f * (low.x + high.x),
            0.5f * (low.y + high.y), shift);
    float angle = m->turns[0] + share * (m->turns[1] - m->turns[0]);
    float c = cosf(angle), s = sinf(angle), x = m->axis[0], z = m->axis[1];
    float fall = m->fall > 0 ? fminf(share * share * m->fall, low.y) : 0;
    return (rsv_motion){ .object = object,
        .matrix = { c, 0, -s, 0, 0, 1, 0, 0, s, 0, c, 0, x - c * x - s * z + shift,
            share * m->shift.y - fall, z + s * x - c * z + share * m->shift.z, 1 } };
}
