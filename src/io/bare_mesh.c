#include "bare_mesh.h"

#include "../core/vec.h"
#include "../scene/far_box.h"
#include "../scene/smooth_normals.h"
#include "matrix.h"

#include <stdio.h>
#include <string.h>

#define BARE_ALBEDO 0.8f

rsv_status rsv_add_bare_material(rsv_scene *scene, uint32_t *material)
{
    rsv_material bare = rsv_default_material();
    bare.name = "unnamed";
    bare.base_color = rgb_gray(BARE_ALBEDO);
    bare.specular = 0;
    bare.double_sided = true;
    return rsv_scene_add_material(scene, &bare, material);
}

void rsv_bring_near(const rsv_place *place, size_t count, double origin[3], rsv_vec3 *position)
{
    rsv_far_box bounds = rsv_far_nothing();
    for (size_t k = 0; k < count; k++)
        rsv_far_enclose(&bounds, place[k].at);
    rsv_far_origin(&bounds, origin);
    for (size_t k = 0; k < count; k++)
        position[k] = v3((float)(place[k].at[0] - origin[0]), (float)(place[k].at[1] - origin[1]),
            (float)(place[k].at[2] - origin[2]));
}

static rsv_status add_placed(
    rsv_scene *scene, const rsv_load_desc *desc, const double origin[3], const rsv_mesh_desc *mesh)
{
    uint32_t id;
    double frame[16], placed[16];
    const double shift[16] = {
        [0] = 1, [5] = 1, [10] = 1, [12] = origin[0], [13] = origin[1], [14] = origin[2], [15] = 1
    };
    rsv_matrix_upright(desc->up, (double)desc->metres_per_unit, frame);
    rsv_matrix_multiply(frame, shift, placed);
    rsv_status status = rsv_scene_add_mesh(scene, mesh, &id);
    return status == RSV_OK ? rsv_scene_place_instance(scene, id, placed, mesh->name) : status;
}

rsv_status rsv_add_bare_mesh(rsv_scene *scene, const rsv_load_desc *desc, const double origin[3],
    bool in_single, rsv_mesh_desc mesh)
{
    rsv_status status;
    rsv_context *context = rsv_scene_get_context(scene);
    rsv_smooth_mesh smooth = { 0 };
    rsv_vec3 *split = NULL;
    if (in_single)
        rsv_scene_note_single(
            scene, (double)desc->metres_per_unit *
                       fmax(fabs(origin[0]), fmax(fabs(origin[1]), fabs(origin[2]))));
    if (mesh.normals) return add_placed(scene, desc, origin, &mesh);
    RSV_TRY(rsv_smooth_normals(context, &mesh, desc->crease_angle, &smooth));
    split = rsv_alloc(context, smooth.vertex_count, sizeof *split);
    if (!split) RSV_TRY(RSV_ERROR_MEMORY);
    for (size_t i = 0; i < smooth.vertex_count; i++)
        split[i] = mesh.positions[smooth.source[i]];
    mesh.positions = split;
    mesh.normals = smooth.normal;
    mesh.vertex_count = smooth.vertex_count;
    mesh.indices = smooth.index;
    RSV_TRY(add_placed(scene, desc, origin, &mesh));
cleanup:
    rsv_free(context, split);
    rsv_smooth_mesh_release(context, &smooth);
    return status;
}
