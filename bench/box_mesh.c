#include "box_mesh.h"

static const uint32_t inwards[36] = { 0, 1, 3, 0, 3, 2, 4, 7, 5, 4, 6, 7, 0, 2, 6, 0, 6, 4, 1, 5, 7,
    1, 7, 3, 0, 4, 5, 0, 5, 1, 2, 3, 7, 2, 7, 6 };
static const uint32_t outwards[36] = { 0, 3, 1, 0, 2, 3, 4, 5, 7, 4, 7, 6, 0, 6, 2, 0, 4, 6, 1, 7,
    5, 1, 3, 7, 0, 5, 4, 0, 1, 5, 2, 7, 3, 2, 6, 7 };

rsv_status cli_add_box(rsv_scene *scene, const char *name, rsv_vec3 low, rsv_vec3 high,
    cli_facing facing, uint32_t material)
{
    rsv_vec3 corner[8];
    uint32_t mesh;
    for (int k = 0; k < 8; k++)
        corner[k] =
            (rsv_vec3){ k & 1 ? high.x : low.x, k & 2 ? high.y : low.y, k & 4 ? high.z : low.z };
    const rsv_mesh_desc desc = { .size = sizeof desc,
        .name = name,
        .positions = corner,
        .vertex_count = 8,
        .indices = facing == CLI_FACES_INWARDS ? inwards : outwards,
        .triangle_count = 12,
        .material = material };
    rsv_status status = rsv_scene_add_mesh(scene, &desc, &mesh);
    return status == RSV_OK ? rsv_scene_add_instance(scene, mesh, NULL, NULL) : status;
}
