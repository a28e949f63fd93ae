/// The Cornell box, from the data that Cornell University's Program of Computer Graphics published
/// ("Cornell Box Data"): millimetres, the viewer at negative z looking along +z. Half a turn about y
/// and metres make it a glTF scene: the viewer looks along -z, red on the left, green on the right.
#include "builtin.h"

#define LEVEL_OF_GLASS 5 // 20,480 triangles a sphere

static rsv_vec3 from_cornell(float x, float y, float z)
{
    return v3(-x / 1000, y / 1000, -z / 1000);
}

static rsv_status add_cornell_quad(rsv_shape shape, const float corner[4][3])
{
    rsv_vec3 converted[4];
    for (int i = 0; i < 4; i++)
        converted[i] = from_cornell(corner[i][0], corner[i][1], corner[i][2]);
    return rsv_add_quad(shape, converted);
}

/// @param footprint published (x, z) corners of the top face, in their published order
static rsv_status add_cornell_block(rsv_shape shape, const float footprint[4][2], float height)
{
    float converted[4][2];
    for (int i = 0; i < 4; i++) {
        rsv_vec3 p = from_cornell(footprint[i][0], 0, footprint[i][1]);
        converted[i][0] = p.x;
        converted[i][1] = p.z;
    }
    return rsv_add_block(shape, converted, 0, height / 1000);
}

static rsv_status add_cornell_walls(rsv_scene *scene, uint32_t *white)
{
    static const float floor[4][3] = { { 552.8f, 0, 0 }, { 0, 0, 0 }, { 0, 0, 559.2f },
        { 549.6f, 0, 559.2f } };
    static const float ceiling[4][3] = { { 556, 548.8f, 0 }, { 556, 548.8f, 559.2f },
        { 0, 548.8f, 559.2f }, { 0, 548.8f, 0 } };
    static const float back[4][3] = { { 549.6f, 0, 559.2f }, { 0, 0, 559.2f },
        { 0, 548.8f, 559.2f }, { 556, 548.8f, 559.2f } };
    static const float right[4][3] = { { 0, 0, 559.2f }, { 0, 0, 0 }, { 0, 548.8f, 0 },
        { 0, 548.8f, 559.2f } };
    static const float left[4][3] = { { 552.8f, 0, 0 }, { 549.6f, 0, 559.2f },
        { 556, 548.8f, 559.2f }, { 556, 548.8f, 0 } };
    rsv_status status;
    uint32_t red, green;
    RSV_TRY(rsv_add_lambert(scene, "white", rgb(0.725f, 0.71f, 0.68f), rgb_gray(0), white));
    RSV_TRY(rsv_add_lambert(scene, "red", rgb(0.63f, 0.065f, 0.05f), rgb_gray(0), &red));
    RSV_TRY(rsv_add_lambert(scene, "green", rgb(0.14f, 0.45f, 0.091f), rgb_gray(0), &green));
    RSV_TRY(add_cornell_quad((rsv_shape){ scene, "floor", *white, NULL }, floor));
    RSV_TRY(add_cornell_quad((rsv_shape){ scene, "ceiling", *white, NULL }, ceiling));
    RSV_TRY(add_cornell_quad((rsv_shape){ scene, "back wall", *white, NULL }, back));
    RSV_TRY(add_cornell_quad((rsv_shape){ scene, "right wall", green, NULL }, right));
    RSV_TRY(add_cornell_quad((rsv_shape){ scene, "left wall", red, NULL }, left));
cleanup:
    return status;
}

/// The published quad lies in the ceiling; here it hangs 0.2 mm below, so that no hole is needed.
static rsv_status add_cornell_light(rsv_scene *scene)
{
    const float y = 548.8f - 0.2f;
    const float corner[4][3] = { { 343, y, 227 }, { 343, y, 332 }, { 213, y, 332 },
        { 213, y, 227 } };
    rsv_status status;
    uint32_t light;
    RSV_TRY(rsv_add_lambert(scene, "light", rgb_gray(0), rgb(17, 12, 4), &light));
    RSV_TRY(add_cornell_quad((rsv_shape){ scene, "light", light, NULL }, corner));
cleanup:
    return status;
}

/// 35 mm lens on 25 mm film, as published.
static rsv_status add_cornell_camera(rsv_scene *scene)
{
    rsv_camera camera = rsv_camera_look_at("cornell", from_cornell(278, 273, -800),
        from_cornell(278, 273, 0), 2 * atanf(12.5f / 35), 1);
    return rsv_scene_add_camera(scene, &camera);
}

rsv_status rsv_build_cornell_box(rsv_scene *scene)
{
    rsv_status status;
    uint32_t white;
    RSV_TRY(add_cornell_walls(scene, &white));
    RSV_TRY(add_cornell_light(scene));
    RSV_TRY(add_cornell_camera(scene));
cleanup:
    return status;
}

rsv_status rsv_build_cornell_blocks(rsv_scene *scene)
{
    static const float low[4][2] = { { 130, 65 }, { 82, 225 }, { 240, 272 }, { 290, 114 } };
    static const float tall[4][2] = { { 423, 247 }, { 265, 296 }, { 314, 456 }, { 472, 406 } };
    rsv_status status;
    uint32_t white;
    RSV_TRY(add_cornell_walls(scene, &white));
    RSV_TRY(add_cornell_block((rsv_shape){ scene, "short block", white, NULL }, low, 165));
    RSV_TRY(add_cornell_block((rsv_shape){ scene, "tall block", white, NULL }, tall, 330));
    RSV_TRY(add_cornell_light(scene));
    RSV_TRY(add_cornell_camera(scene));
cleanup:
    return status;
}

rsv_status rsv_build_cornell_spheres(rsv_scene *scene)
{
    const float radius = 0.1f, gap = 1e-4f; // a hair above the floor: they do not touch
    rsv_status status;
    uint32_t white, glass_id;
    rsv_material glass = rsv_default_material();
    glass.name = "glass";
    glass.roughness = 0;
    glass.transmission = 1;
    glass.thickness = 2 * radius;
    RSV_TRY(add_cornell_walls(scene, &white));
    RSV_TRY(rsv_scene_add_material(scene, &glass, &glass_id));
    // where the blocks stand in the other scene
    rsv_vec3 front = from_cornell(186, 0, 169), back = from_cornell(368, 0, 351);
    front.y = back.y = radius + gap;
    RSV_TRY(rsv_add_sphere(
        (rsv_shape){ scene, "front sphere", glass_id, NULL }, front, radius, LEVEL_OF_GLASS));
    RSV_TRY(rsv_add_sphere(
        (rsv_shape){ scene, "back sphere", glass_id, NULL }, back, radius, LEVEL_OF_GLASS));
    RSV_TRY(add_cornell_light(scene));
    RSV_TRY(add_cornell_camera(scene));
cleanup:
    return status;
}
