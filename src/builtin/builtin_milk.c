/// A glass of milk on a table. The milk reaches a little into the glass: they touch without air in between.
#include "builtin.h"

#define STEPS 96 // around the axis
#define HEIGHT 0.13f
#define OUTER 0.036f
#define INNER 0.033f
#define BOTTOM 0.008f // of glass
#define LEVEL 0.1f    // of milk
#define GAP 1e-4f     // a hair above the table: they do not touch
#define INTO_GLASS 2e-4f

/// Half of a cross-section: distance from the axis and height, from axis to axis, upwards outside.
typedef struct profile {
    const float (*point)[2];
    uint32_t count;
} profile;

static rsv_vec3 turned(const float point[2], uint32_t step)
{
    float angle = 2 * RSV_PI * (float)step / STEPS;
    return v3(point[0] * cosf(angle), point[1] + GAP, -point[0] * sinf(angle));
}

/// The quads between neighbouring points of the profile, all around; those at the axis are triangles.
static size_t join(const profile *p, uint32_t (*triangle)[3])
{
    size_t count = 0;
    for (uint32_t k = 0; k + 1 < p->count; k++)
        for (uint32_t i = 0; i < STEPS; i++) {
            uint32_t here = k * STEPS, above = here + STEPS, next = (i + 1) % STEPS;
            const uint32_t quad[2][3] = { { here + i, here + next, above + next },
                { here + i, above + next, above + i } };
            for (int half = 0; half < 2; half++) {
                if (p->point[half ? k + 1 : k][0] == 0) continue;
                for (int c = 0; c < 3; c++)
                    triangle[count][c] = quad[half][c];
                count++;
            }
        }
    return count;
}

/// A body of revolution about the y axis.
static rsv_status add_turned(rsv_scene *scene, const char *name, uint32_t material, profile p)
{
    rsv_status status = RSV_ERROR_MEMORY;
    rsv_context *context = scene->context;
    uint32_t id;
    rsv_vec3 *position = rsv_alloc(context, p.count * STEPS, sizeof *position);
    uint32_t(*triangle)[3] = rsv_alloc(context, 2 * p.count * STEPS, sizeof *triangle);
    if (!position || !triangle) goto cleanup;
    for (uint32_t k = 0; k < p.count * STEPS; k++)
        position[k] = turned(p.point[k / STEPS], k % STEPS);
    const rsv_mesh_desc mesh = { .size = sizeof mesh,
        .name = name,
        .positions = position,
        .vertex_count = p.count * STEPS,
        .indices = *triangle,
        .triangle_count = join(&p, triangle),
        .material = material };
    RSV_TRY(rsv_scene_add_mesh(scene, &mesh, &id));
    RSV_TRY(rsv_scene_add_instance(scene, id, NULL, name));
cleanup:
    rsv_free(context, position);
    rsv_free(context, triangle);
    return status;
}

static rsv_status add_glass_of_milk(rsv_scene *scene)
{
    static const float tumbler[][2] = { { 0, 0 }, { OUTER, 0 }, { OUTER, HEIGHT },
        { INNER, HEIGHT }, { INNER, BOTTOM }, { 0, BOTTOM } };
    static const float content[][2] = { { 0, BOTTOM - INTO_GLASS },
        { INNER + INTO_GLASS, BOTTOM - INTO_GLASS }, { INNER + INTO_GLASS, LEVEL }, { 0, LEVEL } };
    rsv_status status;
    uint32_t glass_id, milk_id;
    rsv_material glass = rsv_default_material(), milk;
    glass.name = "glass";
    glass.roughness = 0;
    glass.transmission = 1;
    glass.thickness = OUTER - INNER;
    rsv_material_preset("wholemilk", &milk);
    milk.name = "milk";
    RSV_TRY(rsv_scene_add_material(scene, &glass, &glass_id));
    RSV_TRY(rsv_scene_add_material(scene, &milk, &milk_id));
    RSV_TRY(add_turned(scene, "tumbler", glass_id, (profile){ tumbler, 6 }));
    RSV_TRY(add_turned(scene, "milk", milk_id, (profile){ content, 4 }));
cleanup:
    return status;
}

static rsv_status add_lamp(rsv_scene *scene)
{
    const rsv_vec3 corner[4] = { { -0.45f, 0.55f, 0.3f }, { -0.45f, 0.55f, 0.1f },
        { -0.25f, 0.7f, 0.1f }, { -0.25f, 0.7f, 0.3f } };
    rsv_status status;
    uint32_t lamp;
    RSV_TRY(rsv_add_lambert(scene, "lamp", rgb_gray(0), rgb(32, 28, 22), &lamp));
    RSV_TRY(rsv_add_quad((rsv_shape){ scene, "lamp", lamp, NULL }, corner));
cleanup:
    return status;
}

rsv_status rsv_build_milk(rsv_scene *scene)
{
    rsv_status status;
    uint32_t wall, wood;
    RSV_TRY(rsv_add_lambert(scene, "wall", rgb(0.4f, 0.5f, 0.55f), rgb_gray(0), &wall));
    RSV_TRY(rsv_add_lambert(scene, "wood", rgb(0.45f, 0.3f, 0.18f), rgb_gray(0), &wood));
    RSV_TRY(rsv_add_room(
        (rsv_shape){ scene, "room", wall, NULL }, v3(-0.6f, -0.05f, -0.4f), v3(0.6f, 0.9f, 0.8f)));
    RSV_TRY(rsv_add_box(
        (rsv_shape){ scene, "table", wood, NULL }, v3(-0.4f, -0.03f, -0.3f), v3(0.4f, 0, 0.3f)));
    RSV_TRY(add_glass_of_milk(scene));
    RSV_TRY(add_lamp(scene));
    rsv_camera camera = rsv_camera_look_at(
        "table", v3(0.12f, 0.24f, 0.42f), v3(0, 0.06f, 0), 26 * RSV_PI / 180, 1);
    RSV_TRY(rsv_scene_add_camera(scene, &camera));
cleanup:
    return status;
}
