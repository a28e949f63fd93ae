/// Scenes far from their origin, as maps have them: single precision leaves few digits there. What all have in common is
/// taken out, once, before anything becomes a float; rsv_scene_view.origin keeps it for whoever writes coordinates.
#include "../core/vec.h"
#include "scene.h"

#include <float.h>

/// Sizes of the scene between its centre and the origin from which on this is done. There a float has lost six of its 24
/// binary digits.
#define FAR_SIZES 64

typedef struct box {
    double low[3], high[3];
} box;

static box nothing(void)
{
    return (box){ { DBL_MAX, DBL_MAX, DBL_MAX }, { -DBL_MAX, -DBL_MAX, -DBL_MAX } };
}

static void enclose(box *b, const double point[3])
{
    for (int axis = 0; axis < 3; axis++) {
        b->low[axis] = fmin(b->low[axis], point[axis]);
        b->high[axis] = fmax(b->high[axis], point[axis]);
    }
}

/// Bounds of a mesh's triangles, in its own space.
static box mesh_bounds(const rsv_mesh *mesh)
{
    box b = nothing();
    for (size_t k = 0; k < 3 * mesh->triangle_count; k++) {
        rsv_vec3 p = mesh->position[mesh->index[k]];
        enclose(&b, (const double[3]){ (double)p.x, (double)p.y, (double)p.z });
    }
    return b;
}

/// Adds the corners of a mesh's bounds, where an instance has them. What is not finite is refused later.
static void add_instance(const box *mesh, const double m[16], box *all)
{
    for (int corner = 0; corner < 8; corner++) {
        double p[3];
        for (int row = 0; row < 3; row++) {
            p[row] = m[12 + row];
            for (int axis = 0; axis < 3; axis++)
                p[row] +=
                    m[4 * axis + row] * (corner >> axis & 1 ? mesh->high[axis] : mesh->low[axis]);
        }
        if (isfinite(p[0] + p[1] + p[2])) enclose(all, p);
    }
}

static rsv_status find_bounds(const rsv_scene *scene, box *all)
{
    box *mesh = rsv_alloc(scene->context, scene->mesh_count, sizeof *mesh);
    if (!mesh) return RSV_ERROR_MEMORY;
    for (size_t k = 0; k < scene->mesh_count; k++)
        mesh[k] = mesh_bounds(&scene->mesh[k]);
    *all = nothing();
    for (size_t k = 0; k < scene->instance_count; k++) {
        const rsv_instance *instance = &scene->instance[k];
        if (scene->mesh[instance->mesh].triangle_count)
            add_instance(&mesh[instance->mesh], instance->transform, all);
    }
    rsv_free(scene->context, mesh);
    return RSV_OK;
}

/// A round place near the centre of what lies far away: whole tens or hundreds of metres say the same to everybody.
static bool choose(const box *all, double origin[3])
{
    double size = 0, distance = 0;
    for (int axis = 0; axis < 3; axis++) {
        double centre = 0.5 * (all->low[axis] + all->high[axis]);
        size = fmax(size, all->high[axis] - all->low[axis]);
        distance = fmax(distance, fabs(centre));
    }
    if (!(size > 0) || !(distance > FAR_SIZES * size) || distance > (double)RSV_FARTHEST)
        return false;
    double step = pow(10, ceil(log10(size)));
    for (int axis = 0; axis < 3; axis++)
        origin[axis] = step * rint(0.5 * (all->low[axis] + all->high[axis]) / step);
    return true;
}

static void shift(const rsv_scene *scene, const rsv_fixture *fixture, rsv_vec3 *position)
{
    *position = v3((float)(fixture->position[0] - scene->origin[0]),
        (float)(fixture->position[1] - scene->origin[1]),
        (float)(fixture->position[2] - scene->origin[2]));
}

rsv_status rsv_scene_take_origin(rsv_scene *scene)
{
    box all;
    if (!scene->in_double) return RSV_OK;
    rsv_status status = find_bounds(scene, &all);
    if (status != RSV_OK || !choose(&all, scene->origin)) return status;
    for (size_t k = 0; k < scene->light_count; k++)
        shift(scene, &scene->light_fixture[k], &scene->light[k].position);
    for (size_t k = 0; k < scene->camera_count; k++)
        shift(scene, &scene->camera_fixture[k], &scene->camera[k].position);
    rsv_log(scene->context, RSV_LOG_INFO,
        "the scene lies far from its origin: (%.15g, %.15g, %.15g) m is taken out of its "
        "coordinates while it is worked on, and put back in what is written",
        scene->origin[0], scene->origin[1], scene->origin[2]);
    return RSV_OK;
}
